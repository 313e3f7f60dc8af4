//! Single-point positions in a street: reflected signals travel 20 to 60 m further than the line of sight.

use crate::synthetic::{BASE_ECEF_M, L1, Noise, Receiver, navigation, observe};
use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::{
    ObservationData, PositioningMode, PpkOptions, Solution, System, SystemSet, process,
};

const EPOCHS: usize = 240;

/// Single-point positions of a receiver at rest. A share of the signals of every epoch is reflected, at random;
/// at most `satellites` are received.
fn positions(reflected: f64, satellites: usize, options: &PpkOptions) -> Vec<Solution> {
    let navigation = navigation();
    let mut log = observe(
        &navigation,
        &Receiver {
            seed: 5,
            epochs: EPOCHS,
            interval_s: 30.0,
            position: &|_| BASE_ECEF_M,
            clock_s: &|_| 3e-4,
            noise_m: [0.003, 0.5],
            signals: &L1,
        },
    );
    let mut noise = Noise::new(9);
    for epoch in &mut log.epochs {
        while epoch.satellites.len() > satellites {
            let left_out = (noise.uniform() * epoch.satellites.len() as f64) as usize;
            epoch.satellites.remove(left_out);
        }
        for observation in &mut epoch.satellites {
            if noise.uniform() < reflected {
                let signal = observation.signals[0].as_mut().unwrap();
                *signal.pseudorange_m.as_mut().unwrap() += 20.0 + 40.0 * noise.uniform();
            }
        }
    }
    let options = options
        .clone()
        .with_mode(PositioningMode::Single)
        .with_systems(SystemSet::GPS.with(System::Galileo));
    process(&log, &ObservationData::default(), &navigation, &options)
        .unwrap()
        .epochs
}

/// Share of coordinates (east, north, up) within two deviations of the truth, median distance from the truth and
/// median deviation in space (m).
fn accuracy(positions: &[Solution]) -> (f64, f64, f64) {
    let frame = EnuFrame::from_ecef(BASE_ECEF_M);
    let mut within = 0;
    let (mut distances_m, mut sigmas_m) = (Vec::new(), Vec::new());
    for position in positions {
        let error_m = frame.enu_from_ecef(position.position_ecef_m);
        let covariance_m2 = frame.enu_covariance_from_ecef(&position.covariance_ecef_m2);
        let variances_m2 = [0, 1, 2].map(|k| covariance_m2[k][k]);
        let pairs = error_m.iter().zip(&variances_m2);
        within += pairs.filter(|(e, v)| **e * **e < 4.0 * **v).count();
        distances_m.push(error_m.iter().map(|e| e * e).sum::<f64>().sqrt());
        sigmas_m.push(variances_m2.iter().sum::<f64>().sqrt());
    }
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    (
        within as f64 / (3 * positions.len()) as f64,
        median(&mut distances_m),
        median(&mut sigmas_m),
    )
}

/// Of the formal covariances 23 to 41 % of the coordinates lie within two deviations where 40 % of the signals and more are
/// reflected.
#[test]
fn deviations_hold_where_many_signals_are_reflected() {
    let guarded = PpkOptions::default();
    for (reflected, satellites, least_within) in [
        (0.0, 8, 0.99),
        (0.0, 12, 0.99),
        (0.1, 12, 0.9),
        (0.1, 20, 0.9),
        (0.2, 20, 0.85),
        (0.4, 12, 0.8),
        (0.4, 20, 0.8),
        (0.6, 12, 0.75),
        (0.6, 20, 0.8),
    ] {
        let found = positions(reflected, satellites, &guarded);
        let (within, distance_m, sigma_m) = accuracy(&found);
        println!(
            "{satellites:2} satellites, {:3.0} % reflected: {} positions, {:.0} % of coordinates within two deviations, \
             median error {distance_m:.1} m, deviation {sigma_m:.1} m",
            100.0 * reflected,
            found.len(),
            100.0 * within
        );
        assert!(found.len() > EPOCHS * 9 / 10, "{}", found.len());
        assert!(within > least_within, "{within}");
        assert!(sigma_m > 0.5 * distance_m);
    }
}

#[test]
fn a_few_reflected_signals_among_many_hardly_change_deviations() {
    let guarded = PpkOptions::default();
    let (_, _, clean_m) = accuracy(&positions(0.0, 20, &guarded));
    let (within, distance_m, sigma_m) = accuracy(&positions(0.05, 20, &guarded));
    assert!(within > 0.95 && distance_m < 3.0 && sigma_m < 1.5 * clean_m);
}
