//! Any kind of grid, as an argument or an answer.

use std::sync::Arc;

use acerra_chain::Pixels;
use pyo3::prelude::*;

use super::plane::Plane;
use super::surface::Surface;
use super::tilted::Tilted;
use super::volume::Volume;
use crate::errors::Failure;

/// A grid of any kind, as an argument.
#[derive(FromPyObject)]
pub enum Grid {
    /// A horizontal plane.
    Plane(Plane),
    /// A tilted plane.
    Tilted(Tilted),
    /// Uneven ground.
    Surface(Surface),
    /// A volume.
    Volume(Volume),
}

impl Grid {
    /// Slices, where there are several, rows and columns.
    pub fn shape(&self) -> Vec<usize> {
        match self {
            Self::Plane(Plane(g)) => vec![g.ny, g.nx],
            Self::Tilted(Tilted(g)) => vec![g.rows, g.columns],
            Self::Surface(Surface(g)) => vec![g.base().ny, g.base().nx],
            Self::Volume(Volume(g)) => vec![g.nz, g.base.ny, g.base.nx],
        }
    }

    /// Number of pixels or voxels.
    pub fn points(&self) -> u64 {
        self.shape().iter().map(|n| *n as u64).product()
    }

    /// The pixels as the chain takes them; it images no tilted planes.
    pub fn pixels(self) -> Result<Pixels, Failure> {
        match self {
            Self::Plane(plane) => Ok(plane.0.into()),
            Self::Surface(surface) => Ok(Pixels::surface(surface.0)),
            Self::Volume(volume) => Ok(volume.0.into()),
            Self::Tilted(_) => Err(Failure::imaging(
                "grid: expected a Plane, Surface or Volume, found a Tilted plane; image it with \
                 acerra.adjoint",
            )),
        }
    }
}

/// The pixels of an image of the chain, as the grid that Python knows.
pub fn grid_of<'py>(py: Python<'py>, pixels: &Pixels) -> PyResult<Bound<'py, PyAny>> {
    Ok(match (&pixels.volume, &pixels.surface) {
        (Some(volume), _) => Bound::new(py, Volume(*volume))?.into_any(),
        (None, Some(surface)) => Bound::new(py, Surface(Arc::clone(surface)))?.into_any(),
        (None, None) => Bound::new(py, Plane(pixels.grid))?.into_any(),
    })
}
