//! Self-check of the forward operator: spectra of random pixels at random places.

use super::places::{Deviation, MOST_PATCHES, judged, patches};
use crate::control::Meter;
use crate::engine::weights::WeightedPulses;
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::grid::tilted::TiltedGrid;
use crate::plan::options::SelfCheck;
use crate::plan::request::Request;
use crate::sampling::Random;
use acerra_control::Control;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use std::ops::Range;

/// Adds the spectra of some pulses of an image on a grid to the third argument.
pub(in crate::plan) type Run<'a> =
    dyn Fn(Range<usize>, (&TiltedGrid, &[Complex32]), &mut [Complex64], &Meter) + Sync + 'a;

/// Places that a check compares.
pub(in crate::plan) struct Places<'a> {
    pub grid: ImageGrid<'a>,
    /// Pixels of the coarse lattice on which patches start.
    pub coarse: [usize; 2],
    /// Random pixels of all patches.
    pub pixels: usize,
    pub seed: u64,
    /// Ranges of pulses; a range drawn at random observes each patch.
    pub pulses: Vec<Range<usize>>,
}

/// Seed of the check of a plan.
const SEED: u64 = 0x5eed_0002;

/// Double-precision contributions (frequency × pulse) that a check may spend.
const CONTRIBUTIONS: usize = 20_000_000;

/// Number of pixels of a check: the number in the options, or fewer where a pixel is expensive.
pub(in crate::plan) fn check_pixels(request: &Request) -> usize {
    let most = request.options.check_pixels.max(1);
    let spectra = request.echoes.len() * request.echoes.pulses.frequency_hz().len();
    (CONTRIBUTIONS / spectra.max(1)).clamp(most.min(MOST_PATCHES), most)
}

/// Compares the spectra of all pulses, as a plan's self-check does.
pub(in crate::plan) fn compare_spectra(
    request: &Request,
    coarse: [usize; 2],
    pixels: usize,
    run: &Run,
    control: Control,
) -> Result<SelfCheck, ImagingError> {
    let places = Places {
        grid: request.grid,
        coarse,
        pixels,
        seed: SEED,
        pulses: vec![Range {
            start: 0,
            end: request.echoes.len(),
        }],
    };
    compare_places(&request.echoes, &places, run, control)
}

/// Models small patches that start on the coarse lattice with a few random pixels each.
pub(in crate::plan) fn compare_places(
    echoes: &WeightedPulses,
    places: &Places,
    run: &Run,
    control: Control,
) -> Result<SelfCheck, ImagingError> {
    let coarse = places.coarse;
    let n = echoes.pulses.frequency_hz().len();
    let meter = Meter::silent(control);
    let found: Vec<Deviation> = patches(places.grid.plane(), coarse, places.pixels, places.seed)
        .par_iter()
        .map(|place| {
            let size = [(4 * coarse[0]).max(40), 2 * coarse[1]];
            let patch = places.grid.patch(place.start, size).grid;
            let image = random_image(&patch, place.pixels, place.seed);
            let drawn = Random(place.seed ^ SEED).below(places.pulses.len());
            let which = places.pulses[drawn].clone();
            let mut modelled = vec![Complex64::ZERO; which.len() * n];
            run(which.clone(), (&patch, &image), &mut modelled, &meter);
            let mut sum = Deviation::default();
            let mut expected = vec![Complex64::ZERO; n];
            for (m, row) in which.zip(modelled.chunks_exact(n)) {
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
    Ok(judged(&found, places.pixels))
}

/// An image that is zero except for `pixels` random values at random places.
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
