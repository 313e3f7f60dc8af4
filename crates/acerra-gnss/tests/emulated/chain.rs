//! The whole chain on observations whose truth is known exactly.

use crate::synthetic;
use crate::synthetic::{BASE_ECEF_M, L1, L1_L2_L5, base, flight, navigation, rover, start};
use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::{
    AmbiguityMode, BasePosition, Dynamics, EventKind, EventRecord, FilterDirection, LossOfLock,
    Navigation, ObservationData, PositioningMode, PpkError, PpkOptions, PpkSolution, PpkWarning,
    Quality, System, SystemSet, process,
};

fn options() -> PpkOptions {
    PpkOptions::default()
        .with_systems(SystemSet::GPS.with(System::Galileo))
        .with_base_position(BasePosition::Ecef(BASE_ECEF_M))
}

/// Horizontal and vertical distance from the truth (m).
fn error(solution: &acerra_gnss::Solution) -> (f64, f64) {
    let truth = flight(solution.time.seconds_since(start()));
    let [e, n, u] = EnuFrame::from_ecef(truth).enu_from_ecef(solution.position_ecef_m);
    (e.hypot(n), u.abs())
}

fn assert_fixed_and_right(solution: &PpkSolution, least_fixed: usize, name: &str) {
    let fixed: Vec<_> = solution
        .epochs
        .iter()
        .filter(|e| e.quality == Quality::Fixed)
        .collect();
    assert!(
        fixed.len() >= least_fixed,
        "{name}: {} of {} fixed, {:?}",
        fixed.len(),
        solution.epochs.len(),
        solution.summary.not_fixed
    );
    for e in fixed {
        let (horizontal, vertical) = error(e);
        assert!(
            horizontal < 0.015 && vertical < 0.03,
            "{name}: {} off by {horizontal:.4} m horizontally, {vertical:.4} m vertically",
            e.time
        );
    }
}

/// Measurements count once however often an epoch's update is repeated.
#[test]
fn iterations_take_nothing_off_the_deviations() {
    let navigation = navigation();
    let (rover, base) = (rover(&navigation, 20, &L1), base(&navigation, 20, &L1));
    let run = |iterations: usize, mode: PositioningMode| {
        let options = PpkOptions::rtklib()
            .with_systems(SystemSet::GPS.with(System::Galileo))
            .with_base_position(BasePosition::Ecef(BASE_ECEF_M))
            .with_ambiguity(AmbiguityMode::Off)
            .with_mode(mode)
            .with_iterations(iterations);
        process(&rover, &base, &navigation, &options).unwrap()
    };
    for mode in [PositioningMode::Kinematic, PositioningMode::Dgps] {
        let (once, thrice) = (run(1, mode), run(3, mode));
        assert_eq!(once.epochs.len(), 20);
        for (a, b) in once.epochs.iter().zip(&thrice.epochs) {
            for k in 0..3 {
                let ratio = b.covariance_ecef_m2[k][k] / a.covariance_ecef_m2[k][k];
                assert!((ratio - 1.0).abs() < 1e-3, "{mode}: {ratio}");
                let moved_m = b.position_ecef_m[k] - a.position_ecef_m[k];
                assert!(moved_m.abs() < 1e-3, "{mode}: {moved_m} m");
            }
        }
    }
}

