//! The antenna's pattern turns with the recorded attitude, from the trajectory to the pixel.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use acerra_chain::choices::AntennaAxis;
use acerra_chain::clean::CleanOptions;
use acerra_chain::findings::{Evidence, Finding, Verdict};
use acerra_chain::findings::{weigh_prepared, weigh_unchecked};
use acerra_chain::focus::inversion::options::Method;
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

/// The attitude of a platform or a gimbal that is rolled about east, from its definition: w = cos ½φ, x = sin ½φ.
fn rolled(angle_rad: f64) -> Option<Attitude> {
    let (s, c) = (0.5 * angle_rad).sin_cos();
    Attitude::from_quaternion(c, s, 0.0, 0.0)
}

/// A line of flight along x, 4 m up, past one reflector.
fn prepared(attitude: impl Fn(f64) -> Option<Attitude>) -> Prepared {
    prepared_with_gimbal(attitude, |_| None)
}

/// The same with a gimbal.
fn prepared_with_gimbal(
    attitude: impl Fn(f64) -> Option<Attitude>,
    gimbal: impl Fn(f64) -> Option<Attitude>,
) -> Prepared {
    prepare(
        vec![flight("one", attitude, gimbal)],
        Scene::plane(grid()),
        &Default::default(),
        &mut Journal::default(),
        &Control::default(),
    )
    .unwrap()
}

fn flight(
    name: &str,
    attitude: impl Fn(f64) -> Option<Attitude>,
    gimbal: impl Fn(f64) -> Option<Attitude>,
) -> Recording {
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
        gimbal: gimbal(*t),
        ..Fix::new(*t, [t - 2.0, 0.0, 4.0])
    };
    let fixes = t_s.iter().map(fix).collect();
    let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes).unwrap();
    let radargram = Radargram::new(t_s, 0.0, 61e-12, Samples::Real(samples)).unwrap();
    Recording::new(name, radargram, trajectory).clean_by(CleanOptions::none())
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
    weigh_unchecked(prepared, &request.options, None, &evidence, &[])
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

/// Tilt of a gimbal's antenna towards the reflector (rad).
const TILT_RAD: f64 = 0.4;

/// A gimbal in the place of a camera: its forward axis points down, turned by `tilt_rad` about east as a roll is;
/// its up axis points east.
fn pitched_down(tilt_rad: f64) -> Option<Attitude> {
    let (s, c) = tilt_rad.sin_cos();
    let (forward, up) = ([0.0, s, -c], [1.0, 0.0, 0.0]);
    // left = up × forward.
    let left = [
        up[1] * forward[2] - up[2] * forward[1],
        up[2] * forward[0] - up[0] * forward[2],
        up[0] * forward[1] - up[1] * forward[0],
    ];
    let rows = [0, 1, 2].map(|k: usize| [forward[k], left[k], up[k]]);
    Some(Attitude::from_rotation(&rows))
}

#[test]
fn an_antenna_on_a_gimbal_looks_where_the_gimbal_points() {
    let attitude = |t_s| rolled(roll_rad(t_s));
    let off = |found: &[Complex64], expected: &[Complex64]| {
        reference::relative_l2(found, expected).unwrap()
    };
    // Kept level, the rolling flight's image is that of an antenna that looks straight down.
    let level = prepared_with_gimbal(attitude, |_| rolled(0.0));
    let by_gimbal = image(&level, &request(AntennaAxis::Gimbal));
    let vertical = image(&level, &request(AntennaAxis::Vertical));
    assert!(off(&by_gimbal, &vertical) < 2e-3);
    assert!(off(&by_gimbal, &image(&level, &request(AntennaAxis::Attitude))) > 0.05);
    // Tilted by a known angle, it is the sum of the pulses weighted from there, whatever the platform does.
    let tilted = prepared_with_gimbal(attitude, |_| rolled(TILT_RAD));
    let summed = expected(&tilted, |_| TILT_RAD);
    assert!(off(&image(&tilted, &request(AntennaAxis::Gimbal)), &summed) < 2e-3);
    assert!(off(&vertical, &summed) > 0.05);
    // A gimbal that moves, an antenna in the place of a camera.
    let swing_rad = |t_s: f64| TILT_RAD + 0.2 * (2.3 * t_s).cos();
    let camera = prepared_with_gimbal(attitude, |t_s| pitched_down(swing_rad(t_s)));
    let summed = expected(&camera, swing_rad);
    let by_forward = image(&camera, &request(AntennaAxis::GimbalForward));
    assert!(off(&by_forward, &summed) < 2e-3);
    assert!(off(&image(&camera, &request(AntennaAxis::Gimbal)), &summed) > 0.05);
}

