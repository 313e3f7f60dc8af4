//! Interpolation of positions and clocks.

use acerra_geo::time::GpsTime;

use super::state::EARTH_ROTATION_RAD_S;

/// Number of positions of an interpolation.
pub(super) const NODES: usize = 11;
/// Ratio of steps between positions above which a step is a gap.
const STEP_RATIO: f64 = 1.5;

/// The eleven positions around `t`, as central as possible; `None` where `t` is not between the first and the
/// last position or a step is longer than the others.
pub(super) fn window(nodes: &[(GpsTime, [f64; 3])], t: GpsTime) -> Option<&[(GpsTime, [f64; 3])]> {
    let after = nodes.partition_point(|(time, _)| *time <= t);
    let last_start = nodes.len().checked_sub(NODES)?;
    let start = after.saturating_sub(NODES.div_ceil(2)).min(last_start);
    let taken = &nodes[start..start + NODES];
    let steps = || {
        taken
            .windows(2)
            .map(|pair| pair[1].0.seconds_since(pair[0].0))
    };
    let shortest = steps().fold(f64::INFINITY, f64::min);
    let longest = steps().fold(0.0, f64::max);
    let inside = taken[0].0 <= t && t <= taken[NODES - 1].0;
    (inside && longest <= STEP_RATIO * shortest).then_some(taken)
}

/// The position at `t` (ECEF at `t`, m) by Neville's scheme.
///
/// The positions are first rotated into the axes at `t`, since an orbit is smooth in axes that do not rotate
/// (Schenewerk, GPS Solutions 6, 2003).
pub(super) fn orbit(nodes: &[(GpsTime, [f64; 3])], t: GpsTime) -> [f64; 3] {
    let mut table: Vec<(f64, [f64; 3])> = nodes
        .iter()
        .map(|&(time, [x, y, z])| {
            let after_s = time.seconds_since(t);
            let (sin, cos) = (EARTH_ROTATION_RAD_S * after_s).sin_cos();
            (after_s, [cos * x - sin * y, sin * x + cos * y, z])
        })
        .collect();
    let count = table.len();
    for level in 1..count {
        for i in 0..count - level {
            let (a, b) = (table[i].0, table[i + level].0);
            let next = table[i + 1].1;
            for (value, next) in table[i].1.iter_mut().zip(next) {
                *value = (b * *value - a * next) / (b - a);
            }
        }
    }
    table.first().map_or([0.0; 3], |(_, position)| *position)
}

/// The clock at `t` (s) on the straight line between its neighbours, where these are no farther
/// apart than `max_step_s`.
pub(super) fn clock(nodes: &[(GpsTime, f64)], t: GpsTime, max_step_s: f64) -> Option<f64> {
    let after = nodes.partition_point(|(time, _)| *time <= t);
    let (time, value) = *nodes.get(after.checked_sub(1)?)?;
    let since_s = t.seconds_since(time);
    if since_s == 0.0 {
        return Some(value);
    }
    let (next_time, next) = *nodes.get(after)?;
    let step_s = next_time.seconds_since(time);
    (step_s <= max_step_s).then(|| value + (next - value) * since_s / step_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS_M: f64 = 26_560e3;
    const RATE_RAD_S: f64 = 1.458_5e-4;

    fn start() -> GpsTime {
        GpsTime::from_week_tow(2262, 0.0)
    }

    /// A circular orbit of GPS, inclined by 55°, in axes that rotate with the Earth.
    fn position(after_s: f64) -> [f64; 3] {
        let (sin, cos) = (RATE_RAD_S * after_s).sin_cos();
        let (sin_i, cos_i) = 55f64.to_radians().sin_cos();
        let inertial = [
            RADIUS_M * cos,
            RADIUS_M * sin * cos_i,
            RADIUS_M * sin * sin_i,
        ];
        let (s, c) = (EARTH_ROTATION_RAD_S * after_s).sin_cos();
        let [x, y, z] = inertial;
        [c * x + s * y, -s * x + c * y, z]
    }

    fn nodes(steps: impl IntoIterator<Item = i32>) -> Vec<(GpsTime, [f64; 3])> {
        let node = |k: i32| {
            let after_s = 900.0 * f64::from(k);
            (start() + after_s, position(after_s))
        };
        steps.into_iter().map(node).collect()
    }

    #[test]
    fn a_quarter_of_an_hour_is_bridged_to_the_millimetre() {
        let nodes = nodes(0..97);
        for after_s in [5.0 * 900.0, 40_000.123, 43_650.0, 80_000.0] {
            let t = start() + after_s;
            let found = orbit(window(&nodes, t).unwrap(), t);
            for (found, truth) in found.iter().zip(position(after_s)) {
                assert!((found - truth).abs() < 1e-3, "{after_s}: {found} {truth}");
            }
        }
        // At the ends, where all positions lie on one side, errors are still centimetres.
        let t = start() + 450.0;
        let found = orbit(window(&nodes, t).unwrap(), t);
        for (found, truth) in found.iter().zip(position(450.0)) {
            assert!((found - truth).abs() < 0.05, "{found} {truth}");
        }
    }

    #[test]
    fn gaps_and_ends_are_not_bridged() {
        let with_gap = nodes((0..20).chain(22..60));
        let at = |k: f64| window(&with_gap, start() + 900.0 * k).is_some();
        assert!(at(10.0) && at(40.0));
        assert!(!at(20.5), "inside the gap");
        assert!(!at(19.0), "the gap is among the nearest eleven");
        assert!(!at(-0.1) && !at(59.1), "outside");
        assert!(at(0.0) && at(59.0), "at the very ends");
        assert!(window(&nodes(0..10), start() + 3600.0).is_none(), "too few");
    }

    #[test]
    fn clocks_lie_on_lines() {
        let nodes = [
            (start(), 1e-6),
            (start() + 30.0, 2e-6),
            (start() + 90.0, 4e-6),
        ];
        let at = |s: f64| clock(&nodes, start() + s, 31.0);
        assert_eq!((at(0.0), at(30.0)), (Some(1e-6), Some(2e-6)));
        assert!((at(15.0).unwrap() - 1.5e-6).abs() < 1e-18);
        assert_eq!((at(60.0), at(-1.0), at(91.0)), (None, None, None));
        assert_eq!(at(90.0), Some(4e-6));
    }
}
