//! Double differences between receivers and satellites, with their noise.

use super::state::FilterState;
use crate::linear::double_row::DoubleRow;
use crate::measurements::common::Common;
use crate::measurements::constellation::Constellation;
use crate::measurements::noise::{
    Separation, SignalView, single_difference_variances_m2, weak_signal_factor,
};
use crate::measurements::signal_group::GROUPS;
use crate::measurements::zero::ZeroDifference;
use crate::noise::code_noise::MeasuredNoise;
use crate::observations::satellite::System;
use crate::options::PpkOptions;

/// Share of a code's variance that is common to all codes: reflected signals arrive late, never early, later
/// for lower and weaker satellites.
const COMMON_DELAY_SHARE: f64 = 0.3;

/// Inputs of differencing at one epoch.
pub(crate) struct Differencing<'a> {
    pub constellation: &'a Constellation,
    pub options: &'a PpkOptions,
    pub common: &'a [Common],
    /// Wavelength (m) of each common satellite and slot, of the rover's signal; 0 unknown.
    pub wavelengths_m: &'a [[f64; 3]],
    pub rover: &'a [ZeroDifference],
    pub base: &'a [ZeroDifference],
    pub separation: Separation,
    /// Noise of the codes, measured or the model's.
    pub noise: &'a MeasuredNoise,
    /// Noise factor of each code of this epoch.
    pub inflation: &'a [[f64; 3]],
    /// Whether only codes are differenced.
    pub codes_alone: bool,
    /// Phases left out of this epoch: (common index, slot).
    pub excluded: &'a [(usize, usize)],
}

/// Double differences and the satellites rejected for too large an innovation.
pub(crate) struct Differences {
    pub rows: Vec<DoubleRow>,
    /// (common index, slot) of rejected phases.
    pub rejected: Vec<(usize, usize)>,
}

