//! The codes' true noise and its correlation in time, measured from code minus phase.
//!
//! Code minus phase of one satellite is free of geometry and clocks. The difference between rover and base is
//! free of the ionosphere too: while no cycle slips, it changes by code noise and multipath. Half the mean
//! square of its change over a lag τ is σ²·(1 − ρ(τ)), the semivariogram: its sill is the variance, and its
//! rise gives the autocorrelation ρ.
//!
//! Multipath lasts for minutes at a receiver at rest and for seconds at a flying one. Modelled as white
//! noise, multipath would average out ten times too fast, and float ambiguities with errors of cycles would
//! count as certain. The mean of n samples has the variance V(n) = σ²/n·(1 + 2Σ(1 − k/n)·ρ(k)); so the n-th
//! sample is given the weight 1/V(n) − 1/V(n−1).

use super::calibration::Calibration;
use super::correlated::{CodeNoise, Lasting};
use super::series::{Series, place};
use crate::measurements::constellation::Constellation;
use crate::measurements::measurement::Epoch;
use crate::observations::satellite::System;
use crate::observations::signal::FREQUENCY_SLOTS;
use crate::options::PpkOptions;
use crate::stations::epoch_input::RoverEpoch;

/// Measured noise of every system and frequency slot.
#[derive(Debug, Clone)]
pub(crate) struct MeasuredNoise {
    groups: Vec<[CodeNoise; FREQUENCY_SLOTS]>,
    /// Growth of an ambiguity's variance by the multipath of its phase (cycle²/s), where measured; never less
    /// than the value of the options.
    pub phase_walk_cycles2_s: Option<f64>,
    float_factors: [f64; 2],
}

impl MeasuredNoise {
    /// The noise of the model.
    pub(crate) fn model() -> Self {
        Self {
            groups: vec![std::array::from_fn(|_| CodeNoise::model()); System::ALL.len()],
            phase_walk_cycles2_s: None,
            float_factors: [1.0; 2],
        }
    }

    /// This noise with a calibration by fixes.
    pub(crate) fn calibrated(mut self, calibration: Calibration) -> Self {
        for noise in self.groups.iter_mut().flatten() {
            noise.variance_factor *= calibration.code_factor;
        }
        self.phase_walk_cycles2_s = Some(calibration.phase_walk_cycles2_s);
        self.float_factors = calibration.float_factors;
        self
    }

    /// Factors on the filter's variances of float positions, horizontally and vertically.
    pub(crate) fn float_factors(&self) -> [f64; 2] {
        self.float_factors
    }

    /// Share of the lasting part in the variance of the mean of `count` codes.
    pub(crate) fn lasting_share(&self, count: usize) -> f64 {
        let [lasting, varying] = self.sums(count, |lasting| lasting.expected);
        lasting / (lasting + varying)
    }

    /// Expected variance of the mean of `count` codes over the guarded variance.
    pub(crate) fn expected_share(&self, count: usize) -> f64 {
        let expected = self.sums(count, |lasting| lasting.expected);
        let guarded = self.sums(count, |lasting| lasting.guarded);
        expected.iter().sum::<f64>() / guarded.iter().sum::<f64>()
    }

    /// Sums over all groups of the variances of the lasting part, and of the variances of means of `count`
    /// codes without it.
    fn sums(&self, count: usize, of: impl Fn(Lasting) -> f64) -> [f64; 2] {
        let all = self.groups.iter().flatten();
        all.fold([0.0; 2], |[lasting, varying], noise| {
            [
                lasting + of(noise.lasting),
                varying + noise.mean_factor(count),
            ]
        })
    }

    /// This noise with the lasting part of `lasting` for each system and slot.
    pub(crate) fn with_lasting(
        mut self,
        lasting: impl IntoIterator<Item = ((System, usize), Lasting)>,
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
            let own = series
                .holds(system, slot)
                .then(|| series.noise(|s, f| (s, f) == (system, slot)));
            measured.groups[system][slot] = own.flatten().unwrap_or_else(|| pooled.clone());
        }
        measured
    }
}
