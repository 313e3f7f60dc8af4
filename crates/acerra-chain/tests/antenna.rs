//! The antenna's pattern turns with the recorded attitude, from the trajectory to the pixel.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use acerra_chain::choices::AntennaAxis;
use acerra_chain::clean::CleanOptions;
use acerra_chain::evidence::{Evidence, Finding, Verdict};
use acerra_chain::weigh::{weigh_prepared, weigh_unchecked};
use acerra_chain::{
    Control, ImageRequest, Journal, MemorySink, Prepared, Recording, Scene, prepare,
};
use acerra_geo::trajectory::{Attitude, Fix, Frame, TimeOrigin, Trajectory};
use acerra_imaging::{Complex64, IncidenceWeight, PlaneGrid, SPEED_OF_LIGHT_M_S, reference};
use acerra_radar::{Radargram, Samples};

const TARGET_M: [f64; 3] = [0.313, 2.02, 0.0];
const POWER: f64 = 3.0;

/// Roll (rad) of the platform, which flies east: positive turns its left side up.
fn roll_rad(t_s: f64) -> f64 {
    0.3 * (1.7 * t_s).sin() + 0.05
}

/// The attitude of a roll about east, from its definition: w = cos ½φ, x = sin ½φ.
fn rolled(angle_rad: f64) -> Option<Attitude> {
    let (s, c) = (0.5 * angle_rad).sin_cos();
    Attitude::from_quaternion(c, s, 0.0, 0.0)
}

/// A line of flight along x, 4 m up, past one reflector.
fn prepared(attitude: impl Fn(f64) -> Option<Attitude>) -> Prepared {
    let t_s: Vec<f64> = (0..81).map(|k| 0.05 * f64::from(k)).collect();
    let mut samples = Vec::new();
    for t in &t_s {
        let range_m = (t - 2.0 - TARGET_M[0]).hypot(TARGET_M[1]).hypot(4.0);
        for n in 0..800 {
            let s = 61e-12 * f64::from(n) - 2.0 * range_m / SPEED_OF_LIGHT_M_S;
            let pulse = (-(s / 0.3e-9).powi(2)).exp() * (std::f64::consts::TAU * 4e9 * s).cos();
            samples.push(pulse as f32);
        }
    }
    let fix = |t: &f64| Fix {
        attitude: attitude(*t),
        ..Fix::new(*t, [t - 2.0, 0.0, 4.0])
    };
    let fixes = t_s.iter().map(fix).collect();
    let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes).unwrap();
    let radargram = Radargram::new(t_s, 0.0, 61e-12, Samples::Real(samples)).unwrap();
    let flight = Recording::new("one", radargram, trajectory).clean_by(CleanOptions::none());
    prepare(
        vec![flight],
        Scene::plane(grid()),
        &Default::default(),
        &mut Journal::default(),
        &Control::default(),
    )
    .unwrap()
}

fn grid() -> PlaneGrid {
    PlaneGrid::from_ranges([0.0, 0.6], [1.5, 2.5], 0.0, 0.025).unwrap()
}

fn request(antenna_axis: AntennaAxis) -> ImageRequest {
    let mut request = ImageRequest::on(grid());
    request.options.antenna_axis = antenna_axis;
    request.options.incidence = Some(IncidenceWeight {
        cosine_power: POWER,
        ..IncidenceWeight::default()
    });
    request
}

fn image(prepared: &Prepared, request: &ImageRequest) -> Vec<Complex64> {
    let focused = prepared
        .image(request, &mut MemorySink::default(), &Control::default())
        .unwrap();
    let wide = |v: &acerra_imaging::Complex32| Complex64::new(v.re.into(), v.im.into());
    focused.image.iter().map(wide).collect()
}

