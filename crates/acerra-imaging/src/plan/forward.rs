//! The forward operator: from an image to the spectra that its pixels would return, Eq. (1) of
//! Catapano et al. 2020 in its discrete form, as fast as imaging.
//!
//! Both engines are the transposes of the imaging engines, bins and weights included, so that ⟨Lσ, d⟩ = ⟨σ, L⁺d⟩
//! holds far within the accuracy, as iterative inversions require.

use super::check::forward::{Places, check_pixels, compare_places, compare_spectra};
use super::groups::{choose_groups, choose_spread};
use super::operator::{DoublePlan, Operator, Segment, allowed_error};
use super::options::{Engine, PlanOptions, SelfCheck};
use super::planner::{Method, Planner};
use super::report::{OperatorKind, PathShares, PlanReport};
use super::request::Request;
use crate::checks::check_length;
use crate::control::Meter;
use crate::engine::batches::Piece;
use crate::engine::direct::DirectSpec;
use crate::engine::factorized::aperture::partition_aperture;
use crate::engine::forward::direct::DirectForward;
use crate::engine::forward::factorized::FactorizedForward;
use crate::engine::forward::filling::Echo;
use crate::engine::forward::grouped::grouped_pixels;
use crate::engine::planar::padded;
use crate::engine::weights::WeightedPulses;
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::job::Shape;
use crate::pulses::Pulses;
use acerra_control::Control;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use std::convert::Infallible;
use std::fmt;
use std::ops::Range;

/// A forward operator that is ready to be applied, any number of times.
///
/// Positions, frequencies, weights and the speed of light of the pulses are used, their spectra are not: E(m,
/// n) = w_m Σ_i σ_i e^{−j4πf_n R/c} / R² is the adjoint of [`ImagingPlan`](crate::ImagingPlan) on the same
/// pulses and grid.
///
/// Its accuracy is relative to the echoes of pixels that are independent of one another, as the self-check
/// draws them. The echoes of even or periodic images cancel over most of the aperture; the error does not, so
/// that the relative error is larger.
///
/// ```
/// use acerra_imaging::{
///     Complex32, Complex64, Control, Forward, PlanOptions, PlaneGrid, PulseArrays, Pulses,
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
/// let grid = PlaneGrid::from_ranges([0.0, 0.5], [0.0, 0.5], 0.0, 0.02)?;
/// let forward = Forward::new(pulses, grid, &PlanOptions::default())?;
/// let mut image = vec![Complex32::ZERO; grid.len()];
/// image[0] = Complex32::new(1.0, 0.0);
/// let mut echo = vec![Complex64::ZERO; 20 * 50];
/// forward.run(&image, &mut echo, Control::default())?;
/// let range_m = f64::hypot(5.0, 1.0); // from the first pulse to pixel 0
/// assert!((echo[0].norm() * range_m * range_m - 1.0).abs() < 1e-2);
/// # Ok::<(), acerra_imaging::ImagingError>(())
/// ```
pub struct Forward<'a> {
    pub(super) request: Request<'a>,
    pub(super) method: Method<DirectForward, FactorizedForward, Infallible>,
    pub(super) report: PlanReport,
}

impl<'a> Forward<'a> {
    /// Chooses an engine, builds it and checks it.
    ///
    /// # Errors
    /// As [`ImagingPlan::new`](crate::ImagingPlan::new).
    pub fn new(
        pulses: Pulses<'a>,
        grid: impl Into<TiltedGrid>,
        options: &PlanOptions,
    ) -> Result<Self, ImagingError> {
        Self::with_control(pulses, grid, options, Control::default())
    }

    /// As [`Forward::new`]; planning can be cancelled and reports no progress.
    ///
    /// # Errors
    /// As [`Forward::new`], and cancellation.
    pub fn with_control(
        pulses: Pulses<'a>,
        grid: impl Into<TiltedGrid>,
        options: &PlanOptions,
        control: Control,
    ) -> Result<Self, ImagingError> {
        let grid: ImageGrid = grid.into().into();
        Self::of_request(Request::new(pulses, grid, options)?, control)
    }

