//! Stage `read`: the radar log, whatever its format.

mod antenna_frequency;
mod foreign;
pub mod grid;
pub mod inputs;
pub(crate) mod path_text;
pub(crate) mod phase_history;
pub(crate) mod raw;
pub(crate) mod trace_positions;

use std::fs::File;
use std::io::{self, BufReader, Read as _, Seek as _};
use std::path::{Path, PathBuf};

use acerra_formats::Contradiction;
use acerra_radar::quality::{OutlierOptions, scan_outliers};
use acerra_radar::{
    LogRadargram, LoggedClock, LoggedClockError, NeutralContent, NeutralFile, OpenError, RadarFile,
    RadarLog, Radargram, RadargramOptions, RunError, Spectrum,
};

use crate::journal::warnings::Warnings;
use crate::read::foreign::Signal;
use crate::read::phase_history::{PhaseHistoryError, read_phase_history};
use crate::read::trace_positions::TracePositions;

pub use foreign::{ForeignError, Line};
pub use raw::read_raw;

/// Content of the log for the chain.
#[derive(Clone, Debug)]
pub enum RadarContent {
    /// Traces, still to be cleaned.
    Radargram(Radargram),
    /// Spectra, ready for the adjoint.
    Spectrum(Spectrum),
}

impl RadarContent {
    /// Slow time of each trace (s).
    #[must_use]
    pub fn time_s(&self) -> &[f64] {
        match self {
            Self::Radargram(radargram) => &radargram.time_s,
            Self::Spectrum(spectrum) => &spectrum.time_s,
        }
    }
}

impl From<Radargram> for RadarContent {
    fn from(radargram: Radargram) -> Self {
        Self::Radargram(radargram)
    }
}

impl From<Spectrum> for RadarContent {
    fn from(spectrum: Spectrum) -> Self {
        Self::Spectrum(spectrum)
    }
}

/// A radar log as the chain takes it.
#[derive(Clone, Debug)]
pub struct RadarData {
    /// The measurement.
    pub content: RadarContent,
    /// Antenna position of each trace, where the file brings it.
    pub positions: Option<TracePositions>,
    /// Name of the measurement in summaries and pictures.
    pub label: RadarLabel,
    /// The clock recorded with the log. With such a clock, times count seconds of GPS time.
    pub clock: Option<LoggedClock>,
    /// Whether the file states no times: traces are numbered.
    pub is_untimed: bool,
    /// Statements of the file that do not agree.
    pub contradictions: Vec<Contradiction>,
}

/// Name of a radar measurement in summaries and pictures.
#[derive(Clone, Debug)]
pub struct RadarLabel {
    /// Unit of the samples.
    pub unit: &'static str,
    /// One line on the log.
    pub summary: String,
}

impl RadarData {
    /// A measurement in memory; positions are given separately.
    #[must_use]
    pub fn in_memory(content: RadarContent) -> Self {
        let summary = match &content {
            RadarContent::Radargram(radargram) => format!(
                "radargram, {} traces × {} samples",
                radargram.traces, radargram.samples_per_trace
            ),
            RadarContent::Spectrum(spectrum) => format!(
                "spectra, {} traces × {} frequencies",
                spectrum.traces(),
                spectrum.frequency_hz.len()
            ),
        };
        Self {
            content,
            positions: None,
            label: RadarLabel {
                unit: "amplitude",
                summary,
            },
            clock: None,
            is_untimed: false,
            contradictions: Vec::new(),
        }
    }
}

