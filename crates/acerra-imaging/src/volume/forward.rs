//! The forward operator of volumes.

use crate::checks::check_length;
use crate::control::Meter;
use crate::engine::forward::filling::Echo;
use crate::error::ImagingError;
use crate::grid::volume::VolumeGrid;
use crate::plan::forward::Forward;
use crate::plan::options::PlanOptions;
use crate::plan::report::PlanReport;
use crate::plan::slices::forward::{Shared, SlicesForward};
use crate::plan::slices::groups::groups;
use crate::pulses::Pulses;
use acerra_control::Control;
use num_complex::{Complex32, Complex64};
use std::fmt;
use std::ops::Range;

/// Number of failed plans for a group of slices after which each slice is planned separately.
const MOST_FAILURES: usize = 3;

/// Least pixels of the self-check of a separately planned slice: the slices share the pixels of a plane's
/// check.
const LEAST_CHECK: usize = 6;

/// The forward operator of a volume, ready to be applied any number of times: the transpose of
/// [`image_volume`](crate::image_volume).
///
/// Neighbouring slices share a plan, as in [`image_volume_planned_once`](crate::image_volume_planned_once), and
/// where pixels are added to range bins directly, the bins of a pulse are turned into its spectrum once for all
/// of them. Every slice is compared with the double-precision sum at some places while it is planned.
///
/// ```
/// use acerra_imaging::{
///     Complex32, Complex64, Control, ForwardVolume, PlanOptions, PlaneGrid, PulseArrays, Pulses, VolumeGrid,
/// };
/// let position_m: Vec<[f64; 3]> = (0..20).map(|m| [0.0, 0.1 * f64::from(m) - 1.0, 5.0]).collect();
/// let frequency_hz: Vec<f64> = (0..50).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
/// let spectrum = vec![Complex64::ZERO; 20 * 50];
/// let pulses = Pulses::new(PulseArrays {
///     position_m: &position_m,
///     frequency_hz: &frequency_hz,
///     spectrum: &spectrum,
///     weight: &[1.0; 20],
///     light_speed_m_s: 3e8,
/// })?;
/// let base = PlaneGrid::from_ranges([0.0, 0.5], [0.0, 0.5], 0.0, 0.02)?;
/// let volume = VolumeGrid::new(base, 0.1, 3)?;
/// let forward = ForwardVolume::new(&volume, pulses, &PlanOptions::default(), Control::default())?;
/// let mut echo = vec![Complex64::ZERO; 20 * 50];
/// // One scatterer, in the corner of the topmost slice.
/// let give = |slice: usize, image: &mut [Complex32]| {
///     image.fill(Complex32::ZERO);
///     image[0].re = if slice == 2 { 1.0 } else { 0.0 };
/// };
/// forward.run(give, &mut echo, Control::default())?;
/// let range_m = f64::hypot(4.8, 1.0); // from the first pulse
/// assert!((echo[0].norm() * range_m * range_m - 1.0).abs() < 1e-2);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub struct ForwardVolume<'a> {
    volume: VolumeGrid,
    parts: Vec<Part<'a>>,
    /// Pulses and frequencies.
    spectra: [usize; 2],
}

