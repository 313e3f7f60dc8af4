//! Clean spectra with the places where they were measured, as the imaging operators take them.

pub(crate) mod history;
pub mod sharpen;
pub(crate) mod window;

use acerra_imaging::{
    Complex32, ImagingPlan, PlanOptions, PlaneGrid, PulseArrays, Pulses, Spreading, TrialImages,
};
use acerra_radar::Spectrum;

use crate::choices::Weight;
use crate::position::aligned::Aligned;
use acerra_imaging::ImagingError;

/// Clean spectra of one or more tracks, and the places of their traces.
#[derive(Clone, Copy, Debug)]
pub struct Echoes<'a> {
    /// Clean spectra, track after track.
    pub spectrum: &'a Spectrum,
    /// Positions at which the echoes were measured.
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
            Weight::Auto if self.aligned.is_often_at_rest => self.aligned.path_m.clone(),
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

/// Relative error of images that are made for their sharpness alone.
const QUICK_ACCURACY: f64 = 1e-2;

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
    // Without 1/R², by which the nearest echoes would dominate.
    let options = PlanOptions::default()
        .with_accuracy(QUICK_ACCURACY)
        .with_spreading(Spreading::None)
        .with_check_pixels(4);
    let plan = ImagingPlan::new(pulses, grid, &options)?;
    let mut image = vec![Complex32::default(); grid.len()];
    plan.run(&mut image, acerra_imaging::Control::default())?;
    Ok(image)
}

/// Spectra that a search images again and again, from other positions or at other delays, with equal weights.
#[derive(Clone, Debug)]
pub(crate) struct Searched<'a> {
    position_m: &'a [[f64; 3]],
    spectrum: &'a Spectrum,
    light_speed_m_s: f64,
    weight: Vec<f64>,
}

impl<'a> Searched<'a> {
    /// The spectra of traces at these positions.
    pub fn new(position_m: &'a [[f64; 3]], spectrum: &'a Spectrum, light_speed_m_s: f64) -> Self {
        Self {
            position_m,
            spectrum,
            light_speed_m_s,
            weight: vec![1.0; position_m.len()],
        }
    }

    /// [Quick looks](quick_look) from other positions at pixels near `grid`, whose ranges differ by `reach_m` at most
    /// from those between the positions and the grid.
    ///
    /// # Errors
    /// Data that the imaging operators refuse.
    pub fn looks(&self, grid: PlaneGrid, reach_m: f64) -> Result<TrialImages<'_>, ImagingError> {
        TrialImages::new(self.echoes(), grid, reach_m, QUICK_ACCURACY)
    }

    /// Quick looks at the pixels of `grid` with ranges that are longer or shorter by `reach_m` at most.
    ///
    /// # Errors
    /// Data that the imaging operators refuse.
    pub fn delays(&self, grid: PlaneGrid, reach_m: f64) -> Result<TrialImages<'_>, ImagingError> {
        TrialImages::of_delays(self.echoes(), grid, reach_m, QUICK_ACCURACY)
    }

    fn echoes(&self) -> PulseArrays<'_> {
        PulseArrays {
            position_m: self.position_m,
            frequency_hz: &self.spectrum.frequency_hz,
            spectrum: &self.spectrum.values,
            weight: &self.weight,
            light_speed_m_s: self.light_speed_m_s,
        }
    }
}