#[test]
fn every_mode_finds_the_integers() {
    let navigation = navigation();
    let (rover, base) = (rover(&navigation, 90, &L1), base(&navigation, 90, &L1));
    let run = |o: &PpkOptions| process(&rover, &base, &navigation, o).unwrap();
    for (direction, least) in [
        (FilterDirection::Forward, 80),
        (FilterDirection::Backward, 80),
        (FilterDirection::Combined, 89),
        (FilterDirection::CombinedWithoutReset, 89),
    ] {
        let o = options().with_direction(direction);
        assert_fixed_and_right(&run(&o), least, &format!("{direction:?}"));
    }
    for ambiguity in [AmbiguityMode::Continuous, AmbiguityMode::FixAndHold] {
        for systems in [SystemSet::GPS, options().systems] {
            let direction = FilterDirection::Forward;
            let o = options()
                .with_ambiguity(ambiguity)
                .with_systems(systems)
                .with_direction(direction);
            assert_fixed_and_right(&run(&o), 70, &format!("{ambiguity:?} {systems:?}"));
        }
    }
    let instantaneous = options().with_ambiguity(AmbiguityMode::Instantaneous);
    assert_fixed_and_right(&run(&instantaneous), 70, "instantaneous");
    let dynamics = Some(Dynamics {
        horizontal_noise: 3.0,
        vertical_noise: 3.0,
    });
    assert_fixed_and_right(&run(&options().with_dynamics(dynamics)), 80, "dynamics");
    let demo5 = PpkOptions::demo5()
        .with_systems(options().systems)
        .with_base_position(options().base_position)
        .with_direction(FilterDirection::Combined)
        .with_dynamics(dynamics);
    assert_fixed_and_right(&run(&demo5), 80, "demo5");
}

/// A guarded run says that the backward pass does not go on from the forward pass's integers, as it was told to.
#[test]
fn passes_that_start_anew_against_the_settings_say_so() {
    let navigation = navigation();
    let (rover, base) = (rover(&navigation, 30, &L1), base(&navigation, 30, &L1));
    let says = |o: &PpkOptions| {
        let solution = process(&rover, &base, &navigation, o).unwrap();
        let told = &solution.summary.warnings;
        told.contains(&PpkWarning::PassesStartAnew)
    };
    let told = options().with_direction(FilterDirection::CombinedWithoutReset);
    assert!(says(&told));
    assert!(!says(
        &told.clone().with_ambiguity(AmbiguityMode::Instantaneous)
    ));
    assert!(!says(&told.with_direction(FilterDirection::Combined)));
}

#[test]
fn more_frequencies_fix_at_once() {
    let navigation = navigation();
    let (rover, base) = (
        rover(&navigation, 20, &L1_L2_L5),
        base(&navigation, 20, &L1_L2_L5),
    );
    for frequencies in [2, 3] {
        for rules in [PpkOptions::rtklib(), options()] {
            let o = rules
                .with_frequencies(frequencies)
                .with_direction(FilterDirection::Forward)
                .with_systems(options().systems)
                .with_base_position(options().base_position);
            let solution = process(&rover, &base, &navigation, &o).unwrap();
            assert_fixed_and_right(&solution, 20, &format!("{frequencies} frequencies"));
        }
    }
}

#[test]
fn coarser_modes_are_as_good_as_their_codes() {
    let navigation = navigation();
    let (rover, base) = (rover(&navigation, 30, &L1), base(&navigation, 30, &L1));
    for (mode, quality, limit_m) in [
        (PositioningMode::Single, Quality::Single, 4.0),
        (PositioningMode::Dgps, Quality::Dgps, 2.5),
    ] {
        let o = options().with_mode(mode);
        let solution = process(&rover, &base, &navigation, &o).unwrap();
        assert_eq!(solution.epochs.len(), 30);
        for e in &solution.epochs {
            assert_eq!(e.quality, quality);
            let (horizontal, vertical) = error(e);
            assert!(
                horizontal < limit_m && vertical < 2.0 * limit_m,
                "{horizontal} {vertical}"
            );
        }
    }
    let float = options().with_ambiguity(AmbiguityMode::Off);
    let solution = process(&rover, &base, &navigation, &float).unwrap();
    assert!(solution.epochs.iter().all(|e| e.quality == Quality::Float));
    assert!(solution.epochs.iter().all(|e| error(e).0 < 1.0));
}

#[test]
fn a_static_rover_converges() {
    let navigation = navigation();
    let rover = base(&navigation, 60, &L1);
    let mut moved = synthetic::observe(
        &navigation,
        &synthetic::Receiver {
            seed: 5,
            epochs: 60,
            interval_s: 1.0,
            position: &|_| flight(0.0),
            clock_s: &|_| 1e-5,
            noise_m: [0.001, 0.25],
            signals: &L1,
        },
    );
    moved.events.clear();
    let o = options()
        .with_mode(PositioningMode::Static)
        .with_direction(FilterDirection::Forward);
    let solution = process(&moved, &rover, &navigation, &o).unwrap();
    let last = solution.epochs.last().unwrap();
    assert_eq!(last.quality, Quality::Fixed);
    let truth = flight(0.0);
    for (found, true_value) in last.position_ecef_m.into_iter().zip(truth) {
        assert!((found - true_value).abs() < 0.004);
    }
}

