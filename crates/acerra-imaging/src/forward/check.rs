//! The self-check: spectra of random pixels at random places against the double-precision sum.

use super::{Forward, exact};
use crate::SelfCheck;
use crate::plan::check::{PATCHES, patch_at};
use crate::rows::TiltedGrid;
use crate::trial::Random;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

/// Spectra of an image on a grid, added to the last argument.
pub(super) type Run<'a> = dyn Fn(&TiltedGrid, &[Complex32], &mut [Complex64]) + Sync + 'a;

/// Runs small patches that start on the coarse lattice with a few random pixels each.
pub(super) fn compare(forward: &Forward, coarse: [usize; 2], run: &Run) -> SelfCheck {
    let (grid, pulses) = (&forward.grid, &forward.pulses);
    let spectra = pulses.len() * pulses.frequency_hz().len();
    let pixels = (20_000_000 / spectra.max(1)).clamp(PATCHES, 240) / PATCHES;
    let [dx, dy] = coarse;
    let mut random = Random(0x5eed_0002);
    let places: Vec<(usize, usize, u64)> = (0..PATCHES)
        .map(|k| {
            let [i, j] = patch_at(k, &mut random, grid, coarse);
            (i, j, random.next())
        })
        .collect();
    let found: Vec<(f64, f64)> = places
        .par_iter()
        .map(|&(i0, j0, seed)| {
            let patch = TiltedGrid {
                origin_m: grid.point_m(i0 as f64, j0 as f64),
                columns: (grid.columns - i0).min((4 * dx).max(40)),
                rows: (grid.rows - j0).min(2 * dy),
                ..*grid
            };
            let mut random = Random(seed);
            let mut image = vec![Complex32::ZERO; patch.columns * patch.rows];
            for _ in 0..pixels {
                let k = random.below(image.len());
                let mut part = || (random.below(2001) as f32 - 1000.0) * 1e-3;
                image[k] = Complex32::new(part(), part());
            }
            let mut modelled = vec![Complex64::ZERO; spectra];
            run(&patch, &image, &mut modelled);
            let n = pulses.frequency_hz().len();
            let (mut difference, mut power) = (0.0, 0.0);
            let mut expected = vec![Complex64::ZERO; n];
            for (m, row) in modelled.chunks_exact(n).enumerate() {
                expected.fill(Complex64::ZERO);
                exact(pulses, m, &patch, &image, &forward.weights, &mut expected);
                for (a, b) in row.iter().zip(&expected) {
                    difference += (a - b).norm_sqr();
                    power += b.norm_sqr();
                }
            }
            (difference, power)
        })
        .collect();
    let difference: f64 = found.iter().map(|f| f.0).sum();
    let power: f64 = found.iter().map(|f| f.1).sum();
    SelfCheck {
        pixels: pixels * PATCHES,
        error: if power > 0.0 {
            (difference / power).sqrt()
        } else {
            difference.sqrt()
        },
    }
}
