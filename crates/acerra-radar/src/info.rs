//! What a radar file holds, in numbers.

use crate::clean::envelope;
use crate::clock::ClockBasis;
use crate::log::{LogFormat, RadarLog};
use crate::mrm::RadarConfig;
use crate::npz::{NeutralContent, NeutralFile};
use crate::open::RadarFile;
use crate::radargram::Radargram;
use crate::report::ReadReport;
use crate::runs::{RadargramOptions, RunError};
use crate::scan::{Filtering, ScanWindow};

/// Kinds of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// A log of scans.
    Log(LogFormat),
    /// A neutral NPZ file with a radargram.
    NeutralRadargram,
    /// A neutral NPZ file with spectra.
    NeutralSpectrum,
}

impl FileKind {
    /// Name for people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Log(LogFormat::Mrm) => "MRM capture",
            Self::Log(LogFormat::MrmRet) => "MRM-RET text log",
            Self::NeutralRadargram => "neutral NPZ, radargram",
            Self::NeutralSpectrum => "neutral NPZ, spectra",
        }
    }
}

/// Levels of a radargram.
///
/// The noise is estimated from differences between neighbouring traces (what is constant cancels) in
/// the quietest tenth of fast time, where no echo moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Levels {
    /// Largest envelope, in the samples' own units.
    pub peak: f64,
    /// Fast time of the largest envelope, s.
    pub peak_fast_time_s: f64,
    /// Root mean square of all samples relative to the peak, dB.
    pub rms_db: f64,
    /// Noise (standard deviation of one sample) relative to the peak, dB; `None` with fewer than
    /// three traces or without noise.
    pub noise_db: Option<f64>,
}

/// A log's own facts, beyond its radargram's.
#[derive(Debug, Clone, PartialEq)]
pub struct LogInfo {
    /// Scans of each filtering, with the number of runs they make.
    pub filterings: Vec<(Filtering, usize, usize)>,
    /// The window in the radio's integers.
    pub window: ScanWindow,
    /// Filtering of the radargram.
    pub filtering: Filtering,
    /// Antenna the scans were received on.
    pub antenna_id: u8,
    /// The radio's configuration, where the log states it.
    pub config: Option<RadarConfig>,
    /// What the trace times rest on.
    pub clock: ClockBasis,
    /// Scans the radio made that are not in the log.
    pub lost_scans: u64,
    /// Pauses and other breaks of the even clock.
    pub clock_breaks: usize,
    /// Root mean square of stamps less recovered times, s.
    pub clock_residual_rms_s: f64,
    /// Interval asked of the radio, µs.
    pub requested_interval_us: Option<u32>,
    /// The account of reading.
    pub report: ReadReport,
}

/// Summary of a radar file.
#[derive(Debug, Clone, PartialEq)]
pub struct FileInfo {
    /// Kind of file.
    pub kind: FileKind,
    /// Traces (of the run that a radargram is made of).
    pub traces: usize,
    /// Samples a trace, or frequencies.
    pub samples_per_trace: usize,
    /// Whether samples are complex.
    pub complex: bool,
    /// First and last fast time, s.
    pub fast_time_s: Option<[f64; 2]>,
    /// Spacing of samples, s.
    pub fast_time_step_s: Option<f64>,
    /// Lowest and highest frequency, Hz (spectra).
    pub frequency_hz: Option<[f64; 2]>,
    /// Time from the first to the last trace, s.
    pub duration_s: f64,
    /// Median time between traces, s.
    pub interval_s: f64,
    /// Whether every trace has a position.
    pub has_positions: bool,
    /// Levels (radargrams).
    pub levels: Option<Levels>,
    /// What only a log states.
    pub log: Option<LogInfo>,
}

/// Summarises a file as read.
///
/// # Errors
/// If a log's scans make no radargram.
pub fn file_info(file: &RadarFile) -> Result<FileInfo, RunError> {
    match file {
        RadarFile::Log(log) => log_info(log),
        RadarFile::Neutral(neutral) => Ok(neutral_info(neutral)),
    }
}

fn log_info(log: &RadarLog) -> Result<FileInfo, RunError> {
    let made = log.radargram(&RadargramOptions::default())?;
    let mut kinds: Vec<Filtering> = log.scans.iter().map(|s| s.filtering).collect();
    kinds.sort();
    kinds.dedup();
    let count = |f: Filtering| log.scans.iter().filter(|s| s.filtering == f).count();
    let mut info = radargram_info(FileKind::Log(log.format), &made.radargram);
    info.interval_s = made.clock.interval_s;
    info.log = Some(LogInfo {
        filterings: kinds
            .into_iter()
            .map(|f| (f, count(f), log.runs(f).len()))
            .collect(),
        window: made.run.window,
        filtering: made.run.filtering,
        antenna_id: made.run.antenna_id,
        config: made.run.config,
        clock: made.clock.basis,
        lost_scans: made.clock.lost_scans,
        clock_breaks: made.clock.stretches.len().saturating_sub(1),
        clock_residual_rms_s: made.clock.residual_rms_s,
        requested_interval_us: log.requested_interval_us,
        report: log.report.clone(),
    });
    Ok(info)
}

