//! A run: from a campaign file to its products.

use std::path::{Path, PathBuf};

use acerra_chain::campaign::Campaign;
use acerra_chain::position::positioning::GnssConfiguration;
use acerra_chain::read::inputs::InputFile;
use acerra_chain::{Control, Journal};
use acerra_radar::LoggedClock;
use anyhow::Context;

use crate::data;
use crate::deliver::{deliver, deliver_image};
use crate::maps;
use crate::names::{PRODUCTS, of_older_run};
use crate::outcome::Outcome;
use crate::process::{NamedCampaign, process};
use crate::space::check_space;
use crate::stack_npz::NpzSink;
use crate::staging::Staging;

/// Reads a campaign file, runs it, and writes its products into `directory`. Cost and remarks of the stages
/// are in the journal, also after a failure.
///
/// # Errors
/// Any failure, with the file, the place and the expectation. The directory is then unchanged.
pub fn run_campaign(
    file: &Path,
    directory: &Path,
    journal: &mut Journal,
    control: &Control<'_>,
) -> anyhow::Result<Outcome> {
    run_campaign_with(
        RunRequest {
            file,
            directory,
            autofocus: false,
            wanted: Wanted::All,
        },
        journal,
        control,
    )
}

/// A run asked for.
#[derive(Clone, Copy, Debug)]
pub struct RunRequest<'a> {
    /// The campaign file.
    pub file: &'a Path,
    /// Directory of the products.
    pub directory: &'a Path,
    /// Whether positions are corrected by autofocus even where the campaign does not enable it.
    pub autofocus: bool,
    /// Selection of the products to write.
    pub wanted: Wanted,
}

/// Selection of the products of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wanted {
    /// All that the campaign asks for.
    #[default]
    All,
    /// `image.npz` and `run.json` alone, with `looks.npz` and `volume.npz` of a campaign that asks for them.
    Image,
}

/// As [`run_campaign`], with additions of the command line to the campaign.
///
/// # Errors
/// As [`run_campaign`].
pub fn run_campaign_with(
    request: RunRequest<'_>,
    journal: &mut Journal,
    control: &Control<'_>,
) -> anyhow::Result<Outcome> {
    let RunRequest {
        file, directory, ..
    } = request;
    let campaign = open(request)?;
    let mut staging = Staging::new(directory)?;
    staging.supersede(of_older_run(directory));
    // Pixels that cannot be held are refused before anything is read.
    check_space(&campaign.campaign, &staging.folder())?;
    let mut sink = NpzSink::new(&staging.folder());
    let read = campaign.campaign.clone();
    // Only the products need the digests of the inputs: another thread computes them.
    let (inputs, outcome) = std::thread::scope(|scope| {
        let inputs = scope.spawn(|| record_inputs(file, &read));
        let outcome = process(campaign, &mut sink, journal, control);
        (inputs.join(), outcome)
    });
    let inputs = inputs.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
    let mut outcome = outcome?;
    outcome.inputs = inputs;
    delivered(outcome, staging, request.wanted, journal)
}

/// Writes the products of a run and puts them in place.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn delivered(
    mut outcome: Outcome,
    staging: Staging,
    wanted: Wanted,
    journal: &mut Journal,
) -> anyhow::Result<Outcome> {
    name_sources(&mut outcome);
    let left_out = data::left_out(&outcome).filter(|_| wanted == Wanted::All);
    if let Some(left_out) = left_out {
        journal.warnings.add(&left_out);
        outcome.warnings.push(left_out);
    }
    match wanted {
        Wanted::All => deliver(&outcome, staging, &mut journal.stages)?,
        Wanted::Image => deliver_image(&outcome, staging, &mut journal.stages)?,
    }
    Ok(outcome)
}

/// Reads a campaign file, and refuses requests that no run of it could fulfil.
///
/// # Errors
/// A file that cannot be read or holds something else, a directory in which inputs would be
/// overwritten.
pub(crate) fn open(request: RunRequest<'_>) -> anyhow::Result<NamedCampaign> {
    let RunRequest {
        file, directory, ..
    } = request;
    let at = || format!("{}", file.display());
    let text = std::fs::read_to_string(file).with_context(at)?;
    let mut campaign = Campaign::parse(&text).with_context(at)?;
    campaign.autofocus.enabled |= request.autofocus;
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let campaign = NamedCampaign {
        name: name_of_campaign(file),
        campaign: campaign.resolved_in(folder),
    };
    inputs_are_kept(file, &campaign.campaign, directory)?;
    maps::check(&campaign.campaign).with_context(at)?;
    Ok(campaign)
}

/// Size and digest of every file that a campaign reads, each once.
pub(crate) fn record_inputs(file: &Path, campaign: &Campaign) -> anyhow::Result<Vec<InputFile>> {
    let mut inputs = Vec::new();
    for path in input_paths(file, campaign)? {
        let input = InputFile::record(&path).with_context(|| format!("{}", path.display()))?;
        if !inputs.contains(&input) {
            inputs.push(input);
        }
    }
    Ok(inputs)
}

