//! The planner of both operators: chooses an engine, builds it, and proves its accuracy.

use super::budget::{Budget, FactorizedBudget, HOPELESS};
use super::options::{Engine, PlanOptions, SelfCheck};
use super::report::{
    Decision, DirectChoice, FactorizedChoice, OperatorKind, PathShares, PlanReport,
};
use crate::control::Control;
use crate::engine::direct::{DirectSpec, table_ranges_m};
use crate::engine::factorized::coarse::coarse_grid;
use crate::engine::factorized::spec::FactorizedSpec;
use crate::engine::weights::{WeightedPulses, Weights};
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::level::SimdLevel;
use crate::pulses::{Pulses, Spreading};

/// Below this relative error single precision does not suffice and the reference itself is run.
const SINGLE_PRECISION_FLOOR: f64 = 4e-6;
/// Plans of the direct engine that are tried, each for half of the error of the one before.
const DIRECT_ATTEMPTS: i32 = 6;

/// Data, pixels and requirements of a plan.
#[derive(Debug)]
pub(crate) struct Request<'a> {
    pub echoes: WeightedPulses<'a>,
    pub grid: ImageGrid<'a>,
    /// Other planes that the same engine images: slices of a volume; none for a single image.
    pub slices: Vec<TiltedGrid>,
    pub options: PlanOptions,
}

/// The engine of a plan.
#[derive(Debug)]
pub(crate) enum Method<D, F> {
    Direct(Box<D>),
    Factorized(Box<F>),
    Reference,
}

/// The engine chosen and the report of its choice.
pub(crate) type Planned<O> = (
    Method<<O as Operator>::Direct, <O as Operator>::Factorized>,
    PlanReport,
);

/// What differs between imaging and the forward operator.
pub(crate) trait Operator {
    /// The direct engine.
    type Direct;
    /// The factorized engine.
    type Factorized;
    const KIND: OperatorKind;
    /// Factorized plans that are tried, each for half of the error of the one before.
    const FACTORIZED_ATTEMPTS: i32;
    /// Share of the accuracy that the self-check may find.
    const ACCEPTED_SHARE: f64;
    /// Whether the direct engine uses windows of bins on coarse grids, or must go lane by lane.
    const WINDOWS: bool;
    /// The arrays that count against the limit of memory.
    const MEMORY: &'static str;

    /// Power expected at each frequency of the data.
    fn power(request: &Request) -> Vec<f64>;
    /// Whether the factorized engine is sufficiently cheaper to be chosen.
    fn factorized_pays(cost: f64, direct_cost: f64) -> bool;
    /// Pixels of a first self-check, and of one that the first left undecided.
    fn check_pixels(request: &Request) -> [usize; 2];
    /// Bytes of the result.
    fn output_bytes(request: &Request) -> u128;
    /// Bytes of a direct engine.
    fn direct_bytes(request: &Request, spec: &DirectSpec, ranges_m: &[[f64; 2]]) -> u128;
    /// Bytes of a factorized engine.
    fn factorized_bytes(
        request: &Request,
        spec: &FactorizedSpec,
        inner: &DirectSpec,
        ranges_m: &[[f64; 2]],
    ) -> u128;
    /// Batches of pulses in which a direct engine takes them.
    fn direct_batches(_: &Self::Direct) -> usize {
        1
    }
    /// Those of a factorized engine.
    fn factorized_batches(_: &Self::Factorized) -> usize {
        1
    }
    /// Builds a direct engine.
    fn direct(
        request: &Request,
        ranges_m: &[[f64; 2]],
        spec: DirectSpec,
        control: Control,
    ) -> Result<Self::Direct, ImagingError>;
    /// Builds a factorized engine.
    fn factorized(
        request: &Request,
        ranges_m: &[[f64; 2]],
        specs: (FactorizedSpec, DirectSpec),
        control: Control,
    ) -> Result<Self::Factorized, ImagingError>;
    /// Compares a direct engine with the double-precision sum.
    fn check_direct(
        request: &Request,
        direct: &Self::Direct,
        pixels: usize,
        control: Control,
    ) -> Result<(SelfCheck, Option<PathShares>), ImagingError>;
    /// Compares a factorized engine with the double-precision sum.
    fn check_factorized(
        request: &Request,
        factorized: &Self::Factorized,
        pixels: usize,
        control: Control,
    ) -> Result<SelfCheck, ImagingError>;
}

