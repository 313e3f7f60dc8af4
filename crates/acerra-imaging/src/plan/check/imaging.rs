//! Self-checks of imaging: pixels at random places.

use super::places::{Deviation, Place, brightest, judged_apart, patches};
use crate::engine::batches::Imager;
use crate::engine::direct::Direct;
use crate::engine::double::{DoubleTables, rows_together};
use crate::engine::factorized::merged::Factorized;
use crate::engine::factorized::spec::FactorizedSpec;
use crate::engine::ways::BLOCK;
use crate::engine::weights::WeightedPulses;
use crate::error::ImagingError;
use crate::grid::image::Patch;
use crate::kernel::direct::job::{SIDE, Shape, Tally};
use crate::plan::options::SelfCheck;
use crate::plan::report::PathShares;
use crate::plan::request::{Propagation, Request};
use crate::sampling::Random;
use acerra_control::Control;
use num_complex::{Complex32, Complex64};

/// Double-precision contributions (frequency × pulse) that a check may spend.
const CONTRIBUTIONS: usize = 40_000_000;
/// Double-precision contributions of a check for each contribution (pixel × pulse) of the image. A term of
/// the double-precision sum takes about as long as a contribution, so that the check takes a few hundredths
/// of the image's time.
const SHARE: f64 = 0.05;
/// Accuracy below which rounding in single precision dominates: rounding errors concentrate in few pixels,
/// and checks draw as many pixels as allowed.
pub(in crate::plan) const ROUNDING_BELOW: f64 = 1e-4;
/// Least pixels of a check, where the options ask for as many.
const LEAST_PIXELS: usize = 40;

/// Pixels of a first check: the number in the options, or fewer where each pixel is expensive relative to the
/// image.
pub(in crate::plan) fn first_pixels(request: &Request) -> usize {
    let pulses = &request.echoes.pulses;
    let frequencies = pulses.frequency_hz().len().max(1);
    let most = request.options.check_pixels.max(1);
    // Below uneven ground errors are largest at few places, where rays change their crossing.
    if request.options.accuracy < ROUNDING_BELOW
        || request.propagation() == Propagation::UnevenGround
    {
        return most_pixels(request);
    }
    let of_image = SHARE * request.pixels() as f64 / frequencies as f64;
    (of_image as usize)
        .min(affordable(request))
        .clamp(least_pixels(request), most)
}

/// Fewest pixels from which an error is estimated.
pub(in crate::plan) fn least_pixels(request: &Request) -> usize {
    request.options.check_pixels.clamp(1, LEAST_PIXELS)
}

/// Most pixels of a check that the first one left undecided.
pub(in crate::plan) fn most_pixels(request: &Request) -> usize {
    let most = request.options.check_pixels.max(1);
    affordable(request).clamp(least_pixels(request), most)
}

fn affordable(request: &Request) -> usize {
    let pulses = &request.echoes.pulses;
    CONTRIBUTIONS / (pulses.len() * pulses.frequency_hz().len()).max(1)
}

/// Length and width of a patch in samples of the coarse grid, without the surrounding samples.
const PATCH_SAMPLES: [usize; 2] = [4, 2];

/// Images small patches at random places and compares pixels of each.
pub(in crate::plan) fn compare_patches(
    request: &Request,
    factorized: &Imager<Factorized>,
    pixels: usize,
    control: Control,
) -> Result<SelfCheck, ImagingError> {
    let (grid, echoes) = (request.grid.plane(), &request.echoes);
    // Sizes of the coarsest grids, so that a patch holds all phases of every interpolation.
    let most = |of: &dyn Fn(&FactorizedSpec, usize) -> usize| {
        (factorized.specs()).fold([1, 1], |most, (spec, _)| {
            [0, 1].map(|axis| most[axis].max(of(spec, axis)))
        })
    };
    let period = most(&|spec, axis| spec.period_pixels()[axis]);
    let size = most(&|spec, axis| {
        let cell = spec.outer.coarse.cells[axis];
        PATCH_SAMPLES[axis].div_ceil(cell.samples) * cell.pixels
    });
    let places = patches(grid, period, pixels.div_ceil(2), 0x5eed_0001);
    let patches: Vec<Patch> = places
        .iter()
        .map(|place| request.grid.patch(place.start, size))
        .collect();
    let images = factorized.patches(echoes, &patches, control)?;
    let chosen = |((place, patch), (out, _)): ((&Place, &Patch), &(Vec<Complex32>, Tally))| {
        let mut random = Random(place.seed);
        let share = out.len().div_ceil(place.pixels.max(1));
        let pixel = |k: usize| {
            let (i, j) = (k % patch.grid.columns, k / patch.grid.columns);
            (patch.point_m(i, j), out[k])
        };
        (0..place.pixels)
            .flat_map(|n| {
                let first = (n * share).min(out.len() - 1);
                let piece = &out[first..(first + share).min(out.len())];
                [random.below(out.len()), first + brightest(piece)].map(pixel)
            })
            .collect::<Vec<_>>()
    };
    let pixels: Vec<Pixel> = (places.iter().zip(&patches).zip(&images))
        .flat_map(chosen)
        .collect();
    let found = deviations(echoes, &pixels, control);
    control.check()?;
    Ok(judged_in_pairs(&found))
}

