//! Merging: a sub-aperture's coarse image is interpolated to rows of the fine grid, multiplied by
//! the carrier phase of the range to the sub-aperture's centre, and added.
//!
//! A row is held phase by phase: of fine pixels D·q + p all q of one p are together, so that the
//! interpolation taps are plain vectors of coarse samples. Neighbouring phases use the same samples with
//! other weights, and are summed together: each sample is loaded once for several phases.

use super::lanes::{Lanes, MAX_LANES};
use super::phase::{Intervals, PhaseRow, RowCarrier, RowHeights};
use std::ops::Range;

/// Number of coarse samples from which a value is interpolated in either direction: more taps permit coarser
/// grids.
pub(crate) const TAPS: usize = 12;
pub(crate) const MOST_TAPS: usize = 16;

/// Most coarse samples of a cell.
pub(crate) const MOST_SAMPLES: usize = 3;

/// Most samples that the pixels of a cell take together.
pub(crate) const MOST_REACH: usize = MOST_TAPS + MOST_SAMPLES - 1;

/// Most phases that are summed together: their real and imaginary parts leave registers for samples and weights.
const MOST_TOGETHER: usize = 4;

/// Interpolation weights of the pixels of a cell along an axis.
#[derive(Debug)]
pub(crate) struct Stencil {
    /// For each pixel the weights of the samples from the cell's first on, zeros for unused samples.
    weights: Vec<[f32; MOST_REACH]>,
    /// Samples that each pixel uses.
    taken: Vec<Range<usize>>,
}

impl Stencil {
    /// `weights` of the samples that each pixel uses, and the first such sample, below [`MOST_SAMPLES`];
    /// zeros at either end are left out.
    pub fn new(weights: &[[f32; MOST_TAPS]], first: impl Fn(usize) -> usize) -> Self {
        let padded = |(pixel, taps): (usize, &[f32; MOST_TAPS])| {
            let from = first(pixel);
            let mut weights = [0.0; MOST_REACH];
            weights[from..from + MOST_TAPS].copy_from_slice(taps);
            let last = weights.iter().rposition(|w| *w != 0.0).unwrap_or(0);
            let first = weights.iter().position(|w| *w != 0.0).unwrap_or(0);
            (weights, first..last + 1)
        };
        let (weights, taken) = weights.iter().enumerate().map(padded).unzip();
        Self { weights, taken }
    }

    /// Pixels of the cell.
    pub fn pixels(&self) -> usize {
        self.weights.len()
    }

    /// The first `pixels` in runs that are summed together, as even as possible.
    fn runs(&self, pixels: usize) -> impl Iterator<Item = Range<usize>> {
        let pixels = pixels.min(self.pixels());
        let runs = pixels.div_ceil(MOST_TOGETHER);
        (0..runs).map(move |k| k * pixels / runs..(k + 1) * pixels / runs)
    }

    /// Range of samples that the pixels `pixels` use together.
    fn reach(&self, pixels: &Range<usize>) -> Range<usize> {
        let taken = &self.taken[pixels.clone()];
        let from = taken.iter().map(|t| t.start).min().unwrap_or(0);
        let to = taken.iter().map(|t| t.end).max().unwrap_or(0);
        from..to
    }
}

/// Coarse rows of a sub-aperture about a cell of fine rows.
pub(crate) struct MergeAcross<'a> {
    /// Real and imaginary parts, from the cell's first row on; rows that no fine row uses are ignored.
    pub rows: [(&'a [f32], &'a [f32]); MOST_REACH],
    pub stencil: &'a Stencil,
}

/// Interpolates coarse samples at the first fine rows of a cell: `lines` `[fine rows, 2, coarse samples]`.
#[inline(always)]
pub(crate) fn merge_across<S: Lanes>(s: S, job: &MergeAcross, lines: &mut [f32]) {
    let coarse = job.rows[0].0.len();
    let is_long = |r: &(&[f32], &[f32])| r.0.len() >= coarse && r.1.len() >= coarse;
    assert!(coarse >= S::N && job.rows.iter().all(is_long));
    let count = lines.len() / (2 * coarse);
    assert!(count <= job.stencil.pixels());
    let mut column = 0;
    while column < coarse {
        // Whole vectors: the last one begins where it ends with the row.
        let at = column.min(coarse - S::N);
        // All runs at one place use the same samples, which are then in the first-level cache.
        for run in job.stencil.runs(count) {
            // SAFETY: the run lies within the first `count` fine rows, each of which has two lines; rows and lines
            // have `coarse` samples, and at + N ≤ coarse.
            unsafe {
                match run.len() {
                    1 => fine_samples::<S, 1>(s, job, run, at, lines),
                    2 => fine_samples::<S, 2>(s, job, run, at, lines),
                    3 => fine_samples::<S, 3>(s, job, run, at, lines),
                    _ => fine_samples::<S, MOST_TOGETHER>(s, job, run, at, lines),
                }
            }
        }
        column += S::N;
    }
}