#[test]
fn one_thread_or_two_give_the_same_bits() {
    let navigation = navigation();
    let (rover, base) = (rover(&navigation, 40, &L1), base(&navigation, 40, &L1));
    let run = |threads| {
        let o = options().with_threads(threads);
        process(&rover, &base, &navigation, &o).unwrap()
    };
    let (one, two, five) = (run(1), run(2), run(5));
    assert_eq!(one, two);
    assert_eq!(one, five);
}

/// Flags a slip and changes the integer of one satellite from epoch `from` on.
fn slip(data: &mut ObservationData, from: usize, satellite_index: usize, cycles: f64, flag: bool) {
    let id = data.epochs[from].satellites[satellite_index].satellite;
    for (k, epoch) in data.epochs.iter_mut().enumerate().skip(from) {
        for s in epoch.satellites.iter_mut().filter(|s| s.satellite == id) {
            let signal = s.signals[0].as_mut().unwrap();
            signal.phase_cycles = signal.phase_cycles.map(|p| p + cycles);
            if k == from && flag {
                signal.loss_of_lock = LossOfLock(LossOfLock::SLIP);
            }
        }
    }
}

#[test]
fn slips_do_not_move_fixed_positions() {
    let navigation = navigation();
    let base = base(&navigation, 90, &L1);
    let clean = rover(&navigation, 90, &L1);
    for direction in [
        FilterDirection::Forward,
        FilterDirection::Backward,
        FilterDirection::Combined,
    ] {
        let mut flagged = clean.clone();
        slip(&mut flagged, 40, 1, 17.0, true);
        slip(&mut flagged, 60, 3, -1.0, true);
        let o = options().with_direction(direction);
        let solution = process(&flagged, &base, &navigation, &o).unwrap();
        assert_fixed_and_right(&solution, 75, "flagged");
        // A slip that no flag announces must be noticed from the phases themselves.
        let mut silent = clean.clone();
        slip(&mut silent, 50, 2, 1.0, false);
        let solution = process(&silent, &base, &navigation, &o).unwrap();
        assert_fixed_and_right(&solution, 70, "silent");
    }
}

#[test]
fn a_time_window_is_kept_to() {
    let navigation = navigation();
    let (rover, base) = (rover(&navigation, 60, &L1), base(&navigation, 60, &L1));
    let window = |from_s: f64, to_s: f64| {
        options()
            .with_start(Some(start() + from_s))
            .with_end(Some(start() + to_s))
    };
    let solution = process(&rover, &base, &navigation, &window(10.0, 50.0)).unwrap();
    assert_eq!(solution.summary.rover_epochs, 41);
    assert_fixed_and_right(&solution, 39, "window");
    let seconds = |e: &acerra_gnss::Solution| e.time.seconds_since(start()).round();
    assert_eq!(seconds(&solution.epochs[0]), 10.0);
    assert_eq!(seconds(&solution.epochs[solution.epochs.len() - 1]), 50.0);
    let error = process(&rover, &base, &navigation, &window(70.0, 80.0)).unwrap_err();
    assert!(matches!(error, PpkError::NothingInWindow { .. }), "{error}");
}

