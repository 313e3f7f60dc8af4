//! Positions with precise orbits and with antenna calibrations, on observations whose truth is
//! known exactly.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use crate::synthetic::{BASE_ECEF_M, L1, base, flight, navigation, rover, start};
use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::antex::{AntennaCalibration, FrequencyCalibration};
use acerra_gnss::input::Limits;
use acerra_gnss::{
    BasePosition, Navigation, ObservationData, PpkError, PpkOptions, PpkSolution, Quality,
    SPEED_OF_LIGHT_M_S, System, SystemSet, azimuth_elevation_rad, line_of_sight, process,
    read_navigation,
};

fn options() -> PpkOptions {
    PpkOptions::default()
        .with_systems(SystemSet::GPS.with(System::Galileo))
        .with_base_position(BasePosition::Ecef(BASE_ECEF_M))
}

/// The constellation as an SP3-d file of positions five minutes apart.
fn sp3(navigation: &Navigation) -> String {
    let mut out = "#dP2026 11 21  0  0  0.00000000      25 ORBIT IGS20 FIT TEST\n\
                   %c M  cc GPS ccc cccc cccc cccc cccc ccccc ccccc ccccc ccccc\n"
        .to_owned();
    for k in -12..=12 {
        let t = start() + 300.0 * f64::from(k);
        let c = t.to_calendar();
        writeln!(
            out,
            "*  {} {:2} {:2} {:2} {:2} {:11.8}",
            c.year,
            c.month,
            c.day,
            c.hour,
            c.minute,
            c.second_f64()
        )
        .unwrap();
        for e in &navigation.ephemerides {
            let [x, y, z] = e.orbit_at(t).position_ecef_m.map(|m| m / 1e3);
            let clock_us = e.clock_without_relativity_s(t) * 1e6;
            let name = e.satellite();
            writeln!(out, "P{name}{x:14.6}{y:14.6}{z:14.6}{clock_us:14.6}").unwrap();
        }
    }
    out + "EOF\n"
}

#[test]
fn precise_orbits_lead_to_the_same_positions() {
    let broadcast = navigation();
    let (rover, base) = (rover(&broadcast, 60, &L1), base(&broadcast, 60, &L1));
    let by_broadcast = process(&rover, &base, &broadcast, &options()).unwrap();
    let text = sp3(&broadcast);
    let (precise, report) = read_navigation(text.as_bytes(), Limits::default()).unwrap();
    assert_eq!(report.dropped, []);
    // The products alone: no broadcast ephemeris.
    let by_products = process(&rover, &base, &precise, &options()).unwrap();
    assert_eq!(by_products.summary.fixed, by_broadcast.summary.fixed);
    assert!(by_products.summary.fixed >= 50);
    for (a, b) in by_products.epochs.iter().zip(&by_broadcast.epochs) {
        for (x, y) in a.position_ecef_m.iter().zip(b.position_ecef_m) {
            assert!((x - y).abs() < 1e-3, "{}: {x} {y}", a.time);
        }
    }
    // Products of another day hold the satellites, and no position at this time.
    let other_day = text.replace("*  2026 11 21", "*  2026 11 25");
    let (elsewhere, _) = read_navigation(other_day.as_bytes(), Limits::default()).unwrap();
    let answer = process(&rover, &base, &elsewhere, &options());
    assert!(
        matches!(answer, Err(PpkError::NoNavigation { .. })),
        "{answer:?}"
    );
    // Nor do broadcast ephemerides stand in for satellites that the products hold.
    let mut both = broadcast.clone();
    both.merge(elsewhere);
    let answer = process(&rover, &base, &both, &options());
    assert!(
        matches!(answer, Err(PpkError::NoNavigation { .. })),
        "{answer:?}"
    );
}

/// Ten centimetres high, a centimetre to the east, variations of up to 9 mm.
fn calibration() -> AntennaCalibration {
    let l1 = FrequencyCalibration {
        offset_enu_m: [0.01, 0.0, 0.1],
        zenith_rad: [0.0, 90f64.to_radians(), 30f64.to_radians()],
        variation_m: vec![0.0, 0.003, 0.006, 0.009],
        azimuth_variation_m: Vec::new(),
        azimuth_step_rad: 0.0,
    };
    AntennaCalibration {
        antenna: "MADE_UP         NONE".to_owned(),
        frequencies: BTreeMap::from([((System::Gps, 1), l1)]),
    }
}

/// The log of a base whose antenna has these phase centres.
fn with_antenna(
    mut log: ObservationData,
    navigation: &Navigation,
    antenna: &AntennaCalibration,
) -> ObservationData {
    let frame = EnuFrame::from_ecef(BASE_ECEF_M);
    for epoch in &mut log.epochs {
        for satellite in &mut epoch.satellites {
            let id = satellite.satellite;
            let of = navigation.ephemerides.iter().find(|e| e.satellite() == id);
            let place = of.unwrap().orbit_at(epoch.time - 0.07).position_ecef_m;
            let sight = line_of_sight(place, BASE_ECEF_M).unwrap();
            let (azimuth, elevation) = azimuth_elevation_rad(&frame, sight.unit_ecef);
            for signal in satellite.signals.iter_mut().flatten() {
                let at = antenna.of_signal(id.system(), signal.code).unwrap();
                let more_m = at.range_m(azimuth, elevation);
                let frequency = signal.code.carrier_frequency_hz(id.system(), None).unwrap();
                let cycles = more_m * frequency / SPEED_OF_LIGHT_M_S;
                signal.pseudorange_m = signal.pseudorange_m.map(|m| m + more_m);
                signal.phase_cycles = signal.phase_cycles.map(|c| c + cycles);
            }
        }
    }
    log
}

/// Mean error of the fixed positions: east, north, up (m).
fn bias(solution: &PpkSolution) -> [f64; 3] {
    let fixed: Vec<_> = solution
        .epochs
        .iter()
        .filter(|e| e.quality == Quality::Fixed)
        .collect();
    assert!(fixed.len() >= 50, "{:?}", solution.summary);
    let mut sum = [0.0; 3];
    for e in &fixed {
        let truth = flight(e.time.seconds_since(start()));
        let error = EnuFrame::from_ecef(truth).enu_from_ecef(e.position_ecef_m);
        for (sum, x) in sum.iter_mut().zip(error) {
            *sum += x / fixed.len() as f64;
        }
    }
    sum
}

#[test]
fn calibrations_of_base_and_rover_take_their_offsets_away() {
    let navigation = navigation();
    let antenna = Arc::new(calibration());
    let (rover, base) = (rover(&navigation, 60, &L1), base(&navigation, 60, &L1));
    let raised = with_antenna(base, &navigation, &antenna);
    let run = |options: &PpkOptions| process(&rover, &raised, &navigation, options).unwrap();
    // Unknown, the base's phase centre lowers the rover by as much as it is high.
    let [e, n, u] = bias(&run(&options()));
    assert!((e + 0.01).abs() < 0.005 && n.abs() < 0.005, "{e} {n}");
    assert!((-0.13..-0.07).contains(&u), "{u}");
    let known = options().with_base_calibration(Some(Arc::clone(&antenna)));
    let [e, n, u] = bias(&run(&known));
    assert!(
        e.abs() < 0.002 && n.abs() < 0.002 && u.abs() < 0.004,
        "{e} {n} {u}"
    );
    // The same antenna on both ends: what is known of both cancels on this short baseline, and the
    // rover, which has a point for an antenna, comes out ten centimetres too low.
    let [_, _, u] = bias(&run(&known.with_rover_calibration(Some(antenna))));
    assert!((-0.13..-0.07).contains(&u), "{u}");
}
