//! The self-check: pixels at random places against the double-precision sum.

use super::{Plan, SelfCheck};
use crate::direct::Direct;
use crate::factorized::Factorized;
use crate::rows::TiltedGrid;
use crate::simd::rows::{Tally, block_width};
use crate::trial::Random;
use crate::weights::Weights;
use crate::{Pulses, reference};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

impl Plan<'_> {
    /// Runs small patches at random places and compares pixels of each.
    pub(crate) fn compare_patches(&self, factorized: &Factorized) -> SelfCheck {
        let grid = &self.grid;
        let work = self.pulses.len() * self.pulses.frequency_hz().len();
        let pixels = (30_000_000 / work.max(1)).clamp(PATCHES, 400) / PATCHES;
        let [dx, dy] = factorized.lattice.spec.coarse;
        let mut random = Random(0x5eed_0001);
        let places: Vec<(usize, usize, u64)> = (0..PATCHES)
            .map(|k| {
                let [i, j] = patch_at(k, &mut random, grid, [dx, dy]);
                (i, j, random.next())
            })
            .collect();
        let found: Vec<(f64, f64)> = places
            .par_iter()
            .flat_map_iter(|&(i0, j0, seed)| {
                let patch = TiltedGrid {
                    origin_m: grid.point_m(i0 as f64, j0 as f64),
                    columns: (grid.columns - i0).min(4 * dx),
                    rows: (grid.rows - j0).min(2 * dy),
                    ..*grid
                };
                let mut out = vec![Complex32::ZERO; patch.columns * patch.rows];
                factorized.run(&self.pulses, &self.weights, &patch, &mut out, &|_| ());
                let mut random = Random(seed);
                (0..pixels)
                    .map(|_| {
                        let k = random.below(out.len());
                        let (i, j) = (k % patch.columns, k / patch.columns);
                        let point = patch.point_m(i as f64, j as f64);
                        let expected = exact(&self.pulses, point, &self.weights);
                        let value = Complex64::new(f64::from(out[k].re), f64::from(out[k].im));
                        ((value - expected).norm_sqr(), expected.norm_sqr())
                    })
                    .collect::<Vec<_>>()
            })
            .collect();
        let difference: f64 = found.iter().map(|f| f.0).sum();
        let power: f64 = found.iter().map(|f| f.1).sum();
        SelfCheck {
            pixels: found.len(),
            error: if power > 0.0 {
                (difference / power).sqrt()
            } else {
                difference.sqrt()
            },
        }
    }

    /// Runs short pieces of rows at random places and compares a pixel of each.
    pub(crate) fn compare(&self, direct: &Direct) -> (SelfCheck, Tally) {
        let grid = &self.grid;
        let work = self.pulses.len() * self.pulses.frequency_hz().len();
        let most = self.options.check_pixels.max(1);
        let pixels = (40_000_000 / work.max(1)).clamp(most.min(24), most);
        let mut random = Random(0x1234_5678);
        let width = block_width(self.options.level.lanes());
        let places: Vec<[usize; 3]> = (0..pixels)
            .map(|_| {
                let i = random.below(grid.columns);
                // Anywhere in a block, so that every vector of one has its turn.
                let start = i.saturating_sub(random.below(width));
                [start, i, random.below(grid.rows)]
            })
            .collect();
        let found: Vec<(f64, f64, Tally)> = places
            .par_iter()
            .map(|&[start, i, j]| {
                let piece = TiltedGrid {
                    origin_m: grid.point_m(start as f64, j as f64),
                    columns: i - start + 1,
                    rows: 1,
                    ..*grid
                };
                let mut out = vec![Complex32::ZERO; i - start + 1];
                let tally = direct.run_over(
                    &self.pulses,
                    0..self.pulses.len(),
                    &self.weights,
                    &piece,
                    self.relief().map(|r| r.seen_from(start, j)),
                    &mut out,
                    &|_| (),
                );
                let point = self.point_m(i, j);
                let expected = exact(&self.pulses, point, &self.weights);
                let value = out[i - start];
                let value = Complex64::new(f64::from(value.re), f64::from(value.im));
                ((value - expected).norm_sqr(), expected.norm_sqr(), tally)
            })
            .collect();
        let mut tally = Tally::default();
        let (mut difference, mut power) = (0.0, 0.0);
        for (d, p, t) in found {
            difference += d;
            power += p;
            tally.add(t);
        }
        let error = if power > 0.0 {
            (difference / power).sqrt()
        } else {
            difference.sqrt()
        };
        (SelfCheck { pixels, error }, tally)
    }
}

/// Patches of a self-check: four corners, where spatial frequencies are highest, and one at random in
/// each cell of a 6 × 6 lattice, since errors may gather in small places.
pub(crate) const PATCHES: usize = 4 + LATTICE * LATTICE;
const LATTICE: usize = 6;

/// Where the `k`th patch begins: on the coarse lattice, as pixels of the whole image do.
pub(crate) fn patch_at(
    k: usize,
    random: &mut Random,
    grid: &TiltedGrid,
    coarse: [usize; 2],
) -> [usize; 2] {
    let sizes = [grid.columns, grid.rows];
    std::array::from_fn(|axis| {
        let (size, d) = (sizes[axis], coarse[axis]);
        let at = match (k, (k >> axis) & 1) {
            (0..4, 0) => 0,
            (0..4, _) => (size - 1).saturating_sub(d),
            _ => {
                let cell = [(k - 4) % LATTICE, (k - 4) / LATTICE][axis];
                let (from, to) = (cell * size / LATTICE, (cell + 1) * size / LATTICE);
                (from + random.below((to - from).max(1))).min(size - 1)
            }
        };
        at / d * d
    })
}

/// Eq. (3) at a point in double precision; for even frequencies by turning phasors, renewed often
/// enough to stay exact.
pub(crate) fn exact(pulses: &Pulses, point: [f64; 3], weights: &Weights) -> Complex64 {
    const RENEW: usize = 32;
    let step = pulses.frequency_step_hz();
    let f = pulses.frequency_hz();
    let mut sum = Complex64::ZERO;
    for (m, p) in pulses.position_m().iter().enumerate() {
        let range = reference::range_m(*p, point);
        let weight = pulses.weight()[m] * weights.at(m, range);
        let Some(step) = step else {
            sum += reference::pulse_at_range(pulses, m, range) * weight;
            continue;
        };
        let delay = 4.0 * std::f64::consts::PI * range / pulses.light_speed_m_s();
        let turn = Complex64::cis(step * delay);
        let mut profile = Complex64::ZERO;
        for (k, e) in pulses.spectrum_of(m).chunks(RENEW).enumerate() {
            // Horner from the last frequency of the piece to its first.
            let piece = e
                .iter()
                .rev()
                .fold(Complex64::ZERO, |sum, e| sum * turn + e);
            profile += piece * Complex64::cis(f[k * RENEW] * delay);
        }
        sum += profile * weight;
    }
    sum
}