    /// The operator of a request, which may aim at a finer accuracy or include further slices.
    ///
    /// # Errors
    /// As [`Forward::with_control`].
    pub(super) fn of_request(
        mut request: Request<'a>,
        control: Control,
    ) -> Result<Self, ImagingError> {
        let (method, report) = Planner::plan::<Modelling>(&mut request, control)?;
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

    /// Bytes of a run in addition to the image given, spectra included.
    #[must_use]
    pub fn memory_bytes(&self) -> u128 {
        u128::from(self.report.working_bytes) + u128::from(self.report.output_bytes)
    }

    /// Result of the self-check on random pixels; `None` where the double-precision sum is run.
    #[must_use]
    pub fn self_check(&self) -> Option<SelfCheck> {
        self.report.self_check
    }

    /// The engine chosen.
    #[must_use]
    pub fn engine(&self) -> Engine {
        self.report.engine
    }

    /// Computes the spectra `[M, N]` of `image` `[rows, columns]`, both row-major. The result is bitwise
    /// equal for any number of threads.
    ///
    /// # Errors
    /// Arrays of other lengths than the grid's and the pulses'; cancellation, after which the
    /// spectra are incomplete.
    pub fn run(
        &self,
        image: &[Complex32],
        spectrum: &mut [Complex64],
        control: Control,
    ) -> Result<(), ImagingError> {
        let echoes = &self.request.echoes;
        let n = echoes.pulses.frequency_hz().len();
        check_length("image", self.request.pixels(), image.len())?;
        check_length("spectrum", echoes.len() * n, spectrum.len())?;
        let meter = Meter::new(control, self.request.contributions());
        spectrum.fill(Complex64::ZERO);
        let image = (self.request.grid.plane(), image);
        self.add(&self.all(), image, Echo::Spectra(spectrum), &meter);
        Ok(control.check()?)
    }

    /// Compares a slice at some places, each seen by one of the ranges `pulses`, which consist of whole
    /// [`Forward::units`].
    ///
    /// # Errors
    /// Cancellation.
    pub(super) fn check_slice(
        &self,
        grid: ImageGrid,
        (pixels, seed): (usize, u64),
        pulses: Vec<Range<usize>>,
        control: Control,
    ) -> Result<SelfCheck, ImagingError> {
        let coarse = match &self.method {
            Method::Factorized(factorized) => factorized.lattice.stage.coarse.cell_pixels(),
            _ => [1, 1],
        };
        let places = Places {
            grid,
            coarse,
            pixels,
            seed,
            pulses,
        };
        let run = |which: Range<usize>,
                   image: (&TiltedGrid, &[Complex32]),
                   out: &mut [Complex64],
                   meter: &Meter| {
            self.add(&which, image, Echo::Spectra(out), meter);
        };
        compare_places(&self.request.echoes, &places, &run, control)
    }

    /// Ranges of pulses that the engine cannot divide.
    pub(super) fn units(&self) -> Vec<Range<usize>> {
        match &self.method {
            Method::Factorized(factorized) => factorized.parts(&self.request.echoes),
            _ => (0..self.request.echoes.len()).map(|m| m..m + 1).collect(),
        }
    }

    /// The engine whose range bins images can be added to before they are turned into spectra.
    pub(super) fn bins(&self) -> Option<&DirectForward> {
        match &self.method {
            Method::Direct(direct) => Some(direct),
            Method::Factorized(factorized) => Some(factorized.direct()),
            Method::Double(none) => match **none {},
            Method::Reference => None,
        }
    }

    /// The largest error bound, including the uncertainty of few places, that a check accepts.
    pub(super) fn allowed_error(&self) -> f64 {
        allowed_error::<Modelling>(&self.request)
    }

    /// Adds to `echo` the spectra that the pulses `which`, whole [`Forward::units`], receive from an image on
    /// the plan's grid, on another slice or on a part of either. After cancellation `echo` is incomplete; the
    /// double-precision sum adds to spectra alone.
    pub(crate) fn add(
        &self,
        which: &Range<usize>,
        image: (&TiltedGrid, &[Complex32]),
        echo: Echo,
        meter: &Meter,
    ) {
        let echoes = &self.request.echoes;
        match &self.method {
            Method::Direct(direct) => direct.run_on(echoes, which.clone(), image, echo, meter),
            Method::Factorized(factorized) => factorized.run_on(echoes, which, image, echo, meter),
            Method::Double(none) => match **none {},
            Method::Reference => add_sum(echoes, which, image, echo.spectra(), meter),
        }
    }

    /// All pulses.
    pub(crate) fn all(&self) -> Range<usize> {
        0..self.request.echoes.len()
    }
}

/// Adds to `out` `[which.len(), N]` the spectra that the pulses `which` receive from an image, in double
/// precision.
fn add_sum(
    echoes: &WeightedPulses,
    which: &Range<usize>,
    (grid, image): (&TiltedGrid, &[Complex32]),
    out: &mut [Complex64],
    meter: &Meter,
) {
    let n = echoes.pulses.frequency_hz().len();
    out.par_chunks_mut(n).enumerate().for_each(|(m, out)| {
        for (k, v) in image.iter().enumerate() {
            if meter.is_cancelled() {
                return;
            }
            if *v != Complex32::ZERO {
                let (i, j) = (k % grid.columns, k / grid.columns);
                let value = Complex64::new(f64::from(v.re), f64::from(v.im));
                let point_m = grid.point_m(i as f64, j as f64);
                echoes.add_echo(which.start + m, point_m, value, out);
            }
        }
        meter.add(image.len() as u64);
    });
}

impl fmt::Debug for Forward<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Forward({self})")
    }
}

