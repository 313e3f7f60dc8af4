//! The sky of a log whose directions and signal strengths are known.

use crate::synthetic::{BASE_ECEF_M, L1, base, flight, navigation, rover, start};
use acerra_gnss::{BasePosition, PpkOptions, System, SystemSet, process, sky};

/// The emulated signal strength is a function of the elevation, and a position's residuals have both angles.
#[test]
fn directions_are_those_of_positions_and_strengths_those_of_the_log() {
    let navigation = navigation();
    let (rover, base) = (rover(&navigation, 30, &L1), base(&navigation, 30, &L1));
    let satellites = sky(&rover, &navigation, flight(0.0), 1.0);
    assert!(satellites.len() >= 12, "{}", satellites.len());
    assert!(satellites.is_sorted_by_key(|one| one.satellite));
    let samples = satellites.iter().flat_map(|one| &one.samples);
    for sample in samples {
        let [_, elevation_rad] = sample.azimuth_elevation_rad.unwrap();
        let expected_db_hz = 35.0 + 13.0 * elevation_rad.sin();
        let found_db_hz = sample.cn0_db_hz[0].unwrap();
        assert!(
            (found_db_hz - expected_db_hz).abs() < 1e-3,
            "{found_db_hz} {expected_db_hz}"
        );
    }
    let options = PpkOptions::default()
        .with_systems(SystemSet::GPS.with(System::Galileo))
        .with_base_position(BasePosition::Ecef(BASE_ECEF_M));
    let solution = process(&rover, &base, &navigation, &options).unwrap();
    let mut compared = 0;
    for epoch in &solution.epochs {
        for residual in epoch.residuals.iter().filter(|r| r.slot == 0) {
            let own = satellites
                .iter()
                .find(|s| s.satellite == residual.satellite);
            let samples = &own.unwrap().samples;
            let sample = samples
                .iter()
                .find(|s| (s.time - epoch.time).abs() < 0.02)
                .unwrap();
            let [azimuth_rad, elevation_rad] = sample.azimuth_elevation_rad.unwrap();
            assert!((azimuth_rad - residual.azimuth_rad).abs() < 2e-5);
            assert!((elevation_rad - residual.elevation_rad).abs() < 2e-5);
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared}");
}

#[test]
fn epochs_are_thinned_and_satellites_without_ephemeris_keep_their_strength() {
    let mut navigation = navigation();
    let log = rover(&navigation, 30, &L1);
    let every = sky(&log, &navigation, flight(0.0), 0.0);
    let tenth = sky(&log, &navigation, flight(0.0), 10.0);
    let of = |list: &[acerra_gnss::SatelliteInSky], k: usize| list[k].samples.clone();
    let times = of(&tenth, 0).into_iter().map(|s| s.time - start());
    let times: Vec<f64> = times.map(|s| s.round()).collect();
    assert!(of(&every, 0).len() > 2 * times.len());
    assert!(times.windows(2).all(|w| w[1] - w[0] >= 10.0), "{times:?}");
    let lost = every[0].satellite;
    navigation.ephemerides.retain(|e| e.satellite() != lost);
    let without = sky(&log, &navigation, flight(0.0), 0.0);
    assert_eq!(without.len(), every.len());
    for (one, other) in of(&without, 0).iter().zip(of(&every, 0)) {
        assert_eq!(one.azimuth_elevation_rad, None);
        assert_eq!(one.cn0_db_hz, other.cn0_db_hz);
    }
}
