//! Self-check of the forward operator: spectra of random pixels at random places.

use super::places::{Deviation, MOST_PATCHES, judged, patches};
use crate::control::{Control, Meter};
use crate::error::ImagingError;
use crate::grid::tilted::TiltedGrid;
use crate::plan::options::SelfCheck;
use crate::plan::request::Request;
use crate::sampling::Random;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

/// Adds the spectra of an image on a grid to the third argument.
pub(in crate::plan) type Run<'a> =
    dyn Fn(&TiltedGrid, &[Complex32], &mut [Complex64], &Meter) + Sync + 'a;

/// Double-precision contributions (frequency × pulse) that a check may spend.
const CONTRIBUTIONS: usize = 20_000_000;

/// Pixels of a check: as the options ask, and fewer where each is expensive.
pub(in crate::plan) fn check_pixels(request: &Request) -> usize {
    let most = request.options.check_pixels.max(1);
    let spectra = request.echoes.len() * request.echoes.pulses.frequency_hz().len();
    (CONTRIBUTIONS / spectra.max(1)).clamp(most.min(MOST_PATCHES), most)
}

/// Models small patches that start on the coarse lattice with a few random pixels each.
pub(in crate::plan) fn compare_spectra(
    request: &Request,
    coarse: [usize; 2],
    pixels: usize,
    run: &Run,
    control: Control,
) -> Result<SelfCheck, ImagingError> {
    let (grid, echoes) = (request.grid.plane(), &request.echoes);
    let n = echoes.pulses.frequency_hz().len();
    let spectra = echoes.len() * n;
    let meter = Meter::silent(control);
    let found: Vec<Deviation> = patches(grid, coarse, pixels, 0x5eed_0002)
        .par_iter()
        .map(|place| {
            let size = [(4 * coarse[0]).max(40), 2 * coarse[1]];
            let patch = request.grid.patch(place.start, size).grid;
            let image = random_image(&patch, place.pixels, place.seed);
            let mut modelled = vec![Complex64::ZERO; spectra];
            run(&patch, &image, &mut modelled, &meter);
            let mut sum = Deviation::default();
            let mut expected = vec![Complex64::ZERO; n];
            for (m, row) in modelled.chunks_exact(n).enumerate() {
                if control.is_cancelled() {
                    break;
                }
                expected.fill(Complex64::ZERO);
                for (k, v) in image
                    .iter()
                    .enumerate()
                    .filter(|(_, v)| **v != Complex32::ZERO)
                {
                    let (i, j) = (k % patch.columns, k / patch.columns);
                    let value = Complex64::new(f64::from(v.re), f64::from(v.im));
                    let point_m = patch.point_m(i as f64, j as f64);
                    echoes.add_echo(m, point_m, value, &mut expected);
                }
                for (a, b) in row.iter().zip(&expected) {
                    sum.difference += (a - b).norm_sqr();
                    sum.power += b.norm_sqr();
                }
            }
            sum
        })
        .collect();
    control.check()?;
    Ok(judged(&found, pixels))
}

/// An image of zeros but for `pixels` random values at random places.
fn random_image(patch: &TiltedGrid, pixels: usize, seed: u64) -> Vec<Complex32> {
    let mut random = Random(seed);
    let mut image = vec![Complex32::ZERO; patch.columns * patch.rows];
    for _ in 0..pixels {
        let k = random.below(image.len());
        let mut part = || (random.below(2001) as f32 - 1000.0) * 1e-3;
        image[k] = Complex32::new(part(), part());
    }
    image
}
