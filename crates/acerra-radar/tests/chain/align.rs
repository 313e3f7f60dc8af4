//! Selecting moving traces and aligning clocks from the data alone.

use crate::common::shared;
use acerra_radar::align::{AlignError, OffsetSearch, activity, coarse_offset};
use acerra_radar::mrm::read_mrm;
use acerra_radar::{
    Limits, MovingOptions, Radargram, RadargramOptions, Samples, moving_traces, two_way_delay_s,
};

/// Speed of the platform from the motion capture: central differences over 0.2 s.
fn mocap_speed(text: &str) -> (Vec<f64>, Vec<f64>) {
    let mut fixes: Vec<(f64, [f64; 3])> = Vec::new();
    for line in text.lines() {
        let fields: Vec<Option<f64>> = line.split(',').map(|f| f.parse().ok()).collect();
        if let [Some(_), Some(t), _, _, _, _, Some(x), Some(y), Some(z), ..] = fields[..] {
            fixes.push((t, [x, y, z]));
        }
    }
    let half = 36;
    let speed = |w: &[(f64, [f64; 3])]| {
        let ((t0, a), (t1, b)) = (w[0], w[2 * half]);
        let d2: f64 = (0..3).map(|k| (b[k] - a[k]).powi(2)).sum();
        (w[half].0, d2.sqrt() / (t1 - t0))
    };
    fixes.windows(2 * half + 1).map(speed).unzip()
}

#[test]
fn the_flight_aligns_to_motion_capture() {
    let (Some(capture), Some(mocap)) = (
        shared("uav-flight-2019/flight.mrm"),
        shared("uav-flight-2019/platform-mocap.csv"),
    ) else {
        return;
    };
    let log = read_mrm(&capture[..], &Limits::default()).unwrap();
    let radargram = log
        .radargram(&RadargramOptions::default())
        .unwrap()
        .radargram;
    let (times, speeds) = mocap_speed(std::str::from_utf8(&mocap).unwrap());
    let found = coarse_offset(
        &radargram.time_s,
        &activity(&radargram),
        &times,
        &speeds,
        &OffsetSearch::default(),
    )
    .unwrap();
    println!(
        "offset {:.3} s, correlation {:.3}, runner-up {:.3}, confidence {:.2}, within {:?}",
        found.offset_s, found.correlation, found.runner_up, found.confidence, found.interval_s
    );
    assert!((found.offset_s - 6.51).abs() < 0.02);
    assert!(found.correlation > 0.89);
    assert!(found.confidence > 0.5);
    assert!(found.interval_s[0] < 6.51 && 6.51 < found.interval_s[1]);
}

/// A radar 3 m above five scatterers, following a given x(t).
fn synthetic(x: impl Fn(f64) -> f64, traces: usize, interval_s: f64) -> Radargram {
    let n = 400;
    let time_s: Vec<f64> = (0..traces).map(|m| m as f64 * interval_s).collect();
    let samples = time_s
        .iter()
        .enumerate()
        .flat_map(|(m, &t)| {
            let x = x(t);
            (0..n).map(move |k| {
                let fast = 18e-9 + k as f64 * 61e-12;
                let mut v = 50.0 * (k as f64 * 0.7).sin();
                for target in 0..5 {
                    let r = ((x - f64::from(target) * 0.7).powi(2) + 9.0).sqrt();
                    let u = (fast - two_way_delay_s(r)) / 0.3e-9;
                    v += 10.0 * (-u * u).exp() * (std::f64::consts::TAU * 3.95 * 0.3 * u).cos();
                }
                v += 0.3 * ((m * n + k) as f64 * 12.9898).sin();
                v as f32
            })
        })
        .collect();
    Radargram::new(time_s, 18e-9, 61e-12, Samples::Real(samples)).unwrap()
}

#[test]
fn a_known_offset_is_found() {
    // Stands, flies from 4.0 to 9.0 s with a halt from 6.5 to 7.1 s, stands.
    let speed_at = |t: f64| match t {
        t if (4.0..6.5).contains(&t) || (7.1..9.0).contains(&t) => 0.8,
        _ => 0.0,
    };
    let x_at = |t: f64| {
        let (mut x, mut s) = (0.0, 0.0);
        while s < t {
            x += 0.002 * speed_at(s);
            s += 0.002;
        }
        x
    };
    let radargram = synthetic(x_at, 500, 0.025);
    let offset = 311.37;
    let times: Vec<f64> = (0..400)
        .map(|i| offset - 3.0 + 0.05 * f64::from(i))
        .collect();
    let speeds: Vec<f64> = times.iter().map(|t| speed_at(t - offset)).collect();
    let curve = activity(&radargram);
    let found = coarse_offset(
        &radargram.time_s,
        &curve,
        &times,
        &speeds,
        &OffsetSearch::default(),
    )
    .unwrap();
    assert!((found.offset_s - offset).abs() < 0.03, "{}", found.offset_s);
    assert!(
        found.correlation > 0.97 && found.confidence > 0.5,
        "{found:?}"
    );
    // Restricted to a range without the truth, it still answers, and less surely.
    let search = OffsetSearch::default().within([offset + 2.0, offset + 4.0]);
    let wrong = coarse_offset(&radargram.time_s, &curve, &times, &speeds, &search).unwrap();
    assert!(wrong.correlation < 0.8);
}

#[test]
fn what_cannot_be_aligned_is_refused() {
    let search = OffsetSearch::default();
    let rising: Vec<f64> = (0..10).map(f64::from).collect();
    let flat = vec![2.0; 10];
    assert!(matches!(
        coarse_offset(&rising, &flat, &rising, &rising, &search),
        Err(AlignError::Constant {
            what: "radar activity"
        })
    ));
    assert!(matches!(
        coarse_offset(&rising, &rising, &flat, &rising, &search),
        Err(AlignError::Order {
            what: "speed",
            index: 1
        })
    ));
    assert!(matches!(
        coarse_offset(&rising, &rising, &rising[..2], &rising[..2], &search),
        Err(AlignError::Length { .. })
    ));
    let far = search.within([100.0, 101.0]);
    assert!(matches!(
        coarse_offset(&rising, &rising, &rising, &rising, &far),
        Err(AlignError::NoOverlap { .. })
    ));
    let step = search.with_step_s(0.0);
    assert!(matches!(
        coarse_offset(&rising, &rising, &rising, &rising, &step),
        Err(AlignError::Step { .. })
    ));
}

#[test]
fn moving_traces_bridge_short_halts_and_ignore_twitches() {
    let mut speed = vec![0.0; 300];
    speed[10..14].fill(1.0); // a twitch while the battery goes in
    speed[100..150].fill(1.0);
    speed[160..200].fill(0.9); // a short halt before
    speed[40] = f64::NAN;
    let options = MovingOptions::default().with_bridge(20);
    assert_eq!(moving_traces(&speed, &options), 100..200);
    let given = options.with_threshold_m_s(2.0);
    assert!(moving_traces(&speed, &given).is_empty());
    assert!(moving_traces(&[], &options).is_empty());
}
