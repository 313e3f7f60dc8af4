//! One attempt at prepared logs with one set of options: trial pass, forward and backward pass.

use super::both_passes::Passes;
use super::diagnose::contradicting_groups;
use super::preparation::Preparation;
use crate::confirm::agreement::Witness;
use crate::control::watch::Watch;
use crate::control::workers::{join, threads};
use crate::filter::epoch_result::EpochResult;
use crate::filter::glonass::GlonassPlan;
use crate::measurements::signal_group::SignalGroup;
use crate::noise::calibration::Calibration;
use crate::noise::code_bias::LastingBiases;
use crate::noise::code_noise::MeasuredNoise;
use crate::noise::phase_walk::rise_per_s;
use crate::options::{AmbiguityMode, FilterDirection, PpkOptions};
use crate::passes::combine::combine;
use crate::passes::pass::{Prepared, Trial};
use crate::passes::time_correlation::error_correlation;
use crate::single::SingleContext;
use crate::solution::{
    ErrorCorrelation, GlonassDecision, LostEpoch, PpkError, PpkWarning, Quality,
};

/// Share of the epochs with phases below which fixing is poor.
const POOR_SHARE: f64 = 0.9;

/// The results of one set of options.
pub(crate) struct Attempt {
    pub results: Vec<EpochResult>,
    /// Epochs without a single-point position.
    pub lost: Vec<LostEpoch>,
    pub rover_epochs: usize,
    pub base_position_ecef_m: [f64; 3],
    /// Distance of the base position from the base's single-point position (m), where the latter exists.
    pub base_from_single_m: Option<f64>,
    pub glonass: Option<GlonassDecision>,
    pub warnings: Vec<PpkWarning>,
    /// The forward and the backward pass, each in order of processing, where the passes confirm each other.
    pub passes: Option<Passes>,
    /// Epochs at which fixes of passes in opposite directions agree.
    pub agreeing: usize,
    /// Correlation in time of the positions' errors, where there are enough fixes to measure it.
    pub error_correlation: Option<ErrorCorrelation>,
    /// Whether ambiguities are resolved.
    resolves: bool,
}

/// A trial pass's estimates of the signals.
struct Findings {
    noise: MeasuredNoise,
    left_out: Vec<SignalGroup>,
    glonass: Option<GlonassDecision>,
    /// The results of the trial pass, before any fix is confirmed.
    trial: Vec<EpochResult>,
}

impl Findings {
    /// Runs a trial pass.
    fn of(prepared: &Prepared<'_>, watch: &Watch<'_>) -> Result<Self, PpkError> {
        let Trial {
            results,
            unconfirmed,
            left_out,
        } = prepared.trial(watch)?;
        let glonass = prepared.glonass_decision(&results);
        let noise = if prepared.options.measure_code_noise {
            let misfits: Vec<_> = results.iter().map(EpochResult::misfit).collect();
            let fixes: Vec<_> = results
                .iter()
                .filter_map(EpochResult::fix_residuals)
                .collect();
            let codes: Vec<_> = results.iter().filter_map(EpochResult::fix_codes).collect();
            let lasting = LastingBiases::of(&codes, prepared.constellation, &prepared.noise);
            let ratio = lasting.ratio;
            let noise = prepared.noise.clone().with_lasting(lasting.variances);
            // An epoch in the middle has half of the log before it.
            let expected_share = noise.expected_share(prepared.rover.len() / 2);
            let calibration = Calibration::of(&misfits, rise_per_s(&fixes), ratio, expected_share);
            noise.calibrated(calibration)
        } else {
            prepared.noise.clone()
        };
        Ok(Self {
            noise,
            left_out,
            glonass,
            trial: unconfirmed,
        })
    }
}

impl Attempt {
    /// Epochs fixed, and epochs fixed or float.
    pub(crate) fn fixed(&self) -> [usize; 2] {
        let count = |q: Quality| self.results.iter().filter(|r| r.quality == Some(q)).count();
        let fixed = count(Quality::Fixed);
        [fixed, fixed + count(Quality::Float)]
    }

