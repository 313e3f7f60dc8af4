//! The codes' true noise and its correlation in time, measured from code minus phase.
//!
//! Code minus phase of one satellite is free of geometry and clocks. Differenced between rover and
//! base it is free of the ionosphere too: what changes in it while no cycle slips is code noise
//! and multipath. Half the mean square of its change over a lag τ is σ²·(1 − ρ(τ)), the
//! semivariogram: its sill is the variance, and the way there is the autocorrelation ρ.
//!
//! Multipath lasts for minutes at a receiver that stands and for seconds at one that flies. Taken
//! for white noise it would average out ten times faster than it does, and float ambiguities would
//! be called certain that are cycles off. The mean of n samples has the variance
//! V(n) = σ²/n·(1 + 2Σ(1 − k/n)·ρ(k)); so the n-th sample is given the weight 1/V(n) − 1/V(n−1).

use super::calibration::Calibration;
use super::constellation::Constellation;
use super::epoch_input::RoverEpoch;
use super::matching::matching_base;
use super::measurement::{Epoch, Measurement};
use super::noise::{Separation, SignalView, single_difference_variance_m2, weak_signal_factor};
use super::outliers::median;
use crate::geometry::{azimuth_elevation_rad, line_of_sight};
use crate::options::PpkOptions;
use crate::satellite::System;
use crate::signal::{FREQUENCY_SLOTS, SPEED_OF_LIGHT_M_S};
use acerra_geo::geodesy::EnuFrame;

/// Largest lag looked at (s): beyond it multipath is no longer the same reflection.
const LARGEST_LAG_S: f64 = 300.0;
/// A semivariogram rises still where its last value exceeds that at half the lag by this factor.
const RISING: f64 = 1.25;
/// Epochs that lags start from, at most.
const LARGEST_STARTS: usize = 600;
/// Differences that a lag needs.
const LEAST_DIFFERENCES: usize = 40;
/// Differences beyond this many robust standard deviations count as that many.
const LARGEST_SIGMA: f64 = 4.0;
/// Variance factors are kept within these bounds.
const VARIANCE_FACTORS: [f64; 2] = [0.01, 100.0];
/// Standard deviation at the zenith of biases that last longer than any lag: receivers' delays
/// that differ between satellites' signals (m).
const LASTING_SIGMA_M: f64 = 0.28;
/// The same of multipath, over the variance of what varies.
const LASTING_SHARE: f64 = 0.25;
/// Samples of one ambiguity after which each further one brings as much as the last counted.
const LARGEST_COUNT: usize = 1_000;
/// Least information of a sample, in units of the first's.
const LEAST_INFORMATION: f64 = 1e-4;

/// Noise of one system's codes on one frequency, in units of the model's variance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CodeNoise {
    /// Variance of a single code.
    variance_factor: f64,
    /// Variance of the n-th sample of a constant, by its new information, over that of the first.
    sample_factors: Vec<f64>,
    /// Variance of the mean of n samples of what varies.
    mean_factors: Vec<f64>,
    /// Variance of what lasts longer than any lag.
    lasting: f64,
}

impl CodeNoise {
    /// The model's own: white, as large as stated.
    fn model() -> Self {
        Self {
            variance_factor: 1.0,
            sample_factors: vec![1.0],
            mean_factors: vec![1.0],
            lasting: 0.0,
        }
    }

    /// Noise of this variance and autocorrelation at lags of 1, 2, … epochs, besides what lasts
    /// longer than any lag; `lasting` is the variance of receivers' delays.
    fn new(varying: f64, lasting: f64, correlation: impl Fn(usize) -> f64) -> Self {
        let (mut sum, mut moment) = (0.0, 0.0);
        let mut mean_factors = Vec::with_capacity(LARGEST_COUNT);
        for n in 1..=LARGEST_COUNT {
            let count = n as f64;
            mean_factors.push(varying * (1.0 + 2.0 * (sum - moment / count)) / count);
            let rho = correlation(n).clamp(0.0, 1.0);
            sum += rho;
            moment += rho * count;
        }
        Self::with_means(mean_factors, LASTING_SHARE * varying + lasting)
    }

