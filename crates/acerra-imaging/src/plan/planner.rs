//! The planner of both operators: chooses an engine, builds it, and proves its accuracy.

use super::arrangement::HOPELESS;
use super::budget::Budget;
use super::operator::{AT_ONCE, FAR, Operator, Segment, allowed_error, decided, margin};
use super::options::{Engine, SelfCheck};
use super::partitions::{Partition, mean_costs, partitions};
use super::report::{Decision, DirectChoice, PlanReport};
use super::request::{Propagation, Request};
use crate::engine::batches::Piece;
use crate::error::ImagingError;
use crate::kernel::level::SimdLevel;
use acerra_control::Control;

/// Share of a plan's error from which on that of a finer plan counts as no smaller.
const STALLED: f64 = 0.8;

/// Below this relative error single precision does not suffice and the reference itself is run.
pub(super) const SINGLE_PRECISION_FLOOR: f64 = 4e-6;
/// Plans of the direct engine that are tried.
const DIRECT_ATTEMPTS: usize = 6;

/// Room that the next plan leaves under the accuracy, and limits of its share of the last one's.
const NEXT_ROOM: f64 = 0.8;
const FINEST_NEXT: f64 = 1.0 / 16.0;
const COARSEST_NEXT: f64 = 0.75;

/// Vector operations of the direct engine that take as long as planning the factorized one takes longer:
/// its partition, coarse tables and self-check by patches.
const FEW_OPERATIONS: f64 = 5e7;

/// The engine of a plan.
#[derive(Debug)]
pub(crate) enum Method<D, F, T> {
    Direct(Box<D>),
    Factorized(Box<F>),
    Double(Box<T>),
    Reference,
}

/// The engine chosen and the report of its choice.
pub(crate) type Planned<O> = (MethodOf<O>, PlanReport);

