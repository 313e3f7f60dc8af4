//! Images of volumes.

use crate::error::ImagingError;
use crate::grid::plane::PlaneGrid;
use crate::grid::volume::VolumeGrid;
use crate::plan::imaging::ImagingPlan;
use crate::plan::options::{PlanOptions, SelfCheck};
use crate::plan::report::PlanReport;
use crate::plan::slices::groups::groups;
use crate::plan::slices::plan::SlicesPlan;
use crate::pulses::Pulses;
use acerra_control::{Control, Progress};
use num_complex::Complex32;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// Report of imaging a volume.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct VolumeRun {
    /// The plan of the slice that needed most memory.
    pub report: PlanReport,
    /// Most bytes that a slice and its tables took together.
    pub memory_bytes: u128,
    /// Largest relative error that a slice's self-check found.
    pub checked_error: Option<f64>,
    /// The slices that each plan imaged, in their order.
    pub plans: Vec<Range<usize>>,
}

/// Least number of pixels of a slice's self-check where every slice is planned separately.
const LEAST_CHECK: usize = 32;

/// Images slice after slice and calls `take` (index, grid, `[ny, nx]` image) for each; the same memory serves
/// all slices. Every slice is planned separately and is identical to the slice imaged alone; the slices share
/// the pixels of the self-check, at least 32 to each. [`image_volume_planned_once`] is faster, and checks
/// more pixels.
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
    let options = options.with_check_pixels((options.check_pixels / volume.nz).max(LEAST_CHECK));
    let mut imaging = Imaging::new(volume, pulses, &options, control);
    for k in 0..volume.nz {
        imaging.alone(k, &mut take)?;
    }
    Ok(imaging.run()?)
}

/// As [`image_volume`], with one plan and its tables for all slices, or for groups of them where far slices
/// of a tall volume can be imaged in less time. Every slice is compared with the double-precision sum at some
/// of its pixels before it is handed out: from a slice that exceeds the accuracy on, the slices are planned
/// finer, in the end each separately. A slice differs from the slice imaged alone by at most the accuracy.
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
    let mut imaging = Imaging::new(volume, pulses, options, control);
    for group in groups(volume, pulses, options, control)? {
        imaging.together(group, &mut take)?;
    }
    Ok(imaging.run()?)
}

/// Number of plans that fail on the same slice before it is planned separately.
const MOST_FAILURES: usize = 3;

/// A volume in the making.
struct Imaging<'a> {
    volume: &'a VolumeGrid,
    pulses: Pulses<'a>,
    options: &'a PlanOptions,
    control: Control<'a>,
    following: Following<'a>,
    image: Vec<Complex32>,
    run: Option<VolumeRun>,
}

impl<'a> Imaging<'a> {
    fn new(
        volume: &'a VolumeGrid,
        pulses: Pulses<'a>,
        options: &'a PlanOptions,
        control: Control<'a>,
    ) -> Self {
        Self {
            volume,
            pulses,
            options,
            control,
            following: Following::new(volume, &pulses, control),
            image: vec![Complex32::ZERO; volume.base.len()],
            run: None,
        }
    }

    /// Slice `k` with a separate plan.
    fn alone<E: From<ImagingError>>(
        &mut self,
        k: usize,
        take: &mut impl FnMut(usize, &PlaneGrid, &[Complex32]) -> Result<(), E>,
    ) -> Result<(), E> {
        let slice = self.volume.slice(k);
        let plan = ImagingPlan::with_control(self.pulses, slice, self.options, self.control)?;
        let report = |p: Progress| self.following.report(k, p);
        plan.run(&mut self.image, self.control.reporting_to(&report))?;
        self.add(k..k + 1, plan.memory_bytes(), plan.self_check(), || {
            plan.report().clone()
        });
        take(k, &slice, &self.image)
    }

    /// Neighbouring slices with one plan as far as it holds, then with finer ones.
    fn together<E: From<ImagingError>>(
        &mut self,
        slices: Range<usize>,
        take: &mut impl FnMut(usize, &PlaneGrid, &[Complex32]) -> Result<(), E>,
    ) -> Result<(), E> {
        let (mut next, mut aim, mut failures) = (slices.start, 1.0, 0);
        while next < slices.end && failures < MOST_FAILURES {
            let left = next..slices.end;
            let (volume, options) = (self.volume, self.options);
            let plan = SlicesPlan::new(volume, left, aim, self.pulses, options, self.control)?;
            let Some(mut plan) = plan else { break };
            let first = next;
            let broken = self.until_broken(&mut plan, &mut next, slices.end, take)?;
            if next > first {
                self.add(first..next, plan.memory_bytes(), plan.worst(), || {
                    plan.report()
                });
                failures = 0;
            }
            if let Some(check) = broken {
                failures += 1;
                aim = plan.next_aim(check);
            }
        }
        (next..slices.end).try_for_each(|k| self.alone(k, take))
    }

    /// Images slices from `next` on, which counts those that are handed out; the check of the first that does
    /// not keep the accuracy.
    fn until_broken<E: From<ImagingError>>(
        &mut self,
        plan: &mut SlicesPlan,
        next: &mut usize,
        end: usize,
        take: &mut impl FnMut(usize, &PlaneGrid, &[Complex32]) -> Result<(), E>,
    ) -> Result<Option<SelfCheck>, E> {
        while *next < end {
            let k = *next;
            let report = |p: Progress| self.following.report(k, p);
            let control = self.control.reporting_to(&report);
            let check = plan.run(k, &mut self.image, control)?;
            if let Some(broken) = check.filter(|check| !plan.keeps(*check)) {
                return Ok(Some(broken));
            }
            *next += 1;
            take(k, &self.volume.slice(k), &self.image)?;
        }
        Ok(None)
    }

    /// Takes the larger error and the larger memory.
    fn add(
        &mut self,
        slices: Range<usize>,
        memory_bytes: u128,
        checked: Option<SelfCheck>,
        report: impl Fn() -> PlanReport,
    ) {
        let run = self.run.get_or_insert_with(|| VolumeRun {
            report: report(),
            memory_bytes,
            checked_error: None,
            plans: Vec::new(),
        });
        let errors = [run.checked_error, checked.map(|check| check.error)];
        run.checked_error = errors.into_iter().flatten().reduce(f64::max);
        if memory_bytes > run.memory_bytes {
            run.memory_bytes = memory_bytes;
            run.report = report();
        }
        run.plans.push(slices);
    }

    fn run(self) -> Result<VolumeRun, ImagingError> {
        self.run.ok_or(ImagingError::Empty { what: "volume" })
    }
}

/// Progress of slices as progress of their volume.
struct Following<'a> {
    control: Control<'a>,
    per_slice: u64,
    total: u64,
    /// The largest progress reported so far: repeated work counts once.
    most: AtomicU64,
}

impl<'a> Following<'a> {
    fn new(volume: &VolumeGrid, pulses: &Pulses, control: Control<'a>) -> Self {
        let per_slice = (volume.base.len() as u64).saturating_mul(pulses.len() as u64);
        Self {
            control,
            per_slice,
            total: per_slice.saturating_mul(volume.nz as u64),
            most: AtomicU64::new(0),
        }
    }

    fn report(&self, k: usize, slice: Progress) {
        let done = self.per_slice * k as u64 + slice.done;
        if self.most.fetch_max(done, Ordering::Relaxed) < done {
            let total = self.total;
            self.control.report(Progress { done, total });
        }
    }
}