/// Reason why a radar log cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system does not open the file.
    #[error("{}: {cause}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
    /// The content is no radar log, or a damaged one.
    #[error("{}: {cause}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The place in it, what was expected and what was found.
        cause: OpenError,
    },
    /// A file of another maker's radar, or a damaged one.
    #[error("{}: {cause}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// The place in it, what was expected and what was found.
        cause: Box<ForeignError>,
    },
    /// Traces of which neither time nor place is known.
    #[error(
        "{}: expected times or positions of traces in the file, the ends of the line ([radar] line_start_m and \
         line_end_m) or a [trajectory] file with a column trace, found none",
        path.display()
    )]
    NoPlace {
        /// The file.
        path: PathBuf,
    },
    /// Ends of a line are stated for a file that does not need them.
    #[error(
        "{}: [radar] line_start_m: expected a file of traces along a line (SEG-Y, DZT, DT1, rd3, …), found another kind",
        path.display()
    )]
    NoLine {
        /// The file.
        path: PathBuf,
    },
    /// A requested file name that no file has.
    #[error("[radar] files: expected at least one file named {}, found none", pattern.display())]
    NoMatch {
        /// The name, with `*` and `?` for any characters.
        pattern: PathBuf,
    },
    /// A file of a grid that the table of lines does not hold.
    #[error("[radar] lines: expected a row for each file, found none for {}", path.display())]
    NoRow {
        /// The file.
        path: PathBuf,
    },
    /// A row of the table of lines whose file is not among the files.
    #[error("[radar] lines: expected files among those of [radar] files, found {}", path.display())]
    RowWithoutFile {
        /// The row's file.
        path: PathBuf,
    },
    /// Files of a grid with different measurement parameters.
    #[error("{}: {what}: expected {expected} as in {first}, found {found}", path.display())]
    GridDiffers {
        /// The file.
        path: PathBuf,
        /// Difference.
        what: &'static str,
        /// What the first file has.
        expected: Box<str>,
        /// The first file's name.
        first: Box<str>,
        /// What this file has.
        found: Box<str>,
    },
    /// The scans of the log make no radargram.
    #[error("{}: {cause}", path.display())]
    Scans {
        /// The file.
        path: PathBuf,
        /// Cause.
        cause: RunError,
    },
    /// Phase history data that cannot be used.
    #[error("{}: {cause}", path.display())]
    PhaseHistory {
        /// The file.
        path: PathBuf,
        /// The place in it, what was expected and what was found.
        cause: Box<PhaseHistoryError>,
    },
    /// Error of the recorded clock.
    #[error(transparent)]
    Clock(#[from] LoggedClockError),
    /// The campaign uses a recorded clock, and the log has none.
    #[error(
        "{}: [trajectory] time_offset_s = \"logged\": expected the clock of the recording next to the radar \
         log, found none",
        path.display()
    )]
    NoClock {
        /// Path at which the clock is expected.
        path: PathBuf,
    },
    /// A channel is named for a file without channels.
    #[error(
        "{}: [radar] channel: expected a file that has channels (CPHD, SEG-Y, DZT, gprMax, …), found another kind",
        path.display()
    )]
    NoChannels {
        /// The file.
        path: PathBuf,
    },
    /// A neutral file that holds neither times nor places of its traces.
    #[error("{}: expected time_s or position_m with the data, found neither", path.display())]
    NoTime {
        /// The file.
        path: PathBuf,
    },
}

/// Reads a radar log, or the reference channel of phase history data.
///
/// # Errors
/// As [`read_channel`].
pub fn read_radar(path: &Path, warnings: &mut Warnings) -> Result<RadarData, ReadError> {
    read_channel(path, None, None, warnings)
}

/// Reads a radar log, or the named channel of a file that has several; `line` places traces that were recorded along
/// one.
///
/// # Errors
/// A file that is absent, of another kind, cut off before its first whole scan, or hostile; a channel that
/// the file lacks. The message names the file and the place in it.
pub fn read_channel(
    path: &Path,
    channel: Option<&str>,
    line: Option<Line>,
    warnings: &mut Warnings,
) -> Result<RadarData, ReadError> {
    let (kind, file) = kind_of(path)?;
    let path_owned = || path.to_owned();
    match kind {
        Kind::Foreign => return from_foreign(path, channel, line, warnings),
        _ if line.is_some() => return Err(ReadError::NoLine { path: path_owned() }),
        Kind::PhaseHistory => return from_phase_history(path, file, channel, warnings),
        Kind::Own if channel.is_some() => {
            return Err(ReadError::NoChannels { path: path_owned() });
        }
        Kind::Own => {}
    }
    let content = acerra_radar::read(BufReader::new(file), &acerra_radar::Limits::default())
        .map_err(|cause| ReadError::Content {
            path: path_owned(),
            cause,
        })?;
    match content {
        RadarFile::Log(log) => from_log(path, &log, warnings),
        RadarFile::Neutral(neutral) => from_neutral(path, neutral, warnings),
    }
}

