//! Logs with hostile values, flags, clocks and orders of epochs: no panic, and never a wrong
//! position called fixed.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod synthetic;

use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::{
    BasePosition, FilterDirection, LossOfLock, Navigation, ObservationData, PpkError, PpkOptions,
    PpkSolution, Quality, SPEED_OF_LIGHT_M_S, SignalObservation, System, SystemSet, process,
};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngAlgorithm, RngSeed, TestRng, TestRunner};
use std::sync::LazyLock;
use synthetic::{BASE_ECEF_M, L1, flight, start};

const EPOCHS: usize = 12;
/// Faults at a time that no wrong fix may come of.
const SIMULTANEOUS: usize = 3;

static NAVIGATION: LazyLock<Navigation> = LazyLock::new(synthetic::navigation);
static ROVER: LazyLock<ObservationData> =
    LazyLock::new(|| synthetic::rover(&NAVIGATION, EPOCHS, &L1));
static BASE: LazyLock<ObservationData> =
    LazyLock::new(|| synthetic::base(&NAVIGATION, EPOCHS, &L1));

fn options() -> PpkOptions {
    PpkOptions::default()
        .with_systems(SystemSet::GPS.with(System::Galileo))
        .with_base_position(BasePosition::Ecef(BASE_ECEF_M))
        .with_threads(1)
}

/// Fixed positions further than 0.1 m horizontally or 0.2 m vertically from the truth.
fn wrong_fixes(solution: &PpkSolution) -> Vec<String> {
    solution
        .epochs
        .iter()
        .filter(|e| e.quality == Quality::Fixed)
        .filter_map(|e| {
            let truth = flight(e.time.seconds_since(start()));
            let [east, north, up] = EnuFrame::from_ecef(truth).enu_from_ecef(e.position_ecef_m);
            let (horizontal, vertical) = (east.hypot(north), up.abs());
            let right = horizontal < 0.1 && vertical < 0.2;
            (!right).then(|| {
                format!(
                    "{}: {horizontal:.2} m, {vertical:.2} m, {} satellites, ratio {:.1}",
                    e.time, e.satellites, e.ratio
                )
            })
        })
        .collect()
}

fn check(rover: &ObservationData, base: &ObservationData) -> Result<(), TestCaseError> {
    for direction in [FilterDirection::Forward, FilterDirection::Combined] {
        let o = options().with_direction(direction);
        if let Ok(solution) = process(rover, base, &NAVIGATION, &o) {
            let wrong = wrong_fixes(&solution);
            prop_assert!(wrong.is_empty(), "{direction:?} {wrong:#?}");
        }
    }
    Ok(())
}

/// One thing that a damaged receiver, cable or file does to a log.
#[derive(Debug, Clone)]
enum Damage {
    /// A measurement replaced: pseudorange, phase, Doppler or signal strength.
    Value {
        epoch: usize,
        satellite: usize,
        field: u8,
        value: f64,
    },
    /// A measurement moved by a length (pseudorange) or by cycles (phase), from an epoch on or
    /// at it alone, without a word.
    Offset {
        epoch: usize,
        satellite: usize,
        phase: bool,
        lasting: bool,
        amount: f64,
    },
    /// Loss-of-lock bits.
    Flags {
        epoch: usize,
        satellite: usize,
        bits: u8,
    },
    /// A satellite or measurement gone.
    Missing {
        epoch: usize,
        satellite: usize,
        phase_only: bool,
    },
    /// The receiver's clock steps from an epoch on; which of tag, code and phase follow.
    ClockStep {
        epoch: usize,
        milliseconds: i32,
        tag: bool,
        code: bool,
        phase: bool,
    },
    /// An epoch appears twice, the second time at another place of the file.
    Duplicate { epoch: usize, place: usize },
    /// The measurements of two epochs change places under their tags.
    SwapMeasurements { one: usize, other: usize },
    /// The file's order of epochs changes.
    SwapOrder { one: usize, other: usize },
    /// Tags run backwards from an epoch on.
    BackInTime { epoch: usize, by_s: i32 },
}

