//! The positioning of a rover's log against a base's.

use crate::control::{Control, Watch};
use crate::engine::{
    Calibration, Constellation, Epoch, EpochResult, GlonassPlan, MeasuredNoise, Prepared, RoverEpoch,
    SingleContext, base_gaps, base_position, combine, epochs, missing_navigation,
    phases_and_copies, reject_implausible,
};
use crate::events::interpolate_events;
use crate::navigation::{Klobuchar, Navigation};
use crate::observation::{EPOCH_TOLERANCE_S, ObservationData};
use crate::options::{FilterDirection, PositioningMode, PpkOptions};
use crate::ppk_error::{PpkError, TimeSpan};
use crate::signal::FREQUENCY_SLOTS;
use crate::solution::{
    LostEpoch, NotFixedReason, PpkSolution, PpkSummary, PpkWarning, Quality, Solution,
};
use acerra_geo::time::GpsTime;
use std::collections::BTreeMap;

/// Positions of `rover` (against `base`, except in single-point mode) for every epoch.
///
/// Logs need not be sorted; epochs within 25 ms of another are taken for duplicates. The answer
/// is the same, bit for bit, for any number of threads.
///
/// # Errors
/// [`PpkError`] when nothing can be computed: no epochs, no overlap, no navigation data, an
/// impossible base position or option. Epochs that fail singly are listed in
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
/// What cannot be computed is said, not guessed (`examples/synthetic_flight.rs` positions a
/// self-made flight):
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

/// As [`process`], followed and stopped through `control`.
///
/// # Errors
/// Those of [`process`], and [`PpkError::Cancelled`].
pub fn process_with(
    rover: &ObservationData,
    base: &ObservationData,
    navigation: &Navigation,
    options: &PpkOptions,
    control: Control<'_>,
) -> Result<PpkSolution, PpkError> {
    check_options(options)?;
    let relative = options.mode != PositioningMode::Single;
    let span = |data: &ObservationData| -> Option<TimeSpan> {
        let times = || data.epochs.iter().map(|e| e.time);
        Some((times().min()?, times().max()?))
    };
    let whole_span = span(rover).ok_or(PpkError::NoRoverEpochs)?;
    let wanted = |tag: GpsTime| {
        let late_s = |t: GpsTime| tag.seconds_since(t);
        options
            .start
            .is_none_or(|t| late_s(t) >= -EPOCH_TOLERANCE_S)
            && options.end.is_none_or(|t| late_s(t) < EPOCH_TOLERANCE_S)
    };
    let times = || rover.epochs.iter().map(|e| e.time).filter(|t| wanted(*t));
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

    let mut warnings = Vec::new();
    let constellation = Constellation::new(rover, relative.then_some(base), navigation, options);
    if constellation.len() == 0 {
        return Err(PpkError::NoSatellites);
    }
    let klobuchar = navigation.klobuchar.filter(|k| !k.is_zero());
    if klobuchar.is_none() {
        warnings.push(PpkWarning::DefaultIonosphere);
    }
    let klobuchar = klobuchar.unwrap_or(Klobuchar::FALLBACK);
    let context = |is_base: bool| SingleContext {
        constellation: &constellation,
        klobuchar: &klobuchar,
        options,
        base: is_base,
    };
    let mut rover_measured = epochs(rover, &constellation);
    rover_measured.retain(|e| wanted(e.tag));
    let trial = usize::from(Prepared::needs_trial(options));
    let passes = 1 + usize::from(options.direction.is_combined()) + trial;
    let watch = Watch::new(control, rover_measured.len() * (1 + passes));
    let rover_epochs = rover_epochs(&context(false), rover_measured, options, &watch)?;
    let any_state = rover_epochs
        .iter()
        .any(|e| e.states.iter().any(Result::is_ok));
    if !any_state {
        let times = || navigation.ephemerides.iter().map(crate::Ephemeris::toe);
        return Err(PpkError::NoNavigation {
            observations: rover_span,
            navigation: times().min().zip(times().max()),
        });
    }
    missing_navigation(&constellation, &rover_epochs, &mut warnings);

    let base_context = context(true);
    let (base_epochs, base_position_ecef_m) = if relative {
        phases_and_copies(rover, base, options, &mut warnings);
        let base_epochs = epochs(base, &constellation);
        base_gaps(&base_epochs, &rover_epochs, options, &mut warnings);
        let position = base_position(&base_context, base, &base_epochs, options, &mut warnings)?;
        (base_epochs, position)
    } else {
        (Vec::new(), [0.0; 3])
    };
    let noise = if options.measure_code_noise && relative {
        MeasuredNoise::measure(&constellation, options, &rover_epochs, &base_epochs)
            .calibrated(Calibration::prior())
    } else {
        MeasuredNoise::model()
    };
    let mut prepared = Prepared {
        noise,
        constellation: &constellation,
        options,
        rover: rover_epochs,
        base: base_epochs,
        base_context,
        base_position_ecef_m,
    };
    let mut glonass = None;
    if Prepared::needs_trial(options) {
        let trial = prepared.trial(&watch)?;
        glonass = prepared.glonass_decision(&trial);
        if options.measure_code_noise {
            let c = Calibration::of(&trial);
            if std::env::var("DBG").is_ok() { eprintln!("CAL {c:?}"); }
            prepared.noise = prepared.noise.calibrated(c);
        }
    }
    let plan = glonass.map_or(GlonassPlan::Estimate, GlonassPlan::from);
    let results = run_passes(&prepared, plan, &watch)?;
    let mut solution = assemble(results, &prepared, warnings);
    solution.summary.glonass = glonass;
    solution.base_position_ecef_m = relative.then_some(base_position_ecef_m);
    solution.events = interpolate_events(&rover.events, &solution.epochs);
    Ok(solution)
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
    let positive = [
        ("phase_error_m", options.phase_error_m),
        ("initial_bias_cycles", options.initial_bias_cycles),
        ("hold_variance_cycles2", options.hold_variance_cycles2),
        ("doppler_error_hz", options.doppler_error_hz),
        ("code_phase_ratio", options.code_phase_ratio[0]),
    ];
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

fn threads(options: &PpkOptions) -> usize {
    match options.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        n => n,
    }
}