#[test]
fn a_scene_is_solved_for_with_the_gimbal_s_pattern() {
    let tilted = prepared_with_gimbal(|t_s| rolled(roll_rad(t_s)), |_| rolled(TILT_RAD));
    let platform = prepared(|_| rolled(TILT_RAD));
    let solved = |prepared: &Prepared, axis| {
        let mut request = request(axis);
        request.options.inversion.method = Method::Cgls;
        request.pulses = Some(32..48);
        image(prepared, &request)
    };
    let by_gimbal = solved(&tilted, AntennaAxis::Gimbal);
    let by_platform = solved(&platform, AntennaAxis::Attitude);
    assert!(reference::relative_l2(&by_gimbal, &by_platform).unwrap() < 1e-6);
}

#[test]
fn a_gimbal_of_unknown_attitude_is_refused() {
    let unknown = prepared(|t_s| rolled(roll_rad(t_s)));
    let message = |prepared: &Prepared, axis| {
        let mut sink = MemorySink::default();
        let made = prepared.image(&request(axis), &mut sink, &Control::default());
        made.unwrap_err().to_string()
    };
    let found = message(&unknown, AntennaAxis::GimbalForward);
    assert!(found.contains("antenna_axis = \"gimbal-forward\": expected the attitude of a gimbal"));
    // Of two tracks one without it.
    let flights = vec![
        flight("one", |_| None, |_| rolled(0.0)),
        flight("two", |_| None, |_| None),
    ];
    let two = prepare(
        flights,
        Scene::plane(grid()),
        &Default::default(),
        &mut Journal::default(),
        &Control::default(),
    );
    let found = message(&two.unwrap(), AntennaAxis::Gimbal);
    assert!(found.contains("every track"), "{found}");
}

#[test]
fn evidence_speaks_of_the_gimbal_where_it_carries_the_antenna() {
    let find = |gimbal: Option<Attitude>, axis| {
        let prepared = prepared_with_gimbal(|t_s| rolled(roll_rad(t_s)), |_| gimbal);
        assert!(!is_unchecked(&prepared, &request(axis)));
        let mut all = findings(&prepared, &request(axis)).into_iter();
        all.find(|finding| finding.name == "antenna_tilt").unwrap()
    };
    let level = find(rolled(0.0), AntennaAxis::Gimbal);
    assert_eq!(level.verdict, Verdict::Agrees);
    assert!(level.value.is_some_and(|deg| deg < 1e-6));
    // Far to the side: more than a platform would.
    let side = find(rolled(0.9), AntennaAxis::Gimbal);
    assert_eq!(side.verdict, Verdict::Agrees, "{}", side.explanation);
    assert!(
        side.value
            .is_some_and(|deg| (deg - 0.9_f64.to_degrees()).abs() < 1e-3)
    );
    assert!(side.explanation.contains("of the gimbal"));
    // The wrong one of its axes.
    let wrong = find(pitched_down(0.2), AntennaAxis::Gimbal);
    assert_eq!(wrong.verdict, Verdict::Doubtful);
    assert!(
        wrong.explanation.contains("its forward axis lies 11.5°"),
        "{}",
        wrong.explanation
    );
    let right = find(pitched_down(0.2), AntennaAxis::GimbalForward);
    assert_eq!(right.verdict, Verdict::Agrees);
}
