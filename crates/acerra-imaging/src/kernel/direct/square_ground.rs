//! Heights of the pixels of a block of squares, split into a plane per square and the rest.

use super::job::{GROUP, HALF, SIDE};
use crate::grid::relief::Relief;
use crate::kernel::lanes::MAX_LANES;

/// Planes through the heights of the squares of one block, and the remaining heights.
#[derive(Clone, Copy)]
pub(super) struct SquareGround {
    /// Height of the block's middle above the band's plane, m.
    pub middle_m: f64,
    /// Plane through each square: height at its middle above the block's (m), slopes along the row and across, and
    /// the largest departure from it (m); one lane a square.
    pub plane_m: [f32; MAX_LANES],
    pub slope: [[f32; MAX_LANES]; 2],
    pub uneven_m: [f32; MAX_LANES],
    /// Every pixel's height above the plane of its square, square by square, m.
    pub residual_m: [[f32; GROUP]; MAX_LANES],
}

impl SquareGround {
    /// Level ground.
    pub const LEVEL: Self = Self {
        middle_m: 0.0,
        plane_m: [0.0; MAX_LANES],
        slope: [[0.0; MAX_LANES]; 2],
        uneven_m: [0.0; MAX_LANES],
        residual_m: [[0.0; GROUP]; MAX_LANES],
    };

    /// Fits planes to the first `columns` columns and `rows` rows of `relief`, `groups` squares side by side; the
    /// last heights are repeated up to the ends of the last squares.
    #[inline(always)]
    pub fn fit(
        &mut self,
        relief: &Relief,
        pixel_m: [f64; 2],
        [columns, rows]: [usize; 2],
        groups: usize,
    ) {
        let row = |j: usize| &relief.heights_m[j.min(rows - 1) * relief.stride..][..columns];
        let lines: [&[f32]; SIDE] = std::array::from_fn(row);
        self.middle_m = f64::from(lines[SIDE / 2][columns / 2]);
        // Σx² over the square, x being pixels from its middle.
        let spread: f32 = (0..GROUP).map(|p| from_middle(p % SIDE).powi(2)).sum();
        for k in 0..groups {
            let height = |p: usize| {
                let column = (SIDE * k + p % SIDE).min(columns - 1);
                (f64::from(lines[p / SIDE][column]) - self.middle_m) as f32
            };
            let heights: [f32; GROUP] = std::array::from_fn(height);
            let moment = |x: &dyn Fn(usize) -> f32| -> f32 {
                (0..GROUP).map(|p| x(p) * heights[p]).sum::<f32>() / spread
            };
            let rise = [
                moment(&|p| from_middle(p % SIDE)),
                moment(&|p| from_middle(p / SIDE)),
            ];
            let residual = &mut self.residual_m[k];
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for (p, residual) in residual.iter_mut().enumerate() {
                let plane = rise[0] * from_middle(p % SIDE) + rise[1] * from_middle(p / SIDE);
                *residual = heights[p] - plane;
                low = low.min(*residual);
                high = high.max(*residual);
            }
            let middle = 0.5 * (low + high);
            for residual in residual {
                *residual -= middle;
            }
            self.plane_m[k] = middle;
            for axis in 0..2 {
                self.slope[axis][k] = rise[axis] / pixel_m[axis] as f32;
            }
            self.uneven_m[k] = 0.5 * (high - low);
        }
        // Squares without pixels repeat the last one that has any.
        for k in groups..MAX_LANES {
            self.plane_m[k] = self.plane_m[groups - 1];
            self.uneven_m[k] = self.uneven_m[groups - 1];
            for slope in &mut self.slope {
                slope[k] = slope[groups - 1];
            }
        }
    }

    /// Height of a pixel above the plane of the band, m.
    pub fn height_m(&self, pixel_m: [f64; 2], k: usize, p: usize) -> f64 {
        let rise = |axis: usize, x: usize| {
            f64::from(self.slope[axis][k]) * pixel_m[axis] * f64::from(from_middle(x))
        };
        let residual_m = f64::from(self.plane_m[k]) + f64::from(self.residual_m[k][p]);
        self.middle_m + residual_m + rise(0, p % SIDE) + rise(1, p / SIDE)
    }
}

/// Pixels from the middle of a square to the `x`-th column or row.
fn from_middle(x: usize) -> f32 {
    x as f32 - HALF
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_and_what_they_leave_are_the_heights() {
        const STRIDE: usize = 40;
        let height = |i: usize, j: usize| {
            let (x, y) = (0.02 * i as f32, 0.03 * j as f32);
            7.0 + 0.4 * x - 0.3 * y + 0.05 * (9.0 * x + 4.0 * y).sin()
        };
        let heights_m: Vec<f32> = (0..4 * STRIDE)
            .map(|k| height(k % STRIDE, k / STRIDE))
            .collect();
        let relief = Relief {
            heights_m: &heights_m,
            stride: STRIDE,
        };
        let pixel_m = [0.02, 0.03];
        let mut ground = SquareGround::LEVEL;
        ground.fit(&relief, pixel_m, [33, 3], 9);
        for k in 0..9 {
            for p in 0..GROUP {
                let (i, j) = ((SIDE * k + p % SIDE).min(32), (p / SIDE).min(2));
                let found = ground.height_m(pixel_m, k, p);
                assert!((found - f64::from(height(i, j))).abs() < 2e-6);
                assert!(ground.residual_m[k][p].abs() <= ground.uneven_m[k] + 1e-7);
            }
        }
        assert_eq!(ground.plane_m[15], ground.plane_m[8]);
        ground.fit(&relief, pixel_m, [32, 4], 8);
        // At most half of the change of the wave's second derivatives between the corners: 0.05·81·0.03²/2
        // along, 0.05·16·0.045²/2 across, and 0.05·36·0.03·0.045 mixed.
        assert!(ground.uneven_m[..8].iter().all(|u| *u < 4e-3));
        let slope = 0.4 + 0.45 * (9.0f32 * 0.03 + 4.0 * 0.045).cos();
        assert!((ground.slope[0][0] - slope).abs() < 0.05);
    }
}