/// Images small pieces of blocks at random places and compares the last and the brightest pixel of each.
pub(in crate::plan) fn compare_pixels(
    request: &Request,
    direct: &Imager<Direct>,
    pixels: usize,
    control: Control,
) -> Result<(SelfCheck, PathShares), ImagingError> {
    let (grid, echoes) = (&request.grid, &request.echoes);
    let mut random = Random(0x1234_5678);
    let shape = direct
        .specs()
        .next()
        .map_or(Shape::Row, |spec| spec.shape_on(grid.is_uneven()));
    let width = shape.block_width(request.options.level.lanes());
    let height = if shape == Shape::Row { 1 } else { SIDE };
    let places: Vec<[[usize; 2]; 2]> = (0..pixels.div_ceil(2))
        .map(|_| {
            let at = [random.below(grid.columns()), random.below(grid.rows())];
            // Pixels anywhere in a block, so that every vector of a block is covered.
            let before = [random.below(width), random.below(height)];
            [[0, 1].map(|axis| at[axis].saturating_sub(before[axis])), at]
        })
        .collect();
    let size = |[start, [i, j]]: &[[usize; 2]; 2]| [i - start[0] + 1, j - start[1] + 1];
    let patches: Vec<Patch> = places
        .iter()
        .map(|place| grid.patch(place[0], size(place)))
        .collect();
    let images = direct.patches(echoes, &patches, control)?;
    let pixels: Vec<Pixel> = (places.iter().zip(&images))
        .flat_map(|(place, (out, _))| {
            let (start, [columns, _]) = (place[0], size(place));
            [out.len() - 1, brightest(out)].map(|k| {
                let point_m = grid.point_m(start[0] + k % columns, start[1] + k / columns);
                (point_m, out[k])
            })
        })
        .collect();
    let found = deviations(echoes, &pixels, control);
    control.check()?;
    let mut tally = Tally::default();
    for (_, counted) in &images {
        tally.add(*counted);
    }
    Ok((judged_in_pairs(&found), shares(tally)))
}

/// Random pixels that are compared in a block of one or several rows, at least: rays to the whole block are traced for
/// the first.
const OF_BLOCK: usize = 4;

/// Compares values in double precision at random pixels, and at as many that are the brightest of a part of their block.
pub(in crate::plan) fn compare_values(
    request: &Request,
    tables: &DoubleTables,
    pixels: usize,
    control: Control,
) -> Result<SelfCheck, ImagingError> {
    let (grid, echoes) = (&request.grid, &request.echoes);
    let mut random = Random(0x0d0b_1e00);
    let together = rows_together(echoes);
    let mut blocks: Vec<[usize; 2]> = (0..pixels.div_ceil(2 * OF_BLOCK))
        .map(|_| {
            [
                random.below(grid.columns()) / BLOCK,
                random.below(grid.rows()) / together,
            ]
        })
        .collect();
    blocks.sort_unstable();
    blocks.dedup();
    let of_block = pixels.div_ceil(2 * blocks.len().max(1));
    let block_m = |[across, along]: &[usize; 2]| -> Vec<Vec<[f64; 3]>> {
        let part = |k: usize, size: usize, end: usize| k * size..((k + 1) * size).min(end);
        let columns = part(*across, BLOCK, grid.columns());
        let row_m = |j: usize| columns.clone().map(|i| grid.point_m(i, j)).collect();
        part(*along, together, grid.rows()).map(row_m).collect()
    };
    let blocks_m: Vec<Vec<Vec<[f64; 3]>>> = blocks.iter().map(block_m).collect();
    let values = tables.values_at(echoes, grid, &blocks_m, control);
    let compared: Vec<Pixel> = (blocks_m.iter().zip(&values))
        .flat_map(|(rows_m, values)| {
            let points_m = rows_m.concat();
            let share = values.len().div_ceil(of_block);
            let drawn: Vec<usize> = (0..of_block)
                .flat_map(|k| {
                    let first = (k * share).min(values.len() - 1);
                    let part = &values[first..(first + share).min(values.len())];
                    [random.below(values.len()), first + brightest(part)]
                })
                .collect();
            drawn.into_iter().map(move |k| (points_m[k], values[k]))
        })
        .collect();
    let found = deviations(echoes, &compared, control);
    control.check()?;
    Ok(judged_in_pairs(&found))
}

/// Place of a pixel, m, and its value.
pub(in crate::plan) type Pixel = ([f64; 3], Complex32);

/// Deviations of pixels from the double-precision sum, without meaning once cancelled.
pub(in crate::plan) fn deviations(
    echoes: &WeightedPulses,
    pixels: &[Pixel],
    control: Control,
) -> Vec<Deviation> {
    let points_m: Vec<[f64; 3]> = pixels.iter().map(|(point_m, _)| *point_m).collect();
    let expected = echoes.adjoint_at(&points_m, || control.is_cancelled());
    let deviation = |((_, value), expected): (&Pixel, Complex64)| Deviation {
        difference: (Complex64::new(f64::from(value.re), f64::from(value.im)) - expected)
            .norm_sqr(),
        power: expected.norm_sqr(),
    };
    pixels.iter().zip(expected).map(deviation).collect()
}

/// The self-check by pairs of a random pixel and the brightest pixel near it.
fn judged_in_pairs(found: &[Deviation]) -> SelfCheck {
    let every_second = |first: usize| found.iter().copied().skip(first).step_by(2);
    let [random, bright] = [0, 1].map(|first| every_second(first).collect::<Vec<_>>());
    judged_apart(&random, &bright)
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