/// The engine of an operator's plan.
type MethodOf<O> =
    Method<<O as Operator>::Direct, <O as Operator>::Factorized, <O as Operator>::Double>;

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
            is_uneven: request.grid.is_uneven(),
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
            Method::Double(_) => Engine::Double,
            Method::Reference => Engine::Reference,
        };
        Ok((method, planner.report))
    }

    fn choose<O: Operator>(&mut self) -> Result<MethodOf<O>, ImagingError> {
        let accuracy = self.request.options.accuracy;
        if self.request.options.engine == Engine::Reference {
            self.decide(Decision::ReferenceRequested);
            return Ok(Method::Reference);
        }
        if self.request.options.engine == Engine::Double {
            return self.choose_double::<O>();
        }
        let propagation = self.request.propagation();
        if propagation == Propagation::UnevenGround
            && O::LEVEL_GROUND
            && accuracy >= SINGLE_PRECISION_FLOOR
        {
            self.decide(Decision::UnevenRays);
            return match self.choose_direct::<O>()? {
                Ok(direct) => Ok(Method::Direct(Box::new(direct))),
                Err(_) => {
                    self.decide(Decision::RaysOfPixels);
                    self.choose_double::<O>()
                }
            };
        }
        if matches!(propagation, Propagation::Any | Propagation::UnevenGround)
            || (propagation == Propagation::LevelGround && !O::LEVEL_GROUND)
        {
            self.decide(Decision::RaysOfPixels);
            return self.choose_double::<O>();
        }
        if accuracy < SINGLE_PRECISION_FLOOR {
            self.decide(Decision::BelowSinglePrecision { accuracy });
            return self.choose_double::<O>();
        }
        if propagation == Propagation::LevelGround {
            self.decide(Decision::LevelGround);
        } else if let Some(factorized) = self.choose_factorized::<O>()? {
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
                return self.choose_double::<O>();
            }
        }
    }

    /// The engine in double precision, or the sum itself where there is none.
    fn choose_double<O: Operator>(&mut self) -> Result<MethodOf<O>, ImagingError> {
        let Some(found) = O::double(self.request, self.control)? else {
            self.decide(Decision::NoDoubleTables);
            return Ok(Method::Reference);
        };
        self.working_bytes = found.bytes;
        self.decide(Decision::Double(found.choice));
        self.report.self_check = Some(found.check);
        Ok(Method::Double(Box::new(found.engine)))
    }

    /// The factorized engine where it was requested or is sufficiently cheaper, and keeps the accuracy.
    fn choose_factorized<O: Operator>(&mut self) -> Result<Option<O::Factorized>, ImagingError> {
        let options = self.request.options;
        if !matches!(options.engine, Engine::Auto | Engine::Factorized) {
            return Ok(None);
        }
        if self.request.grid.is_uneven() && !O::UNEVEN {
            self.decide(Decision::UnevenGround);
            return Ok(None);
        }
        let power = O::power(self.request);
        if options.engine == Engine::Auto && !O::REPEATED {
            let direct_operations = self.direct_operations(&power);
            if direct_operations < FEW_OPERATIONS {
                self.decide(Decision::FewContributions { direct_operations });
                return Ok(None);
            }
        }
        let mut accuracy = self.request.aim * options.accuracy;
        for attempt in 0..O::FACTORIZED_ATTEMPTS {
            let found = partitions::<O>(self.request, accuracy, &power, self.control)?;
            let Some(partitions) = found else {
                if self.request.grid.is_uneven() {
                    self.decide(Decision::UnevenGround);
                }
                return Ok(None);
            };
            let [cost, direct_cost] = mean_costs(&partitions);
            if options.engine == Engine::Auto && !O::factorized_pays(cost, direct_cost) {
                self.decide(Decision::DirectIsCheaper {
                    factorized_cost: cost,
                    direct_cost,
                });
                return Ok(None);
            }
            // After a rejection the next plan takes its time as well, and may be rejected too.
            let saved_operations = (direct_cost - cost) * self.contributions_of_all();
            let plans = (1 + attempt) as f64;
            if options.engine == Engine::Auto
                && !O::REPEATED
                && attempt > 0
                && saved_operations < plans * FEW_OPERATIONS
            {
                self.decide(Decision::LittleSaved { saved_operations });
                return Ok(None);
            }
            let segment = |partition: &Partition| partition.segment(self.request);
            let pieces: Vec<Segment> = partitions.iter().map(segment).collect();
            self.working_bytes = O::factorized_bytes(self.request, &pieces)?;
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
            let engine = O::factorized(self.request, &pieces, self.control)?;
            let check = decided::<O>(self.request, FAR, |pixels| {
                O::check_factorized(self.request, &engine, pixels, self.control)
            })?;
            for partition in &partitions {
                self.decide(Decision::Factorized(partition.choice(options.level)));
            }
            self.decide_batches(O::factorized_batches(&engine));
            if self.accepts::<O>(check) {
                return Ok(Some(engine));
            }
            accuracy *= self.next_share::<O>(check);
        }
        Ok(None)
    }

    /// Vector operations that the direct engine takes for the image, or for all slices of a volume.
    fn direct_operations(&self, power: &[f64]) -> f64 {
        let (options, grid) = (&self.request.options, &self.request.grid);
        let pulses = &self.request.echoes.pulses;
        let budget = Budget::new(pulses, grid, options.level, power.to_vec());
        let (_, cost) = budget.direct(options.accuracy);
        cost * self.contributions_of_all()
    }

    /// Contributions to the image, or to all slices of a volume.
    fn contributions_of_all(&self) -> f64 {
        let images = self.request.slices.len().max(1);
        self.request.contributions() as f64 * images as f64
    }

    /// The direct engine, or the least error that it reached.
    fn choose_direct<O: Operator>(&mut self) -> Result<Result<O::Direct, f64>, ImagingError> {
        let options = self.request.options;
        let pulses = 0..self.request.echoes.len();
        let is_below_relief = self.request.propagation() == Propagation::UnevenGround;
        let ranges_m = match is_below_relief {
            true => self.request.optical_ranges_m(),
            false => self.request.ranges_m(pulses.clone(), |plane| *plane),
        };
        let power = O::power(self.request);
        let (mut reached, mut before) = (f64::INFINITY, f64::INFINITY);
        let mut accuracy = margin(self.request) * self.request.aim * options.accuracy;
        for _ in 0..DIRECT_ATTEMPTS {
            let (echoes, grid) = (&self.request.echoes.pulses, &self.request.grid);
            let budget = Budget::new(echoes, grid, options.level, power.clone());
            let (spec, cost) = budget.direct(accuracy);
            if cost >= HOPELESS {
                break;
            }
            let (mut spec, cost) = O::direct_spec(self.request, accuracy, (spec, cost));
            spec.is_below_relief = is_below_relief;
            if is_below_relief && !spec.windows {
                break;
            }
            let carrier_rad_per_bin = spec.table.carrier_rad(echoes);
            let piece = Piece {
                pulses: pulses.clone(),
                spec,
                ranges_m: ranges_m.clone(),
            };
            self.working_bytes = O::direct_bytes(self.request, &piece)?;
            self.check_memory::<O>()?;
            let engine = O::direct(self.request, piece, self.control)?;
            let mut paths = None;
            let check = decided::<O>(self.request, AT_ONCE, |pixels| {
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
                group: match spec.groups {
                    Some(groups) => groups.shape,
                    None => spec.shape_on(self.request.grid.is_uneven()).group(),
                },
                cubic: spec.cubic,
                cost,
                paths,
            }));
            self.decide_batches(O::direct_batches(&engine));
            if self.accepts::<O>(check) {
                return Ok(Ok(engine));
            }
            // Earlier rays that no crossing nearby leads to are missed by finer plans too.
            if is_below_relief && check.error > STALLED * before {
                break;
            }
            before = check.error;
            accuracy *= self.next_share::<O>(check);
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

    /// Keeps the result of a self-check, or rejects the engine and the memory that it would have used.
    fn accepts<O: Operator>(&mut self, check: SelfCheck) -> bool {
        let good = check.error_bound <= allowed_error::<O>(self.request);
        if good {
            self.report.self_check = Some(check);
        } else {
            self.working_bytes = 0;
            self.decide(Decision::Rejected { error: check.error });
        }
        good
    }

    /// Share of a rejected plan's accuracy that the next one aims at: as much finer as the error found was
    /// too large, with a little room, and within limits, since it is estimated from few pixels and not every error falls
    /// with the accuracy aimed at.
    fn next_share<O: Operator>(&self, check: SelfCheck) -> f64 {
        next_share(allowed_error::<O>(self.request), check)
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

/// That share where a check may find errors up to `allowed`.
pub(super) fn next_share(allowed: f64, check: SelfCheck) -> f64 {
    (NEXT_ROOM * allowed / check.error_bound).clamp(FINEST_NEXT, COARSEST_NEXT)
}

fn saturated(bytes: u128) -> u64 {
    u64::try_from(bytes).unwrap_or(u64::MAX)
}
