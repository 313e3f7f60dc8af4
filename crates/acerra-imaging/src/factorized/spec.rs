//! Where to cut the aperture, and how coarse the grids may be.

use super::interpolation::{TAPS, worst_error};
use super::lattice::coarse_grid;
use crate::Pulses;
use crate::rows::{TiltedGrid, dot, norm};
use rayon::prelude::*;
use std::ops::Range;

/// Greatest number of fine pixels in a coarse interval.
const COARSEST: usize = 32;

/// How the aperture is cut and how coarse the grids are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FactorizedSpec {
    /// Pulses in a sub-aperture.
    pub pulses: usize,
    /// Fine pixels a coarse interval, along the row and across.
    pub coarse: [usize; 2],
    /// Bound of the spatial frequencies along the row and across, cycles a metre.
    pub bandwidth_a_metre: [f64; 2],
    /// Interpolation error expected for a spectrum that fills the bound.
    pub interpolation_error: f64,
    /// Estimated cost in vector operations a pixel and pulse.
    pub cost: f64,
}

impl FactorizedSpec {
    /// The cheapest cut that keeps `accuracy`, with `direct_cost` operations a coarse value; `None`
    /// where coarse grids are of no use.
    pub fn choose(
        pulses: &Pulses,
        grid: &TiltedGrid,
        band_hz: [f64; 3],
        accuracy: f64,
        direct_cost: f64,
        lanes: usize,
    ) -> Option<Self> {
        if grid.columns < 4 * TAPS || grid.rows < 4 * TAPS {
            return None;
        }
        let steps = [norm(grid.u_m), norm(grid.v_m)];
        let mut best: Option<Self> = None;
        'counts: for count in [6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256] {
            if count > 2 * pulses.len() {
                break;
            }
            let parts = cut(pulses, count);
            let bandwidth = bandwidth_a_metre(pulses, grid, band_hz, &parts);
            let mut coarse = [1; 2];
            let mut error = 0.0;
            for axis in 0..2 {
                let coarsest = (1..=COARSEST)
                    .map(|d| (d, worst_error(bandwidth[axis] * steps[axis] * d as f64, d)))
                    .take_while(|(_, e)| *e < 0.5 * accuracy)
                    .last();
                let Some((d, e)) = coarsest else {
                    // So long a part has directions that not even the fine grid samples, and longer
                    // ones have more.
                    break 'counts;
                };
                coarse[axis] = d;
                error += e * e;
            }
            let pixels = |g: &TiltedGrid| (g.columns * g.rows) as f64;
            let share = pixels(&coarse_grid(grid, coarse)) / pixels(grid);
            // Vector operations as measured beside those of the direct engine; the second part is of
            // loads that cross cache lines.
            let merge = 75.0 / lanes as f64 + 4.6;
            let mean = pulses.len() as f64 / parts.len() as f64;
            let cost = direct_cost * share + merge / mean;
            if best.as_ref().is_none_or(|b| cost < b.cost) {
                best = Some(Self {
                    pulses: count,
                    coarse,
                    bandwidth_a_metre: bandwidth,
                    interpolation_error: f64::sqrt(error),
                    cost,
                });
            }
        }
        best
    }
}

/// Steps this many times the usual one part tracks: there and back again, or a gap.
const BREAK: f64 = 8.0;

/// Sub-apertures of at most `count` pulses: tracks, each cut into parts as even as possible. None
/// reaches across a break, where directions would differ too much for a coarse grid.
pub(crate) fn cut(pulses: &Pulses, count: usize) -> Vec<Range<usize>> {
    let position = pulses.position_m();
    let steps: Vec<f64> = position
        .windows(2)
        .map(|p| crate::reference::range_m(p[0], p[1]))
        .collect();
    let mut sorted = steps.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let usual = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let mut parts = Vec::new();
    let mut start = 0;
    for end in 1..=position.len() {
        let broken = end == position.len() || (usual > 0.0 && steps[end - 1] > BREAK * usual);
        if broken {
            let (length, pieces) = (end - start, (end - start).div_ceil(count.max(1)));
            parts.extend(
                (0..pieces).map(|k| start + k * length / pieces..start + (k + 1) * length / pieces),
            );
            start = end;
        }
    }
    parts
}