impl fmt::Display for Forward<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.report.fmt(f)
    }
}

/// The forward operator, Eq. (1).
struct Modelling;

/// Cost of lane-wise additions to bins, in vector operations a contribution.
const SPREAD_COST: f64 = 5.0;

/// Bytes of the image with padded rows or in groups, and of the bins of all threads.
fn image_and_bins_bytes(request: &Request, spec: &DirectSpec, ranges_m: &[[f64; 2]]) -> u128 {
    let grid = request.grid.plane();
    let pixels = match &spec.groups {
        Some(groups) => grouped_pixels(grid, groups.shape),
        None => padded(grid.columns) as u128 * grid.rows as u128,
    };
    pixels * 8
        + DirectForward::bytes_a_thread(spec, ranges_m) * rayon::current_num_threads() as u128
}

impl Operator for Modelling {
    type Direct = DirectForward;
    type Factorized = FactorizedForward;
    type Double = Infallible;
    const KIND: OperatorKind = OperatorKind::Forward;
    const FACTORIZED_ATTEMPTS: usize = 6;
    // The check compares a few places only: errors that concentrate elsewhere need a margin.
    const ACCEPTED_SHARE: f64 = 0.6;
    const WINDOWS: bool = false;
    const UNEVEN: bool = false;
    const LEVEL_GROUND: bool = false;
    const TWO_STAGES: bool = false;
    const SEGMENTS: bool = false;
    // Solvers apply the operator many times.
    const REPEATED: bool = true;
    const MEMORY: &'static str = "range bins, image and spectra";

    /// Modelled spectra may hold all frequencies equally.
    fn power(request: &Request) -> Vec<f64> {
        let n = request.echoes.pulses.frequency_hz().len();
        vec![1.0 / n as f64; n]
    }

    /// Adding to bins lane by lane costs more than reading them through windows.
    fn factorized_pays(cost: f64, direct_cost: f64) -> bool {
        cost <= 0.8 * direct_cost.max(SPREAD_COST)
    }

