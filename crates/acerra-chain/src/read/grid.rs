//! Several files as one recording: the lines of a grid over one area.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use acerra_formats::Contradiction;
use acerra_geo::trajectory::Frame;
use acerra_radar::{Radargram, Samples, Spectrum};

use super::foreign::Line;
use super::trace_positions::TracePositions;
use super::{RadarContent, RadarData, ReadError, name_of, read_channel};
use crate::journal::warnings::Warnings;

/// The files of a grid, and where their lines lie.
#[derive(Clone, Debug, PartialEq)]
pub struct GridSource {
    /// Files; `*` and `?` in a file's name match any characters.
    pub patterns: Vec<PathBuf>,
    /// Position of the lines.
    pub layout: GridLayout,
}

/// Position of the lines of a grid.
#[derive(Clone, Debug, PartialEq)]
pub enum GridLayout {
    /// The files place their traces.
    InFiles,
    /// Parallel lines, in the order of the numbers in the files' names.
    Regular {
        /// The first line.
        first: Line,
        /// From each line to the next: x, y, z (m).
        step_m: [f64; 3],
    },
    /// One line for each file.
    Table(Vec<(PathBuf, Line)>),
}

impl GridSource {
    /// The files, in the order of the numbers in their names. A header next to its samples is no separate
    /// file.
    ///
    /// # Errors
    /// A pattern that no file matches, a folder that cannot be listed.
    pub fn files(&self) -> Result<Vec<PathBuf>, ReadError> {
        let mut files = Vec::new();
        for pattern in &self.patterns {
            let mut found = matching(pattern)?;
            if found.is_empty() {
                return Err(ReadError::NoMatch {
                    pattern: pattern.clone(),
                });
            }
            files.append(&mut found);
        }
        files.sort_by(|a, b| in_natural_order(a, b));
        files.dedup();
        // Samples and header have the same name up to the last dot.
        files.dedup_by(|a, b| a.with_extension("") == b.with_extension(""));
        Ok(files)
    }

    /// The line of file `k` of several.
    fn line_of(&self, k: usize, path: &Path) -> Result<Option<Line>, ReadError> {
        match &self.layout {
            GridLayout::InFiles => Ok(None),
            GridLayout::Regular { first, step_m } => {
                let moved = |p: [f64; 3]| [0, 1, 2].map(|i| p[i] + k as f64 * step_m[i]);
                Ok(Some(Line {
                    start_m: moved(first.start_m),
                    end_m: moved(first.end_m),
                }))
            }
            GridLayout::Table(rows) => {
                let row = rows.iter().find(|(file, _)| {
                    file == path || file.with_extension("") == path.with_extension("")
                });
                row.map(|(_, line)| Some(*line))
                    .ok_or_else(|| ReadError::NoRow {
                        path: path.to_owned(),
                    })
            }
        }
    }
}

/// Reads the files of a grid as one recording, trace after trace in the order of [`GridSource::files`]: lines, or one trace
/// or sweep a file.
///
/// # Errors
/// A file that cannot be read, whose samples or frequencies differ from the first file's, files of which some
/// alone place their traces; a row of the table whose file is not among the files.
pub fn read_grid(
    source: &GridSource,
    channel: Option<&str>,
    warnings: &mut Warnings,
) -> Result<RadarData, ReadError> {
    let files = source.files()?;
    if let GridLayout::Table(rows) = &source.layout {
        let stem = |path: &Path| path.with_extension("");
        let is_missing =
            |row: &&(PathBuf, Line)| files.iter().all(|file| stem(file) != stem(&row.0));
        if let Some((path, _)) = rows.iter().find(is_missing) {
            return Err(ReadError::RowWithoutFile { path: path.clone() });
        }
    }
    let mut remarks = Vec::new();
    let mut joined: Option<Joined> = None;
    for (k, path) in files.iter().enumerate() {
        let mut own = Warnings::default();
        let line = source.line_of(k, path)?;
        let data = read_channel(path, channel, line, &mut own)?;
        let prefix = format!("{}: ", name_of(path));
        let texts = own.said().iter();
        remarks.extend(texts.map(|t| t.strip_prefix(&prefix).unwrap_or(t).to_owned()));
        own.notes().iter().for_each(|note| warnings.note(note));
        match &mut joined {
            None => joined = Some(Joined::new(path, data)),
            Some(joined) => joined.add(path, data)?,
        }
    }
    warn_once(remarks, files.len(), warnings);
    let joined = joined.ok_or_else(|| ReadError::NoMatch {
        pattern: source.patterns.first().cloned().unwrap_or_default(),
    })?;
    Ok(joined.into_data(files.len()))
}

/// A remark that several files share appears once.
fn warn_once(mut remarks: Vec<String>, files: usize, warnings: &mut Warnings) {
    remarks.sort();
    for same in remarks.chunk_by(|a, b| a == b) {
        warnings.add(format!(
            "{} of {files} radar files: {}",
            same.len(),
            same[0]
        ));
    }
}

