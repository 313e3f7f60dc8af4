//! The plan of an image.

use super::band::mean_power;
use super::check::imaging::{compare_patches, compare_pixels, first_pixels, most_pixels};
use super::double::double_tables;
use super::operator::{DoublePlan, Operator, Segment};
use super::options::{Engine, PlanOptions, SelfCheck};
use super::planner::{Method, Planner};
use super::report::{OperatorKind, PathShares, PlanReport};
use super::request::Request;
use crate::checks::check_length;
use crate::control::Meter;
use crate::engine::batches::{Division, Imager, Piece, TableEngine};
use crate::engine::direct::{Direct, DirectSpec};
use crate::engine::double::{DoubleTables, image_by_pieces};
use crate::engine::factorized::merged::{Factorized, Setting};
use crate::engine::weights::WeightedPulses;
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::pulses::Pulses;
use acerra_control::Control;
use num_complex::Complex32;
use std::fmt;

/// An image that is ready to be computed, any number of times.
///
/// Making the plan builds the range tables and checks the accuracy on random pixels against the
/// double-precision sum. Running the plan allocates no memory in the loops over pulses and pixels (the
/// factorized engine allocates its coarse images once, at the start; below uneven ground rays to tiles of pixels are kept as
/// long as these are summed), and the image is bitwise equal for any
/// number of threads.
///
/// Pixels are on a plane of any tilt or on uneven ground. The factorized engine interpolates between
/// pixels: ground with sharp kinks, as heights linear between the knots of a raster have them, may be left to
/// the direct engine, ten times slower.
///
/// ```
/// use acerra_imaging::{
///     Complex64, Control, ImagingPlan, PlanOptions, PlaneGrid, PulseArrays, Pulses, SurfaceGrid,
/// };
/// let position_m: Vec<[f64; 3]> = (0..20).map(|m| [0.0, 0.1 * f64::from(m) - 1.0, 5.0]).collect();
/// let frequency_hz: Vec<f64> = (0..50).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
/// let spectrum = vec![Complex64::new(1.0, 0.0); 20 * 50];
/// let pulses = Pulses::new(PulseArrays {
///     position_m: &position_m,
///     frequency_hz: &frequency_hz,
///     spectrum: &spectrum,
///     weight: &[1.0; 20],
///     light_speed_m_s: 3e8,
/// })?;
/// let grid = PlaneGrid::from_ranges([0.0, 0.5], [0.0, 0.5], 0.0, 0.02)?;
/// let plan = ImagingPlan::new(pulses, grid, &PlanOptions::default())?;
/// println!("{}", plan.report());
/// let mut image = vec![Default::default(); plan.pixels()];
/// let show = |p: acerra_imaging::Progress| assert!(p.done <= p.total);
/// plan.run(&mut image, Control::default().reporting_to(&show))?;
///
/// let slope = |x_m: f64, _: f64| Ok::<_, acerra_imaging::ImagingError>(0.2 * x_m);
/// let ground = SurfaceGrid::from_fn(grid, slope)?;
/// let plan = ImagingPlan::new(pulses, &ground, &PlanOptions::default())?;
/// assert!(plan.self_check().is_some_and(|check| check.error <= 1e-3));
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
#[derive(Debug)]
pub struct ImagingPlan<'a> {
    pub(super) request: Request<'a>,
    pub(super) method: Method<Imager<Direct>, Imager<Factorized>, DoubleTables>,
    pub(super) report: PlanReport,
}

impl<'a> ImagingPlan<'a> {
    /// Chooses an engine, builds it and checks it.
    ///
    /// # Errors
    /// An accuracy outside (0, 0.1], a level the processor lacks, an antenna exactly on a pixel
    /// (with 1/R²), or more memory than allowed.
    pub fn new(
        pulses: Pulses<'a>,
        grid: impl Into<ImageGrid<'a>>,
        options: &PlanOptions,
    ) -> Result<Self, ImagingError> {
        Self::with_control(pulses, grid, options, Control::default())
    }

