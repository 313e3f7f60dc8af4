//! Code minus phase over a log, and its semivariogram.

use super::correlated::{CodeNoise, Lasting, noise_from_semivariogram};
use crate::linear::outliers::median;
use crate::measurements::constellation::Constellation;
use crate::measurements::matching::matching_base;
use crate::measurements::measurement::{Epoch, Measurement};
use crate::measurements::noise::{
    Separation, SignalView, single_difference_variance_m2, weak_signal_factor,
};
use crate::observations::satellite::System;
use crate::observations::signal::SPEED_OF_LIGHT_M_S;
use crate::options::PpkOptions;
use crate::orbits::geometry::{azimuth_elevation_rad, line_of_sight};
use crate::stations::epoch_input::RoverEpoch;
use acerra_geo::geodesy::EnuFrame;

/// Largest lag (s): beyond this time multipath is from other reflections.
const LARGEST_LAG_S: f64 = 300.0;
/// Largest number of epochs from which lags start.
const LARGEST_STARTS: usize = 600;
/// Least number of differences of a lag.
const LEAST_DIFFERENCES: usize = 40;
/// Differences beyond this many robust standard deviations are clipped.
const LARGEST_SIGMA: f64 = 4.0;
/// Standard deviations at the zenith of biases that last longer than any lag: receivers' delays that differ
/// between satellites' signals (m). Integers are guarded against correlators that differ by a nanosecond at a
/// chip's edge, as in unlike receivers; a third of this difference is expected.
const DELAY_SIGMAS_M: Lasting = Lasting {
    guarded: 0.28,
    expected: 0.10,
};

/// Variances of receivers' delays over the model's at the zenith.
fn delay_factors(options: &PpkOptions) -> Lasting {
    let zenith = SignalView {
        system: System::Gps,
        slot: 0,
        is_code: true,
        sin_elevation: 1.0,
        cn0_db_hz: [0.0; 2],
        noise_power: [0.0; 2],
    };
    let model_m2 = single_difference_variance_m2(options, &zenith, Separation::NONE);
    DELAY_SIGMAS_M.map(|sigma_m| sigma_m.powi(2) / model_m2)
}

/// Index of a system among all.
pub(super) fn place(system: System) -> usize {
    System::ALL.iter().position(|s| *s == system).unwrap_or(0)
}

/// Code minus phase of one satellite and slot at one epoch.
#[derive(Debug, Clone, Copy)]
struct Sample {
    satellite: usize,
    system: usize,
    slot: usize,
    /// Slips so far of rover and base: the ambiguity is constant while the counts are.
    slips: [u32; 2],
    code_minus_phase_m: f64,
    /// Variance by the model (m²).
    variance_m2: f64,
}

/// Samples of all epochs, in ascending order of satellite and slot within an epoch.
pub(super) struct Series {
    times_s: Vec<f64>,
    epochs: Vec<Vec<Sample>>,
    /// Variances of receivers' delays over the model's at the zenith.
    delays: Lasting,
}

impl Series {
    pub(super) fn new(
        constellation: &Constellation,
        options: &PpkOptions,
        rover: &[RoverEpoch],
        base: &[Epoch],
    ) -> Self {
        let mut series = Self {
            times_s: Vec::with_capacity(rover.len()),
            epochs: Vec::with_capacity(rover.len()),
            delays: delay_factors(options),
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

    /// Whether there are samples of a system (by its place) and slot.
    pub(super) fn holds(&self, system: usize, slot: usize) -> bool {
        let mut samples = self.epochs.iter().flatten();
        samples.any(|s| (s.system, s.slot) == (system, slot))
    }

    /// The noise of the samples selected by `counts` (by system and slot); `None` where the samples are too
    /// few.
    pub(super) fn noise(&self, counts: impl Fn(usize, usize) -> bool) -> Option<CodeNoise> {
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
        noise_from_semivariogram(&curve, self.delays)
    }

    /// Mean over all pairs of epochs this far apart of half the squared change, in units of the model's
    /// variance; the part common to all satellites of an epoch is removed.
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
            (a.slips == b.slips).then_some(Change {
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
            sin_elevation: elevation_rad.sin(),
            cn0_db_hz: [u.cn0_db_hz[slot], b.cn0_db_hz[slot]],
            noise_power: [u.noise_power[slot], b.noise_power[slot]],
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