/// The mean position of some pulses.
pub(crate) fn centre_m(pulses: &Pulses, which: Range<usize>) -> [f64; 3] {
    let p = &pulses.position_m()[which];
    std::array::from_fn(|a| p.iter().map(|p| p[a]).sum::<f64>() / p.len() as f64)
}

/// Bound of the spatial frequencies of all sub-apertures along the grid's axes, from a lattice of
/// pixels that includes edges and those nearest to the sub-aperture; `band_hz` is lowest, carrier
/// and highest frequency.
fn bandwidth_a_metre(
    pulses: &Pulses,
    grid: &TiltedGrid,
    [low, carrier, high]: [f64; 3],
    parts: &[Range<usize>],
) -> [f64; 2] {
    const LATTICE: usize = 12;
    let axes = [grid.u_m, grid.v_m].map(|v| v.map(|x| x / norm(v).max(1e-300)));
    let scale = 2.0 / pulses.light_speed_m_s();
    let found: Vec<[f64; 2]> = parts
        .par_iter()
        .map(|part| {
            let centre = centre_m(pulses, part.clone());
            let mut points = Vec::with_capacity((LATTICE + 1).pow(2) + 25);
            let (i1, j1) = ((grid.columns - 1) as f64, (grid.rows - 1) as f64);
            for j in 0..=LATTICE {
                for i in 0..=LATTICE {
                    let at = |k: usize, last: f64| last * k as f64 / LATTICE as f64;
                    points.push(grid.point_m(at(i, i1), at(j, j1)));
                }
            }
            // Directions change fastest under the antenna.
            let (i, j) = grid.nearest(centre, [0.0, i1], [0.0, j1]);
            for dj in -2..=2 {
                for di in -2..=2 {
                    let at = |x: f64, d: i32, last: f64| {
                        (x + f64::from(d) * 0.5 * last / LATTICE as f64).clamp(0.0, last)
                    };
                    points.push(grid.point_m(at(i, di, i1), at(j, dj, j1)));
                }
            }
            let stride = (part.len() / 6).max(1);
            let members: Vec<usize> = part.clone().step_by(stride).chain([part.end - 1]).collect();
            let direction = |from: [f64; 3], to: [f64; 3]| {
                let d: [f64; 3] = std::array::from_fn(|a| to[a] - from[a]);
                d.map(|x| x / norm(d).max(1e-12))
            };
            let mut most = [0f64; 2];
            for point in points {
                let u_s = direction(centre, point);
                for &m in &members {
                    let u_m = direction(pulses.position_m()[m], point);
                    for (axis, most) in axes.iter().zip(&mut most) {
                        let (a, b) = (dot(u_m, *axis), carrier * dot(u_s, *axis));
                        *most = most.max((low * a - b).abs()).max((high * a - b).abs());
                    }
                }
            }
            most
        })
        .collect();
    [0, 1].map(|axis| 1.04 * scale * found.iter().map(|f| f[axis]).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn apertures_are_cut_completely_and_at_breaks() {
        let pulses_at = |position_m: &[[f64; 3]], count: usize| {
            let spectrum = vec![num_complex::Complex64::ZERO; position_m.len()];
            let weight = vec![1.0; position_m.len()];
            let pulses = Pulses::new(position_m, &[3e9], &spectrum, &weight, 3e8).unwrap();
            cut(&pulses, count)
        };
        for (number, count) in [(331, 32), (7, 8), (64, 16), (65, 16), (1, 8)] {
            let line: Vec<_> = (0..number)
                .map(|m| [0.0, 0.1 * f64::from(m), 5.0])
                .collect();
            let parts = pulses_at(&line, count);
            assert_eq!(
                (parts[0].start, parts[parts.len() - 1].end),
                (0, line.len())
            );
            assert!(parts.windows(2).all(|p| p[0].end == p[1].start));
            assert!(parts.iter().all(|p| !p.is_empty() && p.len() <= count));
        }
        // Two tracks of 20 and 15 pulses, 3 m apart.
        let mut tracks: Vec<_> = (0..20).map(|m| [0.0, 0.1 * f64::from(m), 5.0]).collect();
        tracks.extend((0..15).map(|m| [3.0, 0.1 * f64::from(m), 5.0]));
        assert_eq!(pulses_at(&tracks, 16), [0..10, 10..20, 20..35]);
        // A drone that hovers has no usual step.
        assert_eq!(pulses_at(&[[0.0, 0.0, 5.0]; 9], 5), [0..4, 4..9]);
    }
}
