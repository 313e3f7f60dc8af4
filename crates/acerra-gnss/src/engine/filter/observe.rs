//! What rover and base see together: common satellites and double differences.

use super::{BaseView, EpochView, Filter, RoverEpoch};
use crate::engine::double::{Common, Differencing};
use crate::engine::noise::Separation;
use crate::engine::state::FilterState;
use crate::engine::zero::{ZeroDifference, zero_differences};
use crate::options::PositioningMode;
use crate::signal::SPEED_OF_LIGHT_M_S;

impl Filter<'_> {
    pub(super) fn uses_phase(&self) -> bool {
        matches!(
            self.options.mode,
            PositioningMode::Kinematic | PositioningMode::Static
        )
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

    pub(super) fn rover_zero(&self, rover: &RoverEpoch) -> Vec<ZeroDifference> {
        zero_differences(
            self.options,
            &rover.epoch,
            &rover.states,
            self.state.position(),
            false,
        )
    }

    pub(super) fn differences(
        &self,
        epoch: &EpochView<'_>,
        rover: &[ZeroDifference],
        state: &FilterState,
        excluded: &[(usize, usize)],
    ) -> crate::engine::double::Differences {
        let baseline_m = (0..3)
            .map(|k| (state.x[k] - self.base_position_ecef_m[k]).powi(2))
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
            excluded,
        }
        .rows(state)
    }
}