    /// As [`ImagingPlan::new`]; planning can be cancelled and reports no progress.
    ///
    /// # Errors
    /// As [`ImagingPlan::new`], and cancellation.
    pub fn with_control(
        pulses: Pulses<'a>,
        grid: impl Into<ImageGrid<'a>>,
        options: &PlanOptions,
        control: Control,
    ) -> Result<Self, ImagingError> {
        Self::of_request(Request::new(pulses, grid.into(), options)?, control)
    }

    /// The plan that a request asks for.
    pub(super) fn of_request(
        mut request: Request<'a>,
        control: Control,
    ) -> Result<Self, ImagingError> {
        let (method, report) = Planner::plan::<Imaging>(&mut request, control)?;
        Ok(Self {
            request,
            method,
            report,
        })
    }

    /// Decisions, cost, accuracy and memory of the plan.
    #[must_use]
    pub fn report(&self) -> &PlanReport {
        &self.report
    }

    /// Bytes of range tables, coarse images and the image together. Apart from the data, no other memory
    /// grows with the size of the task.
    #[must_use]
    pub fn memory_bytes(&self) -> u128 {
        u128::from(self.report.working_bytes) + u128::from(self.report.output_bytes)
    }

    /// Pixels of the image.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.request.pixels()
    }

    /// Pixel × pulse contributions to the image.
    #[must_use]
    pub fn contributions(&self) -> u64 {
        self.request.contributions()
    }

    /// Result of the self-check on random pixels; `None` where the reference itself is run.
    #[must_use]
    pub fn self_check(&self) -> Option<SelfCheck> {
        self.report.self_check
    }

    /// Whether the plan computes in double precision.
    pub(super) fn is_double_precision(&self) -> bool {
        matches!(self.method, Method::Double(_) | Method::Reference)
    }

    /// The engine chosen.
    #[must_use]
    pub fn engine(&self) -> Engine {
        self.report.engine
    }

    /// Computes the image, `[rows, columns]` row-major.
    ///
    /// # Errors
    /// An output of another length than the grid's; cancellation, after which the output is
    /// incomplete.
    pub fn run(&self, image: &mut [Complex32], control: Control) -> Result<(), ImagingError> {
        self.run_on(&self.request.echoes, &self.request.grid, image, control)
    }

    /// Images a grid for which the engine was made, from the plan's pulses with the weights of that grid.
    pub(super) fn run_on(
        &self,
        echoes: &WeightedPulses,
        grid: &ImageGrid,
        image: &mut [Complex32],
        control: Control,
    ) -> Result<(), ImagingError> {
        check_length("image", self.pixels(), image.len())?;
        let meter = Meter::new(control, self.contributions());
        match &self.method {
            Method::Direct(direct) => direct.run(echoes, grid, image, &meter)?,
            Method::Factorized(factorized) => factorized.run(echoes, grid, image, &meter)?,
            Method::Double(tables) => tables.run(echoes, grid, image, &meter),
            Method::Reference => {
                image_by_pieces(grid, image, (echoes.len(), 1), &meter, |parts_m| {
                    let sums = |part_m: &Vec<_>| echoes.adjoint_at(part_m, || meter.is_cancelled());
                    parts_m.iter().map(sums).collect()
                });
            }
        }
        Ok(control.check()?)
    }

    /// Drops the tables; every run then builds them again, with the weights given to the run.
    pub(super) fn forget_tables(&mut self) {
        match &mut self.method {
            Method::Direct(direct) => direct.forget_tables(),
            Method::Factorized(factorized) => factorized.forget_tables(),
            // Tables in double precision hold no weights.
            Method::Double(_) | Method::Reference => {}
        }
    }
}

impl fmt::Display for ImagingPlan<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.report.fmt(f)
    }
}

/// Images `grid` with a separate plan.
///
/// # Errors
/// As [`ImagingPlan::new`], and cancellation.
pub fn image<'a>(
    pulses: Pulses<'a>,
    grid: impl Into<ImageGrid<'a>>,
    options: &PlanOptions,
    control: Control,
) -> Result<Vec<Complex32>, ImagingError> {
    let plan = ImagingPlan::with_control(pulses, grid, options, control)?;
    let mut image = vec![Complex32::ZERO; plan.pixels()];
    plan.run(&mut image, control)?;
    Ok(image)
}

