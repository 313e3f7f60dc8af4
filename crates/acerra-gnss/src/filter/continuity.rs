//! Detection of unflagged slips from the phases' changes since the last epoch.

use super::last_phases::{LastPhases, PhaseDifference};
use super::{EpochView, Filter};
use crate::float::time_difference::{PhaseChange, robust_fit};
use crate::measurements::noise::{Separation, SignalView, single_difference_variance_m2};
use crate::single::SinglePoint;
use crate::stations::epoch_input::UnflaggedSlips;
use std::sync::Arc;

/// Longest time (s) over which phases are compared: the atmosphere and the model of the orbits
/// change by less than a centimetre.
const LONGEST_S: f64 = 60.0;
/// Number of standard deviations beyond which a residual is a slip.
const SLIP_SIGMA: f64 = 5.0;
/// Number of cycles beyond which a residual is a slip, whatever the noise: half a cycle is the smallest slip.
const SLIP_CYCLES: f64 = 0.4;

impl Filter<'_> {
    /// The phases (common index, slot) of this epoch whose change since the last epoch contradicts the other
    /// phases. The result depends on the epochs only, so that the first pass of a direction computes it for
    /// all passes.
    pub(super) fn unflagged_slips(
        &mut self,
        epoch: &EpochView<'_>,
        single: &SinglePoint,
    ) -> UnflaggedSlips {
        let place_ecef_m = single.position_ecef_m;
        let zero = self.zero_at(epoch.rover, place_ecef_m);
        let tag = epoch.rover.epoch.tag;
        let last = std::mem::take(&mut self.last_phases);
        let moved: [f64; 3] = std::array::from_fn(|k| place_ecef_m[k] - last.place_ecef_m[k]);
        let recent = (last.tag).is_some_and(|t| tag.seconds_since(t).abs() <= LONGEST_S);
        let (mut now, mut changes, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for (k, c) in epoch.common.iter().enumerate() {
            let (u, b) = (&zero[c.rover], &epoch.base.zero[c.base]);
            let rover = &epoch.rover.epoch.measurements[c.rover];
            let base = &epoch.base.epoch.measurements[c.base];
            for slot in 0..self.options.frequencies {
                let wavelength_m = epoch.wavelengths_m[k][slot];
                if u.phase_m[slot] == 0.0 || b.phase_m[slot] == 0.0 || wavelength_m == 0.0 {
                    continue;
                }
                let own = PhaseDifference {
                    satellite: c.satellite,
                    slot,
                    difference_m: u.phase_m[slot] - b.phase_m[slot],
                    unit_ecef: u.unit_ecef,
                    slips: [rover.slip_count[slot], base.slip_count[slot]],
                };
                now.push(own);
                let key = (own.satellite, slot);
                let found = last
                    .differences
                    .binary_search_by_key(&key, |d| (d.satellite, d.slot));
                let (Ok(found), true) = (found, recent) else {
                    continue;
                };
                let before = &last.differences[found];
                let along: f64 = (0..3).map(|a| before.unit_ecef[a] * moved[a]).sum();
                let signal = SignalView {
                    system: self.constellation.id(c.satellite).system(),
                    slot,
                    is_code: false,
                    sin_elevation: u.sin_elevation,
                    cn0_db_hz: [u.cn0_db_hz[slot], b.cn0_db_hz[slot]],
                    noise_power: [u.noise_power[slot], b.noise_power[slot]],
                };
                let variance_m2 =
                    single_difference_variance_m2(self.options, &signal, Separation::NONE);
                changes.push(PhaseChange {
                    change_m: own.difference_m - before.difference_m - along,
                    unit_ecef: own.unit_ecef,
                    sigma_m: (2.0 * variance_m2).sqrt(),
                    trusted: before.slips == own.slips,
                });
                places.push((k, slot, wavelength_m));
            }
        }
        now.sort_unstable_by_key(|d| (d.satellite, d.slot));
        self.last_phases = LastPhases {
            tag: Some(tag),
            place_ecef_m,
            differences: now,
        };
        let known = &epoch.rover.unflagged_slips[usize::from(self.backward)];
        Arc::clone(known.get_or_init(|| contradicting(&changes, &places).into()))
    }
}

/// The phases (common index, slot, wavelength in `places`) whose change contradicts that of the others.
fn contradicting(changes: &[PhaseChange], places: &[(usize, usize, f64)]) -> Vec<(usize, usize)> {
    let Some(fit) = robust_fit(changes) else {
        return Vec::new();
    };
    let slipped = |k: usize| {
        let limit_m = (SLIP_SIGMA * fit.scale * changes[k].sigma_m).min(SLIP_CYCLES * places[k].2);
        changes[k].trusted && fit.residuals_m[k].abs() > limit_m
    };
    (0..changes.len())
        .filter(|&k| slipped(k))
        .map(|k| (places[k].0, places[k].1))
        .collect()
}
