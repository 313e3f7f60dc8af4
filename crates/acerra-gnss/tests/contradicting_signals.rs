//! A signal whose phases have constant biases is named and left float; the rest is fixed as if it
//! were not there.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod rtklib;

use acerra_gnss::{
    ObservationData, PpkOptions, PpkSolution, PpkWarning, Quality, SignalCode, System, process,
};
use rtklib::sets::{STATIC_1HZ, Set, WETTZELL};
use rtklib::{distance, enu, position_file};

/// Fractions of a cycle by which the phases of a broken signal are off, by satellite number.
fn bias_cycles(number: u8) -> f64 {
    (0.381 * f64::from(number)).fract()
}

fn break_signal(log: &mut ObservationData, system: System, slot: usize) {
    for s in log.epochs.iter_mut().flat_map(|e| &mut e.satellites) {
        if s.satellite.system() != system {
            continue;
        }
        if let Some(signal) = s.signals[slot].as_mut() {
            let biased = |phase| phase + bias_cycles(s.satellite.number());
            signal.phase_cycles = signal.phase_cycles.map(biased);
        }
    }
}

/// Fixed epochs, and those further than 5 cm from the truth.
fn fixed_and_wrong(solution: &PpkSolution, truth_enu_m: [f64; 3]) -> [usize; 2] {
    let base = solution.base_position_ecef_m.unwrap();
    let fixed = || {
        solution
            .epochs
            .iter()
            .filter(|e| e.quality == Quality::Fixed)
    };
    let wrong = fixed().filter(|e| distance(enu(base, e.position_ecef_m), truth_enu_m) > 0.05);
    [fixed().count(), wrong.count()]
}

fn named(solution: &PpkSolution) -> Vec<(System, Option<SignalCode>)> {
    let warnings = solution.summary.warnings.iter();
    warnings
        .filter_map(|w| match w {
            PpkWarning::SignalsContradict { system, signal } => Some((*system, *signal)),
            _ => None,
        })
        .collect()
}

fn check(set: &Set, truth_enu_m: [f64; 3], broken: &[(System, usize, SignalCode)]) {
    let logs = set.read().unwrap();
    let defaults = PpkOptions::default();
    let options = set
        .adapt(defaults.clone())
        .with_systems(defaults.systems)
        .with_glonass_ambiguity(defaults.glonass_ambiguity)
        .with_frequencies(2);
    let run =
        |rover: &ObservationData| process(rover, &logs.base, &logs.navigation, &options).unwrap();
    let sound = run(&logs.rover);
    assert!(named(&sound).is_empty(), "{:?}", named(&sound));
    let [fixed, wrong] = fixed_and_wrong(&sound, truth_enu_m);
    assert_eq!(wrong, 0);
    for &(system, slot, signal) in broken {
        let mut rover = logs.rover.clone();
        break_signal(&mut rover, system, slot);
        let solution = run(&rover);
        let [still_fixed, wrong] = fixed_and_wrong(&solution, truth_enu_m);
        println!(
            "{} {system} {signal}: {still_fixed} of {fixed} fixed, {wrong} wrong",
            set.name
        );
        assert_eq!(named(&solution), [(system, Some(signal))]);
        assert!(100 * still_fixed >= 99 * fixed, "{still_fixed} of {fixed}");
        assert_eq!(wrong, 0);
    }
}

#[test]
#[ignore = "several logs of five systems on two frequencies; cargo xtask validate, as CI does"]
fn validation_a_signal_that_contradicts_is_named_and_left_float() {
    if rtklib::data(STATIC_1HZ.folder).is_none() || rtklib::data(WETTZELL.folder).is_none() {
        return;
    }
    let base = position_file(STATIC_1HZ.folder, "base_position.txt");
    let mosaic = enu(base, position_file(STATIC_1HZ.folder, "rover_position.txt"));
    let b2i = (System::Beidou, 1, SignalCode::new(7, 'I'));
    let gps_l2 = (System::Gps, 1, SignalCode::new(2, 'W'));
    check(&STATIC_1HZ, mosaic, &[b2i, gps_l2]);
    let b1i = (System::Beidou, 0, SignalCode::new(2, 'I'));
    check(&WETTZELL, [-0.417_88, 1.535_23, 0.081_42], &[b1i]);
}
