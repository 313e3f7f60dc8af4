//! Files of another maker's radar that count their traces along a line, one or several.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use acerra_chain::read::grid::{GridLayout, GridSource};

use super::logs::RadarInput;
use super::named_in;
use crate::settings_files::template::{Filled, quoted};

/// The logs, those once that are named by their samples and by their header.
pub(super) fn distinct(radar: &[RadarInput]) -> Vec<&RadarInput> {
    let mut seen = BTreeSet::new();
    let is_new = |log: &&RadarInput| !log.is_foreign || seen.insert(log.path.with_extension(""));
    radar.iter().filter(is_new).collect()
}

/// The files that the arguments name, with `*` and `?` for any characters where no file has the name itself.
///
/// # Errors
/// A name that no file has.
pub fn expanded(arguments: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for argument in arguments {
        let name = argument.file_name().unwrap_or_default().to_string_lossy();
        if argument.exists() || !name.contains(['*', '?']) {
            files.push(argument.clone());
        } else {
            files.append(&mut matching(argument)?);
        }
    }
    Ok(files)
}

fn matching(pattern: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let source = GridSource {
        patterns: vec![pattern.to_owned()],
        layout: GridLayout::InFiles,
    };
    Ok(source.files()?)
}

/// Several files as `[radar] files` names them: by one name with a star where it matches these files alone,
/// else one by one.
///
/// # Errors
/// A path that TOML cannot hold.
pub(super) fn files_key(folder: &Path, radar: &[&RadarInput]) -> anyhow::Result<Filled> {
    let paths: Vec<&Path> = radar.iter().map(|log| log.path.as_path()).collect();
    let value = match common_pattern(&paths) {
        Some(pattern) => {
            let parent = pattern.parent().unwrap_or(Path::new(""));
            // The pattern is no file: the folder that it lies in is named, and the pattern behind it.
            let named = named_in(folder, parent_or_here(parent))?;
            let name = pattern.file_name().unwrap_or_default().to_string_lossy();
            let is_here = named.is_empty() || named == ".";
            quoted(&if is_here {
                name.into_owned()
            } else {
                Path::new(&named).join(&*name).display().to_string()
            })
        }
        None => {
            let names = paths
                .iter()
                .map(|path| Ok(quoted(&named_in(folder, path)?)));
            let names: Vec<String> = names.collect::<anyhow::Result<_>>()?;
            format!("[{}]", names.join(", "))
        }
    };
    let first = radar.first().map_or("", |log| log.summary.as_str());
    let key = Filled::new("radar.files", value);
    Ok(key.because(format!("{} files, the first {first}", radar.len())))
}

fn parent_or_here(parent: &Path) -> &Path {
    if parent.as_os_str().is_empty() {
        Path::new(".")
    } else {
        parent
    }
}

/// The name with a star that matches these files and no others.
fn common_pattern(paths: &[&Path]) -> Option<PathBuf> {
    let (first, rest) = paths.split_first()?;
    let parent = first.parent()?;
    if rest.iter().any(|path| path.parent() != Some(parent)) {
        return None;
    }
    let names: Vec<Vec<char>> = paths
        .iter()
        .map(|path| Some(path.file_name()?.to_str()?.chars().collect()))
        .collect::<Option<_>>()?;
    let shortest = names.iter().map(Vec::len).min()?;
    let is_same = |at: &dyn Fn(&[char]) -> char| names.iter().all(|n| at(n) == at(&names[0]));
    let before = (0..shortest)
        .take_while(|k| is_same(&|n: &[char]| n[*k]))
        .count();
    let after = (0..shortest - before)
        .take_while(|k| is_same(&|n: &[char]| n[n.len() - 1 - *k]))
        .count();
    let name = &names[0];
    let pattern: String = name[..before]
        .iter()
        .chain(&['*'])
        .chain(&name[name.len() - after..])
        .collect();
    let pattern = parent.join(pattern);
    let found: BTreeSet<PathBuf> = matching(&pattern).ok()?.into_iter().collect();
    let given: BTreeSet<PathBuf> = paths.iter().map(|path| path.to_path_buf()).collect();
    (found == given).then_some(pattern)
}

/// A sentence on the lengths of the lines, as far as the files state them.
pub(super) fn way_said(radar: &[&RadarInput]) -> String {
    let ways: Vec<f64> = radar.iter().filter_map(|log| log.way_m).collect();
    let (low, high) = ways
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(low, high), way| {
            (low.min(*way), high.max(*way))
        });
    match radar {
        _ if ways.len() < radar.len() => "the files give no distance along their lines".to_owned(),
        [_] => format!("the file counts {high:.3} m from the first trace to the last"),
        _ if high - low < 5e-4 => {
            format!("the files count {high:.3} m from the first trace to the last")
        }
        _ => format!("the files count {low:.3} to {high:.3} m from the first trace to the last"),
    }
}

/// Keys for antennas that the files state to be apart: their offset, where the file places the traces itself,
/// and zero-timing by the direct wave between them.
pub(super) fn antennas_apart(radar: &[&RadarInput]) -> Vec<Filled> {
    let Some(apart_m) = radar.first().and_then(|log| log.antenna_separation_m) else {
        return Vec::new();
    };
    if radar
        .iter()
        .any(|log| log.antenna_separation_m != Some(apart_m))
    {
        return Vec::new();
    }
    let offset = radar.iter().all(|log| log.has_positions).then(|| {
        let offset = Filled::new("radar.antenna_offset_m", format!("[{apart_m:?}, 0.0, 0.0]"));
        offset.because(
            "the header gives the distance of transmitter and receiver, not its direction: they are assumed \
             one behind the other along the line",
        )
    });
    let timing = Filled::new("preprocess.zero_timing", "\"direct-wave\"").because(format!(
        "transmitter and receiver are {apart_m} m apart: the direct wave between them, the first arrival, \
         gives the time of range zero; state radar.delay_ns instead where the record begins after it"
    ));
    offset.into_iter().chain([timing]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_by_a_pattern_that_stands_for_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let of = |name: &str| folder.path().join(name);
        for name in ["line-1.rd3", "line-2.rd3", "line-10.rd3", "note.rd3"] {
            std::fs::write(of(name), "").unwrap();
        }
        let all = ["line-1.rd3", "line-2.rd3", "line-10.rd3"].map(of);
        let paths: Vec<&Path> = all.iter().map(PathBuf::as_path).collect();
        assert_eq!(common_pattern(&paths), Some(of("line-*.rd3")));
        // Without one of these files the pattern would match further files.
        assert_eq!(common_pattern(&paths[..2]), None);
        let found = expanded(&[of("line-?.rd3"), of("note.rd3")]).unwrap();
        assert_eq!(found, ["line-1.rd3", "line-2.rd3", "note.rd3"].map(of));
        assert!(expanded(&[of("other-*.rd3")]).is_err());
    }
}
