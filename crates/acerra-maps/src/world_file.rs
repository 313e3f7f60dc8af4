//! World files: six lines in a file next to a picture that give the coordinates of the picture's pixels,
//! without naming a coordinate reference system.

use crate::placement::Placement;

/// The text of a world file: steps of a column and of a row, then the centre of the north-western
/// pixel.
///
/// ```
/// use acerra_maps::placement::{LocalGrid, Placement};
/// use acerra_maps::world_file::world_file;
/// let grid = LocalGrid { x0_m: 1.0, y0_m: 2.0, z_m: 0.0, pixel_m: 0.5, nx: 3, ny: 5 };
/// assert_eq!(world_file(&Placement::local(&grid)), "0.5\n0\n0\n-0.5\n1\n4\n");
/// ```
#[must_use]
pub fn world_file(placement: &Placement) -> String {
    let Placement {
        first, column, row, ..
    } = placement;
    let lines = [column[0], column[1], row[0], row[1], first[0], first[1]];
    lines.map(|value| format!("{}\n", value + 0.0)).concat()
}
