//! Clean spectra with the places where they were measured, as the imaging operators take them.

pub(crate) mod history;
pub mod sharpen;
pub(crate) mod window;

use acerra_imaging::{
    Complex32, ImagingPlan, PlanOptions, PlaneGrid, PulseArrays, Pulses, Spreading,
};
use acerra_radar::Spectrum;

use crate::choices::Weight;
use crate::position::aligned::Aligned;
use acerra_imaging::ImagingError;

/// Clean spectra of one or more tracks, and where they were measured.
#[derive(Clone, Copy, Debug)]
pub struct Echoes<'a> {
    /// Clean spectra, track after track.
    pub spectrum: &'a Spectrum,
    /// Where they were measured.
    pub aligned: &'a Aligned,
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
}

impl<'a> Echoes<'a> {
    /// The weight of each trace.
    #[must_use]
    pub fn weights(&self, weight: Weight) -> Vec<f64> {
        match weight {
            Weight::Path => self.aligned.path_m.clone(),
            Weight::Auto if self.aligned.stands => self.aligned.path_m.clone(),
            Weight::Auto | Weight::Trace => vec![1.0; self.aligned.position_m.len()],
        }
    }

    /// The traces with their weights as pulses of an antenna that is fixed to the platform: they look where the
    /// recorded attitude points it.
    ///
    /// # Errors
    /// Spectra, positions and weights of different numbers, or values that are not finite.
    pub fn pulses(&self, weight: &'a [f64]) -> Result<Pulses<'a>, ImagingError> {
        let pulses = Pulses::new(PulseArrays {
            position_m: &self.aligned.position_m,
            frequency_hz: &self.spectrum.frequency_hz,
            spectrum: &self.spectrum.values,
            weight,
            light_speed_m_s: self.light_speed_m_s,
        })?;
        match self.aligned.boresight.looks.as_slice() {
            [] => Ok(pulses),
            boresight => pulses.with_boresight(boresight),
        }
    }
}

/// A quick, unweighted image of modest accuracy, for its sharpness alone: `position_m` takes the
/// place of the positions that the echoes are aligned to.
///
/// # Errors
/// Data that the imaging operators refuse.
pub(crate) fn quick_look(
    position_m: &[[f64; 3]],
    spectrum: &Spectrum,
    grid: PlaneGrid,
    light_speed_m_s: f64,
) -> Result<Vec<Complex32>, ImagingError> {
    let weight = vec![1.0; position_m.len()];
    let pulses = Pulses::new(PulseArrays {
        position_m,
        frequency_hz: &spectrum.frequency_hz,
        spectrum: &spectrum.values,
        weight: &weight,
        light_speed_m_s,
    })?;
    // Without 1/R², which would let what is nearest decide.
    let options = PlanOptions::default()
        .with_accuracy(1e-2)
        .with_spreading(Spreading::None)
        .with_check_pixels(4);
    let plan = ImagingPlan::new(pulses, grid, &options)?;
    let mut image = vec![Complex32::default(); grid.len()];
    plan.run(&mut image, acerra_imaging::Control::default())?;
    Ok(image)
}
