//! Positioning of a rover's log relative to a base's log.

use super::alternatives::better_of;
use super::attempt::{Attempt, has_witness, passes};
use super::preparation::{Inputs, Preparation, is_wanted};
use crate::control::watch::Watch;
use crate::filter::epoch_result::EpochResult;
use crate::observations::observation::ObservationData;
use crate::observations::signal::FREQUENCY_SLOTS;
use crate::options::{FilterDirection, PositioningMode, PpkOptions};
use crate::orbits::navigation::Navigation;
use crate::solution::{
    Baseline, LostEpoch, NotFixedReason, PpkError, PpkSolution, PpkSummary, PpkWarning, Quality,
    Solution, TimeSpan, interpolate_events,
};
use crate::stations::moving_base::MovedBase;
use acerra_control::Control;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Positions of `rover` (against `base`, except in single-point mode) for every epoch.
///
/// Logs need not be sorted; epochs within 25 ms of another count as duplicates. The answer is bitwise equal
/// for any number of threads.
///
/// # Errors
/// [`PpkError`] when nothing can be computed: no epochs, no overlap, no navigation data, an
/// impossible base position or option. Single epochs that fail are listed in
/// [`PpkSolution::lost`] with the reason.
///
/// ```no_run
/// use acerra_gnss::{PpkOptions, input::Limits, process, read_navigation, read_observations};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let open = |path| std::fs::File::open(path);
/// let (rover, _) = read_observations(open("rover.obs")?, Limits::default())?;
/// let (base, _) = read_observations(open("base.obs")?, Limits::default())?;
/// let (navigation, _) = read_navigation(open("base.nav")?, Limits::default())?;
/// let solution = process(&rover, &base, &navigation, &PpkOptions::default())?;
/// println!("{} of {} epochs fixed", solution.summary.fixed, solution.summary.rover_epochs);
/// # Ok(())
/// # }
/// ```
///
/// Positions that cannot be computed give an error, never a guess (`examples/synthetic_flight.rs` positions a
/// synthetic flight):
///
/// ```
/// use acerra_gnss::{Navigation, ObservationData, PpkError, PpkOptions, process};
/// let empty = ObservationData::default();
/// let answer = process(&empty, &empty, &Navigation::default(), &PpkOptions::default());
/// assert_eq!(answer, Err(PpkError::NoRoverEpochs));
/// ```
pub fn process(
    rover: &ObservationData,
    base: &ObservationData,
    navigation: &Navigation,
    options: &PpkOptions,
) -> Result<PpkSolution, PpkError> {
    process_with(rover, base, navigation, options, Control::default())
}