#[test]
fn base_gaps_are_interpolated_not_extrapolated() {
    let navigation = navigation();
    let rover = rover(&navigation, 90, &L1);
    let mut base = base(&navigation, 90, &L1);
    base.epochs
        .retain(|e| !(41..60).contains(&(e.time.seconds_since(start()).round() as i64)));
    let solution = process(&rover, &base, &navigation, &options()).unwrap();
    assert_fixed_and_right(&solution, 85, "gap of 20 s");
    let short = options().with_max_age_s(5.0).with_interpolate_base(false);
    let solution = process(&rover, &base, &navigation, &short).unwrap();
    assert!(
        solution
            .summary
            .warnings
            .iter()
            .any(|w| matches!(w, PpkWarning::BaseGap(_))),
        "{:?}",
        solution.summary.warnings
    );
    assert!(
        solution
            .lost
            .iter()
            .all(|l| l.reason.key() == "no base data near enough")
    );
    assert_eq!(solution.lost.len() + solution.epochs.len(), 90);
}

#[test]
fn unresolved_half_cycles_are_not_fixed() {
    let navigation = navigation();
    let (mut rover, base) = (rover(&navigation, 30, &L1), base(&navigation, 30, &L1));
    for s in rover.epochs.iter_mut().flat_map(|e| &mut e.satellites) {
        let signal = s.signals[0].as_mut().unwrap();
        signal.loss_of_lock = LossOfLock(LossOfLock::HALF_CYCLE);
        signal.phase_cycles = signal.phase_cycles.map(|p| p + 0.5);
    }
    let solution = process(&rover, &base, &navigation, &options()).unwrap();
    assert_eq!(solution.summary.fixed, 0);
    assert!(
        solution
            .summary
            .warnings
            .iter()
            .any(|w| matches!(w, PpkWarning::NoUsablePhases { base: false }))
    );
}

#[test]
fn every_event_gets_a_position() {
    let navigation = navigation();
    let (mut rover, base) = (rover(&navigation, 60, &L1), base(&navigation, 60, &L1));
    let times = [30.25, 30.5, 30.75, 41.9];
    rover.events = times
        .iter()
        .map(|&t| EventRecord {
            time: start() + t,
            kind: EventKind::FallingEdge,
            count: None,
            accuracy_s: None,
        })
        .collect();
    let solution = process(&rover, &base, &navigation, &options()).unwrap();
    assert_eq!(solution.events.len(), 4);
    for (event, t) in solution.events.iter().zip(times) {
        let found = event.position_ecef_m.unwrap();
        let truth = flight(t);
        let apart: f64 = (0..3)
            .map(|k| (found[k] - truth[k]).powi(2))
            .sum::<f64>()
            .sqrt();
        // The cubic through 1 s positions cannot follow the vibration (1 cm), only the path.
        assert!(apart < 0.08, "{t}: {apart}");
        assert_eq!(event.quality, Some(Quality::Fixed));
    }
}

#[test]
fn bad_input_is_named() {
    let navigation = navigation();
    let (rover, base) = (rover(&navigation, 10, &L1), base(&navigation, 10, &L1));
    let run = |r: &ObservationData, b: &ObservationData, n: &Navigation, o: &PpkOptions| {
        process(r, b, n, o)
    };
    let o = options();
    let empty = ObservationData::default();
    assert_eq!(
        run(&empty, &base, &navigation, &o),
        Err(PpkError::NoRoverEpochs)
    );
    assert_eq!(
        run(&rover, &empty, &navigation, &o),
        Err(PpkError::NoBaseEpochs)
    );
    let none = Navigation::default();
    assert!(matches!(
        run(&rover, &base, &none, &o),
        Err(PpkError::NoNavigation {
            navigation: None,
            ..
        })
    ));
    let mut old = navigation.clone();
    for e in &mut old.ephemerides {
        if let acerra_gnss::Ephemeris::Kepler(k) = e {
            k.toe = k.toe - 86_400.0;
            k.toc = k.toe;
        }
    }
    let error = run(&rover, &base, &old, &o).unwrap_err();
    assert!(error.to_string().contains("2026/11/19"), "{error}");
    let mut later = base.clone();
    for e in &mut later.epochs {
        e.time = e.time + 3_600.0;
    }
    assert!(matches!(
        run(&rover, &later, &navigation, &o),
        Err(PpkError::NoOverlap { .. })
    ));
    let zero = o.clone().with_base_position(BasePosition::Ecef([0.0; 3]));
    let error = run(&rover, &base, &navigation, &zero).unwrap_err();
    assert!(matches!(
        error,
        PpkError::BasePositionImplausible {
            own_single_ecef_m: Some(_),
            ..
        }
    ));
    assert!(
        error
            .to_string()
            .contains("positions, accurate to metres, is 40.649"),
        "{error}"
    );
    let header = o.clone().with_base_position(BasePosition::Header);
    let mut unplaced = base.clone();
    unplaced.station.position_ecef_m = None;
    assert!(matches!(
        run(&rover, &unplaced, &navigation, &header),
        Err(PpkError::BasePositionMissing {
            own_single_ecef_m: Some(_)
        })
    ));
    let absurd = o.clone().with_phase_error_m(f64::NAN);
    assert!(matches!(
        run(&rover, &base, &navigation, &absurd),
        Err(PpkError::Option { .. })
    ));
    let nobody = o.with_systems(SystemSet::GPS.without(System::Gps));
    assert_eq!(
        run(&rover, &base, &navigation, &nobody),
        Err(PpkError::NoSatellites)
    );
}

