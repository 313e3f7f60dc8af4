//! Imaging below the surface of the ground.

use acerra_imaging::ImagingError;
use acerra_imaging::refraction::{Ground, Layer, Surface};

/// A ground with a level surface, of one soil or of level layers.
#[derive(Clone, Debug, PartialEq)]
pub struct Underground {
    /// Height of the surface (m).
    pub surface_z_m: f64,
    /// Layers from the top; the last has no end.
    pub layers: Vec<Layer>,
}

impl Underground {
    /// The ground as rays in the middle of a band see it.
    ///
    /// # Errors
    /// Soils or layers that are none.
    pub fn seen_at(&self, frequency_hz: &[f64]) -> Result<Ground, ImagingError> {
        let middle_hz = frequency_hz.iter().sum::<f64>() / frequency_hz.len().max(1) as f64;
        let surface = Surface::Level {
            z_m: self.surface_z_m,
        };
        Ground::new(surface, &self.layers, middle_hz)
    }
}