/// `N` samples of the lines of `G` fine rows.
///
/// # Safety
/// `rows` are `G` fine rows of the stencil with a pair of lines each, all lines and rows have as many numbers as
/// the first row, and `at` + N does not exceed it.
#[inline(always)]
unsafe fn fine_samples<S: Lanes, const G: usize>(
    s: S,
    job: &MergeAcross,
    rows: Range<usize>,
    at: usize,
    lines: &mut [f32],
) {
    let coarse = job.rows[0].0.len();
    let weights: [&[f32; MOST_REACH]; G] =
        std::array::from_fn(|g| &job.stencil.weights[rows.start + g]);
    let mut sums = [(s.splat(0.0), s.splat(0.0)); G];
    for k in job.stencil.reach(&rows) {
        // SAFETY: at + N ≤ coarse, and every row has `coarse` numbers.
        let (re, im) = unsafe {
            let (re, im) = job.rows[k];
            (s.load(re.as_ptr().add(at)), s.load(im.as_ptr().add(at)))
        };
        for (sum, weights) in sums.iter_mut().zip(weights) {
            let w = s.splat(weights[k]);
            *sum = (s.mul_add(w, re, sum.0), s.mul_add(w, im, sum.1));
        }
    }
    for (g, sum) in sums.into_iter().enumerate() {
        // SAFETY: line 2·row of a row among those that have lines, of `coarse` numbers, and the next.
        unsafe {
            let line = lines.as_mut_ptr().add(2 * (rows.start + g) * coarse + at);
            s.store(line, sum.0);
            s.store(line.add(coarse), sum.1);
        }
    }
}

/// A sub-aperture's line of coarse samples and the fine row it is added to.
pub(crate) struct MergeRow<'a> {
    /// The fine row, seen from the sub-aperture's centre.
    pub phase: PhaseRow,
    /// Heights of its pixels over uneven ground, of `padded` intervals.
    pub heights: Option<RowHeights<'a>>,
    /// Real and imaginary parts of the coarse samples at this fine row.
    pub line: (&'a [f32], &'a [f32]),
    pub stencil: &'a Stencil,
    /// Place in the line of each sample that the pixels of the first cell use; the samples of the following
    /// cells are adjacent.
    pub offsets: &'a [usize; MOST_REACH],
    /// Cells in the row.
    pub intervals: usize,
    /// Cells in a padded row.
    pub padded: usize,
}

/// Adds the line, interpolated, to `real`, `imag` `[D, padded]`.
#[inline(always)]
pub(crate) fn merge_row<S: Lanes>(s: S, job: &MergeRow, real: &mut [f32], imag: &mut [f32]) {
    match job.heights {
        None => merge_row_on::<S, false>(s, job, real, imag),
        Some(_) => merge_row_on::<S, true>(s, job, real, imag),
    }
}

