//! Self-checks of imaging: pixels at random places.

use super::places::{Deviation, patches};
use crate::control::{Control, Meter};
use crate::engine::direct::Direct;
use crate::engine::factorized::merged::Factorized;
use crate::error::ImagingError;
use crate::kernel::direct::job::{Tally, block_width};
use crate::plan::options::SelfCheck;
use crate::plan::planner::Request;
use crate::plan::report::PathShares;
use crate::sampling::Random;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

/// Double-precision contributions (frequency × pulse) that a check may spend.
const CONTRIBUTIONS: usize = 40_000_000;
/// Least pixels of a check, where the options ask for as many.
const LEAST_PIXELS: usize = 24;

/// Pixels of a check: as the options ask, and fewer where each is expensive.
fn check_pixels(request: &Request) -> usize {
    let pulses = &request.echoes.pulses;
    let work = pulses.len() * pulses.frequency_hz().len();
    let most = request.options.check_pixels.max(1);
    (CONTRIBUTIONS / work.max(1)).clamp(most.min(LEAST_PIXELS), most)
}

/// Images small patches at random places and compares pixels of each.
pub(in crate::plan) fn compare_patches(
    request: &Request,
    factorized: &Factorized,
    control: Control,
) -> Result<SelfCheck, ImagingError> {
    let (grid, echoes) = (request.grid.plane(), &request.echoes);
    let [dx, dy] = factorized.lattice.spec.coarse;
    let meter = Meter::silent(control);
    let pixels = check_pixels(request);
    let found: Vec<Deviation> = patches(grid, [dx, dy], pixels, 0x5eed_0001)
        .par_iter()
        .flat_map_iter(|place| {
            let patch = request.grid.patch(place.start, [4 * dx, 2 * dy]).grid;
            let mut out = vec![Complex32::ZERO; patch.columns * patch.rows];
            factorized.run(echoes, &patch, &mut out, &meter);
            let mut random = Random(place.seed);
            (0..place.pixels)
                .map(|_| {
                    let k = random.below(out.len());
                    let (i, j) = (k % patch.columns, k / patch.columns);
                    deviation(request, patch.point_m(i as f64, j as f64), out[k], control)
                })
                .collect::<Vec<_>>()
        })
        .collect();
    control.check()?;
    let mut sum = Deviation::default();
    found.iter().for_each(|d| sum.add(*d));
    Ok(sum.check(pixels))
}

/// Images short pieces of rows at random places and compares a pixel of each.
pub(in crate::plan) fn compare_pixels(
    request: &Request,
    direct: &Direct,
    control: Control,
) -> Result<(SelfCheck, PathShares), ImagingError> {
    let (grid, echoes) = (&request.grid, &request.echoes);
    let pixels = check_pixels(request);
    let meter = Meter::silent(control);
    let mut random = Random(0x1234_5678);
    let width = block_width(request.options.level.lanes());
    let places: Vec<[usize; 3]> = (0..pixels)
        .map(|_| {
            let i = random.below(grid.columns());
            // Anywhere in a block, so that every vector of one is covered.
            let start = i.saturating_sub(random.below(width));
            [start, i, random.below(grid.rows())]
        })
        .collect();
    let found: Vec<(Deviation, Tally)> = places
        .par_iter()
        .map(|&[start, i, j]| {
            let piece = grid.patch([start, j], [i - start + 1, 1]);
            let mut out = vec![Complex32::ZERO; i - start + 1];
            let tally = direct.run(echoes, 0..echoes.len(), &piece, &mut out, &meter);
            let point_m = grid.point_m(i, j);
            (deviation(request, point_m, out[i - start], control), tally)
        })
        .collect();
    control.check()?;
    let mut tally = Tally::default();
    let mut sum = Deviation::default();
    for (deviation, counted) in found {
        sum.add(deviation);
        tally.add(counted);
    }
    Ok((sum.check(pixels), shares(tally)))
}

/// Deviation of a pixel from the double-precision sum; nothing once cancelled.
fn deviation(
    request: &Request,
    point_m: [f64; 3],
    value: Complex32,
    control: Control,
) -> Deviation {
    if control.is_cancelled() {
        return Deviation::default();
    }
    let expected = request.echoes.adjoint_at(point_m);
    let value = Complex64::new(f64::from(value.re), f64::from(value.im));
    Deviation {
        difference: (value - expected).norm_sqr(),
        power: expected.norm_sqr(),
    }
}

/// Shares of all vectors counted.
fn shares(tally: Tally) -> PathShares {
    let vectors = (tally.window + tally.gather + tally.reference).max(1) as f64;
    PathShares {
        windowed: tally.window as f64 / vectors,
        gathered: tally.gather as f64 / vectors,
        reference: tally.reference as f64 / vectors,
    }
}