impl<'a> Request<'a> {
    /// Checks data, pixels and requirements.
    ///
    /// # Errors
    /// An accuracy outside (0, 0.1], a level the processor lacks, an antenna exactly on a pixel
    /// (with 1/R²), a weight by incidence that has no meaning here.
    pub fn new(
        pulses: Pulses<'a>,
        grid: ImageGrid<'a>,
        options: &PlanOptions,
    ) -> Result<Self, ImagingError> {
        options.level.checked()?;
        if !(options.accuracy > 0.0 && options.accuracy <= 0.1) {
            return Err(ImagingError::OutOfRange {
                what: "accuracy",
                expected: "above 0 and at most 0.1",
                found: options.accuracy,
            });
        }
        check_apart(&pulses, &grid, options)?;
        let weights = Weights::new(&pulses, &grid, options.spreading, options.incidence)?;
        Ok(Self {
            echoes: WeightedPulses { pulses, weights },
            grid,
            slices: Vec::new(),
            options: *options,
        })
    }

    /// The same with other planes, which the engine must be able to image as well.
    ///
    /// # Errors
    /// An antenna exactly on a pixel (with 1/R²).
    pub fn with_slices(self, slices: Vec<TiltedGrid>) -> Result<Self, ImagingError> {
        for slice in &slices {
            check_apart(&self.echoes.pulses, &(*slice).into(), &self.options)?;
        }
        Ok(Self { slices, ..self })
    }

    /// The same data and requirements for one of the slices.
    pub fn of_slice(&self, slice: TiltedGrid) -> Self {
        Self {
            echoes: self.echoes.clone(),
            grid: slice.into(),
            slices: Vec::new(),
            options: self.options,
        }
    }

    /// Bounds of the ranges from every pulse that imaging looks up: on the grids that `of` makes of the
    /// planes, or on the pixels themselves.
    pub fn ranges_m(&self, of: impl Fn(&TiltedGrid) -> TiltedGrid) -> Vec<[f64; 2]> {
        if self.grid.is_uneven() {
            return table_ranges_m(&self.echoes, &self.grid);
        }
        let mut ranges_m = table_ranges_m(&self.echoes, &of(self.grid.plane()).into());
        for slice in &self.slices {
            let others = table_ranges_m(&self.echoes, &of(slice).into());
            for (range, other) in ranges_m.iter_mut().zip(others) {
                *range = [range[0].min(other[0]), range[1].max(other[1])];
            }
        }
        ranges_m
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.grid.len()
    }

    /// Pixel × pulse contributions.
    pub fn contributions(&self) -> u64 {
        (self.pixels() as u64).saturating_mul(self.echoes.len() as u64)
    }
}

/// A self-check of few pixels, and of more where those leave the verdict open: good with all that they
/// cannot say, or too large by what they found.
///
/// # Errors
/// Those of `check`.
pub(super) fn decided<O: Operator>(
    request: &Request,
    mut check: impl FnMut(usize) -> Result<SelfCheck, ImagingError>,
) -> Result<SelfCheck, ImagingError> {
    let allowed = O::ACCEPTED_SHARE * request.options.accuracy;
    let [few, most] = O::check_pixels(request);
    let found = check(few)?;
    if found.error_bound <= allowed || found.error > allowed || few == most {
        return Ok(found);
    }
    check(most)
}

/// # Errors
/// An antenna exactly on a pixel, where 1/R² has no value.
fn check_apart(
    pulses: &Pulses,
    grid: &ImageGrid,
    options: &PlanOptions,
) -> Result<(), ImagingError> {
    if options.spreading == Spreading::InverseSquare {
        for (pulse, p) in pulses.position_m().iter().enumerate() {
            if let Some(point) = grid.pixel_at(*p) {
                return Err(ImagingError::ZeroRange { pulse, point });
            }
        }
    }
    Ok(())
}

/// Makes a plan in progress.
pub(crate) struct Planner<'r, 'a> {
    request: &'r mut Request<'a>,
    control: Control<'r>,
    report: PlanReport,
    working_bytes: u128,
}

