//! The volume of a run: planes through it, read from its file on demand.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use acerra_imaging::PlaneGrid;
use acerra_products::data::{Axis, VolumeFile};
use num_complex::Complex32;

use super::image::even;
use crate::error::{RequestError, ViewError};
use crate::raster::{Field, Pyramid, levels};

/// Bytes of the planes kept for further tiles; the newest plane is kept however large it is.
const MOST_KEPT_BYTES: usize = 96 << 20;

/// The volume of a run.
#[derive(Debug)]
pub struct Volume {
    file: VolumeFile,
    /// Height of the lowest slice (m).
    pub z0_m: f64,
    /// Distance of the slices (m).
    pub step_m: f64,
    /// Most recently used planes, the newest at the end.
    kept: Mutex<Vec<Kept>>,
}

#[derive(Debug)]
struct Kept {
    normal: Axis,
    index: usize,
    plane: Arc<Plane>,
}

/// A plane through a volume.
#[derive(Debug)]
pub struct Plane {
    size: [usize; 2],
    values: Vec<Complex32>,
    /// Levels.
    pub pyramid: Pyramid,
}

impl Field for Plane {
    fn size(&self) -> [usize; 2] {
        self.size
    }
    fn at(&self, column: usize, row: usize) -> Complex32 {
        self.values[row * self.size[0] + column]
    }
}

impl Plane {
    fn of(size: [usize; 2], values: Vec<Complex32>) -> Self {
        let mut plane = Self {
            size,
            values,
            pyramid: Pyramid::default(),
        };
        plane.pyramid = Pyramid::of(&plane);
        plane
    }

    fn bytes(&self) -> usize {
        size_of::<Complex32>() * self.values.len() + self.pyramid.bytes()
    }
}

impl Volume {
    /// The volume in a run's directory; none where the run made none.
    ///
    /// # Errors
    /// A file that is broken, or of other columns and rows than the run's image.
    pub fn open(path: &Path, grid: &PlaneGrid) -> Result<Option<Self>, ViewError> {
        if !path.is_file() {
            return Ok(None);
        }
        let file = VolumeFile::open(path).map_err(|cause| ViewError::Product {
            path: path.to_owned(),
            cause,
        })?;
        let refuse = |axis, found| ViewError::Grid {
            path: path.to_owned(),
            axis,
            found,
        };
        for (axis, values, first_m, count) in [
            ("x_m", &file.x_m, grid.x0_m, grid.nx),
            ("y_m", &file.y_m, grid.y0_m, grid.ny),
        ] {
            let start_m = even(values, grid.pixel_m).map_err(|found| refuse(axis, found))?;
            if values.len() != count || (start_m - first_m).abs() > 1e-3 * grid.pixel_m {
                let found = format!("{} from {start_m} m, unlike image.npz", values.len());
                return Err(refuse(axis, found));
            }
        }
        let step_m = match file.z_m.as_slice() {
            [first, .., last] => (last - first) / (file.z_m.len() - 1) as f64,
            _ => grid.pixel_m,
        };
        let z0_m = even(&file.z_m, step_m).map_err(|found| refuse("z_m", found))?;
        Ok(Some(Self {
            file,
            z0_m,
            step_m,
            kept: Mutex::default(),
        }))
    }

    /// Number of slices.
    #[must_use]
    pub fn slices(&self) -> usize {
        self.file.z_m.len()
    }

    /// Height of a slice (m); none beyond the volume.
    #[must_use]
    pub fn height_m(&self, slice: usize) -> Option<f64> {
        self.file.z_m.get(slice).copied()
    }

    /// Number of levels of the planes normal to an axis.
    #[must_use]
    pub fn levels(&self, normal: Axis) -> usize {
        levels(self.file.plane_size(normal))
    }

    /// The value at `[i, j, k]` along x, y and z.
    ///
    /// # Errors
    /// A place beyond the volume, a file that cannot be read.
    pub fn value(&self, at: [usize; 3]) -> Result<Complex32, RequestError> {
        Ok(self.file.value(at)?)
    }

    /// The plane normal to an axis at `index` along it.
    ///
    /// # Errors
    /// A plane beyond the volume, a file that cannot be read.
    pub fn plane(&self, normal: Axis, index: usize) -> Result<Arc<Plane>, RequestError> {
        // Requests for further tiles of a plane wait here until the first has read it.
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let known = |one: &Kept| one.normal == normal && one.index == index;
        let found = match kept.iter().position(known) {
            Some(place) => kept.remove(place),
            None => {
                let [nx, ny, nz] = self.file.size();
                let count = match normal {
                    Axis::X => nx,
                    Axis::Y => ny,
                    Axis::Z => nz,
                };
                if index >= count {
                    return Err(RequestError::Absent { what: "plane" });
                }
                let values = self.file.plane(normal, index)?;
                let plane = Plane::of(self.file.plane_size(normal), values);
                Kept {
                    normal,
                    index,
                    plane: Arc::new(plane),
                }
            }
        };
        let plane = Arc::clone(&found.plane);
        kept.push(found);
        let mut bytes: usize = kept.iter().map(|one| one.plane.bytes()).sum();
        while bytes > MOST_KEPT_BYTES && kept.len() > 1 {
            bytes -= kept.remove(0).plane.bytes();
        }
        Ok(plane)
    }
}
