//! Random places of self-checks, and the relative error found on them.

use crate::grid::tilted::TiltedGrid;
use crate::plan::options::SelfCheck;
use crate::sampling::Random;
use num_complex::Complex32;

/// Cells of the lattice of patches, per axis.
const LATTICE: usize = 6;
/// Number of corners, where spatial frequencies are highest.
const CORNERS: usize = 4;
/// Most patches of a check.
pub(super) const MOST_PATCHES: usize = CORNERS + LATTICE * LATTICE;

/// A patch of a self-check.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// First pixel.
    pub start: [usize; 2],
    /// Pixels to compare.
    pub pixels: usize,
    /// Seed of the choice of pixels.
    pub seed: u64,
}

/// Patches with `pixels` pixels together: the four corners and one at random in each cell of a 6 × 6
/// lattice, since errors may gather in small places. All begin on the coarse lattice, as pixels of
/// the whole image do.
pub(super) fn patches(
    grid: &TiltedGrid,
    coarse: [usize; 2],
    pixels: usize,
    seed: u64,
) -> Vec<Place> {
    let mut random = Random(seed);
    let count = pixels.clamp(1, MOST_PATCHES);
    (0..count)
        .map(|k| Place {
            start: patch_at([k, count], &mut random, grid, coarse),
            // The corners are a tenth of the patches, and far less of the image: the rest goes to cells.
            pixels: pixels / count + usize::from(k + pixels % count >= count),
            seed: random.next(),
        })
        .collect()
}

fn patch_at(
    [k, count]: [usize; 2],
    random: &mut Random,
    grid: &TiltedGrid,
    coarse: [usize; 2],
) -> [usize; 2] {
    let sizes = [grid.columns, grid.rows];
    std::array::from_fn(|axis| {
        let (size, d) = (sizes[axis], coarse[axis]);
        let at = match (k, (k >> axis) & 1) {
            (0..CORNERS, 0) => 0,
            (0..CORNERS, _) => (size - 1).saturating_sub(d),
            _ => {
                // Few patches are spread over the whole lattice.
                let stride = if count < MOST_PATCHES { 23 } else { 1 };
                let scattered = (k - CORNERS) * stride % (LATTICE * LATTICE);
                let cell = [scattered % LATTICE, scattered / LATTICE][axis];
                let (from, to) = (cell * size / LATTICE, (cell + 1) * size / LATTICE);
                (from + random.below((to - from).max(1))).min(size - 1)
            }
        };
        at / d * d
    })
}

/// Power of the difference between a value and its reference, and power of the reference.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::plan) struct Deviation {
    pub difference: f64,
    pub power: f64,
}

/// Index of the value that is largest in magnitude.
pub(in crate::plan) fn brightest(values: &[Complex32]) -> usize {
    (0..values.len())
        .max_by(|a, b| values[*a].norm_sqr().total_cmp(&values[*b].norm_sqr()))
        .unwrap_or(0)
}

/// The self-check by random pixels and by the brightest pixels near them: the larger of both errors. Phase
/// errors show at bright pixels, which a few random draws seldom hit.
pub(super) fn judged_apart(random: &[Deviation], bright: &[Deviation]) -> SelfCheck {
    let [random, bright] = [random, bright].map(|found| judged(found, found.len()));
    SelfCheck {
        pixels: random.pixels + bright.pixels,
        error: random.error.max(bright.error),
        error_bound: random.error_bound.max(bright.error_bound),
    }
}

/// The self-check result from deviations at `pixels` pixels: the relative error, or the absolute error where
/// all values are zero.
///
/// The error's square is a ratio of means, r = Σd/Σp. One bright pixel among those drawn lowers r, so twice
/// its standard error, from the variance Σ(d − rp)²/(Σp)² (linearised, over draws), is added.
pub(in crate::plan) fn judged(found: &[Deviation], pixels: usize) -> SelfCheck {
    let difference: f64 = found.iter().map(|d| d.difference).sum();
    let power: f64 = found.iter().map(|d| d.power).sum();
    let scale = if power > 0.0 { power } else { 1.0 };
    let ratio = difference / scale;
    let residuals: f64 = found
        .iter()
        .map(|d| (d.difference - ratio * d.power).powi(2))
        .sum();
    let draws = found.len() as f64;
    let deviation = (residuals * draws / (draws - 1.0).max(1.0)).sqrt() / scale;
    SelfCheck {
        pixels,
        error: ratio.sqrt(),
        error_bound: (ratio + 2.0 * deviation).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::plane::PlaneGrid;

    #[test]
    fn a_bright_pixel_does_not_vouch_for_the_others() {
        // An error of 1e-3 of a level of 1, and one pixel a hundred times as bright.
        let even = vec![
            Deviation {
                difference: 1e-6,
                power: 1.0
            };
            40
        ];
        let check = judged(&even, 40);
        assert!((check.error - 1e-3).abs() < 1e-12 && (check.error_bound - 1e-3).abs() < 1e-9);
        let mut bright = even;
        bright[7].power = 1e4;
        let check = judged(&bright, 40);
        assert!(check.error < 1e-4 && check.error_bound > 1.5 * check.error);
        // A share of the error's draws beyond the bound: few.
        let mut random = Random(5);
        let mut beyond = 0;
        for _ in 0..400 {
            let found: Vec<_> = (0..40)
                .map(|_| Deviation {
                    difference: 1e-6 * (random.below(1000) as f64 + 0.5) / 500.0,
                    power: (random.below(1000) as f64 + 0.5) / 500.0,
                })
                .collect();
            beyond += usize::from(judged(&found, 40).error_bound < 1e-3);
        }
        assert!(beyond <= 20, "{beyond} of 400 below the truth");
    }

    #[test]
    fn patches_hold_exactly_the_pixels_asked_for() {
        let grid = PlaneGrid::new([0.0; 3], 0.1, [300, 200]).unwrap().into();
        for pixels in [1, 3, 8, 40, 256, 257] {
            let places = patches(&grid, [5, 3], pixels, 7);
            assert_eq!(places.iter().map(|p| p.pixels).sum::<usize>(), pixels);
            assert!(places.iter().all(|p| p.start[0] < 300 && p.start[1] < 200));
            assert!(
                places
                    .iter()
                    .all(|p| p.start[0] % 5 == 0 && p.start[1] % 3 == 0)
            );
        }
        // All 36 cells are covered.
        let mut cells: Vec<_> = patches(&grid, [1, 1], 256, 7)[CORNERS..]
            .iter()
            .map(|p| (p.start[0] * LATTICE / 300, p.start[1] * LATTICE / 200))
            .collect();
        cells.sort_unstable();
        cells.dedup();
        assert_eq!(cells.len(), LATTICE * LATTICE);
    }
}
