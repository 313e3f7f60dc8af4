//! Test of held integers by ambiguities that begin while the integers are held.
//!
//! Where half of the satellites slip at once, the other satellites carry the integers over, and few of these
//! check each other: an unflagged slip among them looks like a motion. The new ambiguities check the held
//! integers. At the position given by the held integers, new ambiguities are whole numbers up to the errors
//! of the phases; at a wrong position new ambiguities are arbitrary. A single new ambiguity that is off may
//! as well be due to a reflection, and is ignored.

use super::{EpochView, Filter};
use crate::ambiguity::attempt::{Pair, members, without};
use crate::ambiguity::evidence::Evidence;
use crate::float::state::FilterState;
use crate::linear::chi_square::chi_square_999;
use crate::measurements::signal_group::GROUPS;
use crate::measurements::zero::ZeroDifference;
use crate::observations::satellite::System;

impl Filter<'_> {
    /// Distance from whole numbers, in standard deviations (root mean square), of the ambiguities that are
    /// not held, at the position given by the held integers; `None` unless the distance is larger than errors
    /// of phases explain once in a thousand cases, whichever of these satellites is left out. `conditioned`
    /// is the state conditioned on the held integers.
    pub(super) fn new_ambiguities_contradict(
        &self,
        epoch: &EpochView<'_>,
        zero: &[ZeroDifference],
        conditioned: &FilterState,
    ) -> Option<f64> {
        // Ambiguities of GLONASS are whole numbers only if the bias between channels is known.
        let counts = |p: &&Pair| GROUPS[p.group] != [System::Glonass];
        let all: Vec<Pair> = self.all_pairs.iter().filter(counts).copied().collect();
        let held = self
            .held_pairs(&epoch.common)
            .0
            .iter()
            .filter(counts)
            .count();
        let variance = |satellite: usize, slot: usize| {
            self.phase_variance_cycles2(epoch, zero, satellite, slot)
        };
        let evidence = Evidence {
            state: conditioned,
            phase_variance_cycles2: &variance,
            all: &all,
            least_probability: 0.0,
        };
        let excess = |pairs: &[Pair]| {
            let freedom = pairs.len().checked_sub(held).filter(|&n| n > 0)?;
            let cost = evidence.cost(pairs)?;
            (cost > chi_square_999(freedom)).then(|| (cost / freedom as f64).sqrt())
        };
        let found = excess(&all)?;
        let is_new =
            |&(satellite, slot): &(usize, usize)| self.state.track(satellite, slot).held.is_none();
        let mut new = members(&all).into_iter().filter(is_new);
        new.all(|(satellite, slot)| excess(&without(&all, satellite, slot)).is_some())
            .then_some(found)
    }
}