fn neutral_info(neutral: &NeutralFile) -> FileInfo {
    let mut info = match &neutral.content {
        NeutralContent::Radargram(r) => radargram_info(FileKind::NeutralRadargram, r),
        NeutralContent::Spectrum(s) => {
            let low = s.frequency_hz.iter().copied().fold(f64::INFINITY, f64::min);
            let high = s
                .frequency_hz
                .iter()
                .copied()
                .fold(f64::NEG_INFINITY, f64::max);
            FileInfo {
                kind: FileKind::NeutralSpectrum,
                traces: s.traces(),
                samples_per_trace: s.frequency_hz.len(),
                complex: true,
                fast_time_s: None,
                fast_time_step_s: None,
                frequency_hz: Some([low, high]),
                duration_s: duration(&s.time_s),
                interval_s: median_interval(&s.time_s),
                has_positions: false,
                levels: None,
                log: None,
            }
        }
    };
    info.has_positions = neutral.position_m.is_some();
    info
}

fn radargram_info(kind: FileKind, radargram: &Radargram) -> FileInfo {
    FileInfo {
        kind,
        traces: radargram.traces,
        samples_per_trace: radargram.samples_per_trace,
        complex: radargram.samples.is_complex(),
        fast_time_s: Some([radargram.fast_time_start_s, radargram.fast_time_end_s()]),
        fast_time_step_s: Some(radargram.fast_time_step_s),
        frequency_hz: None,
        duration_s: duration(&radargram.time_s),
        interval_s: median_interval(&radargram.time_s),
        has_positions: false,
        levels: levels(radargram),
        log: None,
    }
}

fn duration(time_s: &[f64]) -> f64 {
    match (time_s.first(), time_s.last()) {
        (Some(first), Some(last)) => last - first,
        _ => 0.0,
    }
}

fn median_interval(time_s: &[f64]) -> f64 {
    let mut intervals: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    intervals.sort_by(f64::total_cmp);
    intervals.get(intervals.len() / 2).copied().unwrap_or(0.0)
}

/// Levels of a radargram; `None` if every sample is zero.
#[must_use]
pub fn levels(radargram: &Radargram) -> Option<Levels> {
    let n = radargram.samples_per_trace;
    let envelope = envelope(radargram);
    let at = (0..envelope.len()).max_by(|&a, &b| envelope[a].total_cmp(&envelope[b]))?;
    let peak = envelope[at];
    if peak <= 0.0 {
        return None;
    }
    let energy: f64 = (0..envelope.len())
        .map(|i| radargram.samples.at(i).norm_sqr())
        .sum();
    let rms = (energy / envelope.len() as f64).sqrt();
    let decibel = |ratio: f64| 20.0 * ratio.log10();
    let noise_db = (radargram.traces >= 3)
        .then(|| noise(radargram))
        .filter(|noise| *noise > 0.0)
        .map(|noise| decibel(noise / peak));
    Some(Levels {
        peak,
        peak_fast_time_s: radargram.fast_time_s(at % n),
        rms_db: decibel(rms / peak),
        noise_db,
    })
}

/// Standard deviation of the noise on one sample: second differences over traces, column by
/// column, median over traces, and the tenth part of columns that is quietest.
fn noise(radargram: &Radargram) -> f64 {
    /// Median of |N(0, 1)|.
    const MEDIAN_ABS: f64 = 0.674_489_750_196_081_7;
    let n = radargram.samples_per_trace;
    let mut columns: Vec<f64> = (0..n)
        .map(|j| {
            let at = |m: usize| radargram.at(m, j).re;
            let mut differences: Vec<f64> = (2..radargram.traces)
                .map(|m| (at(m) - 2.0 * at(m - 1) + at(m - 2)).abs() / 6f64.sqrt())
                .collect();
            differences.sort_by(f64::total_cmp);
            differences[differences.len() / 2] / MEDIAN_ABS
        })
        .collect();
    columns.sort_by(f64::total_cmp);
    // The middle of the quietest tenth.
    columns[n / 20]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radargram::Samples;

    #[test]
    fn levels_of_a_known_signal() {
        let (traces, n) = (400, 200);
        let mut state = 7u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        // Noise of standard deviation 1 (sum of twelve), a constant echo of 1000 at sample 60.
        let samples = (0..traces * n)
            .map(|i| {
                let noise: f64 = (0..12).map(|_| uniform()).sum();
                let echo = if i % n == 60 { 1000.0 } else { 0.0 };
                (echo + noise) as f32
            })
            .collect();
        let time_s = (0..traces).map(|m| 0.05 * m as f64).collect();
        let r = Radargram::new(time_s, 0.0, 1e-10, Samples::Real(samples)).unwrap();
        let levels = levels(&r).unwrap();
        assert!((levels.peak_fast_time_s - 6e-9).abs() < 1e-15);
        assert!((levels.noise_db.unwrap() + 60.0).abs() < 1.5, "{levels:?}");
        assert!(
            (levels.rms_db + 20.0 * 200f64.sqrt().log10()).abs() < 0.2,
            "{levels:?}"
        );
        assert!((median_interval(&r.time_s) - 0.05).abs() < 1e-12);
    }

    #[test]
    fn silence_has_no_levels() {
        let r = Radargram::new(vec![0.0], 0.0, 1.0, Samples::Real(vec![0.0; 8])).unwrap();
        assert_eq!(levels(&r), None);
    }
}