/// The traces of the files so far.
struct Joined {
    content: RadarContent,
    /// None where no file has positions.
    places: Option<TracePositions>,
    first: RadarData,
    first_path: PathBuf,
    /// Whether every file holds a single trace, so that the files are no lines.
    is_of_single_traces: bool,
}

impl Joined {
    fn new(path: &Path, mut data: RadarData) -> Self {
        let content = taken(&mut data.content);
        Self {
            is_of_single_traces: content.time_s().len() == 1,
            content,
            places: data.positions.take(),
            first: data,
            first_path: path.to_owned(),
        }
    }

    fn add(&mut self, path: &Path, mut data: RadarData) -> Result<(), ReadError> {
        let first_path = self.first_path.clone();
        let differs = |what, expected: &str, found: &str| ReadError::GridDiffers {
            path: path.to_owned(),
            what,
            expected: expected.into(),
            first: name_of(&first_path).into(),
            found: found.into(),
        };
        let before = self.content.time_s().len();
        self.is_of_single_traces &= data.content.time_s().len() == 1;
        match (&mut self.content, taken(&mut data.content)) {
            (RadarContent::Radargram(all), RadarContent::Radargram(own)) => {
                append_traces(all, own, &differs)?;
            }
            (RadarContent::Spectrum(all), RadarContent::Spectrum(own)) => {
                append_sweeps(all, own, &differs)?;
            }
            (RadarContent::Radargram(_), _) => {
                return Err(differs("traces", "over fast time", "spectra"));
            }
            (RadarContent::Spectrum(_), _) => {
                return Err(differs("traces", "spectra", "traces over fast time"));
            }
        }
        match (&mut self.places, data.positions.take()) {
            (Some(all), Some(own)) => append_places(all, own, before, &differs)?,
            (None, None) => {}
            (Some(_), None) => return Err(differs("positions", "one for each trace", "none")),
            (None, Some(_)) => return Err(differs("positions", "none", "one for each trace")),
        }
        for found in data.contradictions {
            let known = &mut self.first.contradictions;
            match known.iter_mut().find(|c| c.about == found.about) {
                None => known.push(found),
                Some(one) if off(&found) > off(one) => *one = found,
                Some(_) => {}
            }
        }
        Ok(())
    }

    fn into_data(self, files: usize) -> RadarData {
        // The clock of every file starts at zero again.
        let numbered = |traces: usize| (0..traces).map(|i| i as f64).collect();
        let mut content = self.content;
        let traces = content.time_s().len();
        match &mut content {
            RadarContent::Radargram(radargram) => radargram.time_s = numbered(traces),
            RadarContent::Spectrum(spectrum) => spectrum.time_s = numbered(traces),
        }
        let mut data = self.first;
        data.label.summary = format!(
            "{files} files, {traces} traces, first {}",
            data.label.summary
        );
        data.content = content;
        data.positions = self.places;
        if let Some(places) = &mut data.positions
            && self.is_of_single_traces
        {
            places.line_starts.clear();
        }
        data.is_untimed = true;
        data
    }
}

