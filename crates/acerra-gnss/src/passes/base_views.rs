//! The base's measurements for a rover epoch: nearest, interpolated, or moved.

use super::pass::Prepared;
use crate::measurements::matching::{matching_base, nearest_base};
use crate::measurements::measurement::Measurement;
use crate::measurements::plausible::reject_implausible;
use crate::measurements::zero::{ZeroDifference, zero_differences};
use crate::observations::observation::EPOCH_TOLERANCE_S;
use crate::options::PositioningMode;
use crate::stations::epoch_input::BaseView;
use crate::stations::moving_base::{BaseTrack, moved};
use std::sync::Arc;

impl Prepared<'_> {
    /// Zero differences of a base epoch for a rover epoch.
    fn base_zero(&self, index: usize, rover: usize) -> Arc<[ZeroDifference]> {
        self.base_zeros
            .get(rover, index, || self.new_base_zero(index, rover))
    }

    fn new_base_zero(&self, index: usize, rover: usize) -> Vec<ZeroDifference> {
        let epoch = &self.base[index];
        // Ephemerides are chosen by the rover's tag, so that both ends use the same ephemerides.
        let mut states = self
            .base_states
            .get(rover, index, || {
                let tag = self.rover[rover].epoch.tag;
                self.base_context.states(epoch, tag, false)
            })
            .to_vec();
        let place_ecef_m = self.base_place_ecef_m(index);
        if self.options.policy().refuses_implausible() {
            reject_implausible(self.constellation, epoch, &mut states, place_ecef_m);
        }
        zero_differences(
            self.base_context.options,
            epoch,
            &states,
            place_ecef_m,
            true,
        )
    }

    /// Assumed position of the base's antenna at one of the base's epochs.
    fn base_place_ecef_m(&self, index: usize) -> [f64; 3] {
        let own = self.base_track.and_then(|track| track.at(index));
        own.map_or(self.base_position_ecef_m, |point| point.position_ecef_m)
    }

    /// A moving base at the epoch nearest to the rover's, carried to the rover's time.
    fn moving_base(&self, track: &BaseTrack, rover_index: usize) -> Option<BaseView<'_>> {
        let rover = &self.rover[rover_index];
        let time = rover.single.as_ref().ok()?.time;
        let index = nearest_base(self.base, &rover.epoch)?;
        let point = track.at(index)?;
        let age_s = time.seconds_since(point.time);
        Some(BaseView {
            epoch: &self.base[index],
            zero: self.base_zero(index, rover_index),
            place_ecef_m: point.position_ecef_m,
            moved: Some(moved(point, time)),
            age_s,
            noise_age_s: age_s,
        })
    }

    /// The base's data for a rover epoch in a pass of the given direction.
    pub(crate) fn base_view(&self, rover_index: usize, backward: bool) -> Option<BaseView<'_>> {
        let rover = &self.rover[rover_index].epoch;
        if self.options.mode == PositioningMode::Single {
            return None;
        }
        if let Some(track) = self.base_track {
            return self.moving_base(track, rover_index);
        }
        if self.options.interpolate_base
            && let Some(view) = self.interpolated(rover_index, backward)
        {
            return Some(view);
        }
        let index = matching_base(self.base, rover, backward)?;
        let epoch = &self.base[index];
        let age_s = rover.tag.seconds_since(epoch.tag);
        Some(BaseView {
            epoch,
            zero: self.base_zero(index, rover_index),
            place_ecef_m: self.base_position_ecef_m,
            moved: None,
            age_s,
            noise_age_s: age_s,
        })
    }

    /// Base residuals interpolated linearly between the base's epochs around the rover's tag; satellites that
    /// slip in between are left out. `None` where interpolation is not possible.
    fn interpolated(&self, rover_index: usize, backward: bool) -> Option<BaseView<'_>> {
        let rover = &self.rover[rover_index].epoch;
        let after = self
            .base
            .partition_point(|b| b.tag.seconds_since(rover.tag) < -EPOCH_TOLERANCE_S);
        let (before, after) = (after.checked_sub(1)?, after);
        let next = self.base.get(after)?;
        let (from_previous_s, from_next_s) = (
            rover.tag.seconds_since(self.base[before].tag),
            rover.tag.seconds_since(next.tag),
        );
        let largest = self.options.max_age_s;
        if from_next_s.abs() < EPOCH_TOLERANCE_S
            || from_previous_s > largest
            || -from_next_s > largest
        {
            return None;
        }
        let (early, late) = (
            self.base_zero(before, rover_index),
            self.base_zero(after, rover_index),
        );
        let span_s = from_previous_s - from_next_s;
        // Flags and phases are taken from the epoch that the filter processes first.
        let (kept, other) = if backward {
            (after, before)
        } else {
            (before, after)
        };
        let (kept_zero, other_zero) = if backward {
            (&late, &early)
        } else {
            (&early, &late)
        };
        let (kept_weight, other_weight) = if backward {
            (from_previous_s / span_s, -from_next_s / span_s)
        } else {
            (-from_next_s / span_s, from_previous_s / span_s)
        };
        let slipped = |a: &Measurement, b: &Measurement, slot: usize| {
            a.slip_count[slot] != b.slip_count[slot]
                || (a.loss_of_lock[slot] ^ b.loss_of_lock[slot]) & 2 != 0
        };
        let mut zero = kept_zero.to_vec();
        for (k, z) in zero.iter_mut().enumerate() {
            let m = &self.base[kept].measurements[k];
            let partner = self.base[other].find(m.satellite);
            for slot in 0..self.options.frequencies {
                let (phase, code) = partner.map_or((0.0, 0.0), |p| {
                    let partner = &self.base[other].measurements[p];
                    let broken = slipped(m, partner, slot);
                    let phase = if broken {
                        0.0
                    } else {
                        other_zero[p].phase_m[slot]
                    };
                    (phase, other_zero[p].code_m[slot])
                });
                let blend = |mine: f64, theirs: f64| {
                    if mine == 0.0 || theirs == 0.0 {
                        0.0
                    } else {
                        mine * kept_weight + theirs * other_weight
                    }
                };
                z.phase_m[slot] = blend(z.phase_m[slot], phase);
                z.code_m[slot] = blend(z.code_m[slot], code);
            }
        }
        let noise_age_s = if self.options.measure_code_noise {
            // Error of interpolating a wandering clock: zero at either end.
            from_previous_s * -from_next_s / span_s
        } else {
            let policy = self.options.policy();
            policy.interpolation_age_s(from_previous_s, -from_next_s)
        };
        Some(BaseView {
            epoch: &self.base[kept],
            zero: zero.into(),
            place_ecef_m: self.base_position_ecef_m,
            moved: None,
            age_s: if backward {
                from_next_s
            } else {
                from_previous_s
            },
            noise_age_s,
        })
    }
}