impl<'r, 'a> Planner<'r, 'a> {
    /// Chooses, builds and checks an engine for `request`, whose instruction set may be lowered.
    ///
    /// # Errors
    /// More memory than allowed, cancellation.
    pub fn plan<O: Operator>(
        request: &'r mut Request<'a>,
        control: Control<'r>,
    ) -> Result<Planned<O>, ImagingError> {
        let report = PlanReport {
            operator: O::KIND,
            columns: request.grid.columns(),
            rows: request.grid.rows(),
            pulses: request.echoes.len(),
            frequencies: request.echoes.pulses.frequency_hz().len(),
            accuracy: request.options.accuracy,
            engine: Engine::Reference,
            decisions: Vec::new(),
            self_check: None,
            working_bytes: 0,
            output_bytes: saturated(O::output_bytes(request)),
        };
        let mut planner = Self {
            request,
            control: control.silent(),
            report,
            working_bytes: 0,
        };
        let method = planner.choose::<O>()?;
        planner.check_memory::<O>()?;
        planner.report.working_bytes = saturated(planner.working_bytes);
        planner.report.engine = match method {
            Method::Direct(_) => Engine::Direct,
            Method::Factorized(_) => Engine::Factorized,
            Method::Reference => Engine::Reference,
        };
        Ok((method, planner.report))
    }

    fn choose<O: Operator>(&mut self) -> Result<Method<O::Direct, O::Factorized>, ImagingError> {
        let accuracy = self.request.options.accuracy;
        if self.request.options.engine == Engine::Reference {
            self.decide(Decision::ReferenceRequested);
            return Ok(Method::Reference);
        }
        if accuracy < SINGLE_PRECISION_FLOOR {
            self.decide(Decision::BelowSinglePrecision { accuracy });
            return Ok(Method::Reference);
        }
        if let Some(factorized) = self.choose_factorized::<O>()? {
            return Ok(Method::Factorized(Box::new(factorized)));
        }
        loop {
            let reached = match self.choose_direct::<O>()? {
                Ok(direct) => return Ok(Method::Direct(Box::new(direct))),
                Err(reached) => reached,
            };
            // Never trust an instruction set over the check.
            if self.request.options.level == SimdLevel::Avx512 {
                self.request.options.level = SimdLevel::Avx2;
            } else {
                self.decide(Decision::SinglePrecisionExhausted { reached });
                return Ok(Method::Reference);
            }
        }
    }

    /// The factorized engine where it was asked for or is sufficiently cheaper, and keeps the
    /// accuracy.
    fn choose_factorized<O: Operator>(&mut self) -> Result<Option<O::Factorized>, ImagingError> {
        let options = self.request.options;
        if !matches!(options.engine, Engine::Auto | Engine::Factorized) {
            return Ok(None);
        }
        if self.request.grid.is_uneven() {
            self.decide(Decision::UnevenGround);
            return Ok(None);
        }
        let power = O::power(self.request);
        for attempt in 0..O::FACTORIZED_ATTEMPTS {
            let accuracy = options.accuracy * 0.5f64.powi(attempt);
            let (pulses, plane) = (&self.request.echoes.pulses, self.request.grid.plane());
            let budget = Budget::new(pulses, plane, options.level, power.clone());
            let budget = budget.factorized(accuracy, O::WINDOWS, self.control)?;
            let Some(budget) = budget else {
                return Ok(None);
            };
            let (spec, inner) = (budget.spec, budget.inner);
            if options.engine == Engine::Auto && !O::factorized_pays(spec.cost, budget.direct_cost)
            {
                self.decide(Decision::DirectIsCheaper {
                    factorized_cost: spec.cost,
                    direct_cost: budget.direct_cost,
                });
                return Ok(None);
            }
            let ranges_m = self
                .request
                .ranges_m(|plane| coarse_grid(plane, spec.coarse));
            self.working_bytes = O::factorized_bytes(self.request, &spec, &inner, &ranges_m);
            if let Err(too_large) = self.check_memory::<O>() {
                if options.engine == Engine::Factorized {
                    return Err(too_large);
                }
                self.decide(Decision::FactorizedTooLarge {
                    bytes: saturated(self.working_bytes),
                });
                self.working_bytes = 0;
                return Ok(None);
            }
            let engine = O::factorized(self.request, &ranges_m, (spec, inner), self.control)?;
            let check = decided::<O>(self.request, |pixels| {
                O::check_factorized(self.request, &engine, pixels, self.control)
            })?;
            self.decide(Decision::Factorized(factorized_choice(
                &budget,
                options.level,
            )));
            self.decide_batches(O::factorized_batches(&engine));
            if self.accepts::<O>(check) {
                return Ok(Some(engine));
            }
        }
        Ok(None)
    }