/// As [`process`], with progress and cancellation through `control`.
///
/// # Errors
/// Errors of [`process`], and [`PpkError::Cancelled`].
pub fn process_with(
    rover: &ObservationData,
    base: &ObservationData,
    navigation: &Navigation,
    options: &PpkOptions,
    control: Control<'_>,
) -> Result<PpkSolution, PpkError> {
    check_options(options)?;
    let dynamics_dropped =
        options.mode == PositioningMode::MovingBase && options.dynamics.is_some();
    let own;
    let options = match without_motion_model(options) {
        Some(changed) => {
            own = changed;
            &own
        }
        None => options,
    };
    let relative = options.mode != PositioningMode::Single;
    let span = |data: &ObservationData| -> Option<TimeSpan> {
        let times = || data.epochs.iter().map(|e| e.time);
        Some((times().min()?, times().max()?))
    };
    let whole_span = span(rover).ok_or(PpkError::NoRoverEpochs)?;
    let times = || {
        let tags = rover.epochs.iter().map(|e| e.time);
        tags.filter(|t| is_wanted(options, *t))
    };
    let rover_span: TimeSpan =
        times()
            .min()
            .zip(times().max())
            .ok_or(PpkError::NothingInWindow {
                rover: whole_span,
                start: options.start,
                end: options.end,
            })?;
    if relative {
        let base_span = span(base).ok_or(PpkError::NoBaseEpochs)?;
        let reach = options.max_age_s;
        if rover_span.0.seconds_since(base_span.1) > reach
            || base_span.0.seconds_since(rover_span.1) > reach
        {
            return Err(PpkError::NoOverlap {
                rover: rover_span,
                base: base_span,
            });
        }
    }

    let inputs = Inputs {
        rover,
        base,
        navigation,
        rover_span,
    };
    // The computation of single-point positions counts as one more pass.
    let watch = Watch::new(control, times().count() * (1 + passes(options)));
    let preparation = Preparation::new(&inputs, options, &watch)?;
    let mut attempt = Attempt::new(&preparation, options, &watch)?;
    if options.try_alternatives && attempt.is_poor() {
        attempt = better_of(attempt, &inputs, &preparation, control)?;
    }
    let base_from_single_m = attempt.base_from_single_m;
    let base_position_ecef_m = attempt.base_position_ecef_m;
    if dynamics_dropped {
        attempt.warnings.push(PpkWarning::DynamicsNotUsed);
    }
    if options.direction == FilterDirection::CombinedWithoutReset && has_witness(options) {
        attempt.warnings.push(PpkWarning::PassesStartAnew);
    }
    let mut solution = assemble(attempt, options);
    solution.summary.base_from_single_m = base_from_single_m;
    let has_fixed_base = relative && options.mode != PositioningMode::MovingBase;
    solution.base_position_ecef_m = has_fixed_base.then_some(base_position_ecef_m);
    solution.events = interpolate_events(&rover.events, &solution.epochs);
    Ok(solution)
}

/// Options without the motion model for a moving base: the model would start from the base's position by
/// codes, which jumps by metres, and the base's path between epochs is not straight.
fn without_motion_model(options: &PpkOptions) -> Option<PpkOptions> {
    (options.mode == PositioningMode::MovingBase).then(|| PpkOptions {
        dynamics: None,
        interpolate_base: false,
        ..options.clone()
    })
}

fn check_options(options: &PpkOptions) -> Result<(), PpkError> {
    let check = |ok: bool, name, expected, found: f64| {
        if ok {
            Ok(())
        } else {
            Err(PpkError::Option {
                name,
                expected,
                found,
            })
        }
    };
    check(
        (1..=FREQUENCY_SLOTS).contains(&options.frequencies),
        "frequencies",
        "1, 2 or 3",
        options.frequencies as f64,
    )?;
    check(
        options.elevation_mask_rad >= 0.0 && options.elevation_mask_rad < 1.57,
        "elevation_mask_rad",
        "0 to below π/2",
        options.elevation_mask_rad,
    )?;
    let mut positive = vec![
        ("phase_error_m", options.phase_error_m),
        ("initial_bias_cycles", options.initial_bias_cycles),
        ("single_point_sigma_m", options.single_point_sigma_m),
        ("hold_variance_cycles2", options.hold_variance_cycles2),
        ("doppler_error_hz", options.doppler_error_hz),
        ("code_phase_ratio", options.code_phase_ratio[0]),
    ];
    if let Some(known) = options.baseline_length {
        positive.extend([
            ("baseline_length.length_m", known.length_m),
            ("baseline_length.sigma_m", known.sigma_m),
        ]);
    }
    for (name, value) in positive {
        check(
            value.is_finite() && value > 0.0,
            name,
            "a positive number",
            value,
        )?;
    }
    let not_negative = [
        ("phase_error_elevation_m", options.phase_error_elevation_m),
        ("phase_error_baseline_m", options.phase_error_baseline_m),
        ("bias_noise_cycles", options.bias_noise_cycles),
        ("max_age_s", options.max_age_s),
        ("ratio_threshold", options.ratio_threshold),
        ("clock_stability", options.clock_stability),
    ];
    for (name, value) in not_negative {
        check(
            value.is_finite() && value >= 0.0,
            name,
            "zero or a positive number",
            value,
        )?;
    }
    Ok(())
}

