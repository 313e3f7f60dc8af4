//! Random places of self-checks, and the relative error found on them.

use crate::grid::tilted::TiltedGrid;
use crate::plan::options::SelfCheck;
use crate::sampling::Random;

/// Cells of the lattice of patches, per axis.
const LATTICE: usize = 6;
/// Corners, where spatial frequencies are highest.
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

/// Power of differences and of the values expected.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Deviation {
    pub difference: f64,
    pub power: f64,
}

impl Deviation {
    pub fn add(&mut self, other: Self) {
        self.difference += other.difference;
        self.power += other.power;
    }

    /// The check of `pixels` pixels: relative error, or absolute where all values are zero.
    pub fn check(self, pixels: usize) -> SelfCheck {
        SelfCheck {
            pixels,
            error: if self.power > 0.0 {
                (self.difference / self.power).sqrt()
            } else {
                self.difference.sqrt()
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::plane::PlaneGrid;

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