/// A plan and the slices that it models.
enum Part<'a> {
    Together(Box<SlicesForward<'a>>),
    Alone(usize, Box<Forward<'a>>),
}

impl<'a> ForwardVolume<'a> {
    /// Plans all slices and compares each with the double-precision sum.
    ///
    /// # Errors
    /// As [`Forward::new`], and cancellation.
    pub fn new(
        volume: &VolumeGrid,
        pulses: Pulses<'a>,
        options: &PlanOptions,
        control: Control,
    ) -> Result<Self, ImagingError> {
        let mut parts = Vec::new();
        let shared_out = (options.check_pixels / volume.nz).max(LEAST_CHECK);
        let of_slice = options.with_check_pixels(shared_out);
        for group in groups(volume, pulses, options, control)? {
            match together(volume, group.clone(), pulses, options, control)? {
                Some(shared) => parts.push(Part::Together(shared)),
                None => {
                    for k in group {
                        let grid = volume.slice(k);
                        let plan = Forward::with_control(pulses, grid, &of_slice, control)?;
                        parts.push(Part::Alone(k, Box::new(plan)));
                    }
                }
            }
        }
        Ok(Self {
            volume: *volume,
            parts,
            spectra: [pulses.len(), pulses.frequency_hz().len()],
        })
    }

    /// The report of every plan, in the order of the slices.
    pub fn reports(&self) -> impl Iterator<Item = &PlanReport> {
        self.parts.iter().map(|part| part.plan().report())
    }

    /// The slices that each plan models, in their order.
    pub fn plans(&self) -> impl Iterator<Item = Range<usize>> {
        self.parts.iter().map(Part::slices)
    }

    /// Bytes of a run in addition to the images given, spectra included.
    #[must_use]
    pub fn memory_bytes(&self) -> u128 {
        let of_part = |part: &Part| match part {
            Part::Together(shared) => shared.working_bytes(),
            Part::Alone(_, plan) => u128::from(plan.report().working_bytes),
        };
        let image = self.volume.base.len() * size_of::<Complex32>();
        let [pulses, frequencies] = self.spectra;
        let spectra = pulses * frequencies * size_of::<Complex64>();
        self.parts.iter().map(of_part).max().unwrap_or(0) + (image + spectra) as u128
    }

    /// Computes the spectra `[M, N]` of the volume; `give` (index, `[ny, nx]` image) fills the image of a slice,
    /// more than once where pulses are taken in batches. The same bits come from any number of threads.
    ///
    /// # Errors
    /// Spectra of another length than the pulses'; cancellation, after which the spectra are incomplete.
    pub fn run(
        &self,
        mut give: impl FnMut(usize, &mut [Complex32]),
        spectrum: &mut [Complex64],
        control: Control,
    ) -> Result<(), ImagingError> {
        let [pulses, frequencies] = self.spectra;
        check_length("spectrum", pulses * frequencies, spectrum.len())?;
        let voxels = (self.volume.base.len() as u64).saturating_mul(self.volume.nz as u64);
        let meter = Meter::new(control, voxels.saturating_mul(pulses as u64));
        spectrum.fill(Complex64::ZERO);
        let mut image = vec![Complex32::ZERO; self.volume.base.len()];
        for part in &self.parts {
            match part {
                Part::Together(shared) => shared.add(&mut give, &mut image, spectrum, &meter),
                Part::Alone(k, plan) => {
                    give(*k, &mut image);
                    let slice = self.volume.slice(*k).into();
                    let spectra = Echo::Spectra(spectrum);
                    plan.add(&plan.all(), (&slice, &image), spectra, &meter);
                }
            }
            control.check()?;
        }
        Ok(())
    }
}

impl<'a> Part<'a> {
    fn plan(&self) -> &Forward<'a> {
        match self {
            Self::Together(shared) => shared.plan(),
            Self::Alone(_, plan) => plan,
        }
    }

    fn slices(&self) -> Range<usize> {
        match self {
            Self::Together(shared) => shared.slices(),
            Self::Alone(k, _) => *k..k + 1,
        }
    }
}

/// A plan that keeps the accuracy for all of `slices`; `None` where none is found.
fn together<'a>(
    volume: &VolumeGrid,
    slices: Range<usize>,
    pulses: Pulses<'a>,
    options: &PlanOptions,
    control: Control,
) -> Result<Option<Box<SlicesForward<'a>>>, ImagingError> {
    let mut aim = 1.0;
    for _ in 0..MOST_FAILURES {
        match SlicesForward::plan_for(volume, slices.clone(), aim, pulses, options, control)? {
            Shared::Held(shared) => return Ok(Some(shared)),
            Shared::Broken(next) => aim = next,
            Shared::Alone => break,
        }
    }
    Ok(None)
}

impl fmt::Debug for ForwardVolume<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ForwardVolume")
            .field("volume", &self.volume)
            .field("plans", &self.plans().collect::<Vec<_>>())
            .finish_non_exhaustive()
    }
}