/// A log to damage: the base's or the rover's.
fn damage() -> impl Strategy<Value = (bool, Damage)> {
    let epoch = || 0..EPOCHS;
    let satellite = || 0usize..30;
    let value = prop_oneof![
        prop::num::f64::ANY,
        -1e3..1e3f64,
        1.9e7..2.9e7f64,
        -2e8..2e8f64
    ];
    let amount = prop_oneof![
        (-40..=40i32).prop_map(|n| f64::from(n) / 2.0),
        -0.5..0.5f64,
        -300.0..300.0f64,
        -1e6..1e6f64,
    ];
    let kind = prop_oneof![
        8 => (epoch(), satellite(), 0u8..4, value).prop_map(|(epoch, satellite, field, value)| {
            Damage::Value { epoch, satellite, field, value }
        }),
        8 => (epoch(), satellite(), any::<bool>(), any::<bool>(), amount).prop_map(
            |(epoch, satellite, phase, lasting, amount)| Damage::Offset {
                epoch, satellite, phase, lasting, amount,
            }
        ),
        3 => (epoch(), satellite(), any::<u8>())
            .prop_map(|(epoch, satellite, bits)| Damage::Flags { epoch, satellite, bits }),
        3 => (epoch(), satellite(), any::<bool>()).prop_map(|(epoch, satellite, phase_only)| {
            Damage::Missing { epoch, satellite, phase_only }
        }),
        // A step of milliseconds moves tag and code alike, of seconds anything. (A code that steps
        // by milliseconds against its tag says that it was taken at another instant, as some
        // receivers truly do: nothing in the log could contradict it.)
        1 => (epoch(), -3..=3i32, any::<bool>()).prop_map(|(epoch, milliseconds, phase)| {
            Damage::ClockStep { epoch, milliseconds, tag: true, code: true, phase }
        }),
        1 => (
            epoch(),
            prop_oneof![Just(1_000), Just(-1_000), -20_000..-500i32, 500..20_000i32],
            any::<bool>(),
            any::<bool>(),
            any::<bool>(),
        )
            .prop_map(|(epoch, milliseconds, tag, code, phase)| Damage::ClockStep {
                epoch, milliseconds, tag, code, phase,
            }),
        1 => (epoch(), epoch()).prop_map(|(epoch, place)| Damage::Duplicate { epoch, place }),
        1 => (epoch(), epoch()).prop_map(|(one, other)| Damage::SwapMeasurements { one, other }),
        1 => (epoch(), epoch()).prop_map(|(one, other)| Damage::SwapOrder { one, other }),
        1 => (epoch(), 1..100_000i32)
            .prop_map(|(epoch, by_s)| Damage::BackInTime { epoch, by_s }),
    ];
    (any::<bool>(), kind)
}

fn signal(
    log: &mut ObservationData,
    epoch: usize,
    satellite: usize,
) -> Option<&mut SignalObservation> {
    let epoch = log.epochs.get_mut(epoch)?;
    let n = epoch.satellites.len();
    epoch.satellites.get_mut(satellite % n.max(1))?.signals[0].as_mut()
}

/// Moves a satellite's codes or phases from an epoch on, or at it alone.
fn offset(
    log: &mut ObservationData,
    (epoch, satellite): (usize, usize),
    phase: bool,
    lasting: bool,
    amount: f64,
) {
    let n = log
        .epochs
        .get(epoch)
        .map_or(1, |e| e.satellites.len())
        .max(1);
    let id = log
        .epochs
        .get(epoch)
        .and_then(|e| e.satellites.get(satellite % n))
        .map(|s| s.satellite);
    let last = if lasting {
        log.epochs.len()
    } else {
        (epoch + 1).min(log.epochs.len())
    };
    for e in log.epochs.get_mut(epoch..last).into_iter().flatten() {
        for s in e.satellites.iter_mut().filter(|s| Some(s.satellite) == id) {
            for s in s.signals.iter_mut().flatten() {
                let field = if phase {
                    &mut s.phase_cycles
                } else {
                    &mut s.pseudorange_m
                };
                *field = field.map(|v| v + amount);
            }
        }
    }
}