    /// Results whose fixes are confirmed by this attempt's passes and those of `others`.
    pub(crate) fn confirmed_by(mut self, options: &PpkOptions, others: &[&[Witness; 2]]) -> Self {
        if let Some(confirmed) = self.confirmed(options, others) {
            (self.results, self.agreeing) = confirmed;
        }
        self
    }

    /// The confirmed results, and the number of epochs at which the passes agree.
    fn confirmed(
        &self,
        options: &PpkOptions,
        others: &[&[Witness; 2]],
    ) -> Option<(Vec<EpochResult>, usize)> {
        let (needed, passes) = (options.min_success_rate?, self.passes.as_ref()?);
        let all = || std::iter::once(&passes.witnesses).chain(others.iter().copied());
        let forward: Vec<&Witness> = all().map(|w| &w[0]).collect();
        let backward: Vec<&Witness> = all().map(|w| &w[1]).collect();
        Some(passes.concluded(options, needed, [&forward, &backward]))
    }

    /// The results confirmed by the passes, and the correlation of their errors in time, computed in parallel
    /// where there are threads.
    fn concluded(mut self, options: &PpkOptions) -> Self {
        let correlation = || error_correlation(&self.passes.as_ref()?.forward);
        let (confirmed, found) = if threads(options) <= 1 {
            (self.confirmed(options, &[]), correlation())
        } else {
            std::thread::scope(|scope| {
                let worker = scope.spawn(correlation);
                (self.confirmed(options, &[]), join(worker))
            })
        };
        self.error_correlation = found;
        if let Some(confirmed) = confirmed {
            (self.results, self.agreeing) = confirmed;
        }
        self
    }

    /// Whether the share of fixed epochs among epochs with phases is below [`POOR_SHARE`].
    pub(crate) fn is_poor(&self) -> bool {
        let [fixed, of] = self.fixed();
        self.resolves && (fixed as f64) < POOR_SHARE * of as f64
    }

    /// Positions by `options`, which differ from those of the preparation at most in ambiguity resolution and
    /// noise model.
    pub(crate) fn new(
        preparation: &Preparation,
        options: &PpkOptions,
        watch: &Watch<'_>,
    ) -> Result<Self, PpkError> {
        Ok(Self::unconfirmed(preparation, options, watch)?.concluded(options))
    }

    /// The passes before confirmation, for other attempts to [confirm](Self::confirmed_by).
    pub(crate) fn unconfirmed(
        preparation: &Preparation,
        options: &PpkOptions,
        watch: &Watch<'_>,
    ) -> Result<Self, PpkError> {
        let mut warnings = preparation.warnings.clone();
        let trial_options = trial_options(options);
        let mut prepared = Prepared {
            constellation: &preparation.constellation,
            options,
            trial_options: &trial_options,
            rover: &preparation.rover,
            base: &preparation.base,
            base_zeros: &preparation.base_zeros,
            base_states: &preparation.base_states,
            base_track: preparation.base_track.as_deref(),
            base_context: SingleContext {
                constellation: &preparation.constellation,
                klobuchar: &preparation.klobuchar,
                options: &preparation.options,
                base: true,
            },
            base_position_ecef_m: preparation.base_place.position_ecef_m,
            noise: if options.measure_code_noise {
                preparation.noise.clone()
            } else {
                MeasuredNoise::model()
            },
            left_out: Vec::new(),
        };
        let (mut glonass, mut trial) = (None, Vec::new());
        if Prepared::needs_trial(options) {
            let found = Findings::of(&prepared, watch)?;
            contradicting_groups(prepared.rover, &found.left_out, &mut warnings);
            glonass = found.glonass;
            prepared.left_out = found.left_out;
            prepared.noise = found.noise;
            trial = found.trial;
        }
        let plan = glonass.map_or(GlonassPlan::Estimate, GlonassPlan::from);
        let (results, passes) = run_passes(&prepared, plan, trial, watch)?;
        let lost = prepared.rover.iter().filter_map(|e| match &e.single {
            Ok(_) => None,
            Err((reason, _)) => Some(LostEpoch {
                time: e.epoch.tag,
                reason: *reason,
            }),
        });
        Ok(Self {
            lost: lost.collect(),
            rover_epochs: prepared.rover.len(),
            results,
            base_position_ecef_m: prepared.base_position_ecef_m,
            base_from_single_m: preparation.base_place.from_single_m,
            glonass,
            warnings,
            passes,
            agreeing: 0,
            error_correlation: None,
            resolves: options.ambiguity != AmbiguityMode::Off,
        })
    }
}