    fn direct_spec(
        request: &Request,
        accuracy: f64,
        imaging: (DirectSpec, f64),
    ) -> (DirectSpec, f64) {
        let power = Self::power(request);
        let (spec, cost) = imaging;
        let by_rows = DirectSpec {
            shape: Shape::Row,
            ..spec
        };
        let summed = choose_groups(request, &power, accuracy, &spec);
        let spread = choose_spread(request, &power, accuracy);
        summed
            .into_iter()
            .chain(spread)
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((by_rows, cost))
    }

    fn check_pixels(request: &Request) -> [usize; 2] {
        [check_pixels(request); 2]
    }

    fn output_bytes(request: &Request) -> u128 {
        let pulses = &request.echoes.pulses;
        pulses.spectrum().len() as u128 * size_of::<Complex64>() as u128
    }

    fn direct_bytes(request: &Request, piece: &Piece<DirectSpec>) -> Result<u128, ImagingError> {
        Ok(image_and_bins_bytes(request, &piece.spec, &piece.ranges_m))
    }

    fn factorized_bytes(request: &Request, pieces: &[Segment]) -> Result<u128, ImagingError> {
        let bytes = |piece: &Segment| {
            let (spec, inner) = &piece.spec;
            let parts = partition_aperture(&request.echoes.pulses, spec.outer.pulses).len();
            (spec.outer.coarse).bytes(request.grid.plane(), parts)
                + image_and_bins_bytes(request, inner, &piece.ranges_m)
        };
        Ok(pieces.iter().map(bytes).sum())
    }

    fn direct(
        request: &Request,
        piece: Piece<DirectSpec>,
        control: Control,
    ) -> Result<DirectForward, ImagingError> {
        control.check()?;
        let (level, ranges_m) = (request.options.level, &piece.ranges_m);
        Ok(DirectForward::new(
            &request.echoes,
            ranges_m,
            piece.spec,
            level,
        ))
    }

    fn factorized(
        request: &Request,
        pieces: &[Segment],
        control: Control,
    ) -> Result<FactorizedForward, ImagingError> {
        control.check()?;
        let (grid, level) = (request.grid.plane(), request.options.level);
        let [piece] = pieces else {
            return Err(ImagingError::Length {
                what: "pieces of the aperture",
                expected: 1,
                found: pieces.len(),
            });
        };
        Ok(FactorizedForward::new(
            &request.echoes,
            grid,
            &piece.ranges_m,
            piece.spec,
            level,
        ))
    }

    fn double(_: &Request, _: Control) -> Result<Option<DoublePlan<Infallible>>, ImagingError> {
        Ok(None)
    }

    fn check_direct(
        request: &Request,
        direct: &DirectForward,
        pixels: usize,
        control: Control,
    ) -> Result<(SelfCheck, Option<PathShares>), ImagingError> {
        let run = |which: Range<usize>,
                   image: (&TiltedGrid, &[Complex32]),
                   out: &mut [Complex64],
                   meter: &Meter| {
            direct.run_on(&request.echoes, which, image, Echo::Spectra(out), meter);
        };
        let check = compare_spectra(request, [1, 1], pixels, &run, control)?;
        Ok((check, None))
    }

    fn check_factorized(
        request: &Request,
        factorized: &FactorizedForward,
        pixels: usize,
        control: Control,
    ) -> Result<SelfCheck, ImagingError> {
        let run = |which: Range<usize>,
                   image: (&TiltedGrid, &[Complex32]),
                   out: &mut [Complex64],
                   meter: &Meter| {
            factorized.run_on(&request.echoes, &which, image, Echo::Spectra(out), meter);
        };
        let coarse = factorized.lattice.stage.coarse.cell_pixels();
        compare_spectra(request, coarse, pixels, &run, control)
    }
}
