//! Incremental imaging: an image to which pulses are added as they arrive.

use crate::error::ImagingError;
use crate::grid::tilted::TiltedGrid;
use crate::plan::imaging::ImagingPlan;
use crate::plan::options::PlanOptions;
use crate::pulses::Pulses;
use acerra_control::Control;
use num_complex::Complex32;
use rayon::prelude::*;

/// The image of all pulses pushed so far, which can be read at any time.
///
/// ```
/// use acerra_imaging::{
///     Complex64, Control, LiveImage, PlanOptions, PlaneGrid, PulseArrays, Pulses,
/// };
/// let grid = PlaneGrid::from_ranges([0.0, 0.2], [0.0, 0.2], 0.0, 0.02)?;
/// let mut live = LiveImage::new(grid, PlanOptions::default());
/// let frequency_hz: Vec<f64> = (0..40).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
/// let spectrum = vec![Complex64::new(1.0, 0.0); 40];
/// for m in 0..3 {
///     let position_m = [[0.0, 0.1 * f64::from(m), 5.0]];
///     let pulse = Pulses::new(PulseArrays {
///         position_m: &position_m,
///         frequency_hz: &frequency_hz,
///         spectrum: &spectrum,
///         weight: &[1.0],
///         light_speed_m_s: 3e8,
///     })?;
///     live.push(pulse, Control::default())?;
/// }
/// assert_eq!((live.pulses(), live.image().len()), (3, grid.len()));
/// live.clear();
/// assert!(live.pulses() == 0 && live.image().iter().all(|v| v.norm() == 0.0));
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
#[derive(Debug)]
pub struct LiveImage {
    grid: TiltedGrid,
    options: PlanOptions,
    image: Vec<Complex32>,
    batch: Vec<Complex32>,
    pulses: u64,
}

impl LiveImage {
    /// An empty image. The accuracy of `options` holds for every batch pushed, and so for their sum
    /// relative to the root sum of squares of the batches' images.
    #[must_use]
    pub fn new(grid: impl Into<TiltedGrid>, options: PlanOptions) -> Self {
        let grid = grid.into();
        let pixels = grid.columns * grid.rows;
        Self {
            grid,
            options,
            image: vec![Complex32::ZERO; pixels],
            batch: vec![Complex32::ZERO; pixels],
            pulses: 0,
        }
    }

    /// Adds a batch of pulses.
    ///
    /// # Errors
    /// As [`ImagingPlan::new`], and cancellation; the image is then unchanged.
    pub fn push(&mut self, pulses: Pulses, control: Control) -> Result<(), ImagingError> {
        let plan = ImagingPlan::with_control(pulses, self.grid, &self.options, control)?;
        plan.run(&mut self.batch, control)?;
        self.image
            .par_iter_mut()
            .zip(&self.batch)
            .for_each(|(sum, v)| *sum += v);
        self.pulses += pulses.len() as u64;
        Ok(())
    }

    /// Removes all pulses.
    pub fn clear(&mut self) {
        self.image.fill(Complex32::ZERO);
        self.pulses = 0;
    }

    /// The image so far, `[rows, columns]` row-major.
    #[must_use]
    pub fn image(&self) -> &[Complex32] {
        &self.image
    }

    /// Number of pulses in the image.
    #[must_use]
    pub fn pulses(&self) -> u64 {
        self.pulses
    }
}
