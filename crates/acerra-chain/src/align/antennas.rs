//! Separate transmitter and receiver of every trace.

use std::ops::Range;

use acerra_geo::trajectory::Attitude;

use crate::read::trace_positions::TracePositions;

/// Vectors from each trace's position to transmitter and receiver (m).
pub(super) type FromPlace = Vec<[[f64; 3]; 2]>;

/// Transmitter and receiver of the traces as a file states them; empty for monostatic traces, `None` where
/// there are fewer antennas than traces.
pub(super) fn in_file(
    places: &TracePositions,
    traces: impl Iterator<Item = usize>,
) -> Option<FromPlace> {
    let Some(antennas_m) = &places.antennas_m else {
        return Some(Vec::new());
    };
    let from_place = |trace: usize| {
        let place = places.position_m.get(trace)?;
        let [transmitter, receiver] = antennas_m.each_ref().map(|all| all.get(trace));
        let offset = |antenna: &[f64; 3]| std::array::from_fn(|axis| antenna[axis] - place[axis]);
        Some([offset(transmitter?), offset(receiver?)])
    };
    traces.map(from_place).collect()
}

/// Transmitter and receiver at ± half of `offset_m` (forward, left, up; from the receiver to the transmitter)
/// from each position: in the axes of the recorded attitude, or, without a recorded attitude, level and along
/// the path of the trace's line. `None` where neither direction is known, as on a line at rest.
pub(super) fn by_offset(
    offset_m: [f64; 3],
    position_m: &[[f64; 3]],
    attitudes: &[Option<Attitude>],
    lines: &[Range<usize>],
) -> Option<FromPlace> {
    let headings = lines
        .iter()
        .flat_map(|line| along(&position_m[line.clone()]));
    let half_m = offset_m.map(|m| 0.5 * m);
    attitudes
        .iter()
        .zip(headings)
        .map(|(recorded, heading)| {
            let transmitter = (*recorded).or(heading)?.rotate(half_m);
            Some([transmitter, transmitter.map(|m| -m)])
        })
        .collect()
}

/// Level attitudes with the nose along the path; at rest the nose keeps the last direction of motion, or
/// takes the next one.
fn along(position_m: &[[f64; 3]]) -> Vec<Option<Attitude>> {
    /// Least step that determines a direction (m).
    const LEAST_M: f64 = 1e-4;
    let last = position_m.len().saturating_sub(1);
    let own = |k: usize| {
        let (from, to) = (
            position_m[k.saturating_sub(1)],
            position_m[(k + 1).min(last)],
        );
        let [east, north] = [to[0] - from[0], to[1] - from[1]];
        (east.hypot(north) >= LEAST_M).then(|| Attitude::from_heading(east.atan2(north)))
    };
    let mut known: Vec<Option<Attitude>> = (0..position_m.len()).map(own).collect();
    for k in 1..known.len() {
        known[k] = known[k].or(known[k - 1]);
    }
    for k in (0..last).rev() {
        known[k] = known[k].or(known[k + 1]);
    }
    known
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn antennas_turn_with_their_line_and_with_the_attitude() {
        // East along the first line, back west along the second, which rests at its beginning.
        let position_m = [
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [2.0, 0.0, 1.0],
            [2.0, 5.0, 1.0],
            [2.0, 5.0, 1.0],
            [1.0, 5.0, 1.0],
        ];
        let lines = [0..3, 3..6];
        let offset_m = [0.2, 0.04, 0.0];
        let level = by_offset(offset_m, &position_m, &[None; 6], &lines).unwrap();
        let near = |found: [f64; 3], expected: [f64; 3]| {
            for k in 0..3 {
                assert!((found[k] - expected[k]).abs() < 1e-12, "{found:?}");
            }
        };
        near(level[0][0], [0.1, 0.02, 0.0]);
        near(level[2][1], [-0.1, -0.02, 0.0]);
        near(level[3][0], [-0.1, -0.02, 0.0]);
        near(level[5][0], [-0.1, -0.02, 0.0]);
        // The nose to the north, whatever the path.
        let north = [Some(Attitude::from_heading(0.0)); 6];
        let turned = by_offset(offset_m, &position_m, &north, &lines).unwrap();
        near(turned[0][0], [-0.02, 0.1, 0.0]);
        assert!(
            by_offset(
                offset_m,
                &[[0.0; 3]; 3],
                &[None; 3],
                std::slice::from_ref(&(0..3))
            )
            .is_none()
        );
    }
}
