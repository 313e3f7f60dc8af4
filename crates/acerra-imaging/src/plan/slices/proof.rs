//! Self-check of slices while they are imaged.
//!
//! Errors hardly change from one slice to the next, and powers may: a slice without targets is darker than
//! its neighbours by orders of magnitude. Errors are therefore drawn at few pixels of every slice; the draws
//! of the last slices together give the size of the error, and the power of all pixels of a slice gives the
//! error relative to the slice. Errors concentrate in few places: few draws are accepted only where they find
//! much less than is allowed; otherwise more pixels of the slice itself are drawn.
//!
//! With squared deviations d and powers p at random pixels, d ≈ a + b·p: a by tables and interpolation
//! everywhere, b·p by errors of phase and amplitude at bright pixels. For any b the mean of d − b·p, plus b
//! times the slice's mean power, is an unbiased estimate of the slice's mean squared deviation (Cochran,
//! Sampling Techniques, 1977, section 7: difference estimates). b is taken from the pixels drawn, and not so
//! large that the mean of d − b·p could be negative.

use super::super::check::imaging::{Pixel, ROUNDING_BELOW, deviations, least_pixels, most_pixels};
use super::super::check::places::{Deviation, brightest, judged};
use super::super::options::SelfCheck;
use super::super::request::Request;
use crate::engine::weights::WeightedPulses;
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::sampling::Random;
use acerra_control::Control;
use num_complex::Complex32;
use std::collections::VecDeque;

/// Double-precision contributions (frequency × pulse) for each contribution (pixel × pulse) of a slice.
const SHARE: f64 = 0.02;
/// Cells of the lattice from which pixels are drawn in turn, per axis.
const LATTICE: usize = 6;
/// Step from one cell to the next, modulo the number of cells: neighbouring draws are far apart.
const CELL_STEP: usize = 23;
/// Side of the square about a random pixel whose brightest pixel is compared too.
const SQUARE: usize = 16;
/// Last slices that are judged together.
const SLICES: usize = 4;
/// Factor by which a slice's draws grow while they leave the verdict open.
const MORE: usize = 2;
/// Shares of the allowed error up to which draws of one slice are accepted: with fewer draws than are judged
/// together, with as many, and with twice as many. Four times as many are accepted up to the whole error.
const BELIEVED: [f64; 3] = [0.6, 0.75, 0.9];

/// Share of the accuracy that the draws of a slice may find, including their uncertainty. Of many slices near
/// the limit some would exceed it by more than two standard errors.
const ALLOWED: f64 = 0.92;

/// A random pixel, and the brightest near it.
type Pair = [Deviation; 2];

/// Draws of the last slices.
pub(super) struct Proof {
    /// Draws of the last slices; the draws of the current slice are at the back.
    pairs: VecDeque<Pair>,
    /// First number of draws of a slice.
    each: usize,
    /// Number of draws that are judged together.
    together: usize,
    /// Largest number of draws of a slice.
    most: usize,
    /// The error allowed.
    allowed: f64,
    /// Number of draws so far, which determines the next cell.
    drawn: usize,
    random: Random,
}

impl Proof {
    /// The check for slices of the same size as the request's grid.
    pub fn new(request: &Request) -> Self {
        let frequencies = request.echoes.pulses.frequency_hz().len().max(1);
        let most = most_pixels(request).div_ceil(2);
        let together = if request.options.accuracy < ROUNDING_BELOW {
            most
        } else {
            least_pixels(request).div_ceil(2)
        };
        let affordable = SHARE * request.pixels() as f64 / (2 * frequencies) as f64;
        Self {
            pairs: VecDeque::new(),
            each: (affordable as usize).clamp(together.div_ceil(SLICES), together),
            together,
            most,
            allowed: ALLOWED * request.options.accuracy,
            drawn: 0,
            random: Random(0x51ce),
        }
    }

    /// Compares pixels of the next slice, and more pixels while the verdict is open.
    ///
    /// # Errors
    /// Cancellation.
    pub fn of_slice(
        &mut self,
        echoes: &WeightedPulses,
        grid: &ImageGrid,
        image: &[Complex32],
        control: Control,
    ) -> Result<SelfCheck, ImagingError> {
        let power = image.iter().map(|v| f64::from(v.norm_sqr())).sum::<f64>() / image.len() as f64;
        let mut own = 0;
        let mut wanted = self
            .each
            .max(self.together - self.pairs.len().min(self.together));
        loop {
            let places: Vec<[usize; 2]> = (own..wanted).map(|_| self.place(grid, image)).collect();
            let pixel = |k: &usize| {
                let point_m = grid.point_m(k % grid.columns(), k / grid.columns());
                (point_m, image[*k])
            };
            let pixels: Vec<Pixel> = places.as_flattened().iter().map(pixel).collect();
            let found = deviations(echoes, &pixels, control);
            control.check()?;
            self.pairs.extend(found.as_chunks().0);
            own = wanted;
            let kept = own.max(self.together).min(self.pairs.len());
            self.pairs.drain(..self.pairs.len() - kept);
            let check = SelfCheck {
                pixels: 2 * own,
                ..judged_of(self.pairs.make_contiguous(), power)
            };
            let is_broken = own >= self.together && check.error > self.allowed;
            if is_broken || own >= self.most || check.error_bound <= self.believed(own) {
                return Ok(check);
            }
            wanted = (MORE * own).min(self.most);
        }
    }