/// The division of pieces that the memory allowed asks for.
fn division<E: TableEngine>(
    request: &Request,
    pieces: &[Piece<E::Spec>],
) -> Result<Division<E::Spec>, ImagingError> {
    let bytes = [
        Imaging::output_bytes(request),
        request.options.memory_limit_bytes,
    ];
    Division::of::<E>(&request.echoes, &request.grid, pieces, bytes)
}

fn imager<E: TableEngine>(
    request: &Request,
    pieces: &[Piece<E::Spec>],
    control: Control,
) -> Result<Imager<E>, ImagingError> {
    let level = request.options.level;
    let setting = Setting { level, control };
    let division = division::<E>(request, pieces)?;
    Imager::new(&request.echoes, request.grid.plane(), division, setting)
}

/// Imaging, Eq. (3).
pub(super) struct Imaging;

impl Operator for Imaging {
    type Direct = Imager<Direct>;
    type Factorized = Imager<Factorized>;
    type Double = DoubleTables;
    const KIND: OperatorKind = OperatorKind::Imaging;
    const FACTORIZED_ATTEMPTS: usize = 4;
    const ACCEPTED_SHARE: f64 = 1.0;
    const WINDOWS: bool = true;
    const UNEVEN: bool = true;
    const LEVEL_GROUND: bool = true;
    const TWO_STAGES: bool = true;
    const SEGMENTS: bool = true;
    const REPEATED: bool = false;
    const MEMORY: &'static str = "range tables and image";

    fn power(request: &Request) -> Vec<f64> {
        mean_power(&request.echoes.pulses)
    }

    fn factorized_pays(cost: f64, direct_cost: f64) -> bool {
        cost <= 0.9 * direct_cost
    }

    fn check_pixels(request: &Request) -> [usize; 2] {
        [first_pixels(request), most_pixels(request)]
    }

    fn output_bytes(request: &Request) -> u128 {
        request.pixels() as u128 * size_of::<Complex32>() as u128
    }

    fn direct_bytes(request: &Request, piece: &Piece<DirectSpec>) -> Result<u128, ImagingError> {
        Ok(division::<Direct>(request, std::slice::from_ref(piece))?.bytes)
    }

    fn factorized_bytes(request: &Request, pieces: &[Segment]) -> Result<u128, ImagingError> {
        Ok(division::<Factorized>(request, pieces)?.bytes)
    }

    fn direct(
        request: &Request,
        piece: Piece<DirectSpec>,
        control: Control,
    ) -> Result<Imager<Direct>, ImagingError> {
        imager(request, &[piece], control)
    }

    fn factorized(
        request: &Request,
        pieces: &[Segment],
        control: Control,
    ) -> Result<Imager<Factorized>, ImagingError> {
        imager(request, pieces, control)
    }

    fn direct_batches(direct: &Imager<Direct>) -> usize {
        direct.batches()
    }

    fn factorized_batches(factorized: &Imager<Factorized>) -> usize {
        factorized.batches()
    }

    fn double(
        request: &Request,
        control: Control,
    ) -> Result<Option<DoublePlan<DoubleTables>>, ImagingError> {
        let power = Self::power(request);
        double_tables(request, &power, Self::output_bytes(request), control)
    }

    fn check_direct(
        request: &Request,
        direct: &Imager<Direct>,
        pixels: usize,
        control: Control,
    ) -> Result<(SelfCheck, Option<PathShares>), ImagingError> {
        let (check, paths) = compare_pixels(request, direct, pixels, control)?;
        Ok((check, Some(paths)))
    }

    fn check_factorized(
        request: &Request,
        factorized: &Imager<Factorized>,
        pixels: usize,
        control: Control,
    ) -> Result<SelfCheck, ImagingError> {
        compare_patches(request, factorized, pixels, control)
    }
}
