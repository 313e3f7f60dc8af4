//! Check of pseudoranges against the receiver's position: a wrong pseudorange gives the satellite's state at
//! a wrong time.

use super::constellation::{Constellation, SatelliteState, Unusable};
use super::measurement::Epoch;
use crate::linear::outliers::median;
use crate::observations::satellite::System;
use crate::observations::signal::SPEED_OF_LIGHT_M_S;
use crate::orbits::geometry::line_of_sight;

/// Pseudoranges further than this from their system's median are wrong (m): beyond delays in the
/// atmosphere and errors of the place, and within a microsecond, in which a satellite moves 4 mm.
const LARGEST_DEPARTURE_M: f64 = 300.0;

/// Marks the states of satellites whose pseudoranges disagree with a receiver at `place_ecef_m`; all states
/// where more than a third disagree, as in an epoch with a wrong tag. Returns whether any state was marked.
pub(crate) fn reject_implausible(
    constellation: &Constellation,
    epoch: &Epoch,
    states: &mut [Result<SatelliteState, Unusable>],
    place_ecef_m: [f64; 3],
) -> bool {
    // The time scales of systems may differ by delays in the receivers.
    let scale = |system| match system {
        System::Qzss | System::Sbas => System::Gps,
        other => other,
    };
    let departures: Vec<Option<(System, f64)>> = epoch
        .measurements
        .iter()
        .zip(&*states)
        .map(|(m, state)| {
            let state = state.as_ref().ok()?;
            let range_m = line_of_sight(state.position_ecef_m, place_ecef_m)?.range_m;
            let expected_m = range_m - SPEED_OF_LIGHT_M_S * state.clock_s;
            let system = constellation.id(m.satellite).system();
            Some((scale(system), m.any_pseudorange_m() - expected_m))
        })
        .collect();
    let mut wrong = vec![false; states.len()];
    for system in System::ALL {
        let own = || {
            let known = departures.iter().enumerate();
            known.filter_map(move |(k, d)| d.filter(|(s, _)| *s == system).map(|(_, m)| (k, m)))
        };
        let middle = median(own().map(|(_, m)| m).collect());
        for (k, m) in own() {
            wrong[k] = (m - middle).abs() > LARGEST_DEPARTURE_M;
        }
    }
    let all = 3 * wrong.iter().filter(|w| **w).count() > departures.iter().flatten().count();
    let mut any = false;
    for (state, wrong) in states.iter_mut().zip(wrong) {
        if state.is_ok() && (wrong || all) {
            *state = Err(Unusable::ImplausiblePseudorange);
            any = true;
        }
    }
    any
}
