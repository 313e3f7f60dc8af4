//! Segments of the aperture by their distance from the image.
//!
//! The directions of far pulses change little from pulse to pulse and from pixel to pixel: far sub-apertures
//! may be longer and their grids coarser than those of near ones. On a long track each segment therefore has
//! a separate partition.

use crate::grid::tilted::TiltedGrid;
use crate::pulses::Pulses;
use crate::vector::range_m;
use std::ops::Range;

/// Ratio of the distances of neighbouring segments.
const RATIO: f64 = 2.0;
/// Least number of pulses of a segment: adding a segment's image takes about as long as imaging a few pulses.
const LEAST: usize = 256;
/// Greatest number of segments: more indicate many passes rather than a long track.
const MOST: usize = 40;

/// Runs of neighbouring pulses whose distances from the image are within a factor of two; short runs are
/// joined to their neighbours. A single run where there would be more than [`MOST`].
pub(crate) fn segments(pulses: &Pulses, grid: &TiltedGrid) -> Vec<Range<usize>> {
    let whole = 0..pulses.len();
    let last = [grid.columns, grid.rows].map(|n| (n - 1) as f64);
    let distance_m = |p: &[f64; 3]| {
        let (i, j) = grid.nearest(*p, [0.0, last[0]], [0.0, last[1]]);
        range_m(*p, grid.point_m(i, j))
    };
    let distances_m: Vec<f64> = pulses.position_m().iter().map(distance_m).collect();
    let nearest_m = distances_m.iter().copied().fold(f64::INFINITY, f64::min);
    if !(nearest_m > 0.0 && nearest_m.is_finite()) {
        return vec![whole];
    }
    let class = |d: &f64| (d / nearest_m).log(RATIO).floor() as i32;
    let mut runs: Vec<(i32, Range<usize>)> = Vec::new();
    for (m, d) in distances_m.iter().enumerate() {
        match runs.last_mut() {
            Some((of_run, run)) if *of_run == class(d) => run.end = m + 1,
            _ => runs.push((class(d), m..m + 1)),
        }
    }
    if runs.len() <= 100 * MOST {
        join_short(&mut runs);
    }
    if runs.len() > MOST {
        return vec![whole];
    }
    runs.into_iter().map(|run| run.1).collect()
}

/// Joins runs of fewer than [`LEAST`] pulses to the shorter neighbour, the shortest run first, and
/// neighbours of one class.
fn join_short(runs: &mut Vec<(i32, Range<usize>)>) {
    while runs.len() > 1 {
        let shortest = (0..runs.len())
            .min_by_key(|k| runs[*k].1.len())
            .unwrap_or(0);
        if runs[shortest].1.len() >= LEAST {
            break;
        }
        let length = |k: Option<usize>| {
            k.and_then(|k| runs.get(k))
                .map_or(usize::MAX, |r| r.1.len())
        };
        let before = length(shortest.checked_sub(1));
        let first = if before < length(Some(shortest + 1)) {
            shortest - 1
        } else {
            shortest
        };
        let (class, run) = runs.remove(first + 1);
        runs[first].0 = runs[first].0.min(class);
        runs[first].1.end = run.end;
        runs.dedup_by(|b, a| {
            let same = a.0 == b.0;
            if same {
                a.1.end = b.1.end;
            }
            same
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::plane::PlaneGrid;
    use crate::pulses::PulseArrays;
    use num_complex::Complex64;

    fn of(position_m: &[[f64; 3]]) -> Vec<Range<usize>> {
        let spectrum = vec![Complex64::ZERO; position_m.len()];
        let weight = vec![1.0; position_m.len()];
        let pulses = Pulses::new(PulseArrays {
            position_m,
            frequency_hz: &[3e9],
            spectrum: &spectrum,
            weight: &weight,
            light_speed_m_s: 3e8,
        })
        .unwrap();
        let grid = PlaneGrid::new([-5.0, -5.0, 0.0], 0.1, [101, 101]).unwrap();
        segments(&pulses, &grid.into())
    }

    #[test]
    fn a_long_track_has_segments_of_doubling_distance() {
        let track: Vec<_> = (0..20_000)
            .map(|m| [0.0, 0.05 * f64::from(m) - 500.0, 5.0])
            .collect();
        let found = of(&track);
        assert_eq!((found[0].start, found[found.len() - 1].end), (0, 20_000));
        assert!(found.windows(2).all(|w| w[0].end == w[1].start));
        assert!(found.len() > 8 && found.iter().all(|r| r.len() >= LEAST));
        // The segment over the image reaches until the distance has doubled: sqrt(10² − 5²) beyond the
        // image's edge.
        let middle = found.iter().find(|r| r.contains(&10_000)).unwrap();
        let reach_m = 0.05 * middle.len() as f64;
        assert!(
            (reach_m - 2.0 * (5.0 + 75f64.sqrt())).abs() < 0.2,
            "{reach_m}"
        );
    }

    #[test]
    fn short_tracks_and_many_passes_stay_whole() {
        let short: Vec<_> = (0..400)
            .map(|m| [0.0, 0.05 * f64::from(m) - 10.0, 5.0])
            .collect();
        let found = of(&short);
        assert_eq!((found.len(), found[0].clone()), (1, 0..400));
        let passes: Vec<_> = (0..40_000)
            .map(|m| {
                [
                    0.01 * f64::from(m / 400),
                    0.5 * f64::from(m % 400) - 100.0,
                    5.0,
                ]
            })
            .collect();
        let found = of(&passes);
        assert!(found.len() <= MOST, "{}", found.len());
        assert_eq!((found[0].start, found[found.len() - 1].end), (0, 40_000));
    }
}