/// An error on what differs: what, expected, found.
type Differs<'a> = &'a dyn Fn(&'static str, &str, &str) -> ReadError;

fn append_traces(
    all: &mut Radargram,
    own: Radargram,
    differs: Differs<'_>,
) -> Result<(), ReadError> {
    if own.samples_per_trace != all.samples_per_trace {
        return Err(differs(
            "samples of a trace",
            &all.samples_per_trace.to_string(),
            &own.samples_per_trace.to_string(),
        ));
    }
    let ps = |s: f64| format!("{:.4} ps", 1e12 * s);
    let window_s = all.fast_time_step_s * all.samples_per_trace as f64;
    // A fiftieth of a sample at the end of the trace.
    let drift = (own.fast_time_step_s / all.fast_time_step_s - 1.0).abs();
    if drift * all.samples_per_trace as f64 > 0.02 {
        return Err(differs(
            "sample interval",
            &ps(all.fast_time_step_s),
            &ps(own.fast_time_step_s),
        ));
    }
    if (own.fast_time_start_s - all.fast_time_start_s).abs() > 1e-6 * window_s {
        return Err(differs(
            "fast time of the first sample",
            &ps(all.fast_time_start_s),
            &ps(own.fast_time_start_s),
        ));
    }
    match (&mut all.samples, own.samples) {
        (Samples::Real(all), Samples::Real(mut more)) => all.append(&mut more),
        (Samples::Complex(all), Samples::Complex(mut more)) => all.append(&mut more),
        (Samples::Real(_), _) => return Err(differs("samples", "real", "complex")),
        (Samples::Complex(_), _) => return Err(differs("samples", "complex", "real")),
    }
    all.traces += own.traces;
    all.time_s.extend(own.time_s);
    Ok(())
}

fn append_sweeps(
    all: &mut Spectrum,
    mut own: Spectrum,
    differs: Differs<'_>,
) -> Result<(), ReadError> {
    let (expected, found) = (&all.frequency_hz, &own.frequency_hz);
    if found.len() != expected.len() {
        let [expected, found] = [expected, found].map(|hz| hz.len().to_string());
        return Err(differs("frequencies", &expected, &found));
    }
    // A millionth of a turn over a delay of a hundred nanoseconds.
    const MOST_HZ: f64 = 10.0;
    let other = expected
        .iter()
        .zip(found)
        .find(|(a, b)| (*a - *b).abs() > MOST_HZ);
    if let Some((expected, found)) = other {
        let [expected, found] = [expected, found].map(|hz| format!("{hz} Hz"));
        return Err(differs("frequency", &expected, &found));
    }
    all.values.append(&mut own.values);
    all.time_s.append(&mut own.time_s);
    Ok(())
}

fn append_places(
    all: &mut TracePositions,
    mut own: TracePositions,
    before: usize,
    differs: Differs<'_>,
) -> Result<(), ReadError> {
    if let Frame::Enu(frame) = &all.frame {
        own = own.in_frame(*frame);
    }
    if (own.frame == Frame::Local) != (all.frame == Frame::Local) {
        return Err(differs("positions", "in the same frame", "another frame"));
    }
    match (&mut all.antennas_m, own.antennas_m) {
        (Some(all), Some(more)) => {
            for (all, more) in all.iter_mut().zip(more) {
                all.extend(more);
            }
        }
        (None, None) => {}
        (Some(_), None) => return Err(differs("antennas", "apart", "one place for both")),
        (None, Some(_)) => return Err(differs("antennas", "one place for both", "apart")),
    }
    all.line_starts.push(before);
    all.position_m.append(&mut own.position_m);
    Ok(())
}

/// Difference between two statements, as a share of the greater.
fn off(found: &Contradiction) -> f64 {
    let greater = found.used.abs().max(found.other.abs());
    (found.used - found.other).abs() / greater.max(f64::MIN_POSITIVE)
}

/// The content of a log, which is left empty.
fn taken(content: &mut RadarContent) -> RadarContent {
    let nothing = Spectrum {
        frequency_hz: Vec::new(),
        values: Vec::new(),
        time_s: Vec::new(),
    };
    std::mem::replace(content, nothing.into())
}

/// Files whose names match a pattern; a pattern without `*` and `?` is the name of one file.
fn matching(pattern: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let name = pattern.file_name().unwrap_or_default().to_string_lossy();
    if !name.contains(['*', '?']) {
        return Ok(vec![pattern.to_owned()]);
    }
    let folder = pattern.parent().filter(|p| !p.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let failed = |cause| ReadError::Open {
        path: folder.to_owned(),
        cause,
    };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let own = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_file() && is_match(name.as_bytes(), own.as_bytes()) {
            found.push(path);
        }
    }
    Ok(found)
}

/// Whether `name` matches `pattern`.
fn is_match(pattern: &[u8], name: &[u8]) -> bool {
    // The last star, and the length of the name that it matches.
    let (mut p, mut n) = (0, 0);
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        match pattern.get(p) {
            Some(b'*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(c) if *c == b'?' || *c == name[n] => {
                p += 1;
                n += 1;
            }
            _ => match &mut star {
                Some((at, taken)) => {
                    *taken += 1;
                    (p, n) = (*at + 1, *taken);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|c| *c == b'*')
}

/// By name, numbers in names by their value: line-2 before line-10.
pub fn in_natural_order(a: &Path, b: &Path) -> Ordering {
    let parts = |path: &Path| -> Vec<(u128, String)> {
        let text = path.to_string_lossy().into_owned();
        let is_digit = |c: &char| c.is_ascii_digit();
        let chars: Vec<char> = text.chars().collect();
        let runs = chars.chunk_by(|a, b| is_digit(a) == is_digit(b));
        runs.map(|run| {
            let run: String = run.iter().collect();
            (run.parse().unwrap_or(u128::MAX), run)
        })
        .collect()
    };
    let by_part = parts(a)
        .into_iter()
        .zip(parts(b))
        .map(|(a, b)| a.0.cmp(&b.0).then_with(|| a.1.cmp(&b.1)))
        .find(|order| order.is_ne());
    by_part.unwrap_or_else(|| a.cmp(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_match_patterns_and_sort_by_their_numbers() {
        for (pattern, name, expected) in [
            ("line-*.rd3", "line-1.rd3", true),
            ("line-*.rd3", "line-1.rad", false),
            ("*", "anything", true),
            ("a*b*c", "aXbYbZc", true),
            ("a*b*c", "aXbYbZ", false),
            ("line-?.rd3", "line-10.rd3", false),
        ] {
            let found = is_match(pattern.as_bytes(), name.as_bytes());
            assert_eq!(found, expected, "{pattern} {name}");
        }
        let mut names = ["line-10.rd3", "line-9.rd3", "line-1.rd3"].map(PathBuf::from);
        names.sort_by(|a, b| in_natural_order(a, b));
        assert_eq!(
            names,
            ["line-1.rd3", "line-9.rd3", "line-10.rd3"].map(PathBuf::from)
        );
    }
}