/// Eq. (3) pulse by pulse, each weighted by the cosine between the way to the pixel and the axis of an antenna
/// that rolls by φ: (0, sin φ, −cos φ).
fn expected(prepared: &Prepared, roll_rad: impl Fn(f64) -> f64) -> Vec<Complex64> {
    let echoes = prepared.echoes();
    let weight = vec![1.0; echoes.aligned.position_m.len()];
    let pulses = echoes.pulses(&weight).unwrap().without_boresight();
    let points: Vec<[f64; 3]> = (0..grid().len()).map(|k| grid().point_m(k)).collect();
    let mut sum = vec![Complex64::ZERO; points.len()];
    for (m, t_s) in echoes.aligned.time_s.iter().enumerate() {
        let one = pulses.slice(m..m + 1).unwrap();
        let values = reference::adjoint(&one, &points, Default::default()).unwrap();
        let (sine, cosine) = roll_rad(*t_s).sin_cos();
        let antenna_m = echoes.aligned.position_m[m];
        for ((sum, value), point) in sum.iter_mut().zip(values).zip(&points) {
            let along_m = sine * (point[1] - antenna_m[1]) + cosine * (antenna_m[2] - point[2]);
            let range_m = reference::range_m(antenna_m, *point);
            *sum += value * (along_m / range_m).powf(POWER);
        }
    }
    sum
}

#[test]
fn the_pattern_follows_the_roll_of_the_flight() {
    let tilted = prepared(|t_s| rolled(roll_rad(t_s)));
    let by_attitude = image(&tilted, &request(AntennaAxis::Attitude));
    let error = reference::relative_l2(&by_attitude, &expected(&tilted, roll_rad)).unwrap();
    assert!(error < 2e-3, "{error:e}");
    // On a gimbal the same flight weighs as a level one, and that is another image.
    let level = expected(&tilted, |_| 0.0);
    let on_gimbal = image(&tilted, &request(AntennaAxis::Vertical));
    assert!(reference::relative_l2(&on_gimbal, &level).unwrap() < 2e-3);
    assert!(reference::relative_l2(&by_attitude, &level).unwrap() > 0.05);
    // Without recorded attitude there is nothing to turn by.
    let unknown = prepared(|_| None);
    let unturned = image(&unknown, &request(AntennaAxis::Attitude));
    assert!(reference::relative_l2(&unturned, &level).unwrap() < 2e-3);
}

fn findings(prepared: &Prepared, request: &ImageRequest) -> Vec<Finding> {
    weigh_prepared(prepared, request, &Control::default()).unwrap()
}

fn is_unchecked(prepared: &Prepared, request: &ImageRequest) -> bool {
    let mut evidence = Evidence::default();
    for finding in findings(prepared, request) {
        evidence.add(finding);
    }
    weigh_unchecked(prepared, &request.options, &evidence)
        .iter()
        .any(|one| one.setting == "antenna_axis")
}

#[test]
fn evidence_says_what_the_tilt_does_and_what_nothing_tells() {
    let by_attitude = request(AntennaAxis::Attitude);
    let find = |prepared: &Prepared, request: &ImageRequest| {
        let mut all = findings(prepared, request).into_iter();
        all.find(|finding| finding.name == "antenna_tilt")
    };
    let tilted = prepared(|t_s| rolled(roll_rad(t_s)));
    let found = find(&tilted, &by_attitude).unwrap();
    assert_eq!(found.verdict, Verdict::Agrees, "{}", found.explanation);
    assert!(found.value.is_some_and(|deg| deg > 3.0 && deg < 20.0));
    assert!(!is_unchecked(&tilted, &by_attitude));
    // Axes of a motion-capture body with another one up.
    let turned = prepared(|_| rolled(std::f64::consts::FRAC_PI_2));
    assert_eq!(
        find(&turned, &by_attitude).unwrap().verdict,
        Verdict::Doubtful
    );
    // Attitudes that end half way.
    let half = prepared(|t_s| rolled(0.1).filter(|_| t_s < 2.0));
    assert_eq!(
        find(&half, &by_attitude).unwrap().verdict,
        Verdict::Doubtful
    );
    let unknown = prepared(|_| None);
    assert_eq!(find(&unknown, &by_attitude), None);
    assert!(is_unchecked(&unknown, &by_attitude));
    assert!(is_unchecked(&tilted, &request(AntennaAxis::Vertical)));
    // Without a pattern it does not matter where the antenna looks.
    let unweighted = ImageRequest::on(grid());
    assert_eq!(find(&tilted, &unweighted), None);
    assert!(!is_unchecked(&tilted, &unweighted));
}
