//! Images in parts: the pixels are divided into tiles, which are imaged separately and assembled.

use std::ops::Range;

use acerra_imaging::{Complex32, ImagingError, PlaneGrid, SurfaceGrid, VolumeGrid};

use crate::choices::Sum;
use crate::focus::inversion::Method;
use crate::focus::plan::ImageError;
use crate::focus::sink::{ImageSink, SinkError};
use crate::focus::volume::assemble_volume;
use crate::focus::{Focused, ImageRequest};
use crate::scene::pixels::Pixels;

/// Largest number of pixels of a tile, unless a row or slice has more.
const TILE_PIXELS: usize = 1 << 20;
/// Least number of tiles of an image, as far as the number of rows permits.
const LEAST_TILES: usize = 64;
/// Least number of rows of a tile: fewer leave vectors of the kernels empty.
const LEAST_ROWS: usize = 16;

/// Division of an image: a plane or terrain into bands of whole rows, a volume into groups of slices.
///
/// ```
/// use acerra_chain::{Pixels, focus::tiles::Tiling};
/// use acerra_imaging::PlaneGrid;
///
/// let pixels = Pixels::plane(PlaneGrid::new([0.0; 3], 0.05, [4000, 3000])?);
/// let tiling = Tiling::of(&pixels);
/// assert_eq!((tiling.per_tile, tiling.count()), (47, 64));
/// let last = tiling.part(&pixels, 63)?;
/// assert_eq!(last.grid.ny, 3000 - 63 * 47);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiling {
    /// Rows, or slices.
    pub length: usize,
    /// Rows or slices of a tile; the last tile may have fewer.
    pub per_tile: usize,
}

impl Tiling {
    /// The tiling of an image, which depends on the pixels only.
    #[must_use]
    pub fn of(pixels: &Pixels) -> Self {
        let (length, row, least) = match &pixels.volume {
            Some(volume) => (volume.nz, volume.base.len(), 1),
            None => (pixels.grid.ny, pixels.grid.nx, LEAST_ROWS),
        };
        let most = (TILE_PIXELS / row.max(1)).min(length.div_ceil(LEAST_TILES));
        Self {
            length,
            per_tile: most.max(least).min(length.max(1)),
        }
    }

    /// Number of tiles.
    #[must_use]
    pub fn count(&self) -> usize {
        self.length.div_ceil(self.per_tile)
    }

    /// Rows or slices of tile `k`.
    #[must_use]
    pub fn range(&self, k: usize) -> Range<usize> {
        let start = (k * self.per_tile).min(self.length);
        start..(start + self.per_tile).min(self.length)
    }

    /// The pixels of tile `k`.
    ///
    /// # Errors
    /// A tile beyond the last.
    pub fn part(&self, pixels: &Pixels, k: usize) -> Result<Pixels, ImagingError> {
        let range = self.range(k);
        if let Some(volume) = &pixels.volume {
            let part = VolumeGrid::new(volume.slice(range.start), volume.step_m, range.len())?;
            return Ok(Pixels::volume(part));
        }
        let grid = &pixels.grid;
        let origin_m = [grid.x_m(0), grid.y_m(range.start), grid.z_m];
        let rows = PlaneGrid::new(origin_m, grid.pixel_m, [grid.nx, range.len()])?;
        match &pixels.surface {
            None => Ok(Pixels::plane(rows)),
            Some(surface) => {
                let kept = range.start * grid.nx..range.end * grid.nx;
                let height_m: Vec<f64> = kept.map(|pixel| surface.z_m(pixel)).collect();
                Ok(Pixels::surface(SurfaceGrid::new(rows, &height_m)?))
            }
        }
    }
}

/// Records of a tile's plans.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TilePlan {
    /// Choices of the planner and their reasons.
    pub plan: String,
    /// Bytes needed in addition to the input.
    pub promised_bytes: u64,
    /// Relative L2 error that the self-check found.
    pub checked_error: Option<f64>,
}

/// Refuses products that cannot be made tile by tile: solutions for the whole scene, and looks.
///
/// # Errors
/// The requested product.
pub fn check_request(request: &ImageRequest) -> Result<(), ImageError> {
    let method = request.options.inversion.method;
    let found = if method != Method::Adjoint {
        "tiles, whose pixels are not solved for together"
    } else if request.looks.is_some() {
        "looks and tiles"
    } else {
        return Ok(());
    };
    Err(ImageError::Method {
        method: method.name(),
        expected: "an image without tiles",
        found,
    })
}

/// Assembles tiles to the result of [`focus`](crate::focus::focus). A volume's slices go to the sink.
///
/// # Errors
/// A missing tile, a failure of the sink.
pub fn assemble(
    request: &ImageRequest,
    plans: &[TilePlan],
    mut tile: impl FnMut(usize) -> Result<Vec<Complex32>, SinkError>,
    sink: &mut dyn ImageSink,
) -> Result<Focused, ImageError> {
    let pixels = &request.pixels;
    let tiling = Tiling::of(pixels);
    let (image, pixels, projections) = match pixels.volume {
        Some(volume) => {
            let groups = (0..tiling.count()).map(tile);
            let (image, pixels, seen) = assemble_volume(volume, groups, sink)?;
            (image, pixels, Some(seen))
        }
        None => {
            let mut image = Vec::with_capacity(pixels.grid.len());
            for k in 0..tiling.count() {
                image.extend(tile(k)?);
            }
            (image, pixels.clone(), None)
        }
    };
    let checked = plans.iter().filter_map(|plan| plan.checked_error);
    let sum = match request.options.sum {
        Sum::Coherent => "",
        Sum::Incoherent => ", powers of the tracks summed",
    };
    Ok(Focused {
        image,
        pixels,
        options: request.options,
        plan: format!(
            "{} tiles, each planned by itself{sum}; the first: {}",
            tiling.count(),
            plans.first().map_or("", |plan| plan.plan.as_str())
        ),
        promised_bytes: plans.iter().map(|p| p.promised_bytes).max().unwrap_or(0),
        checked_error: checked.reduce(f64::max),
        multilook: None,
        projections,
        inversion: None,
        underground: request.underground.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_terrain_and_volume_are_the_wholes() {
        let grid = PlaneGrid::new([1.0, -2.0, 0.0], 0.1, [40, 70]).unwrap();
        let heights: Vec<f64> = (0..grid.len()).map(|k| 1e-3 * k as f64).collect();
        let terrain = Pixels::surface(SurfaceGrid::new(grid, &heights).unwrap());
        let volume = Pixels::volume(VolumeGrid::new(grid, 0.05, 130).unwrap());
        for (pixels, least) in [(terrain, 5), (volume, 44)] {
            let tiling = Tiling::of(&pixels);
            assert_eq!(tiling.count(), least);
            let mut covered = 0;
            for k in 0..tiling.count() {
                let (part, range) = (tiling.part(&pixels, k).unwrap(), tiling.range(k));
                assert_eq!(range.start, covered);
                covered = range.end;
                let (place, whole) = match &pixels.volume {
                    None => (part.place_m(3), pixels.place_m(3 + 40 * range.start)),
                    Some(volume) => {
                        let slice = Pixels::plane(volume.slice(range.start));
                        (part.place_m(3), slice.place_m(3))
                    }
                };
                for axis in 0..3 {
                    assert!((place[axis] - whole[axis]).abs() < 1e-6);
                }
            }
            assert_eq!(covered, tiling.length);
        }
    }
}
