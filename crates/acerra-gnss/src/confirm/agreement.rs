//! Retrospective confirmation of ambiguity fixes.
//!
//! Two passes in opposite directions of time use different codes and have different errors. Where the
//! integers of both passes give the same place, the integers are right; earlier and later fixes with these
//! integers are right too.

use super::contradiction::{Claim, contradicted};
use crate::ambiguity::fixed_integers::FixedIntegers;
use crate::filter::epoch_result::EpochResult;
use crate::observations::observation::EPOCH_TOLERANCE_S;
use crate::solution::{NotFixedReason, Quality};
use acerra_geo::time::GpsTime;
use std::sync::Arc;

/// Distance (m) below which fixes of two passes are equal, a quarter of a wavelength: fixes by neighbouring
/// integers are further apart.
const SAME_PLACE_M: f64 = 0.05;
/// Largest standard deviation (m) of a fix without a check: half a wavelength.
const LARGEST_UNCHECKED_SIGMA_M: f64 = 0.1;
/// Least duration (s) of a log for which agreement of passes alone counts: in a shorter log both passes use
/// nearly the same codes.
const AGREEMENT_S: f64 = 60.0;

/// Fixes of a pass, in ascending order of time.
#[derive(Debug, Clone)]
pub(crate) struct Witness {
    fixes: Vec<Fix>,
}

#[derive(Debug, Clone)]
struct Fix {
    tag: GpsTime,
    position_ecef_m: [f64; 3],
    integers: Arc<FixedIntegers>,
}

impl Witness {
    /// Fixes of a pass, given in the pass's order, as evidence for other passes.
    pub(crate) fn of(results: &[EpochResult]) -> Self {
        let fixed = results.iter().filter_map(|r| {
            Some(Fix {
                tag: r.tag,
                position_ecef_m: r.position_ecef_m,
                integers: r.integers.clone()?,
            })
        });
        let mut fixes: Vec<Fix> = fixed.collect();
        fixes.sort_by_key(|f| f.tag);
        Self { fixes }
    }

    /// The fixes of this pass that agree with fixes of one of `others`, as claims of pass number `pass`.
    fn claims<'a>(
        &'a self,
        pass: usize,
        others: &'a [&Witness],
    ) -> impl Iterator<Item = Claim<'a>> + 'a {
        let agreed = move |f: &&Fix| {
            let agrees = |w: &&Witness| w.agrees(f.tag, f.position_ecef_m, &f.integers).is_some();
            others.iter().any(agrees)
        };
        let claim = move |f: &'a Fix| Claim {
            tag: f.tag,
            integers: &f.integers,
            pass,
        };
        self.fixes.iter().filter(agreed).map(claim)
    }

    /// The place of the first fix at or after an epoch.
    fn from(&self, tag: GpsTime) -> usize {
        let late = |f: &Fix| f.tag.seconds_since(tag) < -EPOCH_TOLERANCE_S;
        self.fixes.partition_point(late)
    }

    /// The fix of an epoch.
    fn at(&self, tag: GpsTime) -> Option<&Fix> {
        let fix = self.fixes.get(self.from(tag))?;
        (fix.tag.seconds_since(tag) <= EPOCH_TOLERANCE_S).then_some(fix)
    }

    /// A fix of this pass that agrees with a fix of another: at the same epoch by its place, at the nearest
    /// epochs before and after by its integers.
    fn agrees(
        &self,
        tag: GpsTime,
        position_ecef_m: [f64; 3],
        integers: &FixedIntegers,
    ) -> Option<&Fix> {
        if let Some(fix) = self.at(tag) {
            return is_near(fix.position_ecef_m, position_ecef_m).then_some(fix);
        }
        let after = self.from(tag);
        let neighbours = [after.checked_sub(1), Some(after)];
        neighbours
            .into_iter()
            .filter_map(|k| self.fixes.get(k?))
            .find(|fix| fix.integers.same_as_in_another_pass(integers))
    }
}

fn is_near(a: [f64; 3], b: [f64; 3]) -> bool {
    let squares = (0..3).map(|k| (a[k] - b[k]).powi(2));
    squares.sum::<f64>().sqrt() < SAME_PLACE_M
}

/// Whether `other` has a certain fix at the epoch of a fix, elsewhere, and none of the passes in the other
/// direction has one near.
fn is_disputed(fix: &EpochResult, other: &Witness, witnesses: &[&Witness]) -> bool {
    let near = |f: &Fix| is_near(f.position_ecef_m, fix.position_ecef_m);
    let certain_elsewhere = |f: &Fix| f.integers.certain && !near(f);
    other.at(fix.tag).is_some_and(certain_elsewhere)
        && !witnesses.iter().any(|w| w.at(fix.tag).is_some_and(near))
}

/// The epochs of each pass, in order of time, whose fixes others [contradict](contradicted); the passes
/// of the other direction are given with each.
pub(crate) fn contradictions(passes: &[(&Witness, &[&Witness])]) -> Vec<Vec<GpsTime>> {
    let mut claims = Vec::new();
    for (number, (pass, others)) in passes.iter().enumerate() {
        claims.extend(pass.claims(number, others));
    }
    let mut tags = vec![Vec::new(); passes.len()];
    for (claim, contradicted) in claims.iter().zip(contradicted(&claims)) {
        if contradicted {
            tags[claim.pass].push(claim.tag);
        }
    }
    tags
}