/// Satellite states and single-point positions of every rover epoch.
fn rover_epochs(
    context: &SingleContext<'_>,
    epochs: Vec<Epoch>,
    options: &PpkOptions,
    watch: &Watch<'_>,
) -> Result<Vec<RoverEpoch>, PpkError> {
    // Every epoch starts from the first position found, so that none depends on its neighbours.
    let start = epochs
        .iter()
        .find_map(|e| {
            let states = context.states(e, e.tag, false);
            context
                .solve(e, &states, [0.0; 3])
                .ok()
                .map(|s| s.position_ecef_m)
        })
        .unwrap_or([0.0; 3]);
    let one = |epoch: Epoch| {
        watch.one_more()?;
        let mut states = context.states(&epoch, epoch.tag, true);
        let single = context.solve(&epoch, &states, start);
        if let (Ok(single), false) = (&single, options.reproduce_defects) {
            let place_ecef_m = single.position_ecef_m;
            reject_implausible(context.constellation, &epoch, &mut states, place_ecef_m);
        }
        Ok(RoverEpoch {
            epoch,
            states,
            single,
        })
    };
    let threads = threads(options).max(1);
    if threads == 1 || epochs.len() < 2 * threads {
        return epochs.into_iter().map(one).collect();
    }
    let share = epochs.len().div_ceil(threads);
    let mut parts: Vec<Vec<Epoch>> = Vec::with_capacity(threads);
    let mut rest = epochs;
    while rest.len() > share {
        let tail = rest.split_off(share);
        parts.push(std::mem::replace(&mut rest, tail));
    }
    parts.push(rest);
    std::thread::scope(|scope| {
        let workers: Vec<_> = parts
            .into_iter()
            .map(|part| scope.spawn(move || part.into_iter().map(one).collect()))
            .collect();
        let parts: Result<Vec<Vec<_>>, _> = workers.into_iter().map(join).collect();
        Ok(parts?.into_iter().flatten().collect())
    })
}

/// The worker's result; a panic in it continues here.
fn join<T>(worker: std::thread::ScopedJoinHandle<'_, T>) -> T {
    worker
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

fn run_passes(
    prepared: &Prepared<'_>,
    plan: GlonassPlan,
    watch: &Watch<'_>,
) -> Result<Vec<EpochResult>, PpkError> {
    let options = prepared.options;
    let fresh = || prepared.filter().with_glonass(plan);
    let pass = |backward: bool| prepared.run(&mut fresh(), backward, watch);
    let merged = |forward, backward| combine(forward, backward, options);
    Ok(match options.direction {
        FilterDirection::Forward => pass(false)?,
        FilterDirection::Backward => {
            let mut results = pass(true)?;
            results.reverse();
            results
        }
        FilterDirection::Combined if threads(options) > 1 => {
            let (forward, backward) = std::thread::scope(|scope| {
                let worker = scope.spawn(|| pass(true));
                (pass(false), join(worker))
            });
            merged(forward?, backward?)
        }
        FilterDirection::Combined => merged(pass(false)?, pass(true)?),
        FilterDirection::CombinedWithoutReset => {
            let mut filter = fresh();
            let forward = prepared.run(&mut filter, false, watch)?;
            let backward = prepared.run(&mut filter, true, watch)?;
            merged(forward, backward)
        }
    })
}

fn assemble(
    results: Vec<EpochResult>,
    prepared: &Prepared<'_>,
    warnings: Vec<PpkWarning>,
) -> PpkSolution {
    let options = prepared.options;
    let mut lost: Vec<LostEpoch> = prepared
        .rover
        .iter()
        .filter_map(|e| match &e.single {
            Ok(_) => None,
            Err((reason, _)) => Some(LostEpoch {
                time: e.epoch.tag,
                reason: *reason,
            }),
        })
        .collect();
    let mut epochs = Vec::with_capacity(results.len());
    for r in results {
        let quality = match r.quality {
            Some(quality) => quality,
            None if options.mode == PositioningMode::Single || options.output_single => {
                Quality::Single
            }
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
        epochs.push(Solution {
            time: r.time,
            position_ecef_m: r.position_ecef_m,
            covariance_ecef_m2: r.covariance_ecef_m2,
            velocity_ecef_m_s: r.velocity.map(|(v, _)| v),
            quality,
            satellites: r.satellites,
            age_s: r.age_s,
            ratio: r.ratio,
            not_fixed: r.reason.filter(|_| quality != Quality::Fixed),
            residuals: r.residuals,
        });
    }
    lost.sort_by_key(|l| l.time);
    let summary = summarise(&epochs, &lost, prepared.rover.len(), warnings);
    PpkSolution {
        base_position_ecef_m: None,
        epochs,
        lost,
        events: Vec::new(),
        summary,
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
        warnings,
    }
}
