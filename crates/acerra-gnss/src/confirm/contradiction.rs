//! Fixes that contradict each other.
//!
//! The integer of a phase is constant as long as the phase does not slip. Of two fixes with different
//! integers for the same unbroken phases at least one is wrong, however good each fix looks at its epoch, and
//! however many passes find it: reflections and biased codes are the same in every pass. Integers of a single
//! satellite count as well: one cycle of a satellite near the zenith is a height that is a wavelength off,
//! and a slip in between would have been noticed by the phases' changes from epoch to epoch.

use crate::ambiguity::fixed_integers::{Continuity, FixedIntegers};
use acerra_geo::time::GpsTime;

/// Equal differences that identify fixes of one set of integers: a position is determined by three.
const LEAST_KEPT: usize = 3;
/// Largest number of satellites with different integers in two passes of equal position at an epoch: a
/// satellite that has just risen in one of the passes.
const LARGEST_DIFFERENT_AT_ONE_EPOCH: usize = 1;
/// Largest number of earlier sets compared: where every epoch has its own set, none is worth more than
/// another.
const LARGEST_SETS: usize = 64;

/// A fix that a pass in the other direction has found too.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Claim<'a> {
    pub tag: GpsTime,
    pub integers: &'a FixedIntegers,
    /// Number of the fix's pass.
    pub pass: usize,
}

impl Claim<'_> {
    /// Whether both fixes belong to one set of integers, to sets that contradict each other, or neither.
    ///
    /// The slips between two epochs are known only within one pass.
    fn agrees(&self, other: &Self) -> Option<bool> {
        let at_one_epoch = self.tag == other.tag;
        if !at_one_epoch && self.pass != other.pass {
            return None;
        }
        let Continuity { kept, changed } = self.integers.continuity(other.integers, at_one_epoch);
        let largest = if at_one_epoch {
            LARGEST_DIFFERENT_AT_ONE_EPOCH
        } else {
            0
        };
        if changed > largest {
            return Some(false);
        }
        (kept >= LEAST_KEPT).then_some(true)
    }
}

/// Fixes with one set of integers.
struct Set {
    /// Indices of the fixes, the latest last.
    members: Vec<usize>,
    /// Index of the latest fix of each pass.
    latest: Vec<Option<usize>>,
    /// Number of epochs at which the phases support the set against all others.
    certain_epochs: usize,
    /// Indices of the sets that this set contradicts.
    against: Vec<usize>,
}

impl Set {
    fn new(passes: usize) -> Self {
        Self {
            members: Vec::new(),
            latest: vec![None; passes],
            certain_epochs: 0,
            against: Vec::new(),
        }
    }