/// Moves the receiver's clock from an epoch on.
fn step_clock(log: &mut ObservationData, epoch: usize, step_s: f64, [tag, code, phase]: [bool; 3]) {
    for e in log.epochs.iter_mut().skip(epoch) {
        if tag {
            e.time = e.time + step_s;
        }
        for s in &mut e.satellites {
            let system = s.satellite.system();
            for s in s.signals.iter_mut().flatten() {
                let frequency = s.code.carrier_frequency_hz(system, None).unwrap();
                if code {
                    s.pseudorange_m = s.pseudorange_m.map(|p| p + step_s * SPEED_OF_LIGHT_M_S);
                }
                if phase {
                    s.phase_cycles = s.phase_cycles.map(|p| p + step_s * frequency);
                }
            }
        }
    }
}

fn apply(log: &mut ObservationData, damage: &Damage) {
    match *damage {
        Damage::Value {
            epoch,
            satellite,
            field,
            value,
        } => {
            if let Some(s) = signal(log, epoch, satellite) {
                match field {
                    0 => s.pseudorange_m = Some(value),
                    1 => s.phase_cycles = Some(value),
                    2 => s.doppler_hz = Some(value),
                    _ => s.cn0_db_hz = Some(value),
                }
            }
        }
        Damage::Offset {
            epoch,
            satellite,
            phase,
            lasting,
            amount,
        } => {
            offset(log, (epoch, satellite), phase, lasting, amount);
        }
        Damage::Flags {
            epoch,
            satellite,
            bits,
        } => {
            if let Some(s) = signal(log, epoch, satellite) {
                s.loss_of_lock = LossOfLock(bits);
            }
        }
        Damage::Missing {
            epoch,
            satellite,
            phase_only,
        } => {
            if phase_only {
                if let Some(s) = signal(log, epoch, satellite) {
                    s.phase_cycles = None;
                }
            } else if let Some(e) = log.epochs.get_mut(epoch) {
                let n = e.satellites.len();
                if n > 0 {
                    e.satellites.remove(satellite % n);
                }
            }
        }
        Damage::ClockStep {
            epoch,
            milliseconds,
            tag,
            code,
            phase,
        } => {
            let step_s = f64::from(milliseconds) * 1e-3;
            step_clock(log, epoch, step_s, [tag, code, phase]);
        }
        Damage::Duplicate { epoch, place } => {
            if let Some(copy) = log.epochs.get(epoch).cloned() {
                log.epochs.insert(place.min(log.epochs.len()), copy);
            }
        }
        Damage::SwapMeasurements { one, other } => {
            let n = log.epochs.len();
            let (one, other) = (one % n, other % n);
            let held = std::mem::take(&mut log.epochs[one].satellites);
            log.epochs[one].satellites = std::mem::replace(&mut log.epochs[other].satellites, held);
            if one == other {
                log.epochs[one].satellites.clear();
            }
        }
        Damage::SwapOrder { one, other } => {
            let n = log.epochs.len();
            log.epochs.swap(one % n, other % n);
        }
        Damage::BackInTime { epoch, by_s } => {
            for e in log.epochs.iter_mut().skip(epoch) {
                e.time = e.time - f64::from(by_s);
            }
        }
    }
}

/// The same cases in every run; `PROPTEST_CASES` and `PROPTEST_RNG_SEED` look further.
fn config() -> ProptestConfig {
    let mut config = ProptestConfig::with_cases(64);
    if config.rng_seed == RngSeed::Random {
        config.rng_seed = RngSeed::Fixed(3);
    }
    config
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn damaged_logs_neither_panic_nor_become_wrong_fixes(
        damages in prop::collection::vec(damage(), 1..=SIMULTANEOUS),
    ) {
        let (mut rover, mut base) = (ROVER.clone(), BASE.clone());
        for (of_base, damage) in &damages {
            apply(if *of_base { &mut base } else { &mut rover }, damage);
        }
        check(&rover, &base)?;
    }

    #[test]
    fn hostile_values_neither_panic_nor_become_fixes(
        changes in prop::collection::vec(
            (0usize..12, 0usize..30, 0u8..6, prop::num::f64::ANY),
            1..40,
        ),
    ) {
        let (mut rover, mut base) = (ROVER.clone(), BASE.clone());
        for (epoch, satellite, field, value) in changes {
            let log = if field % 2 == 0 { &mut rover } else { &mut base };
            let satellites = &mut log.epochs[epoch].satellites;
            let n = satellites.len();
            let signal = satellites[satellite % n].signals[0].as_mut().unwrap();
            match field / 2 {
                0 => signal.pseudorange_m = Some(value),
                1 => signal.phase_cycles = Some(value),
                _ => signal.cn0_db_hz = Some(value),
            }
        }
        check(&rover, &base)?;
    }

    #[test]
    fn hostile_ephemerides_do_not_panic(
        values in prop::collection::vec(prop::num::f64::ANY, 8),
    ) {
        let mut navigation = NAVIGATION.clone();
        let (mut rover, mut base) = (ROVER.clone(), BASE.clone());
        rover.epochs.truncate(3);
        base.epochs.truncate(3);
        for (e, v) in navigation.ephemerides.iter_mut().step_by(3).zip(values.iter().cycle()) {
            if let acerra_gnss::Ephemeris::Kepler(k) = e {
                k.sqrt_semi_major_axis = *v;
                k.eccentricity = *v;
                k.clock[0] = *v;
            }
        }
        let _ = process(&rover, &base, &navigation, &options());
    }
}