/// Number of passes over all epochs in an attempt.
pub(crate) fn passes(options: &PpkOptions) -> usize {
    let both = options.direction.is_combined() || has_witness(options);
    1 + usize::from(both) + usize::from(Prepared::needs_trial(options))
}

/// Options of a trial pass: ambiguities are resolved even where the options do not require it, since only
/// fixes show the errors of codes.
fn trial_options(options: &PpkOptions) -> PpkOptions {
    match options.ambiguity {
        AmbiguityMode::Off => options.clone().with_ambiguity(AmbiguityMode::FixAndHold),
        _ => options.clone(),
    }
}

/// Whether a pass in the other direction can confirm the fixes of the requested pass; not where epochs are
/// resolved one by one, with equal results in both directions.
pub(crate) fn has_witness(options: &PpkOptions) -> bool {
    let with_memory = matches!(
        options.ambiguity,
        AmbiguityMode::Continuous | AmbiguityMode::FixAndHold
    );
    options.min_success_rate.is_some() && options.mode.uses_phases() && with_memory
}

fn run_passes(
    prepared: &Prepared<'_>,
    plan: GlonassPlan,
    trial: Vec<EpochResult>,
    watch: &Watch<'_>,
) -> Result<(Vec<EpochResult>, Option<Passes>), PpkError> {
    let options = prepared.options;
    let fresh = || prepared.filter().with_glonass(plan);
    let float_errors = prepared.float_errors();
    if has_witness(options) {
        let (forward, backward) = both_ways(options, |backward| {
            prepared.run(&mut fresh(), backward, watch)
        })?;
        return Ok((
            Vec::new(),
            Some(Passes::new(forward, backward, trial, float_errors)),
        ));
    }
    let pass = |backward: bool| prepared.run_alone(&mut fresh(), backward, watch);
    let results = match options.direction {
        FilterDirection::Forward => pass(false)?,
        FilterDirection::Backward => {
            let mut results = pass(true)?;
            results.reverse();
            results
        }
        FilterDirection::Combined => {
            let (forward, backward) = both_ways(options, pass)?;
            combine(forward, backward, options, &float_errors)
        }
        FilterDirection::CombinedWithoutReset => {
            let mut filter = fresh();
            let forward = prepared.run_alone(&mut filter, false, watch)?;
            let backward = prepared.run_alone(&mut filter, true, watch)?;
            combine(forward, backward, options, &float_errors)
        }
    };
    Ok((results, None))
}

type Pass = Result<Vec<EpochResult>, PpkError>;

/// The forward and the backward pass, in parallel where there are threads.
fn both_ways(
    options: &PpkOptions,
    pass: impl Fn(bool) -> Pass + Sync,
) -> Result<(Vec<EpochResult>, Vec<EpochResult>), PpkError> {
    if threads(options) <= 1 {
        return Ok((pass(false)?, pass(true)?));
    }
    let (forward, backward) = std::thread::scope(|scope| {
        let worker = scope.spawn(|| pass(true));
        (pass(false), join(worker))
    });
    Ok((forward?, backward?))
}