impl Differencing<'_> {
    fn system(&self, k: usize) -> System {
        self.constellation.id(self.common[k].satellite).system()
    }

    fn single(&self, k: usize, slot: usize, is_code: bool) -> f64 {
        let (u, b) = (
            &self.rover[self.common[k].rover],
            &self.base[self.common[k].base],
        );
        if is_code {
            u.code_m[slot] - b.code_m[slot]
        } else {
            u.phase_m[slot] - b.phase_m[slot]
        }
    }

    fn is_valid(&self, k: usize, slot: usize, is_code: bool) -> bool {
        if self.wavelengths_m[k][slot] == 0.0 || self.excluded.contains(&(k, slot)) {
            return false;
        }
        let (u, b) = (
            &self.rover[self.common[k].rover],
            &self.base[self.common[k].base],
        );
        let phase = u.phase_m[slot] != 0.0 && b.phase_m[slot] != 0.0;
        let code = u.code_m[slot] != 0.0 && b.code_m[slot] != 0.0;
        if !is_code {
            phase
        } else if self.codes_alone || self.options.policy().takes_codes_without_phase() {
            code
        } else {
            code && phase
        }
    }

    fn uses_phase(&self) -> bool {
        self.options.mode.uses_phases()
    }

    fn elevation(&self, k: usize) -> f64 {
        self.rover[self.common[k].rover].elevation_rad
    }

    /// Factor of the measured code noise; a code that is not the first of its ambiguity has a weight reduced
    /// by the correlation in time.
    fn measured_code_factor(&self, k: usize, slot: usize, state: &FilterState) -> f64 {
        let satellite = self.common[k].satellite;
        let count = if self.codes_alone || !self.uses_phase() {
            0.0
        } else {
            state.track(satellite, slot).codes_used
        };
        self.noise.of(self.system(k), slot).factor(count)
    }

    /// The variance of a measurement, and the variance of an undisturbed measurement (m²).
    fn variances_m2(&self, k: usize, slot: usize, is_code: bool, state: &FilterState) -> [f64; 2] {
        let (u, b) = (
            &self.rover[self.common[k].rover],
            &self.base[self.common[k].base],
        );
        let signal = SignalView {
            system: self.system(k),
            slot,
            is_code,
            sin_elevation: u.sin_elevation,
            cn0_db_hz: [u.cn0_db_hz[slot], b.cn0_db_hz[slot]],
            noise_power: [u.noise_power[slot], b.noise_power[slot]],
        };
        let [by_model, undisturbed] =
            single_difference_variances_m2(self.options, &signal, self.separation);
        let weakest_db = u.cn0_drop_db[slot].max(b.cn0_drop_db[slot]);
        let mut variance = by_model * weak_signal_factor(self.options, weakest_db);
        if is_code {
            variance *= self.measured_code_factor(k, slot, state);
            variance *= self.inflation.get(k).map_or(1.0, |of| of[slot]);
        } else if !state.track(self.common[k].satellite, slot).half_cycle_known {
            variance += self.options.policy().half_cycle_variance_m2();
        }
        [variance, undisturbed]
    }

    /// The double differences at the given biases.
    pub(crate) fn rows(&self, state: &FilterState) -> Differences {
        let options = self.options;
        let mut rows = Vec::with_capacity(2 * options.frequencies * self.common.len());
        let mut rejected = Vec::new();
        let mut block = 0;
        let mut members = Vec::with_capacity(self.common.len());
        let frequencies = options.frequencies;
        let uses_phase = !self.codes_alone && self.uses_phase();
        for group in GROUPS {
            members.clear();
            members.extend((0..self.common.len()).filter(|&k| group.contains(&self.system(k))));
            if members.is_empty() {
                continue;
            }
            for kind in 0..2 * frequencies {
                let (is_code, slot) = (kind >= frequencies, kind % frequencies);
                if !is_code && !uses_phase {
                    continue;
                }
                let usable = |k: &usize| {
                    self.is_valid(*k, slot, is_code)
                        && (is_code || state.bias(self.common[*k].satellite, slot).is_some())
                };
                let usable: Vec<usize> = members.iter().copied().filter(usable).collect();
                let Some(reference) = self.reference(state, slot, &usable) else {
                    continue;
                };
                block += 1;
                let of_reference_m2 = self.variances_m2(reference, slot, is_code, state);
                for other in usable {
                    if other == reference {
                        continue;
                    }
                    let mut residual =
                        self.single(reference, slot, is_code) - self.single(other, slot, is_code);
                    let (ei, ej) = (self.by_position(reference), self.by_position(other));
                    let mut wavelengths = [0.0; 2];
                    let channels_apart = if is_code {
                        0.0
                    } else {
                        self.channels_apart(reference, other)
                    };
                    if !is_code {
                        wavelengths = [
                            self.wavelengths_m[reference][slot],
                            self.wavelengths_m[other][slot],
                        ];
                        let bias =
                            |k: usize| state.bias(self.common[k].satellite, slot).unwrap_or(0.0);
                        residual -= wavelengths[0] * bias(reference) - wavelengths[1] * bias(other);
                        residual -=
                            self.inter_channel_m(state, reference, other, slot, wavelengths);
                        residual -= state.channel_slope_m()[0] * channels_apart;
                    }
                    if residual.abs()
                        > self.innovation_limit(state, reference, other, slot, is_code)
                        || residual.is_nan()
                    {
                        if !is_code {
                            rejected.push((other, slot));
                            if options.policy().rejects_reference() {
                                rejected.push((reference, slot));
                            }
                        }
                        continue;
                    }
                    let of_other_m2 = self.variances_m2(other, slot, is_code, state);
                    let variances_m2 = [of_reference_m2[0], of_other_m2[0]];
                    let common_delay_m = if is_code && options.measure_code_noise {
                        COMMON_DELAY_SHARE.sqrt()
                            * (variances_m2[0].sqrt() - variances_m2[1].sqrt())
                    } else {
                        0.0
                    };
                    rows.push(DoubleRow {
                        slot,
                        is_code,
                        reference,
                        other,
                        residual_m: residual,
                        position: std::array::from_fn(|a| ej[a] - ei[a]),
                        wavelengths_m: wavelengths,
                        channels_apart,
                        variance_reference_m2: variances_m2[0],
                        variance_other_m2: variances_m2[1],
                        common_delay_m,
                        undisturbed_m2: [of_reference_m2[1], of_other_m2[1]],
                        block,
                    });
                }
            }
        }
        Differences { rows, rejected }
    }

    fn channels_apart(&self, reference: usize, other: usize) -> f64 {
        let channel = |k: usize| {
            let channel = self.constellation.channel(self.common[k].satellite);
            channel.map_or(0.0, f64::from)
        };
        match self.system(other) {
            System::Glonass => channel(reference) - channel(other),
            _ => 0.0,
        }
    }

    fn by_position(&self, k: usize) -> [f64; 3] {
        self.rover[self.common[k].rover].by_position_ecef
    }

    /// The highest usable satellite (the later one on ties); where the policy requires, preferably a
    /// satellite without a slip, and no SBAS satellite.
    fn reference(&self, state: &FilterState, slot: usize, usable: &[usize]) -> Option<usize> {
        let calm_first = self.options.policy().prefers_calm_reference();
        let mut best: Option<(bool, f64, usize)> = None;
        for &k in usable {
            if calm_first && self.system(k) == System::Sbas {
                continue;
            }
            let calm = !calm_first || !state.track(self.common[k].satellite, slot).slipped();
            let elevation = self.elevation(k);
            let better = best.is_none_or(|(was_calm, highest, _)| {
                (calm && !was_calm) || (calm == was_calm && elevation >= highest)
            });
            if better {
                best = Some((calm, elevation, k));
            }
        }
        best.map(|(_, _, k)| k)
    }

    fn innovation_limit(
        &self,
        state: &FilterState,
        reference: usize,
        other: usize,
        slot: usize,
        is_code: bool,
    ) -> f64 {
        let options = self.options;
        let limit = if is_code {
            options.max_code_innovation_m
        } else if options.dynamics.is_some() {
            options.max_phase_innovation_m
        } else {
            // Here the position is no better than a single-point position.
            options
                .max_phase_innovation_m
                .max(options.max_code_innovation_m)
        };
        let fresh = |k: usize| state.has_initial_variance(self.common[k].satellite, slot);
        if fresh(reference) || fresh(other) {
            options.policy().fresh_innovation_factor() * limit
        } else {
            limit
        }
    }

    /// GLONASS and SBAS inter-channel biases learnt during the hold (m).
    fn inter_channel_m(
        &self,
        state: &FilterState,
        reference: usize,
        other: usize,
        slot: usize,
        wavelengths: [f64; 2],
    ) -> f64 {
        let cycles = |k: usize| {
            state
                .track(self.common[k].satellite, slot)
                .channel_bias_cycles
        };
        wavelengths[0] * cycles(reference) - wavelengths[1] * cycles(other)
    }
}
