//! The covariance function of a trajectory's errors, on flights whose truth is known.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod rtklib;

use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::{BasePosition, PpkOptions, PpkSolution, Quality, process};
use rtklib::motion::{Flight, add_motion};
use rtklib::position_file;
use rtklib::sets::{M8P_ROVER_ENU_M, STATIC_1HZ, STATIC_M8P, Set};

const M8P_BASE_ECEF_M: [f64; 3] = [3_774_093.713_5, -601_662.553_8, 5_089_328.137_0];

/// A flight's positions, and how far they are off.
struct Flown {
    solution: PpkSolution,
    /// Number of each fixed epoch and its error (ECEF, m).
    errors: Vec<(usize, [f64; 3])>,
}

/// A flight added to the logs of a receiver at `place_ecef_m`.
fn flown(set: &Set, base_ecef_m: [f64; 3], place_ecef_m: [f64; 3]) -> Option<Flown> {
    let logs = set.read()?;
    let epochs = &logs.rover.epochs;
    let start = epochs[0].time;
    let flight = Flight::new(epochs[epochs.len() - 1].time.seconds_since(start));
    let options = PpkOptions::default().with_base_position(BasePosition::Ecef(base_ecef_m));
    let moved = add_motion(
        &logs.rover,
        &logs.navigation,
        place_ecef_m,
        &options,
        &flight,
    );
    let solution = process(&moved, &logs.base, &logs.navigation, &options).unwrap();
    let frame = EnuFrame::from_ecef(place_ecef_m);
    let error = |(k, e): (usize, &acerra_gnss::Solution)| {
        let truth = frame.ecef_from_enu(flight.at(e.time.seconds_since(start)));
        let error_m = std::array::from_fn(|a| e.position_ecef_m[a] - truth[a]);
        (e.quality == Quality::Fixed).then_some((k, error_m))
    };
    let errors = solution
        .epochs
        .iter()
        .enumerate()
        .filter_map(error)
        .collect();
    Some(Flown { solution, errors })
}

/// Correlation of errors `lag` epochs apart: as they are, and as the covariance function says.
fn correlation(solution: &PpkSolution, errors: &[(usize, [f64; 3])], lag: usize) -> [f64; 2] {
    let known = solution.summary.error_correlation.as_ref().unwrap();
    let trace = |a: usize, b: usize| {
        let c = known.covariance_ecef_m2(&solution.epochs[a], &solution.epochs[b]);
        c[0][0] + c[1][1] + c[2][2]
    };
    let (mut found, mut stated) = ([0.0; 2], [0.0; 2]);
    for ((a, ea), (b, eb)) in errors.iter().zip(errors.iter().skip(lag)) {
        for k in 0..3 {
            found[0] += ea[k] * eb[k];
            found[1] += (ea[k].powi(2) + eb[k].powi(2)) / 2.0;
        }
        stated[0] += trace(*a, *b);
        stated[1] += (trace(*a, *a) + trace(*b, *b)) / 2.0;
    }
    [found[0] / found[1], stated[0] / stated[1]]
}

#[test]
fn errors_last_as_long_as_the_covariance_function_says() {
    let mosaic = |file| position_file(STATIC_1HZ.folder, file);
    let m8p_rover = EnuFrame::from_ecef(M8P_BASE_ECEF_M).ecef_from_enu(M8P_ROVER_ENU_M);
    let flights = [
        (&STATIC_M8P, flown(&STATIC_M8P, M8P_BASE_ECEF_M, m8p_rover)),
        (
            &STATIC_1HZ,
            rtklib::data(STATIC_1HZ.folder).and_then(|_| {
                let ends = [mosaic("base_position.txt"), mosaic("rover_position.txt")];
                flown(&STATIC_1HZ, ends[0], ends[1])
            }),
        ),
    ];
    for (set, flight) in flights {
        let Some(Flown { solution, errors }) = flight else {
            continue;
        };
        println!("{}: {:?}", set.name, solution.summary.error_correlation);
        assert!(solution.summary.error_correlation.is_some());
        for lag in [1, 3, 10, 30, 100] {
            let [found, stated] = correlation(&solution, &errors, lag);
            println!("{lag} epochs: found {found:.2}, stated {stated:.2}");
            assert!((found - stated).abs() < 0.2, "{lag}: {found} {stated}");
        }
    }
}