/// Notes which sources in the logs of autopilots gave the positions.
fn name_sources(outcome: &mut Outcome) {
    let each = outcome.campaign.each_track();
    for (one, track) in each.iter().zip(&outcome.prepared.tracks) {
        let sources = &track.log_sources;
        for (file, sources) in [
            (&one.trajectory.file, &sources.positions),
            (&one.trajectory.attitude_file, &sources.attitudes),
        ] {
            let inputs = outcome.inputs.iter_mut();
            for input in inputs.filter(|input| Some(&input.path) == file.as_ref()) {
                input.sources.clone_from(sources);
            }
        }
    }
}

/// The campaign file, every file that it names, the antenna calibrations that its RTKLIB configurations name,
/// and the clocks next to radar logs.
fn input_paths(file: &Path, campaign: &Campaign) -> anyhow::Result<Vec<PathBuf>> {
    let each = campaign.each_track();
    let mut radars: Vec<PathBuf> = Vec::new();
    for one in &each {
        match one.radar.grid() {
            Some(grid) => radars.extend(grid.files()?),
            None => radars.push(one.radar.file.clone()),
        }
    }
    let logs = each.iter().flat_map(|one| one.position_files());
    let clocks: Vec<PathBuf> = each
        .iter()
        .map(|one| LoggedClock::path_beside(&one.radar.file))
        .filter(|path| path.is_file())
        .collect();
    let mut antennas = Vec::new();
    for path in each
        .iter()
        .filter_map(|one| one.gnss.as_ref()?.config.as_ref())
    {
        antennas.extend(GnssConfiguration::read(path)?.antennas.file);
    }
    let paths = std::iter::once(file)
        .chain(radars.iter().map(PathBuf::as_path))
        .chain(logs)
        .chain(campaign.image.terrain.as_deref())
        .chain(campaign.image.geoid.as_deref())
        .chain(campaign.measure.survey.as_deref())
        .map(Path::to_owned)
        .chain(antennas)
        .chain(clocks);
    Ok(paths.collect())
}

/// Refuses a directory in which a product would take the place of an input.
fn inputs_are_kept(file: &Path, campaign: &Campaign, directory: &Path) -> anyhow::Result<()> {
    let inputs: Vec<PathBuf> = input_paths(file, campaign)?
        .into_iter()
        .filter_map(|path| path.canonicalize().ok())
        .collect();
    for name in PRODUCTS {
        let place = directory.join(name);
        let clash = place.canonicalize().is_ok_and(|p| inputs.contains(&p));
        anyhow::ensure!(
            !clash,
            "{}: is an input and would be overwritten; name another directory with -o",
            place.display()
        );
    }
    Ok(())
}

/// Name of a campaign: that of its file, or of the folder of a file named `campaign`.
fn name_of_campaign(file: &Path) -> String {
    let of = |part: Option<&std::ffi::OsStr>| part.map(|p| p.to_string_lossy().into_owned());
    let stem = of(file.file_stem()).unwrap_or_default();
    let folder = std::path::absolute(file)
        .ok()
        .and_then(|file| of(file.parent()?.file_name()));
    match folder {
        Some(folder) if stem == "campaign" => folder,
        _ => stem,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn antenna_calibrations_of_a_configuration_are_inputs() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let write = |name: &str, text: &str| std::fs::write(at(name), text).unwrap();
        write("ppk.conf", "ant1-anttype=*\nfile-rcvantfile=igs.atx\n");
        for name in ["a.mrm", "rover.obs", "base.obs", "igs.atx"] {
            write(name, name);
        }
        let text = "[radar]\nfile = \"a.mrm\"\n[gnss]\nrover = \"rover.obs\"\nbase = \"base.obs\"\n\
                    config = \"ppk.conf\"\n[image]\n\
                    x_m = [0.0, 1.0]\ny_m = [0.0, 1.0]\npixel_m = 0.5\n";
        write("campaign.toml", text);
        let campaign = Campaign::parse(text).unwrap().resolved_in(folder.path());
        let found = record_inputs(&at("campaign.toml"), &campaign).unwrap();
        let names: Vec<_> = found.iter().map(|input| input.path.clone()).collect();
        let expected = [
            "campaign.toml",
            "a.mrm",
            "rover.obs",
            "base.obs",
            "ppk.conf",
            "igs.atx",
        ];
        assert_eq!(names, expected.map(at));
        // Calibrations that neither antenna needs are not read.
        write("ppk.conf", "file-rcvantfile=igs.atx\n");
        let found = record_inputs(&at("campaign.toml"), &campaign).unwrap();
        assert_eq!(found.len(), 5);
        write("ppk.conf", "pos1-elmask=high\n");
        let message = record_inputs(&at("campaign.toml"), &campaign)
            .unwrap_err()
            .to_string();
        assert!(message.contains("ppk.conf: line 1"), "{message}");
    }
}
