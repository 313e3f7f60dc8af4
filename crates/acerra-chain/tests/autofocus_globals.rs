//! A campaign whose clock, delay and heights are stated wrongly: what an autofocus with priors for them finds,
//! and that it is carried to everything the image is made of.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::f64::consts::TAU;
use std::fs::File;
use std::path::Path;

use acerra_chain::autofocus::{AutofocusFailure, Quantity};
use acerra_chain::campaign::Campaign;
use acerra_chain::choices::{Delay, TimeOffset};
use acerra_chain::findings::weigh_autofocus;
use acerra_chain::position::Positions;
use acerra_chain::{Control, ImageRequest, Journal, MemorySink, Prepared};
use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
use acerra_geo::write::write_trajectory_csv;
use acerra_imaging::SPEED_OF_LIGHT_M_S;
use acerra_radar::npz::write_npz;
use acerra_radar::{NeutralContent, Radargram, Samples};

/// Trajectory minus radar time (s), fast time at range zero (ns), and by how much the trajectory is too high (m):
/// none of it stated.
const OFFSET_S: f64 = 0.012;
const DELAY_NS: f64 = 0.2;
const TOO_HIGH_M: f64 = 0.12;
const TARGETS_M: [[f64; 2]; 6] = [
    [-1.8, 2.4],
    [-1.0, 3.5],
    [-0.2, 1.7],
    [0.5, 2.9],
    [1.2, 2.0],
    [1.9, 3.2],
];

/// Where the antenna is at a radar time.
fn flown_m(t_s: f64) -> [f64; 3] {
    let wave = |amplitude_m: f64, period_s: f64| amplitude_m * (TAU * t_s / period_s).sin();
    [
        0.5 * t_s - 3.0 + wave(0.3, 4.3),
        wave(0.5, 5.1),
        4.0 + wave(0.3, 3.7),
    ]
}

fn write_flight(folder: &Path) {
    let t_s: Vec<f64> = (0..241).map(|k| 0.05 * f64::from(k)).collect();
    let echo = |t: f64, n: i32| -> f32 {
        let [x, y, z] = flown_m(t);
        let of = |q: &[f64; 2]| {
            let range_m = (x - q[0]).hypot(y - q[1]).hypot(z);
            let late_s = 2.0 * range_m / SPEED_OF_LIGHT_M_S + 1e-9 * DELAY_NS;
            let s = 61e-12 * f64::from(n) - late_s;
            (-(s / 0.3e-9).powi(2)).exp() * (TAU * 4e9 * s).cos()
        };
        TARGETS_M.iter().map(of).sum::<f64>() as f32
    };
    let samples = t_s.iter().flat_map(|t| (0..800).map(move |n| echo(*t, n)));
    let samples = Samples::Real(samples.collect());
    let radargram = Radargram::new(t_s, 0.0, 61e-12, samples).unwrap();
    let radar = File::create(folder.join("flight.npz")).unwrap();
    write_npz(radar, &NeutralContent::Radargram(radargram), None).unwrap();

    let fixes = (-10..=140).map(|k| {
        let time_s = 0.1 * f64::from(k);
        let [x, y, z] = flown_m(time_s - OFFSET_S);
        let variance_m2 = 4e-6;
        Fix {
            covariance_m2: Some([
                [variance_m2, 0.0, 0.0],
                [0.0, variance_m2, 0.0],
                [0.0, 0.0, variance_m2],
            ]),
            ..Fix::new(time_s, [x, y, z + TOO_HIGH_M])
        }
    });
    let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes.collect()).unwrap();
    let out = File::create(folder.join("flight.csv")).unwrap();
    write_trajectory_csv(out, &trajectory).unwrap();
}

const CAMPAIGN: &str = "
[radar]
file = 'flight.npz'
delay_ns = 0.0
[trajectory]
file = 'flight.csv'
time_offset_s = 0.0
[preprocess]
zero_timing = 'none'
background = 'none'
gate_ns = 'none'
[image]
x_m = [-2.6, 2.6]
y_m = [1.0, 4.4]
z_m = 0.0
pixel_m = 0.02
";

/// The campaign prepared, with what it says of an autofocus.
fn prepared(autofocus: &str) -> (Prepared, Campaign) {
    let folder = tempfile::tempdir().unwrap();
    write_flight(folder.path());
    let campaign = Campaign::parse(&format!(
        "{CAMPAIGN}[autofocus]\nenabled = true\n{autofocus}"
    ));
    let campaign = campaign.unwrap().resolved_in(folder.path());
    let prepared = campaign
        .survey()
        .prepare(&mut Journal::default(), &Control::default());
    (prepared.unwrap(), campaign)
}