#[inline(always)]
fn merge_row_on<S: Lanes, const RELIEF: bool>(
    s: S,
    job: &MergeRow,
    real: &mut [f32],
    imag: &mut [f32],
) {
    let padded = job.padded;
    let phases = job.stencil.pixels();
    let coarse = job.line.0.len().min(job.line.1.len());
    assert!(padded.is_multiple_of(MAX_LANES) && job.intervals <= padded);
    assert!(real.len() >= phases * padded && imag.len() >= phases * padded);
    let reach = job.stencil.reach(&(0..phases));
    assert!(job.offsets[reach].iter().all(|at| at + padded <= coarse));
    let carrier = RowCarrier::new(s, &job.phase, phases, job.heights);
    assert!(carrier.has_heights(RELIEF, phases, padded));
    let mut q = 0;
    while q < job.intervals {
        let at_middle = carrier.intervals::<RELIEF>(q);
        for run in job.stencil.runs(phases) {
            // SAFETY: `q` < padded, a multiple of N, so that q + N ≤ padded; the samples that `padded` cells
            // take lie within the line, and the sums of all phases within both parts.
            unsafe {
                let at = (&carrier, &at_middle, q);
                match run.len() {
                    1 => add_pixels::<S, 1, RELIEF>(s, job, at, run, real, imag),
                    2 => add_pixels::<S, 2, RELIEF>(s, job, at, run, real, imag),
                    3 => add_pixels::<S, 3, RELIEF>(s, job, at, run, real, imag),
                    _ => add_pixels::<S, MOST_TOGETHER, RELIEF>(s, job, at, run, real, imag),
                }
            }
        }
        q += S::N;
    }
}

