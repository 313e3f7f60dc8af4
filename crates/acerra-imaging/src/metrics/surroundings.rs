//! Level of clutter, noise and sidelobes about a maximum.
//!
//! A maximum of clutter is as high as the highest of many draws; a target is higher. The power of clutter is
//! modelled as Weibull distributed with the median and the upper quartile of the surroundings, so that spiky
//! clutter raises the threshold (constant false alarm rate). Levels are compared with the 1/R² of Eq. (3)
//! undone, which lets clutter rise steeply towards the antenna.

use std::f64::consts::LN_2;

use rayon::prelude::*;

use super::image::ImageView;

/// Least number of blocks along each side of an image: a corner block then has three neighbours for
/// comparison.
const LEAST_BLOCKS: usize = 2;
/// Side of a block in resolution cells.
const CELLS_A_BLOCK: f64 = 4.0;
/// Largest number of pixels along a block's side that are used.
const BLOCK_SAMPLES: usize = 32;
/// Mean number of clutter maxima that an image may have among its targets.
const FALSE_ALARMS: f64 = 0.01;
/// Largest exponent of the Weibull power: surroundings that consist of targets by half are not clutter.
const MOST_SPIKY: f64 = 2.0;

/// Largest number of track positions among which the nearest to a pixel is searched.
const MOST_POSITIONS: usize = 64;

/// Levels of the clutter over an image, block by block.
#[derive(Clone, Debug)]
pub(super) struct Surroundings<'a> {
    image: ImageView<'a>,
    /// Some places of the track (m).
    track_m: Vec<[f64; 3]>,
    /// Pixels along a block's side.
    side: usize,
    blocks: [usize; 2],
    /// Median and upper quartile of the power of each block.
    quantiles: Vec<[f64; 2]>,
    /// Number of resolution cells of the image divided by the allowed number of false alarms.
    odds: f64,
}

impl<'a> Surroundings<'a> {
    /// Measures the clutter of an image whose resolution cell has sides of `cell_m`, seen from `position_m`.
    pub fn of(image: &ImageView<'a>, cell_m: [f64; 2], position_m: &[[f64; 3]]) -> Self {
        let grid = image.grid();
        let widest = cell_m[0].max(cell_m[1]) / grid.pixel_m;
        let side = (CELLS_A_BLOCK * widest).ceil().clamp(4.0, 4096.0) as usize;
        let blocks = [grid.nx.div_ceil(side), grid.ny.div_ceil(side)];
        let pixels_a_cell = (cell_m[0] * cell_m[1] / grid.pixel_m.powi(2)).max(1.0);
        let cells = (grid.nx as f64 * grid.ny as f64 / pixels_a_cell).max(1.0);
        let stride = position_m.len().div_ceil(MOST_POSITIONS).max(1);
        let mut made = Self {
            image: *image,
            track_m: position_m.iter().step_by(stride).copied().collect(),
            side,
            blocks,
            quantiles: Vec::new(),
            odds: cells / FALSE_ALARMS,
        };
        made.quantiles = (0..blocks[0] * blocks[1])
            .into_par_iter()
            .map(|k| made.quantiles_of([k % blocks[0], k / blocks[0]]))
            .collect();
        made
    }

    /// Whether the maximum at a pixel exceeds the highest expected maximum of the clutter about the pixel.
    pub fn is_exceeded(&self, [ix, iy]: [usize; 2]) -> bool {
        // A single row of blocks (for example of a vertical section) contains a target and its sidelobes
        // only.
        if self.blocks.iter().any(|count| *count < LEAST_BLOCKS) {
            return true;
        }
        let own = [ix / self.side, iy / self.side];
        let about = |k: usize, most: usize| k.saturating_sub(1)..(k + 2).min(most);
        let mut medians = Vec::new();
        let mut quartiles = Vec::new();
        for by in about(own[1], self.blocks[1]) {
            for bx in about(own[0], self.blocks[0]) {
                if [bx, by] != own {
                    let [median, quartile] = self.quantiles[by * self.blocks[0] + bx];
                    medians.push(median);
                    quartiles.push(quartile);
                }
            }
        }
        let (median, quartile) = (middle(&mut medians), middle(&mut quartiles));
        self.power(ix, iy) > self.highest(median, quartile)
    }

