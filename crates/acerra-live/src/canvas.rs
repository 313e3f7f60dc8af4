//! The image, and the batches in which pulses are added to it.

use acerra_imaging::{
    Control, ImagingError, LiveImage, PlanOptions, PlaneGrid, PulseArrays, Pulses,
};

use crate::clean::Clean;
use crate::settings::LiveSettings;

/// Pulses imaged together at most: what a batch adds to the latency is bounded.
pub(crate) const MOST_PULSES: usize = 32;

/// The image.
pub(crate) struct Canvas {
    /// Grid of the pixels.
    pub grid: PlaneGrid,
    /// Values of the pixels.
    pub image: LiveImage,
}

impl Canvas {
    /// An empty image.
    pub fn new(grid: PlaneGrid, accuracy: f64) -> Self {
        let options = PlanOptions::default()
            .with_accuracy(accuracy)
            .with_check_pixels(16);
        Self {
            grid,
            image: LiveImage::new(grid, options),
        }
    }

    /// Empties the image; its pixels stay where they are.
    pub fn clear(&mut self) {
        self.image.clear();
    }

    /// Adds pulses.
    ///
    /// # Errors
    /// Pulses that cannot be imaged, cancellation.
    pub fn add(
        &mut self,
        clean: &Clean,
        settings: &LiveSettings,
        control: Control<'_>,
    ) -> Result<(), ImagingError> {
        let frequencies = settings.frequency_hz.len();
        let spectra = clean.spectrum.chunks(MOST_PULSES * frequencies);
        for (position_m, spectrum) in clean.position_m.chunks(MOST_PULSES).zip(spectra) {
            let weight = vec![1.0; position_m.len()];
            let pulses = Pulses::new(PulseArrays {
                position_m,
                frequency_hz: &settings.frequency_hz,
                spectrum,
                weight: &weight,
                light_speed_m_s: settings.light_speed_m_s,
            })?;
            self.image.push(pulses, control)?;
        }
        Ok(())
    }
}