/// Whose reader takes a file.
#[derive(Clone, Copy)]
enum Kind {
    /// Reader of other makers' radar files.
    Foreign,
    /// Reader of phase history data.
    PhaseHistory,
    /// Reader of this program's radar and of neutral files.
    Own,
}

/// The kind of a file by its content, and the file at its beginning.
fn kind_of(path: &Path) -> Result<(Kind, File), ReadError> {
    let failed = |cause| ReadError::Open {
        path: path.to_owned(),
        cause,
    };
    let mut file = File::open(path).map_err(failed)?;
    let mut head = Vec::new();
    let read = file.by_ref().take(16).read_to_end(&mut head);
    read.and_then(|_| file.rewind()).map_err(failed)?;
    let kind = if acerra_cphd::is_cphd(&head) {
        Kind::PhaseHistory
    } else if is_foreign(path, &mut file)? {
        Kind::Foreign
    } else {
        Kind::Own
    };
    Ok((kind, file))
}

fn from_foreign(
    path: &Path,
    channel: Option<&str>,
    line: Option<Line>,
    warnings: &mut Warnings,
) -> Result<RadarData, ReadError> {
    let read = foreign::read_foreign(path, channel, line).map_err(|cause| ReadError::Foreign {
        path: path.to_owned(),
        cause: Box::new(cause),
    })?;
    for remark in read.remarks {
        warnings.add(format!("{}: {remark}", name_of(path)));
    }
    let mut data = RadarData::in_memory(match read.signal {
        Signal::Radargram(radargram) => radargram.into(),
        Signal::Spectrum(spectrum) => spectrum.into(),
    });
    data.label.summary = format!("{}, {}", read.format, data.label.summary);
    data.positions = read.positions;
    data.is_untimed = read.is_untimed;
    data.contradictions = read.contradictions;
    Ok(data)
}

/// Whether a file is one of another maker's radar, and no log of this program's own.
fn is_foreign(path: &Path, file: &mut File) -> Result<bool, ReadError> {
    let failed = |cause| ReadError::Open {
        path: path.to_owned(),
        cause,
    };
    let format = acerra_formats::recognise(path).map_err(|cause| ReadError::Foreign {
        path: path.to_owned(),
        cause: Box::new(cause.into()),
    })?;
    let is_own = |head: &[u8]| {
        let read = acerra_radar::read(io::Cursor::new(head), &acerra_radar::Limits::default());
        matches!(read, Ok(RadarFile::Log(_)))
    };
    if format.is_none() {
        return Ok(false);
    }
    let mut head = Vec::new();
    let read = file.by_ref().take(1 << 16).read_to_end(&mut head);
    read.and_then(|_| file.rewind()).map_err(failed)?;
    Ok(!is_own(&head))
}

fn from_log(path: &Path, log: &RadarLog, warnings: &mut Warnings) -> Result<RadarData, ReadError> {
    let mut made = log
        .radargram(&RadargramOptions::default())
        .map_err(|cause| ReadError::Scans {
            path: path.to_owned(),
            cause,
        })?;
    let clock = recorded_clock(path, log, &mut made)?;
    for blemish in log.report.blemishes.iter().take(LISTED_BLEMISHES) {
        let text = format!("{}: {blemish}", name_of(path));
        if blemish.is_end_of_recording() {
            warnings.note(text);
        } else {
            warnings.add(text);
        }
    }
    let more = log
        .report
        .blemish_count
        .saturating_sub(LISTED_BLEMISHES as u64);
    if more > 0 {
        warnings.add(format!("{}: {more} more such places", name_of(path)));
    }
    warn_of_left_out(made.other_scans, warnings);
    let summary = summary(log, &made);
    Ok(RadarData {
        content: RadarContent::Radargram(without_outliers(made.radargram, warnings)),
        positions: None,
        label: RadarLabel {
            unit: "counts",
            summary,
        },
        clock,
        is_untimed: false,
        contradictions: Vec::new(),
    })
}

