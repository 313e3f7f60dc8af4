//! The measurement update, and the record of the phases used.

use super::{EpochView, Filter};
use crate::float::state::FilterState;
use crate::linear::double_row::DoubleRow;
use crate::measurements::common::Common;

/// Weight of the model's variance, in degrees of freedom.
const MISFIT_PRIOR: f64 = 30.0;
/// Least ratio of the true variances to the model's.
const LEAST_VARIANCE_FACTOR: f64 = 0.1;

/// Kalman update with double differences; false where it fails.
pub(super) fn update_state(state: &mut FilterState, rows: &[DoubleRow], common: &[Common]) -> bool {
    update_about(state, rows, common, None)
}

/// As [`update_state`], with differences that were formed at the state vector `about`.
fn update_about(
    state: &mut FilterState,
    rows: &[DoubleRow],
    common: &[Common],
    about: Option<&[f64]>,
) -> bool {
    let m = rows.len();
    let mut noise = state.blank(m);
    for (b, (column, rb)) in noise.chunks_exact_mut(m.max(1)).zip(rows).enumerate() {
        for (a, (r, ra)) in column.iter_mut().zip(rows).enumerate().skip(b) {
            if ra.block == rb.block {
                *r = ra.variance_reference_m2 + if a == b { ra.variance_other_m2 } else { 0.0 };
            }
            *r += ra.common_delay_m * rb.common_delay_m;
        }
    }
    let sparse: Vec<_> = rows
        .iter()
        .map(|r| {
            let satellites = [common[r.reference].satellite, common[r.other].satellite];
            let mut row = state.sparse(r, satellites);
            if let Some(about) = about {
                let products = row.coefficients().iter();
                let moved = products.map(|&(k, c)| c * (about[k] - state.x[k]));
                row.residual += moved.sum::<f64>();
            }
            row
        })
        .collect();
    state.update(&sparse, noise)
}

impl Filter<'_> {
    /// True variances over the model's, from the residuals of the codes so far; never above one, since slow
    /// errors do not show in the residuals.
    pub(super) fn variance_factor(&self) -> f64 {
        let [squares, freedom] = self.misfit;
        ((squares + MISFIT_PRIOR) / (freedom + MISFIT_PRIOR)).clamp(LEAST_VARIANCE_FACTOR, 1.0)
    }

    /// The update repeated with differences formed at the present state, from the state `prior` before the
    /// first (the iterated extended Kalman filter; Bell and Cathey 1993). RTKLIB keeps the present position
    /// with the covariance from before the update; a policy that reproduces RTKLIB's defects does so.
    pub(super) fn update_again(
        &mut self,
        prior: &FilterState,
        rows: &[DoubleRow],
        common: &[Common],
    ) -> bool {
        let present = self.state.x.clone();
        self.state.clone_from(prior);
        if self.options.policy().repeats_from_present() {
            self.state.x = present;
            return update_state(&mut self.state, rows, common);
        }
        update_about(&mut self.state, rows, common, Some(&present))
    }

    pub(super) fn measurement_update(&mut self, rows: &[DoubleRow], common: &[Common]) -> bool {
        update_state(&mut self.state, rows, common)
    }

    /// Marks the satellites whose phase was used, and counts rejections.
    pub(super) fn mark_valid(
        &mut self,
        rows: &[DoubleRow],
        epoch: &EpochView<'_>,
        rejected: &[(usize, usize)],
    ) {
        let common = &epoch.common[..];
        let policy = self.options.policy();
        for track in &mut self.state.tracks {
            track.valid = false;
            track.in_fix = false;
        }
        for row in rows.iter().filter(|r| !r.is_code) {
            for k in [row.reference, row.other] {
                self.state.track_mut(common[k].satellite, row.slot).valid = true;
            }
        }
        let mut counted = vec![false; self.state.tracks.len()];
        for row in rows.iter().filter(|r| r.is_code) {
            for k in [row.reference, row.other] {
                let satellite = common[k].satellite;
                let place = row.slot * self.constellation.len() + satellite;
                if !std::mem::replace(&mut counted[place], true) {
                    let inflation = epoch.inflation.get(k).map_or(1.0, |of| of[row.slot]);
                    self.state.track_mut(satellite, row.slot).codes_used += 1.0 / inflation;
                }
            }
        }
        for &(k, slot) in rejected {
            let track = self.state.track_mut(common[k].satellite, slot);
            track.rejections += 1;
            if policy.rejected_phases_are_invalid() {
                track.valid = false;
            }
        }
        for track in self.state.tracks.iter_mut().filter(|t| t.valid) {
            track.outage = 0;
            track.lock = policy.next_lock(track.lock);
        }
    }

    /// Satellites used on the first frequency (by phase; by code in differential mode).
    pub(super) fn count_valid(&self, rows: &[DoubleRow], common: &[Common]) -> usize {
        let by_code = !self.uses_phase();
        let mut used = vec![false; common.len()];
        for row in rows.iter().filter(|r| r.slot == 0 && r.is_code == by_code) {
            used[row.reference] = true;
            used[row.other] = true;
        }
        used.iter().filter(|&&u| u).count()
    }
}