fn peak(prepared: &Prepared) -> f32 {
    let request = ImageRequest::on(prepared.scene.pixels.clone());
    let control = Control::default();
    let focused = prepared
        .image(&request, &mut MemorySink::default(), &control)
        .unwrap();
    focused.image.iter().map(|v| v.norm()).fold(0.0, f32::max)
}

#[test]
fn wrong_settings_with_priors_are_found_and_carried_through() {
    let (mut flight, campaign) = prepared(
        "clock_offset_sigma_s = 0.02\ndelay_sigma_ns = 0.3\nheight_sigma_m = 0.2\n\
         light_speed_sigma_m_s = 1e6\nlever_arm_sigma_m = [0.0, 0.02, 0.0]\n",
    );
    let before = peak(&flight);
    let stated_m = flight.aligned.position_m.clone();
    let options = campaign.autofocus_options();
    let correction = flight.autofocus(&options, &Control::default()).unwrap();
    assert!(correction.is_applied(), "{:?}", correction.found.decision);
    for (quantity, truth) in [
        (Quantity::Delay, DELAY_NS),
        (Quantity::ClockOffset, OFFSET_S),
        (Quantity::LeverLeft, 0.0),
        (Quantity::Height, -TOO_HIGH_M),
        (Quantity::LightSpeed, 0.0),
    ] {
        let found = correction.globals.iter().find(|g| g.quantity == quantity);
        let found = found.unwrap();
        let off = (found.value - truth).abs();
        assert!(off < 4.0 * found.sigma, "{found:?} for {truth}");
        assert!(found.sigma < 0.3 * found.prior_sigma, "{found:?}");
    }
    let findings = weigh_autofocus(correction);
    let clock = findings.iter().find(|f| f.name == "autofocus_clock_offset");
    assert!((clock.unwrap().value.unwrap() - OFFSET_S).abs() < 0.004);

    // Places, heights, speed and spectra are the corrected ones.
    let (mut square_m2, mut count) = (0.0, 0.0);
    for (m, t_s) in flight.aligned.time_s.iter().enumerate() {
        let [right, found] = [flown_m(*t_s), flight.aligned.position_m[m]];
        square_m2 += (0..3).map(|a| (found[a] - right[a]).powi(2)).sum::<f64>();
        count += 1.0;
        assert!((flight.aligned.height_m[m] - found[2]).abs() < 1e-9);
    }
    let rms_m = f64::sqrt(square_m2 / count);
    assert!(rms_m < 0.02, "{rms_m} m");
    let after = peak(&flight);
    assert!(20.0 * (after / before).log10() > 1.0, "{before} to {after}");

    // The settled campaign states what was found.
    let found = |quantity| flight.correction.as_ref().unwrap().of_all(quantity);
    let settled = campaign.with_corrected(&flight);
    let delay_ns = settled.radar.delay_ns.and_then(Delay::given_ns).unwrap();
    assert!((delay_ns - found(Quantity::Delay)).abs() < 1e-12);
    let offset = settled.trajectory.time_offset_s;
    let Some(TimeOffset::Seconds(offset_s)) = offset else {
        panic!("{offset:?}");
    };
    assert!((offset_s - found(Quantity::ClockOffset)).abs() < 1e-12);

    let restored = flight.as_stated();
    assert_eq!(restored.aligned.position_m, stated_m);
    assert!((restored.scene.light_speed_m_s - SPEED_OF_LIGHT_M_S).abs() < 1e-6);
    assert!((peak(&restored) / before - 1.0).abs() < 1e-4);
}

#[test]
fn clocks_and_lever_arms_of_placed_traces_are_refused() {
    for key in [
        "clock_offset_sigma_s = 0.01",
        "clock_drift_sigma_ppm = 10.0",
        "lever_arm_sigma_m = [0.0, 0.0, 0.01]",
    ] {
        let (mut flight, campaign) = prepared(key);
        let mut options = campaign.autofocus_options();
        options.sigma_m = Some([0.01; 3]);
        let placed: Vec<[f64; 3]> = flight.aligned.all.iter().map(|p| p.position_m).collect();
        flight.tracks[0].positions = Positions::PerTrace(placed.into());
        let refused = flight.autofocus(&options, &Control::default());
        assert!(
            matches!(refused, Err(AutofocusFailure::PlacedByTrace)),
            "{key}"
        );
    }
}

#[test]
fn impossible_deviations_are_refused() {
    for (key, value) in [
        ("clock_offset_sigma_s", "-0.1"),
        ("clock_drift_sigma_ppm", "nan"),
        ("lever_arm_sigma_m", "[0.0, -1.0, 0.0]"),
        ("height_sigma_m", "1e3"),
        ("light_speed_sigma_m_s", "inf"),
    ] {
        let refused = Campaign::parse(&format!("{CAMPAIGN}[autofocus]\n{key} = {value}\n"));
        let message = refused.unwrap_err().to_string();
        assert!(message.contains(key), "{message}");
    }
}