/// Confirms the fixes of a pass by the fixes of passes in the other direction, except at the epochs
/// `contradicted` and, where the results will not be combined with the `other` pass, fixes that the `other`
/// pass [disputes](is_disputed). Returns the number of epochs at which the passes agree.
pub(crate) fn confirm_by(
    results: &mut [EpochResult],
    needed: f64,
    witnesses: &[&Witness],
    contradicted: &[GpsTime],
    other: Option<&Witness>,
) -> usize {
    let agreements: Vec<Option<bool>> = results
        .iter()
        .map(|r| {
            let own = r.integers.as_ref()?;
            let mut found = witnesses
                .iter()
                .filter_map(|w| w.agrees(r.tag, r.position_ecef_m, own))
                .peekable();
            found.peek()?;
            Some(own.certain && found.any(|f| f.integers.certain))
        })
        .collect();
    let agreeing = || (0..results.len()).filter(|&k| agreements[k].is_some());
    let span_s = agreeing()
        .next()
        .zip(agreeing().next_back())
        .map_or(0.0, |(a, z)| {
            results[z].time.seconds_since(results[a].time).abs()
        });
    let count = agreeing().count();
    let alone = |r: &EpochResult| {
        let own = r.integers.as_ref();
        span_s >= AGREEMENT_S && own.is_some_and(|own| own.is_checked_twice())
    };
    let disputes = |r: &EpochResult| other.is_some_and(|w| is_disputed(r, w, witnesses));
    let refuted: Vec<bool> = (results.iter())
        .map(|r| contradicted.binary_search(&r.tag).is_ok() || disputes(r))
        .collect();
    let anchors: Vec<bool> = agreements
        .iter()
        .zip(&*results)
        .map(|(a, r)| a.is_some_and(|certain| certain || alone(r)))
        .collect();
    // In a short log a satellite that is used by only one of the two fixes may be the faulty one.
    let wholly = span_s < AGREEMENT_S;
    keep_confirmed(results, &anchors, needed, wholly, &refuted);
    count
}

/// Confirms the fixes of one pass by the certain fixes of the same pass.
///
/// Fixes with integers that were `withdrawn` later confirm no fix and are not confirmed.
pub(crate) fn confirm_alone(results: &mut [EpochResult], needed: f64, withdrawn: &[u32]) {
    let certain = |r: &EpochResult| {
        let own = r.integers.as_ref();
        own.is_some_and(|i| i.certain && !withdrawn.contains(&i.generation))
    };
    let anchors: Vec<bool> = results.iter().map(certain).collect();
    keep_confirmed(
        results,
        &anchors,
        needed,
        false,
        &vec![false; anchors.len()],
    );
}

/// Whether redundant phases check a fix, or the fix's position is at least known to within half a wavelength.
fn is_checked(fix: &EpochResult, integers: &FixedIntegers) -> bool {
    let variance_m2: f64 = (0..3).map(|k| fix.covariance_ecef_m2[k][k]).sum();
    integers.is_checked() || variance_m2 < LARGEST_UNCHECKED_SIGMA_M.powi(2)
}

/// Declares fixes float that neither are anchors nor have the integers of the nearest anchor before or after
/// them, or that have [no check](is_checked); `wholly` requires that the fix uses no other satellite. Fixes
/// that are `refuted` are neither confirmed nor confirm any.
fn keep_confirmed(
    results: &mut [EpochResult],
    anchors: &[bool],
    needed: f64,
    wholly: bool,
    refuted: &[bool],
) {
    let linked = |own: &FixedIntegers, anchor: &FixedIntegers| {
        own.same_as(anchor) && (!wholly || own.is_part_of(anchor))
    };
    let anchors: Vec<bool> = (anchors.iter().zip(refuted))
        .map(|(anchor, refuted)| *anchor && !refuted)
        .collect();
    for (result, anchored) in results.iter_mut().zip(&anchors) {
        result.anchored = *anchored;
    }
    let mut confirmed = anchors.clone();
    let mut confirm_along = |order: &mut dyn Iterator<Item = usize>| {
        let mut nearest: Option<&Arc<FixedIntegers>> = None;
        for k in order {
            let Some(own) = &results[k].integers else {
                continue;
            };
            if refuted[k] {
                continue;
            }
            if anchors[k] || nearest.is_some_and(|certain| linked(own, certain)) {
                confirmed[k] = true;
                nearest = Some(own);
            }
        }
    };
    confirm_along(&mut (0..results.len()).rev());
    confirm_along(&mut (0..results.len()));
    for (result, confirmed) in results.iter_mut().zip(confirmed) {
        let Some(own) = result.integers.take() else {
            continue;
        };
        let checked = is_checked(result, &own);
        if !(confirmed && checked) {
            result.anchored = false;
            result.quality = Some(Quality::Float);
            result.reason = Some(if confirmed {
                NotFixedReason::NothingChecksFix
            } else {
                NotFixedReason::IntegersUncertain {
                    success_rate: own.success_rate,
                    needed,
                }
            });
            result.position_ecef_m = own.float.position_ecef_m;
            result.covariance_ecef_m2 = own.float.covariance_ecef_m2;
            result.velocity = own.float.velocity;
            if result.residuals.iter().any(|residual| residual.fixed) {
                for residual in Arc::make_mut(&mut result.residuals) {
                    residual.fixed = false;
                }
            }
        }
    }
}