    /// Power of a pixel with the 1/R² of its amplitude undone.
    fn power(&self, ix: usize, iy: usize) -> f64 {
        let [x_m, y_m] = self.image.centre_m(ix, iy);
        let at = [x_m, y_m, self.image.z_m(x_m, y_m)];
        let to = |p: &[f64; 3]| (0..3).map(|i| (p[i] - at[i]).powi(2)).sum::<f64>();
        let nearest_m2 = self.track_m.iter().map(to).fold(f64::INFINITY, f64::min);
        let gain = if nearest_m2.is_finite() {
            nearest_m2 * nearest_m2
        } else {
            1.0
        };
        f64::from(self.image.at(ix, iy).norm_sqr()) * gain
    }

    fn quantiles_of(&self, [bx, by]: [usize; 2]) -> [f64; 2] {
        let grid = self.image.grid();
        let within = |k: usize, most: usize| k * self.side..((k + 1) * self.side).min(most);
        // In a large block every few pixels suffice.
        let stride = (self.side / BLOCK_SAMPLES).max(1);
        let mut power: Vec<f64> = within(by, grid.ny)
            .step_by(stride)
            .flat_map(|iy| {
                within(bx, grid.nx)
                    .step_by(stride)
                    .map(move |ix| self.power(ix, iy))
            })
            .collect();
        power.sort_by(f64::total_cmp);
        [0.5, 0.75].map(|share| power[(share * (power.len() - 1) as f64) as usize])
    }

    /// Power that the highest clutter maximum of the image rarely exceeds.
    fn highest(&self, median: f64, quartile: f64) -> f64 {
        if median <= 0.0 {
            return 0.0;
        }
        // For exponentially distributed power the upper quartile is twice the median.
        let exponent = ((quartile / median).ln() / LN_2).clamp(1.0, MOST_SPIKY);
        median * (self.odds.ln() / LN_2).powf(exponent)
    }
}

/// Largest number of pixels from which the levels of an image are estimated.
const IMAGE_SAMPLES: usize = 1 << 18;

/// Expected amplitude of the highest pixel of an image of clutter and noise alone, plus 3 dB: an image whose
/// maximum is lower holds no focused target.
pub(super) fn highest_by_chance(image: &ImageView<'_>, cell_m: [f64; 2]) -> f64 {
    let grid = image.grid();
    let cells = grid.len() as f64 * grid.pixel_m.powi(2) / (cell_m[0] * cell_m[1]);
    // An odd stride, so that pixels of all columns are used.
    let stride = (image.values().len() / IMAGE_SAMPLES) | 1;
    let values = image.values().iter().step_by(stride);
    let mut power: Vec<f64> = values.map(|v| f64::from(v.norm_sqr())).collect();
    highest_power_by_chance(&mut power, cells).sqrt()
}

/// Expected power of the highest of so many resolution `cells` of clutter and noise, plus 3 dB, from the power of some
/// of their pixels, which are put in another order; 0 without pixels.
///
/// The power of the highest of N cells is that of the upper quartile plus ln(N/4) of the exponential tail, whose scale
/// is the quartile's distance from the median over ln 2; likewise where each pixel is itself the highest of a column.
///
/// ```
/// // Power of complex normal clutter of mean 1: the highest of 1000 cells has ln 1000 = 6.9.
/// let mut power: Vec<f64> = (0..1000).map(|k| -((f64::from(k) + 0.5) / 1000.0).ln()).collect();
/// let highest = acerra_imaging::metrics::highest_power_by_chance(&mut power, 1000.0);
/// assert!((highest / 2.0 - 6.9).abs() < 0.1);
/// ```
#[must_use]
pub fn highest_power_by_chance(power: &mut [f64], cells: f64) -> f64 {
    let mut quantile = |share: f64| {
        let at = (share * power.len().saturating_sub(1) as f64) as usize;
        if power.is_empty() {
            return 0.0;
        }
        *power.select_nth_unstable_by(at, f64::total_cmp).1
    };
    let (median, quartile) = (quantile(0.5), quantile(0.75));
    let tail = (quartile - median) / LN_2;
    2.0 * (quartile + tail * (cells / 4.0).max(1.0).ln())
}