    /// Whether a later fix belongs to this set, contradicts this set, or neither.
    fn admits(&self, claims: &[Claim<'_>], later: &Claim<'_>) -> Option<bool> {
        let of_epoch = self.members.iter().rev();
        let of_epoch = of_epoch.take_while(|&&k| claims[k].tag == later.tag);
        let compared = self.latest[later.pass].iter().chain(of_epoch);
        let answers: Vec<bool> = compared.filter_map(|&k| later.agrees(&claims[k])).collect();
        if answers.contains(&false) {
            return Some(false);
        }
        (!answers.is_empty()).then_some(true)
    }

    fn take(&mut self, place: usize, claims: &[Claim<'_>]) {
        let claim = &claims[place];
        let of_epoch = self.members.iter().rev();
        let mut of_epoch = of_epoch.take_while(|&&k| claims[k].tag == claim.tag);
        let counted = of_epoch.any(|&k| claims[k].integers.certain);
        self.certain_epochs += usize::from(claim.integers.certain && !counted);
        self.members.push(place);
        self.latest[claim.pass] = Some(place);
    }
}

/// Whether each claim is contradicted by claims that are certain at no fewer epochs.
///
/// Integers that are certain by themselves are wrong in one of a hundred cases, and then for as long as the
/// reflections that support them last: of two sets the one that is certain for longer is far likelier to be
/// right. Of two uncertain sets neither is accepted.
pub(crate) fn contradicted(claims: &[Claim<'_>]) -> Vec<bool> {
    let passes = claims.iter().map(|c| c.pass + 1).max().unwrap_or(0);
    let mut order: Vec<usize> = (0..claims.len()).collect();
    order.sort_by_key(|&k| claims[k].tag);
    let mut sets: Vec<Set> = Vec::new();
    for k in order {
        let recent = sets.len().saturating_sub(LARGEST_SETS);
        let relations: Vec<(usize, bool)> = (recent..sets.len())
            .rev()
            .filter_map(|place| Some((place, sets[place].admits(claims, &claims[k])?)))
            .collect();
        let mut alike = relations.iter().filter(|(_, same)| *same);
        let place = alike.next().map_or(sets.len(), |(place, _)| *place);
        if place == sets.len() {
            sets.push(Set::new(passes));
        }
        sets[place].take(k, claims);
        for (other, same) in relations {
            if !same && !sets[place].against.contains(&other) {
                sets[place].against.push(other);
                sets[other].against.push(place);
            }
        }
    }
    let mut found = vec![false; claims.len()];
    for set in &sets {
        let mut against = set.against.iter();
        if against.any(|&other| sets[other].certain_epochs >= set.certain_epochs) {
            for &k in &set.members {
                found[k] = true;
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Time (s), pass, integers, slips, and whether it is certain.
    type Made = (f64, usize, [f64; 4], [u32; 4], bool);

    fn of(claims: &[Made]) -> Vec<bool> {
        let made: Vec<FixedIntegers> = claims
            .iter()
            .map(|(_, _, integers, slips, certain)| {
                FixedIntegers::of_one_block(integers, slips, *certain)
            })
            .collect();
        let claims: Vec<Claim<'_>> = claims
            .iter()
            .zip(&made)
            .map(|((since_s, pass, ..), integers)| Claim {
                tag: GpsTime::new(0, 0.0) + *since_s,
                integers,
                pass: *pass,
            })
            .collect();
        contradicted(&claims)
    }

    const HERE: [f64; 4] = [3.0, -2.0, 7.0, 1.0];
    const THERE: [f64; 4] = [4.0, -5.0, 7.0, 3.0];
    const UNBROKEN: [u32; 4] = [0; 4];

    #[test]
    fn of_two_places_along_unbroken_phases_neither_is_believed() {
        let first = (0.0, 0, HERE, UNBROKEN, false);
        let second = (9.0, 0, THERE, UNBROKEN, false);
        assert_eq!(of(&[first, second]), [true, true]);
    }

    #[test]
    fn the_place_that_is_certain_is_believed() {
        let first = (0.0, 0, HERE, UNBROKEN, false);
        let second = (9.0, 0, THERE, UNBROKEN, true);
        assert_eq!(of(&[first, second]), [true, false]);
    }

    #[test]
    fn after_slips_integers_are_others() {
        let first = (0.0, 0, HERE, UNBROKEN, false);
        let second = (9.0, 0, THERE, [1, 1, 1, 1], false);
        assert_eq!(of(&[first, second]), [false, false]);
    }

    #[test]
    fn one_satellite_that_changes_unbroken_suffices_and_between_passes_does_not() {
        let other = [3.0, -2.0, 7.0, 2.0];
        let first = (0.0, 0, HERE, UNBROKEN, false);
        let later = (9.0, 0, other, UNBROKEN, false);
        assert_eq!(of(&[first, later]), [true, true]);
        let other_pass = (0.0, 1, other, UNBROKEN, false);
        assert_eq!(of(&[first, other_pass]), [false, false]);
    }

    #[test]
    fn passes_that_meet_at_an_epoch_share_what_contradicts_either() {
        let claims = [
            (0.0, 0, HERE, UNBROKEN, false),
            (9.0, 0, THERE, UNBROKEN, false),
            (9.0, 1, THERE, UNBROKEN, false),
            (20.0, 1, THERE, UNBROKEN, false),
        ];
        assert_eq!(of(&claims), [true; 4]);
    }
}