/// The logs, of `cases` with so many faults each, in which a wrong position is called fixed.
fn wrong_logs(
    seed: u8,
    cases: usize,
    faults: std::ops::RangeInclusive<usize>,
) -> Vec<Vec<(bool, Damage)>> {
    let mut runner = TestRunner::new_with_rng(
        ProptestConfig::default(),
        TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]),
    );
    let damages = prop::collection::vec(damage(), faults);
    let drawn: Vec<Vec<(bool, Damage)>> = (0..cases)
        .map(|_| damages.new_tree(&mut runner).unwrap().current())
        .collect();
    let is_wrong = |damages: &&Vec<(bool, Damage)>| {
        let (mut rover, mut base) = (ROVER.clone(), BASE.clone());
        for (of_base, damage) in *damages {
            apply(if *of_base { &mut base } else { &mut rover }, damage);
        }
        check(&rover, &base).is_err()
    };
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let started: Vec<_> = drawn
            .chunks(cases.div_ceil(workers))
            .map(|share| scope.spawn(move || share.iter().filter(is_wrong).cloned().collect()))
            .collect();
        let found = started.into_iter().map(|worker| worker.join().unwrap());
        found.collect::<Vec<Vec<_>>>().concat()
    })
}

#[test]
#[ignore = "thousands of logs; cargo xtask validate, as CI does"]
fn validation_no_log_with_few_faults_has_a_wrong_fix() {
    const CASES: usize = 3_000;
    for seed in [1, 2, 3] {
        let wrong = wrong_logs(seed, CASES, 1..=SIMULTANEOUS);
        println!(
            "1 to 3 faults, seed {seed}: a wrong fix in {} of {CASES} logs",
            wrong.len()
        );
        assert!(wrong.is_empty(), "{wrong:#?}");
    }
}

/// Wrong fixes among logs with more faults than [`SIMULTANEOUS`]: how many, for the book.
#[test]
#[ignore = "counts; cargo xtask validate, as CI does"]
fn validation_the_rate_of_wrong_fixes_under_more_faults_is_low() {
    const CASES: usize = 1_000;
    let wrong = wrong_logs(7, CASES, SIMULTANEOUS + 1..=7).len();
    println!("4 to 7 faults: a wrong fix in {wrong} of {CASES} logs");
    assert!(wrong * 200 <= CASES, "{wrong} of {CASES}");
}

#[test]
fn a_base_of_another_day_is_refused() {
    for day in [-1.0, 1.0, 7.0] {
        let mut base = BASE.clone();
        for e in &mut base.epochs {
            e.time = e.time + day * 86_400.0;
        }
        assert!(matches!(
            process(&ROVER, &base, &NAVIGATION, &options()),
            Err(PpkError::NoOverlap { .. })
        ));
        // The same file dated wrongly: nothing that it says about the satellites fits.
        for (e, right) in base.epochs.iter_mut().zip(&BASE.epochs) {
            e.time = right.time + day * 60.0;
        }
        if let Ok(solution) = process(&ROVER, &base, &NAVIGATION, &options()) {
            assert!(wrong_fixes(&solution).is_empty());
        }
    }
}