    /// The direct engine, or the least error that it reached.
    fn choose_direct<O: Operator>(&mut self) -> Result<Result<O::Direct, f64>, ImagingError> {
        let options = self.request.options;
        let ranges_m = self.request.ranges_m(|plane| *plane);
        let power = O::power(self.request);
        let mut reached = f64::INFINITY;
        // The first try leaves room; where the data need more, the error is halved until it holds.
        for attempt in 0..DIRECT_ATTEMPTS {
            let accuracy = options.accuracy * 0.5f64.powi(attempt);
            let (pulses, plane) = (&self.request.echoes.pulses, self.request.grid.plane());
            let budget = Budget::new(pulses, plane, options.level, power.clone());
            let (spec, cost) = budget.direct(accuracy);
            if cost >= HOPELESS {
                break;
            }
            let carrier_rad_per_bin = spec.table.carrier_rad(pulses);
            self.working_bytes = O::direct_bytes(self.request, &spec, &ranges_m);
            self.check_memory::<O>()?;
            let engine = O::direct(self.request, &ranges_m, spec, self.control)?;
            let mut paths = None;
            let check = decided::<O>(self.request, |pixels| {
                let (check, found) = O::check_direct(self.request, &engine, pixels, self.control)?;
                paths = found;
                Ok(check)
            })?;
            reached = reached.min(check.error);
            self.decide(Decision::Direct(DirectChoice {
                level: options.level,
                bin_m: spec.table.bin_m,
                bins_per_period: spec.table.period,
                degree: spec.table.degree,
                carrier_rad_per_bin,
                group: spec.shape_on(self.request.grid.is_uneven()).group(),
                cubic: spec.cubic,
                cost,
                paths,
            }));
            self.decide_batches(O::direct_batches(&engine));
            if self.accepts::<O>(check) {
                return Ok(Ok(engine));
            }
        }
        Ok(Err(reached))
    }

    fn decide(&mut self, decision: Decision) {
        self.report.decisions.push(decision);
    }

    fn decide_batches(&mut self, batches: usize) {
        if batches > 1 {
            self.decide(Decision::Batches { batches });
        }
    }

    /// Keeps the result of a self-check, or rejects the engine and what it would have taken.
    fn accepts<O: Operator>(&mut self, check: SelfCheck) -> bool {
        let good = check.error_bound <= O::ACCEPTED_SHARE * self.request.options.accuracy;
        if good {
            self.report.self_check = Some(check);
        } else {
            self.working_bytes = 0;
            self.decide(Decision::Rejected { error: check.error });
        }
        good
    }

    fn check_memory<O: Operator>(&self) -> Result<(), ImagingError> {
        let bytes = self.working_bytes + O::output_bytes(self.request);
        let limit_bytes = self.request.options.memory_limit_bytes;
        if bytes > limit_bytes {
            return Err(ImagingError::TooLarge {
                what: O::MEMORY,
                bytes,
                limit_bytes,
            });
        }
        Ok(())
    }
}

fn factorized_choice(budget: &FactorizedBudget, level: SimdLevel) -> FactorizedChoice {
    FactorizedChoice {
        level,
        sub_aperture_pulses: budget.spec.pulses,
        coarse: budget.spec.coarse,
        bandwidth_per_m: budget.spec.bandwidth_per_m,
        interpolation_error: budget.spec.interpolation_error,
        bin_m: budget.inner.table.bin_m,
        degree: budget.inner.table.degree,
        cost: budget.spec.cost,
        direct_cost: budget.direct_cost,
    }
}

fn saturated(bytes: u128) -> u64 {
    u64::try_from(bytes).unwrap_or(u64::MAX)
}