    /// Whether a slice keeps the accuracy.
    pub fn accepts(&self, check: SelfCheck) -> bool {
        check.error_bound <= self.allowed
    }

    /// The largest error that this number of draws of a slice excludes.
    fn believed(&self, own: usize) -> f64 {
        let share = match own / self.together {
            0 => BELIEVED[0],
            1 => BELIEVED[1],
            2 | 3 => BELIEVED[2],
            _ => 1.0,
        };
        share * self.allowed
    }

    /// A random pixel of the next cell, and the brightest in the square about it.
    fn place(&mut self, grid: &ImageGrid, image: &[Complex32]) -> [usize; 2] {
        let cell = self.drawn * CELL_STEP % (LATTICE * LATTICE);
        self.drawn += 1;
        let sizes = [grid.columns(), grid.rows()];
        let at: [usize; 2] = std::array::from_fn(|axis| {
            let (size, cell) = (sizes[axis], [cell % LATTICE, cell / LATTICE][axis]);
            let (from, to) = (cell * size / LATTICE, (cell + 1) * size / LATTICE);
            (from + self.random.below((to - from).max(1))).min(size - 1)
        });
        let [columns, rows] = [0, 1].map(|axis| {
            let start = at[axis].saturating_sub(SQUARE / 2);
            start..(start + SQUARE).min(sizes[axis])
        });
        let square: Vec<usize> = rows
            .flat_map(|j| columns.clone().map(move |i| j * sizes[0] + i))
            .collect();
        let values: Vec<Complex32> = square.iter().map(|k| image[*k]).collect();
        [at[1] * sizes[0] + at[0], square[brightest(&values)]]
    }
}

/// The self-check of a slice of mean power `power` by draws of the slice and of its neighbours: the larger of
/// the slice's error and the error of the brightest pixels.
fn judged_of(pairs: &[Pair], power: f64) -> SelfCheck {
    let [random, bright] = [0, 1].map(|k| pairs.iter().map(|d| d[k]).collect::<Vec<_>>());
    let of_bright = judged(&bright, bright.len());
    let of_random = judged(&random, random.len());
    let slope = if random.iter().any(|d| d.power > 0.0) {
        of_bright.error.min(of_random.error).powi(2)
    } else {
        0.0
    };
    let draws = random.len() as f64;
    let residuals: Vec<f64> = (random.iter())
        .map(|d| d.difference - slope * d.power)
        .collect();
    let mean = residuals.iter().sum::<f64>() / draws;
    let squares: f64 = residuals.iter().map(|e| (e - mean).powi(2)).sum();
    let deviation = (squares / (draws - 1.0).max(1.0) / draws).sqrt();
    let scale = if power > 0.0 { power } else { 1.0 };
    let error = |mean: f64| (mean.max(0.0) / scale + slope).sqrt();
    SelfCheck {
        pixels: 2 * pairs.len(),
        error: error(mean).max(of_bright.error),
        error_bound: error(mean + 2.0 * deviation).max(of_bright.error_bound),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws of a slice whose pixels have exponential powers about a mean, with errors of `floor` (power) and
    /// of a share `slope` of each pixel's power.
    fn pairs(count: usize, mean: f64, [floor, slope]: [f64; 2], random: &mut Random) -> Vec<Pair> {
        let mut uniform = Random(random.next());
        let mut exponential = || -((random.below(1 << 20) as f64 + 0.5) / f64::from(1 << 20)).ln();
        let mut draw = |power: f64| Deviation {
            difference: floor * exponential() + slope * power,
            power,
        };
        (0..count)
            .map(|_| {
                let unit = (uniform.below(1 << 20) as f64 + 0.5) / f64::from(1 << 20);
                [draw(-mean * unit.ln()), draw(5.0 * mean)]
            })
            .collect()
    }

    #[test]
    fn a_dark_slice_is_judged_by_its_own_power() {
        let mut random = Random(3);
        // Bright neighbours, 20 draws each, and one draw of a slice of a ten-thousandth of their power.
        let mut drawn = pairs(40, 1.0, [1e-8, 1e-8], &mut random);
        drawn.extend(pairs(1, 1e-4, [1e-8, 1e-8], &mut random));
        let bright = judged_of(&drawn[..40], 1.0);
        assert!((bright.error - 2e-8f64.sqrt()).abs() < 3e-5, "{bright:?}");
        let dark = judged_of(&drawn, 1e-4);
        assert!((dark.error / 1e-2 - 1.0).abs() < 0.4, "{dark:?}");
        assert!(
            dark.error_bound > dark.error && dark.error_bound < 2e-2,
            "{dark:?}"
        );
        // A slice that is black by weights that are 0 has no error.
        let black = vec![[Deviation::default(); 2]; 20];
        assert!(judged_of(&black, 0.0).error_bound.abs() < 1e-30);
    }

    #[test]
    fn few_draws_seldom_lie_below_the_truth() {
        let mut beyond = 0;
        for seed in 0..300 {
            let drawn = pairs(20, 1.0, [1e-6, 3e-7], &mut Random(seed));
            beyond += usize::from(judged_of(&drawn, 1.0).error_bound.powi(2) < 1.3e-6);
        }
        assert!(beyond <= 20, "{beyond} of 300 below the truth");
    }
}
