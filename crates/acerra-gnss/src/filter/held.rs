//! Settled integers, held outside the filter.
//!
//! RTKLIB's hold feeds integers back as measurements: the filter then keeps them for ever, right or wrong.
//! Here the float state is unchanged. At every epoch a copy of the float state is conditioned on the held
//! integers, and the integers are tested against the float state, which is independent of them: integers that
//! no longer fit are withdrawn, with every fix that used them.

use super::{EpochView, Filter};
use crate::ambiguity::attempt::{Attempt, Pair, is_ruled_out};
use crate::float::state::FilterState;
use crate::linear::sparse_row::SparseRow;
use crate::measurements::common::Common;
use crate::measurements::signal_group::GROUPS;
use crate::single::SinglePoint;

/// Fewest pairs whose integers determine the rover's position, with one redundant pair.
const LEAST_HELD_PAIRS: usize = 4;
/// Standard deviation of a position (m) up to which it distinguishes integers from their neighbours: a
/// quarter of a wavelength.
const LARGEST_HELD_SIGMA_M: f64 = 0.05;
/// Largest number of consecutive epochs at which the float state may contradict the held integers: multipath
/// displaces the float state temporarily.
const LARGEST_DOUBTS: u32 = 10;
/// Variance (cycle²) with which integers are imposed on the copy.
const IMPOSED_VARIANCE: f64 = 1e-6;

/// Whether a state determines the rover's position to within a fraction of a wavelength.
fn knows_its_place(state: &FilterState) -> bool {
    let variance_m2: f64 = (0..3).map(|k| state.covariance(k, k)).sum();
    variance_m2 < LARGEST_HELD_SIGMA_M * LARGEST_HELD_SIGMA_M
}

impl Filter<'_> {
    /// Whether the evidence for the integers suffices to hold them: integers fed back into the filter look
    /// certain ever after.
    pub(super) fn may_hold(&self) -> bool {
        if self.options.holds_outside_filter() {
            self.settled
        } else {
            self.certain || self.options.min_success_rate.is_none()
        }
    }

    /// Pairs of satellites whose integers are held and whose phases are used at this epoch.
    pub(super) fn held_pairs(&self, common: &[Common]) -> (Vec<Pair>, Vec<f64>) {
        let (mut pairs, mut integers) = (Vec::new(), Vec::new());
        for (group_index, group) in GROUPS.iter().enumerate() {
            for slot in 0..self.options.frequencies {
                let mut reference: Option<(usize, f64)> = None;
                for c in common {
                    let system = self.constellation.id(c.satellite).system();
                    let track = self.state.track(c.satellite, slot);
                    let Some(integer) = track.held.filter(|_| {
                        group.contains(&system) && track.valid && !track.half_cycle_flag()
                    }) else {
                        continue;
                    };
                    match reference {
                        None => reference = Some((c.satellite, integer)),
                        Some((satellite, of_reference)) => {
                            pairs.push(Pair {
                                slot,
                                group: group_index,
                                reference: satellite,
                                other: c.satellite,
                            });
                            integers.push(of_reference - integer);
                        }
                    }
                }
            }
        }
        (pairs, integers)
    }

    /// The state conditioned on the held integers; `None` where too few integers are held. Integers that
    /// contradict the float state are withdrawn.
    pub(super) fn conditioned(&mut self, common: &[Common]) -> Option<FilterState> {
        if !self.options.holds_outside_filter() {
            return None;
        }
        let (pairs, integers) = self.held_pairs(common);
        if pairs.len() < LEAST_HELD_PAIRS {
            self.rests_on_held = false;
            return self.held_state.clone().filter(knows_its_place);
        }
        self.rests_on_held = true;
        if is_ruled_out(&self.state, &pairs, &integers) {
            self.doubts += 1;
            if self.doubts >= LARGEST_DOUBTS {
                self.withdraw();
                return None;
            }
        } else {
            self.doubts = 0;
        }
        let source = self.held_state.as_ref().unwrap_or(&self.state);
        let mut state = source.copied_into(self.spare.take());
        let rows: Vec<SparseRow> = pairs
            .iter()
            .zip(&integers)
            .map(|(p, integer)| {
                let (i, j) = (
                    state.bias_index(p.reference, p.slot),
                    state.bias_index(p.other, p.slot),
                );
                SparseRow::new(&[(i, 1.0), (j, -1.0)], integer - (state.x[i] - state.x[j]))
            })
            .collect();
        let noise = state.white_noise(rows.len(), IMPOSED_VARIANCE);
        state.update(&rows, noise).then_some(state)
    }

    /// Predicts and updates the state conditioned on the held integers like the float state.
    pub(super) fn advance_held(
        &mut self,
        single: &SinglePoint,
        epoch: &EpochView<'_>,
        elapsed_s: f64,
        excluded: &[(usize, usize)],
    ) {
        let Some(held) = self.held_state.take() else {
            return;
        };
        let float = std::mem::replace(&mut self.state, held);
        self.predict(single, epoch, elapsed_s);
        let updated = self.update(epoch, excluded);
        if let Ok(update) = &updated {
            self.mark_valid(
                &update.differences.rows,
                epoch,
                &update.differences.rejected,
            );
            self.remember(epoch.rover, epoch.base);
        }
        let held = std::mem::replace(&mut self.state, float);
        self.held_state = updated.is_ok().then_some(held);
    }

    /// Withdraws all held integers, and the fixes that use them.
    pub(super) fn withdraw(&mut self) {
        for track in &mut self.state.tracks {
            track.held = None;
        }
        self.withdrawn.push(self.generation);
        self.generation += 1;
        self.held_state = None;
        self.doubts = 0;
        self.settled = false;
        self.certain = false;
        self.consecutive_fixes = 0;
        self.held = false;
    }

    /// Adds the integers of a fix to the held integers.
    pub(super) fn hold_outside_filter(&mut self, attempt: &Attempt) {
        let (pairs, integers) = (&attempt.pairs, &attempt.integers);
        let mut start = 0;
        for block in pairs.chunk_by(|a, b| (a.slot, a.group) == (b.slot, b.group)) {
            let (slot, reference) = (block[0].slot, block[0].reference);
            let integers = &integers[start..start + block.len()];
            start += block.len();
            let held = |satellite: usize| self.state.track(satellite, slot).held;
            // Integers held before give the constant between them and the new ones.
            let known = held(reference).or_else(|| {
                let mut others = block.iter().zip(integers);
                others.find_map(|(p, integer)| Some(held(p.other)? + integer))
            });
            if known.is_none() {
                self.forget_group(block[0].group, slot);
            }
            let of_reference = known.unwrap_or(0.0);
            self.state.track_mut(reference, slot).held = Some(of_reference);
            for (p, integer) in block.iter().zip(integers) {
                self.state.track_mut(p.other, slot).held = Some(of_reference - integer);
            }
        }
        self.held = true;
    }

    /// Releases the held integers of a group that shares no satellite with new integers.
    fn forget_group(&mut self, group: usize, slot: usize) {
        for satellite in 0..self.constellation.len() {
            if GROUPS[group].contains(&self.constellation.id(satellite).system()) {
                self.state.track_mut(satellite, slot).held = None;
            }
        }
    }
}
