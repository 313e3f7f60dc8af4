//! The codes' true noise and its correlation in time, measured from code minus phase.
//!
//! Code minus phase of one satellite is free of geometry and clocks. Differenced between rover and
//! base it is free of the ionosphere too: what changes in it while no cycle slips is code noise
//! and multipath. Half the mean square of its change over a lag τ is σ²·(1 − ρ(τ)), the
//! semivariogram: its sill is the variance, and the way there is the autocorrelation ρ.
//!
//! Multipath lasts for minutes at a receiver that stands and for seconds at one that flies. Taken
//! for white noise it would average out ten times faster than it does, and float ambiguities would
//! be called certain that are cycles off. A constant that is estimated from n samples of such
//! noise gains from the first sample 1/σ², and from each later one 1/(σ²·(1 + 2Σρ)): the sum over
//! lags of the sampling interval.

use super::constellation::Constellation;
use super::measurement::{Epoch, Measurement};
use super::noise::{Separation, SignalView, single_difference_variance_m2, weak_signal_factor};
use super::outliers::median;
use super::pass::matching_base;
use crate::geometry::{azimuth_elevation_rad, line_of_sight};
use crate::options::PpkOptions;
use crate::satellite::System;
use crate::signal::{FREQUENCY_SLOTS, SPEED_OF_LIGHT_M_S};
use acerra_geo::geodesy::EnuFrame;

use super::filter::RoverEpoch;

/// Largest lag looked at (s): beyond it multipath is no longer the same reflection.
const LARGEST_LAG_S: f64 = 300.0;
/// Longest correlation that a short log may be extrapolated to, in units of its largest lag.
const EXTRAPOLATION: f64 = 2.0;
/// Epochs that lags start from, at most.
const LARGEST_STARTS: usize = 600;
/// Differences that a lag needs.
const LEAST_DIFFERENCES: usize = 40;
/// Differences beyond this many robust standard deviations count as that many.
const LARGEST_SIGMA: f64 = 4.0;
/// Variance factors are kept within these bounds.
const VARIANCE_FACTORS: [f64; 2] = [0.02, 100.0];

/// Noise of one system's codes on one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CodeNoise {
    /// Variance over that of the model.
    pub variance_factor: f64,
    /// 1 + 2Σρ: how many epochs are worth one independent sample.
    pub epochs_per_sample: f64,
}

impl CodeNoise {
    /// The model's own: white, as large as stated.
    pub(crate) const MODEL: Self = Self {
        variance_factor: 1.0,
        epochs_per_sample: 1.0,
    };
}

/// Measured noise of every system and frequency slot.
#[derive(Debug, Clone)]
pub(crate) struct MeasuredNoise {
    groups: Vec<[CodeNoise; FREQUENCY_SLOTS]>,
}

impl MeasuredNoise {
    /// Noise as the model states it.
    pub(crate) fn model() -> Self {
        Self {
            groups: vec![[CodeNoise::MODEL; FREQUENCY_SLOTS]; System::ALL.len()],
        }
    }

    pub(crate) fn of(&self, system: System, slot: usize) -> CodeNoise {
        self.groups[place(system)][slot]
    }

    /// Measures the noise of the single differences between two logs.
    pub(crate) fn measure(
        constellation: &Constellation,
        options: &PpkOptions,
        rover: &[RoverEpoch],
        base: &[Epoch],
    ) -> Self {
        let series = Series::new(constellation, options, rover, base);
        let all = (0..System::ALL.len()).flat_map(|s| (0..FREQUENCY_SLOTS).map(move |f| (s, f)));
        let pooled = series.noise(|_, _| true).unwrap_or(CodeNoise::MODEL);
        let mut measured = Self::model();
        for (system, slot) in all {
            measured.groups[system][slot] = series
                .noise(|s, f| (s, f) == (system, slot))
                .unwrap_or(pooled);
        }
        measured
    }
}

fn place(system: System) -> usize {
    System::ALL.iter().position(|s| *s == system).unwrap_or(0)
}

/// Code minus phase of one satellite and slot at one epoch.
#[derive(Debug, Clone, Copy)]
struct Sample {
    satellite: usize,
    system: usize,
    slot: usize,
    /// Slips so far of rover and base: the ambiguity is the same while they are.
    slips: [u32; 2],
    code_minus_phase_m: f64,
    /// Variance that the model states (m²).
    variance_m2: f64,
}

/// Samples of all epochs, those of an epoch in ascending order of satellite and slot.
struct Series {
    times_s: Vec<f64>,
    epochs: Vec<Vec<Sample>>,
}

