//! Two antennas on one vehicle: the vector between them, on observations whose truth is known.

use crate::synthetic::{BASE_ECEF_M, L1, Receiver, flight, navigation, observe, start};
use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::pos::{PosFormat, PosFrame, write_pos};
use acerra_gnss::{
    BaselineLength, Navigation, ObservationData, PositioningMode, PpkOptions, PpkSolution, Quality,
    Solution, System, SystemSet, process,
};

const EPOCHS: usize = 90;
const LENGTH_M: f64 = 1.2;

/// From the base's antenna to the rover's (east, north, up, m): the vehicle turns and rolls.
fn vector_enu_m(t_s: f64) -> [f64; 3] {
    let (heading, pitch) = (
        0.35 * t_s + 0.4 * (0.7 * t_s).sin(),
        0.2 * (0.5 * t_s).sin(),
    );
    let level = LENGTH_M * f64::cos(pitch);
    [
        level * heading.sin(),
        level * heading.cos(),
        LENGTH_M * pitch.sin(),
    ]
}

/// The rover's antenna (ECEF, m), away from the base's.
fn rover_place(t_s: f64) -> [f64; 3] {
    EnuFrame::from_ecef(flight(t_s)).ecef_from_enu(vector_enu_m(t_s))
}

/// Clocks of which one is 12 ms late: the vehicle moves by decimetres in between.
const CLOCKS_S: [f64; 2] = [3e-3, -9e-3];

/// A log of a receiver on the vehicle, with Doppler shifts.
fn log(
    navigation: &Navigation,
    seed: u64,
    place: &dyn Fn(f64) -> [f64; 3],
    clock_s: f64,
) -> ObservationData {
    let of = |epochs: usize, interval_s: f64, noise_m: [f64; 2]| {
        let receiver = Receiver {
            seed,
            epochs,
            interval_s,
            position: place,
            clock_s: &|_| clock_s,
            noise_m,
            signals: &L1,
        };
        observe(navigation, &receiver)
    };
    let mut log = of(EPOCHS, 1.0, [0.001, 0.25]);
    // The phases' rate, from the same phases fifty times a second and without noise.
    let fast = of(50 * EPOCHS + 2, 0.02, [0.0; 2]);
    let phase = |k: usize, satellite| {
        let own = fast.epochs[k].satellites.iter();
        let found = own.clone().find(|s| s.satellite == satellite)?;
        found.signals[0]?.phase_cycles
    };
    for (k, epoch) in log.epochs.iter_mut().enumerate() {
        let middle = (50 * k).max(1);
        for s in &mut epoch.satellites {
            let id = s.satellite;
            let both = phase(middle - 1, id).zip(phase(middle + 1, id));
            if let (Some(signal), Some((before, after))) = (&mut s.signals[0], both) {
                signal.doppler_hz = Some((before - after) / 0.04);
            }
        }
    }
    log
}

fn logs(navigation: &Navigation) -> [ObservationData; 2] {
    [
        log(navigation, 2, &rover_place, CLOCKS_S[0]),
        log(navigation, 1, &flight, CLOCKS_S[1]),
    ]
}

fn options() -> PpkOptions {
    PpkOptions::default()
        .with_systems(SystemSet::GPS.with(System::Galileo))
        .with_mode(PositioningMode::MovingBase)
}

/// Error of an epoch's vector (east, north, up, m).
fn error_enu_m(epoch: &Solution) -> [f64; 3] {
    let found = epoch.baseline.unwrap().enu_m();
    let truth = vector_enu_m(epoch.time.seconds_since(start()));
    std::array::from_fn(|k| found[k] - truth[k])
}

fn fixed(solution: &PpkSolution) -> Vec<&Solution> {
    let epochs = solution.epochs.iter();
    epochs.filter(|e| e.quality == Quality::Fixed).collect()
}