    fn with_means(mean_factors: Vec<f64>, lasting: f64) -> Self {
        let variance_factor = mean_factors[0] + lasting;
        let mut information = 0.0;
        let of_sample = |mean_factor: &f64| {
            let own = variance_factor / (mean_factor + lasting);
            let gained = (own - information).max(LEAST_INFORMATION);
            information = own;
            1.0 / gained
        };
        Self {
            variance_factor,
            sample_factors: mean_factors.iter().map(of_sample).collect(),
            mean_factors,
            lasting,
        }
    }

    /// This noise with another variance of what lasts.
    pub(crate) fn with_lasting(&self, lasting: f64) -> Self {
        Self::with_means(self.mean_factors.clone(), lasting)
    }

    /// Variance of what lasts longer than any lag.
    pub(crate) fn lasting(&self) -> f64 {
        self.lasting
    }

    /// Variance of the mean of `count` codes without what lasts.
    pub(crate) fn mean_factor(&self, count: usize) -> f64 {
        let last = self.mean_factors.len() - 1;
        self.mean_factors[count.saturating_sub(1).min(last)]
    }

    /// Factor on the model's variance of a code that is the `count`-th of its ambiguity, from 0.
    pub(crate) fn factor(&self, count: f64) -> f64 {
        let last = self.sample_factors.len() - 1;
        let place = (count as usize).min(last);
        self.variance_factor * self.sample_factors[place]
    }
}

/// Measured noise of every system and frequency slot.
#[derive(Debug, Clone)]
pub(crate) struct MeasuredNoise {
    groups: Vec<[CodeNoise; FREQUENCY_SLOTS]>,
    /// Growth of an ambiguity's variance by the multipath of its phase (cycle²/s), where that is
    /// measured; never less than the options say.
    pub phase_walk_cycles2_s: Option<f64>,
    float_factors: [f64; 2],
}

impl MeasuredNoise {
    /// Noise as the model states it.
    pub(crate) fn model() -> Self {
        Self {
            groups: vec![std::array::from_fn(|_| CodeNoise::model()); System::ALL.len()],
            phase_walk_cycles2_s: None,
            float_factors: [1.0; 2],
        }
    }

    /// This noise as fixes have calibrated it.
    pub(crate) fn calibrated(mut self, calibration: Calibration) -> Self {
        for noise in self.groups.iter_mut().flatten() {
            noise.variance_factor *= calibration.code_factor;
        }
        self.phase_walk_cycles2_s = Some(calibration.phase_walk_cycles2_s);
        self.float_factors = calibration.float_factors;
        self
    }

    /// Factors on the variances that the filter states for float positions, horizontally and
    /// vertically.
    pub(crate) fn float_factors(&self) -> [f64; 2] {
        self.float_factors
    }

    /// Share of what lasts in the variance of the mean of `count` codes.
    pub(crate) fn lasting_share(&self, count: usize) -> f64 {
        let variances = |noise: &CodeNoise| [noise.lasting, noise.mean_factor(count)];
        let all = self.groups.iter().flatten().map(variances);
        let [lasting, varying] = all.fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
        lasting / (lasting + varying)
    }

    /// This noise with what lasts as `lasting` has it for each system and slot.
    pub(crate) fn with_lasting(
        mut self,
        lasting: impl IntoIterator<Item = ((System, usize), f64)>,
    ) -> Self {
        for ((system, slot), variance) in lasting {
            let noise = &mut self.groups[place(system)][slot];
            *noise = noise.with_lasting(variance);
        }
        self
    }

    pub(crate) fn of(&self, system: System, slot: usize) -> &CodeNoise {
        &self.groups[place(system)][slot]
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
        let pooled = series.noise(|_, _| true).unwrap_or_else(CodeNoise::model);
        let mut measured = Self::model();
        for (system, slot) in all {
            measured.groups[system][slot] = series
                .noise(|s, f| (s, f) == (system, slot))
                .unwrap_or_else(|| pooled.clone());
        }
        measured
    }
}

