//! Places on the image's pixels, between their centres.

use acerra_imaging::ImageGrid;
use nalgebra::Vector3;

/// Surface on which points lie: the image's pixels, with bilinear interpolation between pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground<'a> {
    grid: ImageGrid<'a>,
}

/// A place in columns and rows, fractions between pixel centres.
pub(crate) type PixelPlace = [f64; 2];

impl<'a> Ground<'a> {
    pub fn new(grid: ImageGrid<'a>) -> Self {
        Self { grid }
    }

    pub fn grid(&self) -> ImageGrid<'a> {
        self.grid
    }

    fn cell(&self, place: PixelPlace) -> ([usize; 2], [f64; 2]) {
        let sizes = [self.grid.columns(), self.grid.rows()];
        let start = [0, 1].map(|a| (place[a].max(0.0) as usize).min(sizes[a].saturating_sub(2)));
        let rest = [0, 1].map(|a| place[a] - start[a] as f64);
        (start, rest)
    }

    fn corner(&self, start: [usize; 2], step: [usize; 2]) -> Vector3<f64> {
        let i = (start[0] + step[0]).min(self.grid.columns() - 1);
        let j = (start[1] + step[1]).min(self.grid.rows() - 1);
        self.grid.point_m(i, j).into()
    }

    /// The point at a place, m.
    pub fn point_m(&self, place: PixelPlace) -> Vector3<f64> {
        let (start, [s, t]) = self.cell(place);
        let at = |i, j| self.corner(start, [i, j]);
        at(0, 0) * ((1.0 - s) * (1.0 - t))
            + at(1, 0) * (s * (1.0 - t))
            + at(0, 1) * ((1.0 - s) * t)
            + at(1, 1) * (s * t)
    }

    /// Change of the point per column and per row, m.
    pub fn tangents_m(&self, place: PixelPlace) -> [Vector3<f64>; 2] {
        let (start, [s, t]) = self.cell(place);
        let at = |i, j| self.corner(start, [i, j]);
        [
            (at(1, 0) - at(0, 0)) * (1.0 - t) + (at(1, 1) - at(0, 1)) * t,
            (at(0, 1) - at(0, 0)) * (1.0 - s) + (at(1, 1) - at(1, 0)) * s,
        ]
    }

    /// Whether a place lies on the pixels.
    pub fn holds(&self, place: PixelPlace) -> bool {
        let sizes = [self.grid.columns(), self.grid.rows()];
        (0..2).all(|a| place[a] >= 0.0 && place[a] <= (sizes[a] - 1) as f64)
    }
}
