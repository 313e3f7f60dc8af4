//! Configurations of RTKLIB.

use std::io::BufRead;
use std::path::Path;

use acerra_gnss::RuleSet;
use acerra_gnss::conf::read_conf;
use acerra_gnss::input::{FileKind, sniff};

use super::description::Description;

/// Whether the first bytes belong to a configuration.
pub fn is_configuration(head: &[u8]) -> bool {
    sniff(head) == FileKind::RtklibConf
}

pub fn describe(reader: impl BufRead, path: &Path) -> anyhow::Result<Description> {
    let mut conf = read_conf(reader, RuleSet::Rtklib)?;
    let mut d = Description::new("RTKLIB configuration");
    d.fact("rules", conf.options.rules.to_string());
    d.fact("mode", conf.options.mode.to_string());
    d.fact("frequencies", conf.options.frequencies);
    d.fact(
        "elevation_mask_deg",
        conf.options.elevation_mask_rad.to_degrees(),
    );
    d.fact("precise_orbits", conf.inputs.precise_orbits);
    d.fact("settings_not_followed", conf.not_followed.len());
    if let Err(missing) = conf.find_files(path.parent().unwrap_or(Path::new(""))) {
        d.notes.push(missing.to_string());
    }
    let files = [&conf.inputs.antenna_file, &conf.outputs.geoid_file];
    for file in files.into_iter().flatten() {
        d.notes.push(format!("{} = {}", file.key, file.name));
    }
    d.notes
        .extend(conf.not_followed.iter().map(ToString::to_string));
    Ok(d)
}