fn middle(values: &mut [f64]) -> f64 {
    let at = values.len() / 2;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::plane::PlaneGrid;
    use num_complex::Complex32;

    /// Complex normal clutter whose power falls with x as 1/R² does, and a target far out.
    fn image(target: f32) -> (Vec<Complex32>, PlaneGrid) {
        let mut state = 3_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 + 0.5) / 2f64.powi(53)
        };
        let grid = PlaneGrid::new([0.0, 0.0, 0.0], 0.1, [120, 120]).unwrap();
        let mut values: Vec<Complex32> = (0..grid.len())
            .map(|k| {
                let (u, v) = (uniform(), uniform());
                let x_m = 0.5 + grid.x_m(k % grid.nx);
                let amplitude = (-u.ln()).sqrt() / (x_m * x_m);
                let turn = std::f64::consts::TAU * v;
                Complex32::new(
                    (amplitude * turn.cos()) as f32,
                    (amplitude * turn.sin()) as f32,
                )
            })
            .collect();
        values[60 * 120 + 100] = Complex32::new(target, 0.0);
        (values, grid)
    }

    #[test]
    fn near_clutter_that_is_brighter_than_a_far_target_does_not_stand_out() {
        let (values, grid) = image(0.2);
        let view = ImageView::new(&values, grid).unwrap();
        let track: Vec<[f64; 3]> = (0..120).map(|k| [-0.5, 0.1 * f64::from(k), 0.0]).collect();
        let about = Surroundings::of(&view, [0.1, 0.1], &track);
        let found: Vec<usize> = (0..values.len())
            .filter(|k| about.is_exceeded([k % 120, k / 120]))
            .collect();
        assert!(values[0].norm() > 0.2, "clutter at the antenna is brighter");
        assert_eq!(found, [60 * 120 + 100]);
    }

    #[test]
    fn the_highest_of_clutter_is_what_chance_gives_it() {
        // Clutter of one level: exponential power of mean 1, N cells of one pixel.
        let (values, grid) = image(0.0);
        let level: Vec<Complex32> = (values.iter().enumerate())
            .map(|(k, v)| {
                let x_m = 0.5 + grid.x_m(k % grid.nx);
                v * (x_m * x_m) as f32
            })
            .collect();
        let view = ImageView::new(&level, grid).unwrap();
        let cell_m = [grid.pixel_m; 2];
        let top = level.iter().map(|v| v.norm()).fold(0.0, f32::max);
        let by_chance = highest_by_chance(&view, cell_m) as f32;
        assert!(
            (1.05..2.0).contains(&(by_chance / top)),
            "{by_chance} {top}"
        );
        // The highest of eight such images, as of a volume from above.
        let part = level.len() / 8;
        let above: Vec<Complex32> = (0..part)
            .map(|k| {
                let column = (0..8).map(|i| level[i * part + k]);
                column.fold(
                    Complex32::ZERO,
                    |a, b| if b.norm() > a.norm() { b } else { a },
                )
            })
            .collect();
        let grid = PlaneGrid {
            nx: part,
            ny: 1,
            ..grid
        };
        let by_chance_above =
            highest_by_chance(&ImageView::new(&above, grid).unwrap(), cell_m) as f32;
        assert!(
            (0.95..1.25).contains(&(by_chance_above / by_chance)),
            "{by_chance_above} {by_chance}"
        );
    }

    #[test]
    fn an_image_without_surroundings_keeps_every_maximum() {
        let (values, grid) = image(0.2);
        let view = ImageView::new(&values, grid).unwrap();
        let about = Surroundings::of(&view, [3.2, 0.1], &[]);
        assert!(about.is_exceeded([0, 0]));
    }
}