/// Adds the pixels of `G` phases of the `N` cells from `q` on.
///
/// # Safety
/// `phases` are `G` phases of the stencil, q + N ≤ padded, and line and sums are as [`merge_row`] asserts.
#[inline(always)]
unsafe fn add_pixels<S: Lanes, const G: usize, const RELIEF: bool>(
    s: S,
    job: &MergeRow,
    (carrier, at_middle, q): (&RowCarrier<S>, &Intervals<S>, usize),
    phases: Range<usize>,
    real: &mut [f32],
    imag: &mut [f32],
) {
    let weights: [&[f32; MOST_REACH]; G] =
        std::array::from_fn(|g| &job.stencil.weights[phases.start + g]);
    let mut sums = [(s.splat(0.0), s.splat(0.0)); G];
    for k in job.stencil.reach(&phases) {
        let at = q + job.offsets[k];
        // SAFETY: offset + padded does not exceed the line's length, and q + N ≤ padded.
        let (re, im) = unsafe {
            let (re, im) = job.line;
            (s.load(re.as_ptr().add(at)), s.load(im.as_ptr().add(at)))
        };
        for (sum, weights) in sums.iter_mut().zip(weights) {
            let w = s.splat(weights[k]);
            *sum = (s.mul_add(w, re, sum.0), s.mul_add(w, im, sum.1));
        }
    }
    for (g, (re, im)) in sums.into_iter().enumerate() {
        let p = phases.start + g;
        let (cosine, sine) = carrier.phase::<RELIEF>(at_middle, p);
        let at = p * job.padded + q;
        // SAFETY: each part has `padded` sums of every phase.
        unsafe {
            let (to_re, to_im) = (real.as_mut_ptr().add(at), imag.as_mut_ptr().add(at));
            let sum = s.mul_add(re, cosine, s.load(to_re));
            s.store(to_re, s.neg_mul_add(im, sine, sum));
            let sum = s.mul_add(re, sine, s.load(to_im));
            s.store(to_im, s.mul_add(im, cosine, sum));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::polynomials::even_polynomial;
    use crate::kernel::dispatch::dispatch;
    use crate::kernel::level::SimdLevel;
    use crate::vector::norm;
    use num_complex::Complex64;
    use std::f64::consts::PI;

    /// Numbers that look random, in −1 … 1.
    fn number(k: usize) -> f32 {
        ((k as f64 * 12.9898).sin() * 43_758.545_3).fract() as f32
    }

    fn stencil(pixels: usize, samples: usize, taps: usize, seed: usize) -> Stencil {
        let weights: Vec<[f32; MOST_TAPS]> = (0..pixels)
            .map(|p| {
                std::array::from_fn(|k| match k < taps {
                    true => number(seed + MOST_TAPS * p + k),
                    false => 0.0,
                })
            })
            .collect();
        Stencil::new(&weights, |pixel| pixel * samples / pixels)
    }

    #[test]
    fn lines_are_weighted_sums_of_rows() {
        const COARSE: usize = 37;
        let rows: Vec<[Vec<f32>; 2]> = (0..MOST_REACH)
            .map(|k| [0, 5000].map(|part| (0..COARSE).map(|c| number(part + 50 * k + c)).collect()))
            .collect();
        for (pixels, samples, taps) in [(1, 1, 12), (3, 1, 16), (5, 3, 12), (9, 2, 16), (6, 1, 12)]
        {
            let stencil = stencil(pixels, samples, taps, 900);
            let job = MergeAcross {
                rows: std::array::from_fn(|k| (&rows[k][0][..], &rows[k][1][..])),
                stencil: &stencil,
            };
            for &level in SimdLevel::available() {
                let mut lines = vec![0f32; 2 * pixels * COARSE];
                dispatch!(level, s => merge_across(s, &job, &mut lines));
                for (row, lines) in lines.chunks_exact(2 * COARSE).enumerate() {
                    for (part, line) in lines.chunks_exact(COARSE).enumerate() {
                        for (c, found) in line.iter().enumerate() {
                            let weights = stencil.weights[row].iter().zip(&rows);
                            let expected: f32 = weights.map(|(w, row)| w * row[part][c]).sum();
                            assert!((found - expected).abs() < 1e-5, "{level} {pixels}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn pixels_are_weighted_sums_with_the_phase_of_their_range() {
        // Level, gently uneven so that the range is a series, and rough so that it is computed.
        for height_m in [0.0, 0.004, 0.4] {
            check_pixels(height_m);
        }
    }

    fn check_pixels(height_m: f32) {
        const CELLS: usize = 32;
        const PIXEL_M: f64 = 0.02;
        let cosine = even_polynomial(|x| (2.0 * PI * x).cos(), 6);
        let sine = even_polynomial(|x| (2.0 * PI * x).sin() / x, 6);
        for (pixels, samples, taps) in [(1, 1, 12), (4, 1, 16), (5, 3, 12), (7, 2, 16)] {
            let stencil = stencil(pixels, samples, taps, 300);
            let row_cells = CELLS + MOST_REACH;
            let line = [0, 7000].map(|part| -> Vec<f32> {
                (0..samples * row_cells).map(|k| number(part + k)).collect()
            });
            let offsets = std::array::from_fn(|k| k % samples * row_cells + k / samples);
            let phase = PhaseRow {
                from_centre_m: [-1.3, 0.4, -5.0],
                unit: [0.8, 0.6, 0.0],
                pixel_m: PIXEL_M,
                cycles_per_m: 26.0,
                cosine,
                sine,
            };
            // A slope, with pseudorandom numbers added.
            let middle_m: Vec<f32> = (0..CELLS).map(|q| 0.3 * (q as f32 / 16.0 - 1.0)).collect();
            let above_m: Vec<f32> = (0..pixels * CELLS)
                .map(|at| middle_m[at % CELLS] + height_m * number(500 + at))
                .collect();
            let job = MergeRow {
                phase,
                heights: (height_m > 0.0).then_some(RowHeights {
                    above_m: &above_m,
                    middle_m: &middle_m,
                    departure_m: height_m,
                    span_m: [-0.3 - height_m, 0.3 + height_m],
                }),
                line: (&line[0], &line[1]),
                stencil: &stencil,
                offsets: &offsets,
                intervals: CELLS,
                padded: CELLS,
            };
            for &level in SimdLevel::available() {
                let mut sums = [1.0, -2.0].map(|start| vec![start; pixels * CELLS]);
                let [real, imag] = &mut sums;
                dispatch!(level, s => merge_row(s, &job, real, imag));
                for (at, (re, im)) in sums[0].iter().zip(&sums[1]).enumerate() {
                    let (p, cell) = (at / CELLS, at % CELLS);
                    let along = PIXEL_M * (cell * pixels + p) as f64;
                    let mut d: [f64; 3] =
                        std::array::from_fn(|a| phase.from_centre_m[a] + along * phase.unit[a]);
                    if height_m > 0.0 {
                        d[2] += f64::from(above_m[at]);
                    }
                    let taken = (0..MOST_REACH).map(|k| {
                        let [re, im] = [0, 1].map(|part| f64::from(line[part][offsets[k] + cell]));
                        Complex64::new(re, im) * f64::from(stencil.weights[p][k])
                    });
                    let turned =
                        Complex64::cis(2.0 * PI * 26.0 * norm(d)) * taken.sum::<Complex64>();
                    let found = Complex64::new(f64::from(*re), f64::from(*im));
                    let error = (found - (turned + Complex64::new(1.0, -2.0))).norm();
                    assert!(error < 2e-4, "{level} {pixels} {height_m} {error:e}");
                }
            }
        }
    }
}
