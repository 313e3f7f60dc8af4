//! The pixels of an image, on a plane or on uneven ground.

use super::plane::PlaneGrid;
use super::relief::Relief;
use super::surface::SurfaceGrid;
use super::terrain::Terrain;
use super::tilted::TiltedGrid;

/// The pixels that a plan images: a plane of any tilt, or uneven ground. Made by `From` of a
/// [`PlaneGrid`], a [`TiltedGrid`] or a reference to a [`SurfaceGrid`].
#[derive(Debug, Clone, Copy)]
pub struct ImageGrid<'a> {
    plane: TiltedGrid,
    surface: Option<&'a SurfaceGrid>,
}

impl<'a> ImageGrid<'a> {
    /// Pixels in a row.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.plane.columns
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.plane.rows
    }

    /// Number of pixels.
    #[must_use]
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.plane.columns * self.plane.rows
    }

    /// Centre of pixel (i, j), m.
    #[must_use]
    pub fn point_m(&self, i: usize, j: usize) -> [f64; 3] {
        match self.surface {
            Some(surface) => surface.point_m(j * self.plane.columns + i),
            None => self.plane.point_m(i as f64, j as f64),
        }
    }

    /// Whether every pixel has a separate height.
    #[must_use]
    pub fn is_uneven(&self) -> bool {
        self.surface.is_some()
    }

    /// Whether all pixels have the same height by construction.
    pub(crate) fn is_level(&self) -> bool {
        self.surface.is_none() && self.plane.u_m[2] == 0.0 && self.plane.v_m[2] == 0.0
    }

    /// The plane, or the base plane of uneven ground.
    pub(crate) fn plane(&self) -> &TiltedGrid {
        &self.plane
    }

    /// Least and greatest height of uneven ground, m.
    pub(crate) fn span_m(&self) -> Option<[f64; 2]> {
        self.surface.map(SurfaceGrid::span_m)
    }

    /// The ground under all grids on the base plane.
    pub(crate) fn terrain(&self) -> Terrain<'a> {
        Terrain::new(self.surface)
    }

    /// Bounds of the ranges from `antenna_m` to all pixels and to `margin` further columns on either side.
    pub(crate) fn ranges_m(&self, antenna_m: [f64; 3], margin: f64) -> [f64; 2] {
        match self.surface {
            Some(surface) => surface.ranges_m(antenna_m, margin),
            None => self.plane.ranges_m(antenna_m, margin),
        }
    }

    /// Row-major index of the pixel whose centre is exactly `antenna_m`, if any.
    pub(crate) fn pixel_at(&self, antenna_m: [f64; 3]) -> Option<usize> {
        match self.surface {
            Some(surface) => surface.pixel_at(antenna_m),
            None => self.plane.pixel_at(antenna_m),
        }
    }

    /// All pixels.
    pub(crate) fn whole(&self) -> Patch<'a> {
        self.patch([0, 0], [self.plane.columns, self.plane.rows])
    }

    /// The `size` = `[columns, rows]` pixels from pixel `start` = `[i, j]` on, cut off at the edges.
    pub(crate) fn patch(&self, start: [usize; 2], size: [usize; 2]) -> Patch<'a> {
        let ([i, j], plane) = (start, &self.plane);
        Patch {
            grid: TiltedGrid {
                origin_m: plane.point_m(i as f64, j as f64),
                columns: size[0].min(plane.columns - i),
                rows: size[1].min(plane.rows - j),
                ..*plane
            },
            relief: self.surface.map(|surface| {
                let heights = Relief {
                    heights_m: surface.relief_m(),
                    stride: plane.columns,
                };
                heights.seen_from(i, j)
            }),
            terrain: self.terrain(),
        }
    }
}

impl From<PlaneGrid> for ImageGrid<'_> {
    fn from(grid: PlaneGrid) -> Self {
        TiltedGrid::from(grid).into()
    }
}

impl From<TiltedGrid> for ImageGrid<'_> {
    fn from(plane: TiltedGrid) -> Self {
        Self {
            plane,
            surface: None,
        }
    }
}

impl<'a> From<&'a SurfaceGrid> for ImageGrid<'a> {
    fn from(surface: &'a SurfaceGrid) -> Self {
        Self {
            plane: (*surface.base()).into(),
            surface: Some(surface),
        }
    }
}

/// A rectangle of pixels of an image: the unit of work of an engine.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patch<'a> {
    pub grid: TiltedGrid,
    /// Heights of its pixels over uneven ground.
    pub relief: Option<Relief<'a>>,
    /// The ground between the pixels and around them.
    pub terrain: Terrain<'a>,
}

impl Patch<'_> {
    /// Centre of pixel (i, j), m.
    pub fn point_m(&self, i: usize, j: usize) -> [f64; 3] {
        let [x, y, z] = self.grid.point_m(i as f64, j as f64);
        let above_m = (self.relief).map_or(0.0, |r| f64::from(r.heights_m[j * r.stride + i]));
        [x, y, z + above_m]
    }

    /// The part of `rows` rows from row `first` on.
    pub fn rows_from(&self, first: usize, rows: usize) -> Self {
        Self {
            grid: self.grid.rows_from(first, rows),
            relief: self.relief.map(|relief| relief.seen_from(0, first)),
            ..*self
        }
    }
}

impl From<TiltedGrid> for Patch<'_> {
    fn from(grid: TiltedGrid) -> Self {
        Self {
            grid,
            relief: None,
            terrain: Terrain::LEVEL,
        }
    }
}
