//! Volumes: horizontal slices imaged one after another, so that memory stays that of one slice.

use crate::control::{Control, Progress};
use crate::error::ImagingError;
use crate::grid::plane::PlaneGrid;
use crate::grid::volume::VolumeGrid;
use crate::plan::imaging::ImagingPlan;
use crate::plan::options::PlanOptions;
use crate::plan::report::PlanReport;
use crate::pulses::Pulses;
use num_complex::Complex32;

/// What imaging a volume took.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct VolumeRun {
    /// The plan of the slice that needed most memory.
    pub report: PlanReport,
    /// Most bytes that a slice and its tables took together.
    pub memory_bytes: u128,
    /// Largest relative error that a slice's self-check found.
    pub checked_error: Option<f64>,
}

/// Least pixels of a slice's self-check where each is planned by itself.
const LEAST_CHECK: usize = 8;

/// Images slice after slice and hands each to `take` (index, grid, `[ny, nx]` image); the same memory
/// serves all. Every slice is planned by itself, and so is what imaging it alone gives; the pixels of the
/// self-check are shared out among the slices. [`image_volume_planned_once`] is faster.
///
/// ```
/// use acerra_imaging::{
///     Complex64, Control, ImagingError, PlanOptions, PlaneGrid, PulseArrays, Pulses, VolumeGrid,
///     image_volume,
/// };
/// let pulses = Pulses::new(PulseArrays {
///     position_m: &[[0.0, 0.0, 5.0], [0.0, 0.1, 5.0]],
///     frequency_hz: &[3.1e9, 3.2e9],
///     spectrum: &[Complex64::ONE; 4],
///     weight: &[1.0; 2],
///     light_speed_m_s: 3e8,
/// })?;
/// let base = PlaneGrid::new([0.0; 3], 0.05, [9, 7])?;
/// let volume = VolumeGrid::new(base, 0.1, 3)?;
/// let mut heights_m = vec![];
/// let options = PlanOptions::default();
/// image_volume(&volume, pulses, &options, Control::default(), |_, grid, image| {
///     assert_eq!(image.len(), grid.len());
///     heights_m.push(grid.z_m);
///     Ok::<_, ImagingError>(())
/// })?;
/// assert_eq!(heights_m, [0.0, 0.1, 0.2]);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
///
/// # Errors
/// As [`ImagingPlan::new`], whatever `take` returns, and cancellation.
pub fn image_volume<E: From<ImagingError>>(
    volume: &VolumeGrid,
    pulses: Pulses,
    options: &PlanOptions,
    control: Control,
    mut take: impl FnMut(usize, &PlaneGrid, &[Complex32]) -> Result<(), E>,
) -> Result<VolumeRun, E> {
    let following = Following::new(volume, &pulses, control);
    let mut image = vec![Complex32::ZERO; volume.base.len()];
    let mut run: Option<VolumeRun> = None;
    let options = options.with_check_pixels((options.check_pixels / volume.nz).max(LEAST_CHECK));
    for k in 0..volume.nz {
        let slice = volume.slice(k);
        let plan = ImagingPlan::with_control(pulses, slice, &options, control)?;
        let report = |p: Progress| following.report(k, p);
        plan.run(&mut image, control.reporting_to(&report))?;
        let run = run.get_or_insert_with(|| VolumeRun {
            report: plan.report().clone(),
            memory_bytes: plan.memory_bytes(),
            checked_error: None,
        });
        run.add(&plan);
        take(k, &slice, &image)?;
    }
    run.ok_or_else(|| ImagingError::Empty { what: "volume" }.into())
}

/// As [`image_volume`], with one plan and its tables for all slices, proved on three of them (on all,
/// where they are small); where that does not hold the accuracy, and with a weight by incidence, each
/// slice is planned by itself. A slice differs within the accuracy from itself imaged alone.
///
/// # Errors
/// As [`image_volume`].
pub fn image_volume_planned_once<E: From<ImagingError>>(
    volume: &VolumeGrid,
    pulses: Pulses,
    options: &PlanOptions,
    control: Control,
    mut take: impl FnMut(usize, &PlaneGrid, &[Complex32]) -> Result<(), E>,
) -> Result<VolumeRun, E> {
    let Some(plan) = ImagingPlan::of_volume(volume, pulses, options, control)? else {
        return image_volume(volume, pulses, options, control, take);
    };
    let following = Following::new(volume, &pulses, control);
    let mut image = vec![Complex32::ZERO; volume.base.len()];
    for k in 0..volume.nz {
        let report = |p: Progress| following.report(k, p);
        plan.run_slice(k, &mut image, control.reporting_to(&report))?;
        take(k, &volume.slice(k), &image)?;
    }
    Ok(VolumeRun {
        report: plan.report().clone(),
        memory_bytes: plan.memory_bytes(),
        checked_error: plan.self_check().map(|check| check.error),
    })
}

/// Progress of slices as progress of their volume.
struct Following<'a> {
    control: Control<'a>,
    per_slice: u64,
    total: u64,
}

impl<'a> Following<'a> {
    fn new(volume: &VolumeGrid, pulses: &Pulses, control: Control<'a>) -> Self {
        let per_slice = (volume.base.len() as u64).saturating_mul(pulses.len() as u64);
        Self {
            control,
            per_slice,
            total: per_slice.saturating_mul(volume.nz as u64),
        }
    }

    fn report(&self, k: usize, slice: Progress) {
        self.control.report(Progress {
            done: self.per_slice * k as u64 + slice.done,
            total: self.total,
        });
    }
}

impl VolumeRun {
    /// Takes the larger error and the larger memory.
    fn add(&mut self, plan: &ImagingPlan) {
        let checked = plan.self_check().map(|check| check.error);
        self.checked_error = match (self.checked_error, checked) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        if plan.memory_bytes() > self.memory_bytes {
            self.memory_bytes = plan.memory_bytes();
            self.report = plan.report().clone();
        }
    }
}
