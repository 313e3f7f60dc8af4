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

/// Least pixels of a slice's self-check where each has its own.
const LEAST_CHECK: usize = 8;

/// Images slice after slice and hands each to `take` (index, grid, `[ny, nx]` image); the same memory
/// serves all. One plan and its tables serve all slices, proved on three of them; where that does not
/// hold the accuracy, and with a weight by incidence, each slice has its own.
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
    let per_slice = (volume.base.len() as u64).saturating_mul(pulses.len() as u64);
    let total = per_slice.saturating_mul(volume.nz as u64);
    let following = |k: usize, p: Progress| {
        control.report(Progress {
            done: per_slice * k as u64 + p.done,
            total,
        });
    };
    let mut image = vec![Complex32::ZERO; volume.base.len()];
    if let Some(plan) = ImagingPlan::of_volume(volume, pulses, options, control)? {
        for k in 0..volume.nz {
            let report = |p: Progress| following(k, p);
            plan.run_slice(k, &mut image, control.reporting_to(&report))?;
            take(k, &volume.slice(k), &image)?;
        }
        return Ok(VolumeRun {
            report: plan.report().clone(),
            memory_bytes: plan.memory_bytes(),
            checked_error: plan.self_check().map(|check| check.error),
        });
    }
    let mut run: Option<VolumeRun> = None;
    let options = options.with_check_pixels((options.check_pixels / volume.nz).max(LEAST_CHECK));
    for k in 0..volume.nz {
        let slice = volume.slice(k);
        let plan = ImagingPlan::with_control(pulses, slice, &options, control)?;
        let report = |p: Progress| following(k, p);
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