fn assemble(attempt: Attempt, options: &PpkOptions) -> PpkSolution {
    let mut lost = attempt.lost;
    let mut epochs = Vec::with_capacity(attempt.results.len());
    // Without a vector a moving base has no attitude.
    let output_single = options.output_single && options.mode != PositioningMode::MovingBase;
    for r in attempt.results {
        let quality = match r.quality {
            Some(quality) => quality,
            None if options.mode == PositioningMode::Single || output_single => Quality::Single,
            None => {
                let reason = r
                    .reason
                    .unwrap_or(NotFixedReason::TooFewCommonSatellites { common: 0 });
                lost.push(LostEpoch {
                    time: r.tag,
                    reason,
                });
                continue;
            }
        };
        let baseline = r.base.map(|base| baseline(&r, base));
        let of_base_m2 = r.base.map_or([[0.0; 3]; 3], |b| b.covariance_ecef_m2);
        let relative_m2 = baseline.map_or(r.covariance_ecef_m2, |b| b.covariance_ecef_m2);
        epochs.push(Solution {
            time: r.time,
            position_ecef_m: r.position_ecef_m,
            covariance_ecef_m2: std::array::from_fn(|i| {
                std::array::from_fn(|j| relative_m2[i][j] + of_base_m2[i][j])
            }),
            baseline,
            velocity_ecef_m_s: r.velocity.map(|(v, _)| v),
            quality,
            satellites: r.satellites,
            age_s: r.age_s,
            ratio: r.ratio,
            not_fixed: r.reason.filter(|_| quality != Quality::Fixed),
            residuals: Arc::unwrap_or_clone(r.residuals),
        });
    }
    lost.sort_by_key(|l| l.time);
    let summary = PpkSummary {
        glonass: attempt.glonass,
        error_correlation: attempt.error_correlation,
        ..summarise(&epochs, &lost, attempt.rover_epochs, attempt.warnings)
    };
    PpkSolution {
        base_position_ecef_m: None,
        epochs,
        lost,
        events: Vec::new(),
        summary,
    }
}

/// The vector from a moving base, with the covariance that its motion between the epochs adds.
fn baseline(result: &EpochResult, base: MovedBase) -> Baseline {
    let vector_ecef_m =
        std::array::from_fn(|k| result.position_ecef_m[k] - base.position_ecef_m[k]);
    let length_m = vector_ecef_m
        .iter()
        .map(|v: &f64| v * v)
        .sum::<f64>()
        .sqrt();
    Baseline {
        base_position_ecef_m: base.position_ecef_m,
        vector_ecef_m,
        covariance_ecef_m2: base.of_baseline(&result.covariance_ecef_m2, length_m),
    }
}

fn summarise(
    epochs: &[Solution],
    lost: &[LostEpoch],
    rover_epochs: usize,
    warnings: Vec<PpkWarning>,
) -> PpkSummary {
    let count = |q: Quality| epochs.iter().filter(|e| e.quality == q).count();
    let (fixed, float) = (count(Quality::Fixed), count(Quality::Float));
    let mut reasons: BTreeMap<&'static str, usize> = BTreeMap::new();
    let given = epochs.iter().filter_map(|e| e.not_fixed.as_ref());
    for reason in given.chain(lost.iter().map(|l| &l.reason)) {
        *reasons.entry(reason.key()).or_default() += 1;
    }
    let mut not_fixed: Vec<(&'static str, usize)> = reasons.into_iter().collect();
    not_fixed.sort_by_key(|&(_, n)| std::cmp::Reverse(n));
    let relative: Vec<f64> = epochs
        .iter()
        .filter(|e| e.quality != Quality::Single)
        .map(|e| e.age_s)
        .collect();
    let age_s = (!relative.is_empty()).then(|| {
        let n = relative.len() as f64;
        [
            relative.iter().copied().fold(f64::INFINITY, f64::min),
            relative.iter().sum::<f64>() / n,
            relative.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        ]
    });
    PpkSummary {
        rover_epochs,
        fixed,
        float,
        other: epochs.len() - fixed - float,
        not_fixed,
        age_s,
        glonass: None,
        error_correlation: None,
        base_from_single_m: None,
        warnings,
    }
}