#[test]
fn the_vector_is_right_and_its_deviation_honest() {
    let navigation = navigation();
    let [rover, base] = logs(&navigation);
    let solution = process(&rover, &base, &navigation, &options()).unwrap();
    assert_eq!(solution.base_position_ecef_m, None);
    let fixes = fixed(&solution);
    assert!(fixes.len() >= EPOCHS - 5, "{:?}", solution.summary);
    let (mut within, mut headings) = (0, 0);
    for epoch in &fixes {
        let baseline = epoch.baseline.unwrap();
        let covariance = baseline.enu_covariance_m2();
        let error = error_enu_m(epoch);
        for k in 0..3 {
            let sigma_m = covariance[k][k].sqrt();
            assert!(error[k].abs() < 5.0 * sigma_m, "{}: {error:?}", epoch.time);
            within += usize::from(error[k].abs() < 2.0 * sigma_m);
        }
        // Centimetres of which the codes know nothing.
        assert!(error.iter().all(|e| e.abs() < 0.03), "{error:?}");
        assert!(covariance[2][2].sqrt() < 0.03);
        let attitude = baseline.attitude().unwrap();
        let [e, n, _] = vector_enu_m(epoch.time.seconds_since(start()));
        let turn = attitude.heading_rad - f64::atan2(e, n);
        let off =
            (turn + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        assert!(off.abs() < 5.0 * attitude.heading_sigma_rad, "{off}");
        headings += usize::from(off.abs() < 2.0 * attitude.heading_sigma_rad);
        // The place itself is no better than the base's codes, and says so.
        let sigma_m = epoch.covariance_ecef_m2[0][0].sqrt();
        assert!(sigma_m > 0.2, "{sigma_m}");
    }
    let share = |n: usize, of: usize| n as f64 / of as f64;
    assert!(share(within, 3 * fixes.len()) > 0.9, "{within}");
    assert!(share(headings, fixes.len()) > 0.85, "{headings}");
}

/// Twelve milliseconds at metres per second are decimetres: without Doppler shifts nobody knows
/// them, and the deviations say so.
#[test]
fn without_doppler_shifts_the_deviation_grows() {
    let navigation = navigation();
    let [rover, mut base] = logs(&navigation);
    for s in base.epochs.iter_mut().flat_map(|e| &mut e.satellites) {
        for signal in s.signals.iter_mut().flatten() {
            signal.doppler_hz = None;
        }
    }
    let solution = process(&rover, &base, &navigation, &options()).unwrap();
    let fixes = fixed(&solution);
    assert!(!fixes.is_empty());
    let mut largest_m = 0.0f64;
    for epoch in fixes {
        let sigma_m = epoch.baseline.unwrap().enu_covariance_m2()[0][0].sqrt();
        assert!(sigma_m > 0.1, "{sigma_m}");
        let error = error_enu_m(epoch);
        assert!(error.iter().all(|e| e.abs() < 3.0 * sigma_m), "{error:?}");
        largest_m = error.iter().fold(largest_m, |m, e| m.max(e.abs()));
    }
    assert!(largest_m > 0.03, "{largest_m}");
}

#[test]
fn a_known_length_is_used_and_one_that_is_wrong_contradicts() {
    let navigation = navigation();
    let [rover, base] = logs(&navigation);
    let of = |length_m: f64| {
        let known = BaselineLength {
            length_m,
            sigma_m: 0.005,
        };
        let options = options().with_baseline_length(Some(known));
        process(&rover, &base, &navigation, &options).unwrap()
    };
    let right = of(LENGTH_M);
    assert!(fixed(&right).len() >= EPOCHS - 5, "{:?}", right.summary);
    for epoch in fixed(&right) {
        assert!(error_enu_m(epoch).iter().all(|e| e.abs() < 0.03));
    }
    let wrong = of(LENGTH_M + 0.2);
    assert_eq!(fixed(&wrong).len(), 0);
    let reasons: Vec<&str> = wrong.summary.not_fixed.iter().map(|(r, _)| *r).collect();
    assert!(
        reasons.contains(&"baseline of another length"),
        "{reasons:?}"
    );
    let negative = BaselineLength {
        length_m: -1.0,
        sigma_m: 0.1,
    };
    let options = options().with_baseline_length(Some(negative));
    assert!(process(&rover, &base, &navigation, &options).is_err());
}

#[test]
fn the_baseline_is_what_a_solution_file_holds() {
    let navigation = navigation();
    let [rover, base] = logs(&navigation);
    let solution = process(&rover, &base, &navigation, &options()).unwrap();
    let text = |frame| {
        let mut out = Vec::new();
        let format = PosFormat {
            frame,
            ..PosFormat::default()
        };
        write_pos(&mut out, &solution, &options(), &[], &format).unwrap();
        String::from_utf8(out).unwrap()
    };
    let first = |text: &str| -> Vec<f64> {
        let line = text.lines().find(|l| !l.starts_with('%')).unwrap();
        let fields = line.split_whitespace().skip(2);
        fields.map(|f| f.parse().unwrap()).collect()
    };
    let baseline = text(PosFrame::EnuBaseline);
    assert!(baseline.contains("% pos mode  : Moving-Base\n"));
    assert!(!baseline.contains("ref pos"));
    let fields = first(&baseline);
    let expected = solution.epochs[0].baseline.unwrap().enu_m();
    for (field, expected) in fields.iter().zip(expected) {
        assert!((field - expected).abs() < 1e-4);
    }
    let mut attitudes = Vec::new();
    acerra_gnss::output::write_attitudes(&mut attitudes, &solution).unwrap();
    let attitudes = String::from_utf8(attitudes).unwrap();
    assert_eq!(attitudes.lines().count(), 1 + solution.epochs.len());
    let line = attitudes.lines().nth(1).unwrap();
    let values = line.split(',').skip(2).map(|v| v.parse().unwrap());
    let values: Vec<f64> = values.collect();
    let [e, n, _] = expected;
    let heading_deg = f64::atan2(e, n).to_degrees().rem_euclid(360.0);
    assert!((values[0] - heading_deg).abs() < 1e-3, "{line}");
    assert!((values[4] - LENGTH_M).abs() < 5.0 * values[5], "{line}");
    // The vector to centimetres, the place to decimetres at best.
    let place = first(&text(PosFrame::Ecef));
    assert!(fields[5] < 0.03 && place[5] > 0.2, "{fields:?} {place:?}");
    assert!((place[0] - BASE_ECEF_M[0]).abs() < 500.0);
}

#[test]
fn a_motion_model_is_said_not_to_be_used() {
    let navigation = navigation();
    let [rover, base] = logs(&navigation);
    let options = options().with_dynamics(Some(acerra_gnss::Dynamics::DRONE));
    let solution = process(&rover, &base, &navigation, &options).unwrap();
    let said: Vec<String> = solution
        .summary
        .warnings
        .iter()
        .map(ToString::to_string)
        .collect();
    assert!(said.iter().any(|w| w.contains("motion model")), "{said:?}");
    assert!(fixed(&solution).len() >= EPOCHS - 5);
}
