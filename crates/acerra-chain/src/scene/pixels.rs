//! The pixels of an image: a plane, uneven ground, or the slices of a volume.

use std::sync::Arc;

use acerra_imaging::{PlaneGrid, SurfaceGrid, VolumeGrid};

/// Columns, rows and heights of an image.
#[derive(Clone, Debug)]
pub struct Pixels {
    /// Columns and rows; at the plane's height, the middle of the surface's, or the lowest slice's.
    pub grid: PlaneGrid,
    /// Heights of the pixels, where they are on uneven ground; of the image of a volume the
    /// heights of its strongest values.
    pub surface: Option<Arc<SurfaceGrid>>,
    /// The slices of a volume.
    pub volume: Option<VolumeGrid>,
}

impl Pixels {
    /// Pixels on a horizontal plane.
    #[must_use]
    pub fn plane(grid: PlaneGrid) -> Self {
        Self {
            grid,
            surface: None,
            volume: None,
        }
    }

    /// Pixels on uneven ground.
    #[must_use]
    pub fn surface(surface: impl Into<Arc<SurfaceGrid>>) -> Self {
        let surface = surface.into();
        Self {
            grid: *surface.base(),
            surface: Some(surface),
            volume: None,
        }
    }

    /// The slices of a volume.
    #[must_use]
    pub fn volume(volume: VolumeGrid) -> Self {
        Self {
            grid: volume.base,
            surface: None,
            volume: Some(volume),
        }
    }

    /// East, north and height of pixel `k`, counted row by row (m); of a volume on its lowest slice.
    #[must_use]
    pub fn place_m(&self, k: usize) -> [f64; 3] {
        let (x_m, y_m) = (
            self.grid.x_m(k % self.grid.nx),
            self.grid.y_m(k / self.grid.nx),
        );
        let z_m = self.surface.as_ref().map_or(self.grid.z_m, |s| s.z_m(k));
        [x_m, y_m, z_m]
    }

    /// Least and greatest height, m.
    #[must_use]
    pub fn span_m(&self) -> [f64; 2] {
        match (&self.surface, &self.volume) {
            (Some(surface), _) => surface.span_m(),
            (None, Some(volume)) => [self.grid.z_m, volume.slice(volume.nz - 1).z_m],
            (None, None) => [self.grid.z_m; 2],
        }
    }

    /// A height for uses of a single height, m.
    #[must_use]
    pub fn middle_m(&self) -> f64 {
        let [low, high] = self.span_m();
        0.5 * (low + high)
    }

    /// Places of the pixels, in words.
    #[must_use]
    pub fn describe(&self) -> String {
        let [low, high] = self.span_m();
        if let Some(volume) = &self.volume {
            return format!(
                "in a volume of {} slices from z = {} m by {} m",
                volume.nz, volume.base.z_m, volume.step_m
            );
        }
        match &self.surface {
            Some(_) => {
                // A little below zero is no "-0.00".
                let [low, high] = [low, high].map(|z| (z * 100.0).round() / 100.0 + 0.0);
                format!("on the terrain, z = {low:.2} to {high:.2} m")
            }
            None => {
                let low = (low * 1000.0).round() / 1000.0 + 0.0;
                format!("at z = {low} m")
            }
        }
    }
}

impl From<PlaneGrid> for Pixels {
    fn from(grid: PlaneGrid) -> Self {
        Self::plane(grid)
    }
}

impl From<SurfaceGrid> for Pixels {
    fn from(surface: SurfaceGrid) -> Self {
        Self::surface(surface)
    }
}

impl From<VolumeGrid> for Pixels {
    fn from(volume: VolumeGrid) -> Self {
        Self::volume(volume)
    }
}
