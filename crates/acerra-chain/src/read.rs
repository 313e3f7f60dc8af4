//! Stage `read`: the radar log, whatever its format.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use acerra_radar::{
    LogRadargram, NeutralContent, RadarFile, Radargram, RadargramOptions, Spectrum,
};
use anyhow::Context;

use super::warnings::Warnings;

/// What the log holds for the chain.
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

/// A radar log as the chain takes it.
#[derive(Clone, Debug)]
pub struct RadarData {
    /// The measurement.
    pub content: RadarContent,
    /// Antenna position of each trace, where the file brings it (m).
    pub position_m: Option<Vec<[f64; 3]>>,
    /// Unit of the samples, for pictures.
    pub unit: &'static str,
    /// One line on what was read.
    pub summary: String,
}

/// Reads a radar log.
///
/// # Errors
/// A file that is absent, of another kind, cut off before its first whole scan, or hostile; the
/// message names the file and the place in it.
pub fn read_radar(path: &Path, warnings: &mut Warnings) -> anyhow::Result<RadarData> {
    let file = File::open(path).with_context(|| format!("{}", path.display()))?;
    let read = acerra_radar::read(BufReader::new(file), &acerra_radar::Limits::default())
        .with_context(|| format!("{}", path.display()))?;
    match read {
        RadarFile::Log(log) => {
            let made = log
                .radargram(&RadargramOptions::default())
                .with_context(|| format!("{}", path.display()))?;
            for blemish in log.report.blemishes.iter().take(LISTED_BLEMISHES) {
                warnings.add(format!("{}: {blemish}", name_of(path)));
            }
            let more = log
                .report
                .blemish_count
                .saturating_sub(LISTED_BLEMISHES as u64);
            if more > 0 {
                warnings.add(format!("{}: {more} more such places", name_of(path)));
            }
            warnings.count(
                made.other_scans,
                "scans of other filterings or windows are in the log and were left out",
            );
            let summary = summary(&log, &made);
            Ok(RadarData {
                content: RadarContent::Radargram(made.radargram),
                position_m: None,
                unit: "counts",
                summary,
            })
        }
        RadarFile::Neutral(neutral) => {
            if neutral.time_missing && neutral.position_m.is_none() {
                anyhow::bail!(
                    "{}: expected time_s or position_m beside the data, found neither",
                    path.display()
                );
            }
            for name in &neutral.ignored {
                warnings.add(format!("{}: array {name} is not used", name_of(path)));
            }
            let (content, summary) = match neutral.content {
                NeutralContent::Radargram(radargram) => {
                    let summary = format!(
                        "NPZ radargram, {} traces × {} samples",
                        radargram.traces, radargram.samples_per_trace
                    );
                    (RadarContent::Radargram(radargram), summary)
                }
                NeutralContent::Spectrum(spectrum) => {
                    let summary = format!(
                        "NPZ spectra, {} traces × {} frequencies",
                        spectrum.traces(),
                        spectrum.frequency_hz.len()
                    );
                    (RadarContent::Spectrum(spectrum), summary)
                }
            };
            Ok(RadarData {
                content,
                position_m: neutral.position_m,
                unit: "amplitude",
                summary,
            })
        }
    }
}

/// Places in a log that are named one by one before they are only counted.
const LISTED_BLEMISHES: usize = 5;

fn summary(log: &acerra_radar::RadarLog, made: &LogRadargram) -> String {
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