fn warn_of_left_out(other_scans: usize, warnings: &mut Warnings) {
    warnings.count(
        other_scans,
        "scans of other filterings or windows are in the log and were left out",
    );
}

/// The clock recorded with the log, which places the traces' times on GPS time.
fn recorded_clock(
    path: &Path,
    log: &RadarLog,
    made: &mut LogRadargram,
) -> Result<Option<LoggedClock>, ReadError> {
    let Some(clock) = LoggedClock::next_to(path)? else {
        return Ok(None);
    };
    if let Some(first) = made.run.scans.first().and_then(|&i| log.scans.get(i)) {
        clock.check_traces(path, first.message_id, first.timestamp_ms)?;
    }
    clock.scale(made);
    Ok(Some(clock))
}

fn from_phase_history(
    path: &Path,
    file: File,
    channel: Option<&str>,
    warnings: &mut Warnings,
) -> Result<RadarData, ReadError> {
    let read = read_phase_history(BufReader::new(file), channel).map_err(|cause| {
        ReadError::PhaseHistory {
            path: path.to_owned(),
            cause: Box::new(cause),
        }
    })?;
    for remark in read.remarks {
        warnings.add(format!("{}: {remark}", name_of(path)));
    }
    let mut data = RadarData::in_memory(RadarContent::Spectrum(read.spectrum));
    data.label.summary = read.summary;
    data.positions = Some(read.positions);
    Ok(data)
}

fn from_neutral(
    path: &Path,
    neutral: NeutralFile,
    warnings: &mut Warnings,
) -> Result<RadarData, ReadError> {
    if neutral.time_missing && neutral.position_m.is_none() {
        return Err(ReadError::NoTime {
            path: path.to_owned(),
        });
    }
    for name in &neutral.ignored {
        warnings.note(format!("{}: array {name} is not used", name_of(path)));
    }
    let content = match neutral.content {
        NeutralContent::Radargram(radargram) => RadarContent::Radargram(radargram),
        NeutralContent::Spectrum(spectrum) => RadarContent::Spectrum(spectrum),
    };
    let mut data = RadarData::in_memory(content);
    data.label.summary.insert_str(0, "NPZ ");
    data.is_untimed = neutral.time_missing;
    data.positions = neutral.position_m.map(|position_m| TracePositions {
        antennas_m: neutral.antennas_m,
        ..TracePositions::from(position_m)
    });
    Ok(data)
}

/// The traces without outliers that exceed their neighbours by orders of magnitude.
fn without_outliers(radargram: Radargram, warnings: &mut Warnings) -> Radargram {
    let outliers = scan_outliers(&radargram, &OutlierOptions::default());
    let is_sound = |trace: &usize| outliers.iter().all(|outlier| outlier.trace != *trace);
    let kept: Vec<usize> = (0..radargram.traces).filter(is_sound).collect();
    if kept.len() == radargram.traces || kept.is_empty() {
        return radargram;
    }
    warnings.count(
        outliers.len(),
        "scans exceed their neighbours by orders of magnitude and were left out; trace numbers count the \
         remaining scans",
    );
    radargram.select(&kept).unwrap_or(radargram)
}

/// Places in a log that are named one by one before they are only counted.
const LISTED_BLEMISHES: usize = 5;

fn summary(log: &RadarLog, made: &LogRadargram) -> String {
    format!(
        "{}, {} whole scans × {} samples, {:.3} ms apart{}",
        log.format,
        log.report.whole_scans,
        made.radargram.samples_per_trace,
        made.clock.interval_s * 1e3,
        match made.clock.lost_scans {
            0 => String::new(),
            lost => format!(", {lost} lost between them"),
        }
    )
}

/// The file's own name, for messages in which the directory does not matter.
pub(crate) fn name_of(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}