/// Variance of lasting biases over the model's at the zenith.
fn lasting_factor(options: &PpkOptions) -> f64 {
    let zenith = SignalView {
        system: System::Gps,
        slot: 0,
        is_code: true,
        sin_elevation: 1.0,
        cn0_db_hz: [0.0; 2],
        noise_power: [0.0; 2],
    };
    LASTING_SIGMA_M.powi(2) / single_difference_variance_m2(options, &zenith, Separation::NONE)
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
    /// Variance of lasting biases over the model's at the zenith.
    lasting: f64,
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
            lasting: lasting_factor(options),
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
        noise_from_semivariogram(&curve, self.lasting)
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

/// Variance and correlation from semivariances at growing lags (epochs).
fn noise_from_semivariogram(curve: &[(usize, f64)], lasting: f64) -> Option<CodeNoise> {
    let &(_, first) = curve.first()?;
    let &(last_lag, last) = curve.last()?;
    // The sill is the mean of the longer lags; a curve that still rises at its end has not
    // reached it.
    let tail = &curve[3 * curve.len() / 4..];
    let mean = tail.iter().map(|(_, v)| v).sum::<f64>() / tail.len() as f64;
    let halfway = curve.iter().find(|(lag, _)| 2 * lag >= last_lag)?.1;
    let rising = curve.len() > 1 && last > RISING * halfway;
    let sill = if rising { 1.5 * last } else { mean.max(first) };
    if sill.is_nan() || sill <= 0.0 {
        return None;
    }
    let correlation = |lag: usize| {
        let value = if lag >= last_lag {
            // Beyond what was measured the curve goes on as steeply as it ended, to its sill.
            let slope = if rising {
                2.0 * (last - halfway) / last_lag as f64
            } else {
                sill
            };
            last + slope * (lag - last_lag) as f64
        } else {
            let k = curve.partition_point(|(l, _)| *l <= lag);
            let (a, early) = if k == 0 { (0, first) } else { curve[k - 1] };
            let (b, late) = curve[k];
            early + (late - early) * (lag - a) as f64 / (b - a) as f64
        };
        1.0 - value / sill
    };
    let factor = sill.clamp(VARIANCE_FACTORS[0], VARIANCE_FACTORS[1]);
    Some(CodeNoise::new(factor, lasting, correlation))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LASTING: f64 = 0.025;

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

    /// Variance of the mean of n samples, as the weights of the samples have it.
    fn mean_variance(noise: &CodeNoise, n: u32) -> f64 {
        1.0 / (0..n)
            .map(|k| 1.0 / noise.factor(f64::from(k)))
            .sum::<f64>()
    }

    fn lasting(varying: f64) -> f64 {
        LASTING_SHARE * varying + LASTING
    }

    #[test]
    fn white_noise_averages_out_down_to_what_lasts() {
        let curve: Vec<_> = (1..10).map(|lag| (lag, 2.0)).collect();
        let noise = noise_from_semivariogram(&curve, LASTING).unwrap();
        for n in [1, 2, 10, 900] {
            let exact = 2.0 / f64::from(n) + lasting(2.0);
            let ratio = mean_variance(&noise, n) / exact;
            assert!((0.95..1.05).contains(&ratio), "{n}: {ratio}");
        }
        assert!(noise_from_semivariogram(&[], LASTING).is_none());
    }

    #[test]
    fn a_gauss_markov_process_is_recognised() {
        for tau in [5.0, 20.0, 60.0] {
            let noise = noise_from_semivariogram(&gauss_markov(4.0, tau, 300), LASTING).unwrap();
            for n in [1u32, 10, 100, 500] {
                let exact = (1..n)
                    .map(|k| (1.0 - f64::from(k) / f64::from(n)) * (-f64::from(k) / tau).exp());
                let exact = 4.0 * (1.0 + 2.0 * exact.sum::<f64>()) / f64::from(n) + lasting(4.0);
                let ratio = mean_variance(&noise, n) / exact;
                assert!((0.7..1.3).contains(&ratio), "{tau} {n}: {ratio}");
            }
        }
    }

    #[test]
    fn a_curve_without_a_sill_is_extrapolated() {
        let noise = noise_from_semivariogram(&gauss_markov(4.0, 60.0, 20), LASTING).unwrap();
        assert!(
            mean_variance(&noise, 20) > 0.7 * noise.factor(0.0),
            "not correlated"
        );
    }
}
