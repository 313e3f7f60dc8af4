//! The factorized engine: sub-apertures imaged on coarse grids, then merged.
//!
//! Neighbouring pulses look at a pixel from nearly the same direction. Once the carrier's phase of
//! the range to a sub-aperture's centre is taken out, what its pulses add up to varies slowly over
//! the image: its spatial frequencies are bounded by (2/c)·|f·u_m − f_c·u_s|, u being the unit
//! vectors from pulse and centre to the pixel projected on the grid's axes. The direct engine
//! images each sub-aperture on a grid just fine enough for that; rows of the fine grid follow by
//! separable least-squares interpolation, and get their phase back. Any trajectory and any height
//! will do: a scattered track merely has a wide bound, and is left to the direct engine.

use crate::direct::{Direct, DirectSpec, table_ranges_m};
use crate::rows::{TiltedGrid, dot, norm};
use crate::simd::merge::{MergeRow, merge_row};
use crate::simd::{MAX_LANES, SimdLevel, dispatch};
use crate::{Pulses, Spreading, reference};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;

/// Coarse samples that an interpolated value is made of, in either direction.
pub(crate) const TAPS: usize = 12;
/// Coarse samples before the interval that a value lies in.
const BEFORE: usize = TAPS / 2 - 1;
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
        for count in [6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256] {
            if count > 2 * pulses.len() {
                break;
            }
            let count = balanced(pulses.len(), count);
            let bandwidth = bandwidth_a_metre(pulses, grid, band_hz, count);
            let mut coarse = [1; 2];
            let mut error = 0.0;
            for axis in 0..2 {
                let (d, e) = (1..=COARSEST)
                    .map(|d| (d, worst_error(bandwidth[axis] * steps[axis] * d as f64, d)))
                    .take_while(|(_, e)| *e < 0.5 * accuracy)
                    .last()?;
                coarse[axis] = d;
                error += e * e;
            }
            let [dx, dy] = coarse.map(|d| d as f64);
            let pad = (1.0 + TAPS as f64 * dx / grid.columns as f64)
                * (1.0 + TAPS as f64 * dy / grid.rows as f64);
            let merge = (2.0 * TAPS as f64 * (1.0 + 1.0 / dx) + 48.0) / lanes as f64;
            let cost = direct_cost * pad / (dx * dy) + merge / count as f64;
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

/// A sub-aperture size near `wanted` that cuts `pulses` into parts as even as possible.
fn balanced(pulses: usize, wanted: usize) -> usize {
    let parts = pulses.div_ceil(wanted);
    pulses.div_ceil(parts)
}

/// Pulse ranges of sub-apertures of at most `count` pulses.
fn cut(pulses: usize, count: usize) -> impl Iterator<Item = Range<usize>> {
    (0..pulses.div_ceil(count)).map(move |k| k * count..((k + 1) * count).min(pulses))
}

/// The mean position of some pulses.
fn centre_m(pulses: &Pulses, which: Range<usize>) -> [f64; 3] {
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
    count: usize,
) -> [f64; 2] {
    const LATTICE: usize = 12;
    let axes = [grid.u_m, grid.v_m].map(|v| v.map(|x| x / norm(v).max(1e-300)));
    let scale = 2.0 / pulses.light_speed_m_s();
    let parts: Vec<_> = cut(pulses.len(), count).collect();
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

/// Weights of [`TAPS`] samples at 0, 1, … for a value at `x`, least squares over all signals whose
/// frequencies lie within ±`nu` cycles a sample, and the relative RMS error of the worst frequency.
fn interpolation_weights(x: f64, nu: f64) -> ([f64; TAPS], f64) {
    let nu = nu.clamp(1e-6, 0.5);
    let sinc = |t: f64| {
        let a = 2.0 * PI * nu * t;
        if a.abs() < 1e-9 { 1.0 } else { a.sin() / a }
    };
    // Normal equations; the diagonal's trifle keeps them solvable where samples are plentiful.
    let mut a = [[0.0; TAPS + 1]; TAPS];
    for (i, row) in a.iter_mut().enumerate() {
        for (j, v) in row.iter_mut().take(TAPS).enumerate() {
            *v = sinc(i as f64 - j as f64);
        }
        row[i] += 1e-11;
        row[TAPS] = sinc(x - i as f64);
    }
    for k in 0..TAPS {
        let pivot = a[k];
        for row in a.iter_mut().skip(k + 1) {
            let factor = row[k] / pivot[k];
            for (v, p) in row.iter_mut().zip(pivot).skip(k) {
                *v -= factor * p;
            }
        }
    }
    let mut w = [0.0; TAPS];
    for i in (0..TAPS).rev() {
        let known: f64 = (i + 1..TAPS).map(|j| a[i][j] * w[j]).sum();
        w[i] = (a[i][TAPS] - known) / a[i][i];
    }
    let worst = (0..=16)
        .map(|k| {
            let omega = 2.0 * PI * nu * f64::from(k) / 16.0;
            let sum: Complex64 = (0..TAPS)
                .map(|i| Complex64::cis(omega * (i as f64 - x)) * w[i])
                .sum();
            (sum - 1.0).norm_sqr()
        })
        .sum::<f64>()
        / 17.0;
    (w, worst.sqrt())
}

/// RMS error over all phases of an interval of `d` pixels at `nu` cycles a sample.
fn worst_error(nu: f64, d: usize) -> f64 {
    if nu >= 0.48 {
        return f64::INFINITY;
    }
    let sum: f64 = (0..d)
        .map(|p| {
            interpolation_weights(BEFORE as f64 + p as f64 / d as f64, nu)
                .1
                .powi(2)
        })
        .sum();
    (sum / d as f64).sqrt()
}

/// Everything that does not depend on the pixels: tables of the direct engine and weights.
#[derive(Debug)]
pub(crate) struct Factorized {
    pub spec: FactorizedSpec,
    direct: Direct,
    level: SimdLevel,
    carrier_hz: f64,
    weights: [Vec<[f32; TAPS]>; 2],
    cosine: [f32; 6],
    sine: [f32; 6],
}

/// A sub-aperture's coarse image, real and imaginary, and its phase centre.
struct Coarse {
    centre_m: [f64; 3],
    real: Vec<f32>,
    imag: Vec<f32>,
}

impl Factorized {
    /// The coarse grid that covers `grid`.
    pub fn coarse_grid(grid: &TiltedGrid, coarse: [usize; 2]) -> TiltedGrid {
        let before = |d: usize| -((BEFORE * d) as f64);
        let intervals = grid.columns.div_ceil(coarse[0]).next_multiple_of(MAX_LANES);
        TiltedGrid {
            origin_m: grid.point_m(before(coarse[0]), before(coarse[1])),
            u_m: grid.u_m.map(|x| x * coarse[0] as f64),
            v_m: grid.v_m.map(|x| x * coarse[1] as f64),
            columns: intervals + TAPS,
            rows: grid.rows.div_ceil(coarse[1]) + TAPS,
        }
    }

    /// Bytes of the coarse images of a run.
    pub fn coarse_bytes(spec: &FactorizedSpec, grid: &TiltedGrid, pulses: usize) -> u128 {
        let coarse = Self::coarse_grid(grid, spec.coarse);
        let pixels = coarse.columns as u128 * coarse.rows as u128;
        // One more, complex, is in the making.
        pixels * 8 * (pulses.div_ceil(spec.pulses) as u128 + 1)
    }

    pub fn new(
        pulses: &Pulses,
        grid: &TiltedGrid,
        spec: FactorizedSpec,
        direct: DirectSpec,
        spreading: Spreading,
        level: SimdLevel,
    ) -> Self {
        let coarse = Self::coarse_grid(grid, spec.coarse);
        let ranges_m = table_ranges_m(pulses, &coarse);
        let steps = [norm(grid.u_m), norm(grid.v_m)];
        let weights = [0, 1].map(|axis| {
            let d = spec.coarse[axis];
            let nu = spec.bandwidth_a_metre[axis] * steps[axis] * d as f64;
            (0..d)
                .map(|p| {
                    let x = BEFORE as f64 + p as f64 / d as f64;
                    interpolation_weights(x, nu).0.map(|w| w as f32)
                })
                .collect()
        });
        let (cosine, sine) = turn_polynomials();
        Self {
            spec,
            carrier_hz: pulses.frequency_hz()[direct.table.carrier],
            direct: Direct::new(pulses, &ranges_m, direct, spreading, level),
            level,
            weights,
            cosine,
            sine,
        }
    }

    /// Images `grid` (or a piece of the grid that the plan was made for) into `out`.
    pub fn run(
        &self,
        pulses: &Pulses,
        spreading: Spreading,
        grid: &TiltedGrid,
        out: &mut [Complex32],
        done: &(dyn Fn(u64) + Sync),
    ) {
        let coarse = Self::coarse_grid(grid, self.spec.coarse);
        let turns_a_metre = 2.0 * self.carrier_hz / pulses.light_speed_m_s();
        let parts: Vec<Range<usize>> = cut(pulses.len(), self.spec.pulses).collect();
        let images: Vec<Coarse> = parts
            .par_iter()
            .map(|part| {
                let centre = centre_m(pulses, part.clone());
                let mut image = vec![Complex32::ZERO; coarse.columns * coarse.rows];
                self.direct.run_pulses(
                    pulses,
                    part.clone(),
                    spreading,
                    &coarse,
                    &mut image,
                    &|_| (),
                );
                let mut real = vec![0f32; image.len()];
                let mut imag = vec![0f32; image.len()];
                let columns = coarse.columns;
                real.par_chunks_mut(columns)
                    .zip(imag.par_chunks_mut(columns))
                    .zip(image.par_chunks(columns))
                    .enumerate()
                    .for_each(|(j, ((real, imag), row))| {
                        for (i, v) in row.iter().enumerate() {
                            let point = coarse.point_m(i as f64, j as f64);
                            let turn = reference::range_m(point, centre) * turns_a_metre;
                            let (s, c) = (2.0 * PI * (turn - turn.round())).sin_cos();
                            let (s, c) = (s as f32, c as f32);
                            real[i] = v.re * c + v.im * s;
                            imag[i] = v.im * c - v.re * s;
                        }
                    });
                Coarse {
                    centre_m: centre,
                    real,
                    imag,
                }
            })
            .collect();

        let [dx, dy] = self.spec.coarse;
        let padded = coarse.columns - TAPS;
        let pixel_m = norm(grid.u_m).max(1e-12);
        let unit = grid.u_m.map(|u| u / pixel_m);
        let line_length = 2 * (padded + TAPS);
        out.par_chunks_mut(grid.columns).enumerate().for_each_init(
            || vec![0f32; line_length + 2 * dx * padded],
            |scratch, (j, row)| {
                let (line, sums) = scratch.split_at_mut(line_length);
                let (real, imag) = sums.split_at_mut(dx * padded);
                real.fill(0.0);
                imag.fill(0.0);
                let start = grid.point_m(0.0, j as f64);
                let (cell, phase) = (j / dy, j % dy);
                for image in &images {
                    let job = MergeRow {
                        from_centre_m: std::array::from_fn(|a| start[a] - image.centre_m[a]),
                        unit,
                        pixel_m,
                        turns_a_metre,
                        rows: std::array::from_fn(|k| {
                            let at = (cell + k) * coarse.columns;
                            let end = at + coarse.columns;
                            (
                                &image.real[at..end],
                                &image.imag[at..end],
                                self.weights[1][phase][k],
                            )
                        }),
                        weights: &self.weights[0],
                        intervals: grid.columns.div_ceil(dx),
                        cosine: self.cosine,
                        sine: self.sine,
                    };
                    dispatch!(self.level, s => merge_row(s, &job, padded, line, real, imag));
                }
                for (i, v) in row.iter_mut().enumerate() {
                    let at = (i % dx) * padded + i / dx;
                    *v = Complex32::new(real[at], imag[at]);
                }
                done(row.len() as u64);
            },
        );
    }
}

/// Polynomials in x² of cos 2πx and sin(2πx)/x for |x| ≤ ½, by interpolation at Chebyshev nodes.
fn turn_polynomials() -> ([f32; 6], [f32; 6]) {
    let cosine = crate::direct::even_polynomial(|x| (2.0 * PI * x).cos(), 6);
    let sine = crate::direct::even_polynomial(|x| (2.0 * PI * x).sin() / x, 6);
    (cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_reproduce_what_the_band_holds() {
        for (nu, bound) in [(0.1, 1e-5), (0.25, 4e-4), (0.35, 1e-2)] {
            for phase in 0..5 {
                let x = BEFORE as f64 + f64::from(phase) / 5.0;
                let (w, error) = interpolation_weights(x, nu);
                assert!(error < bound, "{nu} {error:e}");
                for k in -10..=10 {
                    let omega = 2.0 * PI * nu * f64::from(k) / 10.0;
                    let sum: Complex64 = (0..TAPS)
                        .map(|i| Complex64::cis(omega * (i as f64 - x)) * w[i])
                        .sum();
                    assert!((sum - 1.0).norm() < 6.0 * bound);
                }
            }
        }
        assert!(worst_error(0.49, 3).is_infinite());
    }

    #[test]
    fn turns_are_close() {
        let (cosine, sine) = turn_polynomials();
        for k in -50..=50 {
            let x = k as f32 / 100.0;
            let at = |c: [f32; 6]| c.iter().rev().fold(0.0, |sum, c| sum * x * x + c);
            let angle = 2.0 * std::f32::consts::PI * x;
            assert!((at(cosine) - angle.cos()).abs() < 3e-6);
            assert!((at(sine) * x - angle.sin()).abs() < 3e-6);
        }
    }

    #[test]
    fn apertures_are_cut_completely() {
        for (pulses, wanted) in [(331, 32), (7, 8), (64, 16), (65, 16)] {
            let count = balanced(pulses, wanted);
            let parts: Vec<_> = cut(pulses, count).collect();
            assert_eq!(parts.iter().map(Range::len).sum::<usize>(), pulses);
            assert!(parts.iter().all(|p| !p.is_empty() && p.len() <= wanted));
        }
    }
}