impl Series {
    fn new(
        constellation: &Constellation,
        options: &PpkOptions,
        rover: &[RoverEpoch],
        base: &[Epoch],
    ) -> Self {
        let mut series = Self {
            times_s: Vec::with_capacity(rover.len()),
            epochs: Vec::with_capacity(rover.len()),
        };
        let place = rover.iter().find_map(|e| e.single.as_ref().ok());
        let (Some(first), Some(place)) = (rover.first(), place) else {
            return series;
        };
        let frame = EnuFrame::from_ecef(place.position_ecef_m);
        for epoch in rover {
            let Some(b) = matching_base(base, &epoch.epoch, false).map(|k| &base[k]) else {
                continue;
            };
            if epoch.epoch.tag.seconds_since(b.tag).abs() > options.max_age_s {
                continue;
            }
            let mut samples = Vec::new();
            for (u, state) in epoch.epoch.measurements.iter().zip(&epoch.states) {
                let (Ok(state), Some(k)) = (state, b.find(u.satellite)) else {
                    continue;
                };
                let Some(sight) = line_of_sight(state.position_ecef_m, place.position_ecef_m)
                else {
                    continue;
                };
                let (_, elevation_rad) = azimuth_elevation_rad(&frame, sight.unit_ecef);
                if elevation_rad < options.elevation_mask_rad.max(0.05) {
                    continue;
                }
                let system = constellation.id(u.satellite).system();
                for slot in 0..options.frequencies {
                    samples.extend(sample(
                        options,
                        system,
                        slot,
                        elevation_rad,
                        [u, &b.measurements[k]],
                    ));
                }
            }
            series
                .times_s
                .push(epoch.epoch.tag.seconds_since(first.epoch.tag));
            series.epochs.push(samples);
        }
        series
    }

    /// The noise of the samples that `counts` (by system and slot) lets in; `None` where they are
    /// too few.
    fn noise(&self, counts: impl Fn(usize, usize) -> bool) -> Option<CodeNoise> {
        let interval_s = median(self.times_s.windows(2).map(|w| w[1] - w[0]).collect());
        if interval_s <= 0.0 {
            return None;
        }
        let largest = ((LARGEST_LAG_S / interval_s) as usize).min(self.epochs.len() / 3);
        let mut curve: Vec<(usize, f64)> = Vec::new();
        let mut lag = 1;
        while lag <= largest.max(1) {
            if let Some(value) = self.semivariance(lag, lag as f64 * interval_s, &counts) {
                curve.push((lag, value));
            }
            lag = (lag + 1).max(lag * 3 / 2);
        }
        noise_from_semivariogram(&curve)
    }

    /// Mean over all pairs of epochs this far apart of half the squared change, in units of the
    /// model's variance; what all satellites of an epoch share is taken off.
    fn semivariance(
        &self,
        lag: usize,
        lag_s: f64,
        counts: &impl Fn(usize, usize) -> bool,
    ) -> Option<f64> {
        let n = self.epochs.len().checked_sub(lag)?;
        let step = n.div_ceil(LARGEST_STARTS).max(1);
        let mut squares = Vec::new();
        for k in (0..n).step_by(step) {
            if (self.times_s[k + lag] - self.times_s[k] - lag_s).abs() > 0.1 * lag_s {
                continue;
            }
            let changes = changes(&self.epochs[k], &self.epochs[k + lag], counts);
            for of_one_group in changes.chunk_by(|a, b| a.group == b.group) {
                let members = of_one_group.len();
                if members < 3 {
                    continue;
                }
                let weight: f64 = of_one_group.iter().map(|c| 1.0 / c.variance_m2).sum();
                let mean = of_one_group
                    .iter()
                    .map(|c| c.change_m / c.variance_m2)
                    .sum::<f64>()
                    / weight;
                for c in of_one_group {
                    // Expectation of the square about the weighted mean.
                    let share = 1.0 - 1.0 / (c.variance_m2 * weight);
                    squares.push((c.change_m - mean).powi(2) / (c.variance_m2 * share.max(0.05)));
                }
            }
        }
        if squares.len() < LEAST_DIFFERENCES {
            return None;
        }
        // 0.455 is the median of χ² with one degree of freedom.
        let limit = LARGEST_SIGMA.powi(2) * median(squares.clone()) / 0.455;
        let sum: f64 = squares.iter().map(|s| s.min(limit)).sum();
        Some(sum / squares.len() as f64)
    }
}

struct Change {
    group: (usize, usize),
    change_m: f64,
    variance_m2: f64,
}

/// Changes of code minus phase between two epochs, grouped by slot and system.
fn changes(
    early: &[Sample],
    late: &[Sample],
    counts: &impl Fn(usize, usize) -> bool,
) -> Vec<Change> {
    let mut changes: Vec<Change> = early
        .iter()
        .filter(|a| counts(a.system, a.slot))
        .filter_map(|a| {
            let k = late
                .binary_search_by_key(&(a.satellite, a.slot), |b| (b.satellite, b.slot))
                .ok()?;
            let b = &late[k];
            (a.slips == b.slips).then(|| Change {
                group: (a.slot, a.system),
                change_m: b.code_minus_phase_m - a.code_minus_phase_m,
                variance_m2: a.variance_m2 + b.variance_m2,
            })
        })
        .collect();
    changes.sort_by_key(|c| c.group);
    changes
}

