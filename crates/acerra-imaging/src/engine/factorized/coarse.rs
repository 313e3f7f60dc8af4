//! Coarse grids of sub-apertures.

use super::interpolation::BEFORE;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::lanes::MAX_LANES;
use crate::kernel::merge::TAPS;

/// The coarse grid that covers `grid`.
pub(crate) fn coarse_grid(grid: &TiltedGrid, coarse: [usize; 2]) -> TiltedGrid {
    let before = |d: usize| -((BEFORE * d) as f64);
    let intervals = grid.columns.div_ceil(coarse[0]).next_multiple_of(MAX_LANES);
    TiltedGrid {
        origin_m: grid.point_m(before(coarse[0]), before(coarse[1])),
        u_m: grid.u_m.map(|x| x * coarse[0] as f64),
        v_m: grid.v_m.map(|x| x * coarse[1] as f64),
        columns: intervals + TAPS,
        rows: grid.rows.div_ceil(coarse[1]) + TAPS,
    }
}

/// Bytes of the coarse images of `parts` sub-apertures.
pub(crate) fn coarse_bytes(grid: &TiltedGrid, coarse: [usize; 2], parts: usize) -> u128 {
    let coarse = coarse_grid(grid, coarse);
    let pixels = coarse.columns.next_multiple_of(MAX_LANES) as u128 * coarse.rows as u128;
    // One more, complex, is in the making.
    pixels * 8 * (parts as u128 + 1)
}
