//! The image: pulses at known places, which stay, and pulses at extrapolated ones, which are imaged anew.

use acerra_imaging::{
    Control, ImagingError, ImagingPlan, LiveImage, PlanOptions, PlaneGrid, PulseArrays, Pulses,
};
use num_complex::Complex32;
use rayon::prelude::*;

use crate::clean::Clean;
use crate::settings::LiveSettings;

/// Pulses imaged together at most: what a batch adds to the latency is bounded.
pub(crate) const MOST_PULSES: usize = 32;

/// Pixels of one summing task.
const PIECE: usize = 1 << 15;

/// The image.
pub(crate) struct Canvas {
    /// Where its pixels are.
    pub grid: PlaneGrid,
    options: PlanOptions,
    settled: LiveImage,
    /// Pulses at extrapolated places; of no meaning without any.
    ahead: Vec<Complex32>,
    batch: Vec<Complex32>,
    shown: Vec<Complex32>,
    pulses_ahead: usize,
}

impl Canvas {
    /// An empty image.
    pub fn new(grid: PlaneGrid, accuracy: f64) -> Self {
        let options = PlanOptions::default()
            .with_accuracy(accuracy)
            .with_check_pixels(16);
        Self {
            grid,
            settled: LiveImage::new(grid, options),
            options,
            ahead: Vec::new(),
            batch: Vec::new(),
            shown: Vec::new(),
            pulses_ahead: 0,
        }
    }

    /// Adds pulses at known places.
    ///
    /// # Errors
    /// Pulses that cannot be imaged, cancellation.
    pub fn settle(
        &mut self,
        clean: &Clean,
        settings: &LiveSettings,
        control: Control<'_>,
    ) -> Result<(), ImagingError> {
        batches(clean, settings, |pulses| self.settled.push(pulses, control))
    }

    /// Adds pulses at extrapolated places to those of that kind.
    ///
    /// # Errors
    /// Pulses that cannot be imaged, cancellation.
    pub fn add_ahead(
        &mut self,
        clean: &Clean,
        settings: &LiveSettings,
        control: Control<'_>,
    ) -> Result<(), ImagingError> {
        batches(clean, settings, |pulses| {
            let count = pulses.len();
            self.ahead.resize(self.grid.len(), Complex32::ZERO);
            let plan = ImagingPlan::with_control(pulses, self.grid, &self.options, control)?;
            if self.pulses_ahead == 0 {
                plan.run(&mut self.ahead, control)?;
            } else {
                self.batch.resize(self.grid.len(), Complex32::ZERO);
                plan.run(&mut self.batch, control)?;
                let pieces = self.ahead.par_chunks_mut(PIECE);
                pieces
                    .zip(self.batch.par_chunks(PIECE))
                    .for_each(|(sum, batch)| sum.iter_mut().zip(batch).for_each(|(s, v)| *s += v));
            }
            self.pulses_ahead += count;
            Ok(())
        })
    }

    /// Takes the pulses at extrapolated places out.
    pub fn forget_ahead(&mut self) {
        self.pulses_ahead = 0;
    }

    /// Pulses at extrapolated places.
    pub fn pulses_ahead(&self) -> usize {
        self.pulses_ahead
    }

    /// The image of the pulses at known places alone.
    pub fn settled(&self) -> &LiveImage {
        &self.settled
    }

    /// The image of all pulses.
    pub fn shown(&mut self) -> &[Complex32] {
        let settled = self.settled.image();
        if self.pulses_ahead == 0 {
            return settled;
        }
        self.shown.resize(settled.len(), Complex32::ZERO);
        let pieces = self.shown.par_chunks_mut(PIECE);
        pieces
            .zip(settled.par_chunks(PIECE))
            .zip(self.ahead.par_chunks(PIECE))
            .for_each(|((shown, settled), ahead)| {
                for ((shown, settled), ahead) in shown.iter_mut().zip(settled).zip(ahead) {
                    *shown = settled + ahead;
                }
            });
        &self.shown
    }
}

/// Hands clean traces out in batches.
fn batches(
    clean: &Clean,
    settings: &LiveSettings,
    mut image: impl FnMut(Pulses) -> Result<(), ImagingError>,
) -> Result<(), ImagingError> {
    let frequencies = settings.frequency_hz.len();
    let spectra = clean.spectrum.chunks(MOST_PULSES * frequencies);
    for (position_m, spectrum) in clean.position_m.chunks(MOST_PULSES).zip(spectra) {
        let weight = vec![1.0; position_m.len()];
        image(Pulses::new(PulseArrays {
            position_m,
            frequency_hz: &settings.frequency_hz,
            spectrum,
            weight: &weight,
            light_speed_m_s: settings.light_speed_m_s,
        })?)?;
    }
    Ok(())
}