fn sample(
    options: &PpkOptions,
    system: System,
    slot: usize,
    elevation_rad: f64,
    [u, b]: [&Measurement; 2],
) -> Option<Sample> {
    let frequency = u.frequency_hz[slot];
    if frequency == 0.0 || b.frequency_hz[slot] != frequency {
        return None;
    }
    let wavelength_m = SPEED_OF_LIGHT_M_S / frequency;
    let of = |m: &Measurement| {
        let (code, phase) = (m.code_m[slot], m.phase_cycles[slot]);
        (code != 0.0 && phase != 0.0).then_some(code - phase * wavelength_m)
    };
    let model = single_difference_variance_m2(
        options,
        &SignalView {
            system,
            slot,
            is_code: true,
            elevation_rad,
            cn0_db_hz: [u.cn0_db_hz[slot], b.cn0_db_hz[slot]],
        },
        Separation::NONE,
    );
    let weakest_db = u.cn0_drop_db[slot].max(b.cn0_drop_db[slot]);
    Some(Sample {
        satellite: u.satellite,
        system: place(system),
        slot,
        slips: [u.slip_count[slot], b.slip_count[slot]],
        code_minus_phase_m: of(u)? - of(b)?,
        variance_m2: model * weak_signal_factor(options, weakest_db),
    })
}

/// Variance and correlation from semivariances at growing lags (epochs).
fn noise_from_semivariogram(curve: &[(usize, f64)]) -> Option<CodeNoise> {
    let &(first_lag, first) = curve.first()?;
    let &(last_lag, last) = curve.last()?;
    // The sill is the mean of the longer half; a curve that still rises at its end has not
    // reached it.
    let tail = &curve[curve.len() / 2..];
    let mean = tail.iter().map(|(_, v)| v).sum::<f64>() / tail.len() as f64;
    let rising = last > 1.3 * curve[curve.len() / 2].1 && last > 1.3 * first;
    let sill = if rising { 1.5 * last } else { mean.max(first) };
    if sill.is_nan() || sill <= 0.0 {
        return None;
    }
    let correlation = |value: f64| (1.0 - value / sill).max(0.0);
    // Trapezes between the lags measured; the first lag stands for those below it.
    let mut sum = correlation(first) * first_lag as f64;
    for pair in curve.windows(2) {
        let [(a, early), (b, late)] = [pair[0], pair[1]];
        if correlation(late) < 0.05 {
            break;
        }
        sum += (b - a) as f64 * (correlation(early) + correlation(late)) / 2.0;
    }
    if rising {
        sum += correlation(last) * EXTRAPOLATION * last_lag as f64;
    }
    Some(CodeNoise {
        variance_factor: sill.clamp(VARIANCE_FACTORS[0], VARIANCE_FACTORS[1]),
        epochs_per_sample: 1.0 + 2.0 * sum,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Semivariances of a first-order Gauss–Markov process.
    fn gauss_markov(variance: f64, correlation_epochs: f64, largest: usize) -> Vec<(usize, f64)> {
        let mut curve = Vec::new();
        let mut lag = 1;
        while lag <= largest {
            let rho = (-(lag as f64) / correlation_epochs).exp();
            curve.push((lag, variance * (1.0 - rho)));
            lag = (lag + 1).max(lag * 3 / 2);
        }
        curve
    }

    #[test]
    fn white_noise_is_white() {
        let curve: Vec<_> = (1..10).map(|lag| (lag, 2.0)).collect();
        let noise = noise_from_semivariogram(&curve).unwrap();
        assert!((noise.variance_factor - 2.0).abs() < 1e-12);
        assert!((noise.epochs_per_sample - 1.0).abs() < 1e-12);
        assert!(noise_from_semivariogram(&[]).is_none());
    }

    #[test]
    fn a_gauss_markov_process_is_recognised() {
        for tau in [5.0, 20.0, 60.0] {
            let noise = noise_from_semivariogram(&gauss_markov(4.0, tau, 300)).unwrap();
            let exact = (1.0 + (-1.0 / tau).exp()) / (1.0 - (-1.0 / tau).exp());
            assert!((noise.variance_factor / 4.0 - 1.0).abs() < 0.1, "{noise:?}");
            let ratio = noise.epochs_per_sample / exact;
            assert!((0.7..1.3).contains(&ratio), "{tau}: {noise:?}, {exact}");
        }
    }

    #[test]
    fn a_curve_without_a_sill_is_extrapolated() {
        let noise = noise_from_semivariogram(&gauss_markov(4.0, 60.0, 20)).unwrap();
        assert!(noise.epochs_per_sample > 20.0, "{noise:?}");
    }
}
