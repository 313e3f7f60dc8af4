//! Places of samples between the pixels of uneven ground, or around them.

use super::relief::Relief;
use super::surface::SurfaceGrid;
use super::tilted::TiltedGrid;
use crate::vector::norm;
use rayon::prelude::*;

/// The ground under an engine's grids: the plane of the grids, or a surface over it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terrain<'a>(Option<&'a SurfaceGrid>);

impl<'a> Terrain<'a> {
    /// A level ground: all grids are planes.
    pub const LEVEL: Self = Terrain(None);

    /// The ground of a surface on whose base plane all grids lie; level where there is no surface.
    pub fn new(surface: Option<&'a SurfaceGrid>) -> Self {
        Self(surface)
    }

    /// Whether every sample has a separate height.
    pub fn is_uneven(&self) -> bool {
        self.0.is_some()
    }

    /// The ground at a point of the plane, m.
    fn raised_m(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        [x, y, z + self.0.map_or(0.0, |s| s.smooth_relief_m(x, y))]
    }

    /// The ground at sample (i, j) of a grid, m.
    pub fn point_m(&self, grid: &TiltedGrid, i: f64, j: f64) -> [f64; 3] {
        self.raised_m(grid.point_m(i, j))
    }

    /// The sample (i, j) of a grid raised to the height of the nearest pixel of the ground, m.
    pub fn near_m(&self, grid: &TiltedGrid, i: f64, j: f64) -> [f64; 3] {
        let [x, y, z] = grid.point_m(i, j);
        [x, y, z + self.0.map_or(0.0, |s| s.nearest_relief_m(x, y))]
    }

    /// Vectors along the ground at the pixel nearest to sample (i, j), a metre long in the plane: along the row and
    /// across it.
    pub fn axes(&self, grid: &TiltedGrid, i: f64, j: f64) -> [[f64; 3]; 2] {
        let mut axes = [grid.u_m, grid.v_m].map(|v| v.map(|x| x / norm(v).max(1e-300)));
        if let Some(surface) = self.0 {
            let [x, y, _] = grid.point_m(i, j);
            for (axis, slope) in axes.iter_mut().zip(surface.nearest_slopes(x, y)) {
                axis[2] += slope;
            }
        }
        axes
    }

    /// Heights of all samples of a grid; none over a plane.
    pub fn heights_on(&self, grid: &TiltedGrid) -> Option<Heights> {
        let surface = self.0?;
        let columns: Vec<_> = (0..grid.columns)
            .map(|i| surface.column_weights(grid.point_m(i as f64, 0.0)[0]))
            .collect();
        let mut above_m = vec![0f32; grid.columns * grid.rows];
        above_m
            .par_chunks_mut(grid.columns)
            .enumerate()
            .for_each_init(Vec::new, |line, (j, row)| {
                let across = surface.row_weights(grid.point_m(0.0, j as f64)[1]);
                surface.weigh_rows(&across, line);
                for (height, along) in row.iter_mut().zip(&columns) {
                    *height = along.of(line) as f32;
                }
            });
        Some(Heights {
            above_m,
            columns: grid.columns,
        })
    }
}

/// Heights of the samples of a grid above its plane, m.
#[derive(Debug)]
pub(crate) struct Heights {
    above_m: Vec<f32>,
    columns: usize,
}

impl Heights {
    /// The heights in the form that kernels read.
    pub fn relief(&self) -> Relief<'_> {
        Relief {
            heights_m: &self.above_m,
            stride: self.columns,
        }
    }

    /// Least and greatest height, m.
    pub fn span_m(&self) -> [f64; 2] {
        let extreme = |start: f32, of: fn(f32, f32) -> f32| {
            f64::from(self.above_m.iter().copied().fold(start, of))
        };
        [
            extreme(f32::INFINITY, f32::min),
            extreme(f32::NEG_INFINITY, f32::max),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ImagingError;
    use crate::grid::plane::PlaneGrid;

    #[test]
    fn samples_beside_the_pixels_follow_the_slope() {
        let base = PlaneGrid::new([1.0, 2.0, 50.0], 0.1, [40, 30]).unwrap();
        let slope = |x: f64, y: f64| Ok::<_, ImagingError>(0.3 * x - 0.2 * y);
        let surface = SurfaceGrid::from_fn(base, slope).unwrap();
        let terrain = Terrain::new(Some(&surface));
        let plane = TiltedGrid::from(*surface.base());
        for (i, j) in [
            (0.0, 0.0),
            (3.4, 7.9),
            (-5.0, 12.2),
            (45.5, -3.3),
            (39.0, 29.0),
        ] {
            let [x, y, z] = terrain.point_m(&plane, i, j);
            assert!((z - (0.3 * x - 0.2 * y)).abs() < 1e-5, "{i} {j}");
            let expected = [[1.0, 0.0, 0.3], [0.0, 1.0, -0.2]];
            for (found, expected) in terrain.axes(&plane, i, j).iter().zip(expected) {
                let apart = found.iter().zip(expected).map(|(f, e)| (f - e).abs());
                assert!(apart.fold(0.0, f64::max) < 1e-4);
            }
            let [_, _, near] = terrain.near_m(&plane, i, j);
            let [i, j] = [i.round().clamp(0.0, 39.0), j.round().clamp(0.0, 29.0)];
            let [x, y, _] = plane.point_m(i, j);
            assert!((near - (0.3 * x - 0.2 * y)).abs() < 1e-5, "{i} {j}");
        }
    }

    #[test]
    fn heights_on_a_grid_are_those_of_its_points() {
        let base = PlaneGrid::new([-2.0, -1.0, 3.0], 0.05, [90, 70]).unwrap();
        let wave = |x: f64, y: f64| Ok::<_, ImagingError>(0.4 * (2.0 * x + y).sin());
        let surface = SurfaceGrid::from_fn(base, wave).unwrap();
        let terrain = Terrain::new(Some(&surface));
        let plane = TiltedGrid::from(*surface.base());
        let coarse = TiltedGrid {
            origin_m: plane.point_m(-7.0, -4.0),
            u_m: plane.u_m.map(|x| x * 5.0 / 3.0),
            v_m: plane.v_m.map(|x| x * 2.0),
            columns: 61,
            rows: 41,
        };
        let heights = terrain.heights_on(&coarse).unwrap();
        let relief = heights.relief();
        for (i, j) in [(0, 0), (13, 9), (60, 40), (30, 0)] {
            let [_, _, z] = terrain.point_m(&coarse, i as f64, j as f64);
            let found = coarse.origin_m[2] + f64::from(relief.heights_m[j * relief.stride + i]);
            assert!((found - z).abs() < 1e-6);
            // Between pixels the wave is reproduced to third order.
            if (5..50).contains(&i) {
                let [x, y, z] = terrain.point_m(&coarse, i as f64, j as f64);
                assert!(j == 0 || (z - 0.4 * (2.0 * x + y).sin()).abs() < 2e-5);
            }
        }
        let [low, high] = heights.span_m();
        assert!(low < high && high < 1.0);
        assert!(Terrain::LEVEL.heights_on(&coarse).is_none());
    }
}
