//! Common observations of rover and base: satellites and double differences.

use super::predict::POSITION_VARIANCE_M2;
use super::update::update_state;
use super::{EpochView, Filter};
use crate::float::double::{Differences, Differencing};
use crate::float::state::FilterState;
use crate::measurements::common::Common;
use crate::measurements::noise::Separation;
use crate::measurements::zero::ZeroDifference;
use crate::noise::robust_codes::{Inflation, inflation};
use crate::observations::signal::SPEED_OF_LIGHT_M_S;
use crate::single::SinglePoint;
use crate::stations::epoch_input::{BaseView, RoverEpoch};
use std::sync::Arc;

/// Least number of code differences for a position, including one redundant difference.
const LEAST_CODE_ROWS: usize = 4;
const CODE_ITERATIONS: usize = 2;

impl Filter<'_> {
    pub(super) fn uses_phase(&self) -> bool {
        self.options.mode.uses_phases()
    }

    pub(super) fn common(&self, rover: &RoverEpoch, base: &BaseView<'_>) -> Vec<Common> {
        let mut common = Vec::with_capacity(rover.epoch.measurements.len());
        for (index, m) in rover.epoch.measurements.iter().enumerate() {
            if let Some(b) = base.epoch.find(m.satellite)
                && rover.states[index].is_ok()
                && base.zero[b].elevation_rad > 0.0
            {
                common.push(Common {
                    satellite: m.satellite,
                    rover: index,
                    base: b,
                });
            }
        }
        common
    }

    /// Wavelengths of signals that both receivers track on the same carrier.
    pub(super) fn wavelengths(
        &self,
        rover: &RoverEpoch,
        base: &BaseView<'_>,
        common: &[Common],
    ) -> Vec<[f64; 3]> {
        common
            .iter()
            .map(|c| {
                let u = &rover.epoch.measurements[c.rover].frequency_hz;
                let b = &base.epoch.measurements[c.base].frequency_hz;
                std::array::from_fn(|slot| {
                    if u[slot] != 0.0 && u[slot] == b[slot] {
                        SPEED_OF_LIGHT_M_S / u[slot]
                    } else {
                        0.0
                    }
                })
            })
            .collect()
    }

    pub(super) fn zero_at(
        &self,
        rover: &RoverEpoch,
        place_ecef_m: [f64; 3],
    ) -> Arc<[ZeroDifference]> {
        rover.zero_at(self.options, place_ecef_m)
    }

    pub(super) fn rover_zero(&self, rover: &RoverEpoch) -> Arc<[ZeroDifference]> {
        self.zero_at(rover, self.state.position())
    }

    pub(super) fn differences(
        &self,
        epoch: &EpochView<'_>,
        rover: &[ZeroDifference],
        state: &FilterState,
        excluded: &[(usize, usize)],
    ) -> Differences {
        self.differencing(epoch, rover, state, excluded).rows(state)
    }

    fn differencing<'d>(
        &'d self,
        epoch: &'d EpochView<'_>,
        rover: &'d [ZeroDifference],
        state: &FilterState,
        excluded: &'d [(usize, usize)],
    ) -> Differencing<'d> {
        let baseline_m = (0..3)
            .map(|k| (state.x[k] - epoch.base.place_ecef_m[k]).powi(2))
            .sum::<f64>()
            .sqrt();
        Differencing {
            constellation: self.constellation,
            options: self.options,
            common: &epoch.common,
            wavelengths_m: &epoch.wavelengths_m,
            rover,
            base: &epoch.base.zero,
            separation: Separation {
                baseline_m,
                age_s: epoch.base.noise_age_s,
            },
            noise: self.noise,
            inflation: &epoch.inflation,
            codes_alone: false,
            excluded,
        }
    }

    /// Noise factor of this epoch's codes.
    pub(super) fn code_inflation(&self, epoch: &EpochView<'_>, single: &SinglePoint) -> Inflation {
        let zero = self.zero_at(epoch.rover, single.position_ecef_m);
        let differencing = Differencing {
            codes_alone: true,
            ..self.differencing(epoch, &zero, &self.state, &[])
        };
        let rows = differencing.rows(&self.state).rows;
        inflation(&rows, epoch.common.len())
    }

    /// Position and covariance from the differences of codes alone; `None` where they are too few.
    pub(super) fn position_by_codes(
        &self,
        epoch: &EpochView<'_>,
        single: &SinglePoint,
    ) -> Option<FilterState> {
        let mut state = self.state.clone();
        let mut place_ecef_m = single.position_ecef_m;
        for _ in 0..CODE_ITERATIONS {
            // Codes are used once: the prior position only serves to form the differences.
            for (k, place_m) in place_ecef_m.into_iter().enumerate() {
                state.initialise(k, place_m, POSITION_VARIANCE_M2);
            }
            let zero = self.zero_at(epoch.rover, state.position());
            let differencing = Differencing {
                codes_alone: true,
                ..self.differencing(epoch, &zero, &state, &[])
            };
            let rows = differencing.rows(&state).rows;
            if rows.len() < LEAST_CODE_ROWS || !update_state(&mut state, &rows, &epoch.common) {
                return None;
            }
            place_ecef_m = state.position();
        }
        Some(state)
    }
}
