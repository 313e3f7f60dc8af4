//! Scans that are outliers among their neighbours.

use std::fmt;

use rayon::prelude::*;

use super::median;
use crate::radargram::Radargram;

/// Thresholds of an outlier.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct OutlierOptions {
    /// Number of scans to each side for comparison.
    pub neighbours: usize,
    /// Ratio of energies, in dB, from which a scan is an outlier in either direction.
    pub energy_db: f64,
    /// Ratio of largest samples, in dB, from which a scan is an outlier.
    pub peak_db: f64,
}

impl Default for OutlierOptions {
    /// 25 scans to each side, two orders of magnitude in energy, one and a half in amplitude:
    /// coupling keeps the energy of sound scans within a few dB of each other.
    fn default() -> Self {
        Self {
            neighbours: 25,
            energy_db: 20.0,
            peak_db: 30.0,
        }
    }
}

/// Reason why a scan is an outlier.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum OutlierKind {
    /// A sample is NaN or infinite.
    NotFinite {
        /// The first such sample.
        sample: usize,
    },
    /// All samples are equal: nothing was received.
    Dead,
    /// Energy far from the neighbours'.
    Energy {
        /// Energy over the neighbours' median, dB.
        ratio_db: f64,
    },
    /// The largest sample is far above the neighbours'.
    Peak {
        /// Largest sample over the neighbours' median, dB.
        ratio_db: f64,
    },
}

impl fmt::Display for OutlierKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { sample } => write!(f, "sample {sample} is not a finite number"),
            Self::Dead => f.write_str("all samples are equal"),
            Self::Energy { ratio_db } => {
                write!(f, "energy {ratio_db:+.0} dB from that of its neighbours")
            }
            Self::Peak { ratio_db } => {
                write!(
                    f,
                    "largest sample {ratio_db:+.0} dB from that of its neighbours"
                )
            }
        }
    }
}

/// A scan that is an outlier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanOutlier {
    /// The trace.
    pub trace: usize,
    /// Cause.
    pub kind: OutlierKind,
}

impl fmt::Display for ScanOutlier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "trace {}: {}", self.trace, self.kind)
    }
}

/// Energy about the mean and largest modulus of one trace.
#[derive(Clone, Copy)]
struct Size {
    energy: f64,
    peak: f64,
}

/// Traces that a working radar cannot have recorded among their neighbours, in order.
///
/// Each trace is compared with the median of the traces about it, so that a burst of bad traces (up to the
/// number of neighbours to one side) is found too.
///
/// ```
/// use acerra_radar::quality::{OutlierKind, OutlierOptions, scan_outliers};
/// use acerra_radar::{Radargram, Samples};
/// let mut samples: Vec<f32> = (0..400).map(|i| ((i * i) as f32 * 0.7).sin()).collect();
/// samples[123..125].copy_from_slice(&[2e9, -1e9]); // foreign bytes in trace 12
/// samples[200..210].fill(0.0); // trace 20 is dead
/// let time_s = (0..40).map(f64::from).collect();
/// let radargram = Radargram::new(time_s, 0.0, 1e-9, Samples::Real(samples))?;
/// let found = scan_outliers(&radargram, &OutlierOptions::default());
/// assert_eq!(found.iter().map(|o| o.trace).collect::<Vec<_>>(), [12, 20]);
/// assert_eq!(found[1].kind, OutlierKind::Dead);
/// # Ok::<(), acerra_radar::RadargramError>(())
/// ```
#[must_use]
pub fn scan_outliers(radargram: &Radargram, options: &OutlierOptions) -> Vec<ScanOutlier> {
    let sizes: Vec<Result<Size, OutlierKind>> = (0..radargram.traces)
        .into_par_iter()
        .map(|trace| size(radargram, trace))
        .collect();
    (0..radargram.traces)
        .filter_map(|trace| {
            let kind = match sizes[trace] {
                Err(OutlierKind::Dead) | Ok(_) if radargram.traces < 3 => return None,
                Err(kind) => kind,
                Ok(own) => compare(own, &about(&sizes, trace, options.neighbours), options)?,
            };
            Some(ScanOutlier { trace, kind })
        })
        .collect()
}

fn size(radargram: &Radargram, trace: usize) -> Result<Size, OutlierKind> {
    let samples = radargram.trace(trace);
    if let Some(sample) = samples
        .iter()
        .position(|z| !z.re.is_finite() || !z.im.is_finite())
    {
        return Err(OutlierKind::NotFinite { sample });
    }
    if samples.iter().all(|z| *z == samples[0]) {
        // A constant far from zero comes from foreign bytes or a dead receiver: neither is a scan.
        return Err(OutlierKind::Dead);
    }
    let energy = samples.iter().map(|z| z.norm_sqr()).sum();
    let peak = samples.iter().map(|z| z.norm()).fold(0.0, f64::max);
    Ok(Size { energy, peak })
}

/// The valid traces about one trace, without that trace.
fn about(sizes: &[Result<Size, OutlierKind>], trace: usize, neighbours: usize) -> Vec<Size> {
    let first = trace.saturating_sub(neighbours);
    let end = (trace + neighbours + 1).min(sizes.len());
    (first..end)
        .filter(|&i| i != trace)
        .filter_map(|i| sizes[i].ok())
        .collect()
}

fn compare(own: Size, others: &[Size], options: &OutlierOptions) -> Option<OutlierKind> {
    if others.len() < 2 {
        return None;
    }
    let middle = |of: fn(&Size) -> f64| median(&others.iter().map(of).collect::<Vec<_>>());
    let energy_db = 10.0 * (own.energy / middle(|s| s.energy)).log10();
    if energy_db.abs() >= options.energy_db {
        return Some(OutlierKind::Energy {
            ratio_db: energy_db,
        });
    }
    let peak_db = 20.0 * (own.peak / middle(|s| s.peak)).log10();
    (peak_db >= options.peak_db).then_some(OutlierKind::Peak { ratio_db: peak_db })
}