#[test]
fn damaged_logs_never_give_a_wrong_fix() {
    let navigation = navigation();
    let (mut rover, base) = (rover(&navigation, 60, &L1), base(&navigation, 60, &L1));
    // Absurd values, a duplicate epoch, interleaved order, a millisecond clock jump in the tags
    // and the measurements alike.
    let signal = |r: &mut ObservationData, epoch: usize, k: usize| {
        let s = &mut r.epochs[epoch].satellites[k].signals[0];
        *s.as_mut().unwrap()
    };
    let mut damaged = signal(&mut rover, 10, 0);
    damaged.pseudorange_m = Some(f64::INFINITY);
    rover.epochs[10].satellites[0].signals[0] = Some(damaged);
    let mut damaged = signal(&mut rover, 20, 1);
    damaged.pseudorange_m = damaged.pseudorange_m.map(|p| p + 5_000.0);
    rover.epochs[20].satellites[1].signals[0] = Some(damaged);
    let mut damaged = signal(&mut rover, 25, 1);
    damaged.phase_cycles = Some(1e9);
    rover.epochs[25].satellites[1].signals[0] = Some(damaged);
    let copy = rover.epochs[30].clone();
    rover.epochs.push(copy);
    rover.epochs.swap(5, 6);
    for e in rover
        .epochs
        .iter_mut()
        .filter(|e| e.time.seconds_since(start()) > 39.5)
    {
        e.time = e.time + 1e-3;
        for s in &mut e.satellites {
            let signal = s.signals[0].as_mut().unwrap();
            let shift_m = 1e-3 * acerra_gnss::SPEED_OF_LIGHT_M_S;
            let frequency = signal
                .code
                .carrier_frequency_hz(s.satellite.system(), None)
                .unwrap();
            signal.pseudorange_m = signal.pseudorange_m.map(|p| p + shift_m);
            signal.phase_cycles = signal.phase_cycles.map(|p| p + 1e-3 * frequency);
        }
    }
    let solution = process(&rover, &base, &navigation, &options()).unwrap();
    assert_eq!(solution.summary.rover_epochs, 60);
    assert_fixed_and_right(&solution, 50, "damaged");
}

#[test]
fn a_copy_of_the_base_and_a_missing_system_are_noticed() {
    let navigation = navigation();
    let base = base(&navigation, 20, &L1);
    let mut gps_only = navigation.clone();
    gps_only
        .ephemerides
        .retain(|e| e.satellite().system() == System::Gps);
    let solution = process(&base, &base, &gps_only, &options()).unwrap();
    let warnings = &solution.summary.warnings;
    assert!(warnings.contains(&PpkWarning::IdenticalFiles));
    assert!(warnings.contains(&PpkWarning::SystemWithoutNavigation(System::Galileo)));
    let doubtful = options().with_base_position(BasePosition::AverageSingle);
    let solution = process(&base, &base, &navigation, &doubtful).unwrap();
    let mean = solution.base_position_ecef_m.unwrap();
    assert!((0..3).all(|k| (mean[k] - BASE_ECEF_M[k]).abs() < 5.0));
}
