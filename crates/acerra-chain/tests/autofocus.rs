//! A flight whose trajectory sways unseen: what an autofocus in the chain corrects, and keeps.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use acerra_chain::autofocus::{AutofocusFailure, AutofocusOptions, Quantity};
use acerra_chain::clean::CleanOptions;
use acerra_chain::{
    Control, ImageRequest, Journal, MemorySink, Prepared, Recording, Scene, prepare,
};
use acerra_geo::matrix::Matrix3;
use acerra_geo::trajectory::{Fix, Frame, SolutionStatus, TimeOrigin, Trajectory};
use acerra_imaging::{PlaneGrid, SPEED_OF_LIGHT_M_S};
use acerra_radar::{Radargram, Samples};

const SWAYING: Flown = Flown {
    targets_m: &[[-1.0, 2.5], [0.4, 3.6], [1.2, 2.0], [-0.2, 1.6]],
    sway_m: [0.0, 0.015],
    covariance_m2: None,
    float_fixes: 0,
};

/// A flight of 6 s at 1 m/s along x, 4 m up, that sways north and up by so much (m).
#[derive(Clone, Copy)]
struct Flown<'a> {
    targets_m: &'a [[f64; 2]],
    sway_m: [f64; 2],
    covariance_m2: Option<Matrix3>,
    /// So many fixes, from the first on, are float.
    float_fixes: usize,
}

impl Flown<'_> {
    fn place_m(self, t_s: f64) -> [f64; 3] {
        let sway = (std::f64::consts::TAU * t_s / 2.3).sin();
        [
            t_s - 3.0,
            self.sway_m[0] * sway,
            4.0 + self.sway_m[1] * sway,
        ]
    }
}

/// The same with a trajectory that knows of no sway.
fn prepared(flown: Flown) -> Prepared {
    let t_s: Vec<f64> = (0..121).map(|k| 0.05 * f64::from(k)).collect();
    let echo = |t: f64, n: i32| -> f32 {
        let [x, y, z] = flown.place_m(t);
        let of = |q: &[f64; 2]| {
            let range_m = (x - q[0]).hypot(y - q[1]).hypot(z);
            let s = 61e-12 * f64::from(n) - 2.0 * range_m / SPEED_OF_LIGHT_M_S;
            (-(s / 0.3e-9).powi(2)).exp() * (std::f64::consts::TAU * 4e9 * s).cos()
        };
        flown.targets_m.iter().map(of).sum::<f64>() as f32
    };
    let samples = t_s.iter().flat_map(|t| (0..800).map(move |n| echo(*t, n)));
    let samples = Samples::Real(samples.collect());
    let fixes = t_s.iter().enumerate().map(|(k, t)| Fix {
        covariance_m2: flown.covariance_m2,
        status: match k < flown.float_fixes {
            true => SolutionStatus::Float,
            false => SolutionStatus::Fixed,
        },
        ..Fix::new(*t, [t - 3.0, 0.0, 4.0])
    });
    let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes.collect()).unwrap();
    let radargram = Radargram::new(t_s.clone(), 0.0, 61e-12, samples).unwrap();
    let flight = Recording::new("flight", radargram, trajectory).clean_by(CleanOptions::none());
    let grid = PlaneGrid::from_ranges([-2.0, 2.0], [1.0, 4.5], 0.0, 0.02).unwrap();
    let (calibration, control) = (Default::default(), Control::default());
    let scene = Scene::plane(grid);
    prepare(
        vec![flight],
        scene,
        &calibration,
        &mut Journal::default(),
        &control,
    )
    .unwrap()
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
fn an_unseen_sway_is_corrected_and_the_stated_places_are_kept() {
    let mut flown = prepared(SWAYING);
    let before = peak(&flown);
    let stated_m = flown.aligned.position_m.clone();
    let options = AutofocusOptions {
        sigma_m: Some([0.01; 3]),
        correlation_s: Some(0.7),
        ..AutofocusOptions::default()
    };
    let found = flown.autofocus(&options, &Control::default()).unwrap();
    assert!(found.is_applied(), "{:?}", found.found.decision);
    let after = peak(&flown);
    assert!(20.0 * (after / before).log10() > 0.5, "{before} to {after}");
    assert_ne!(flown.aligned.position_m, stated_m);
    let restored = flown.as_stated();
    assert_eq!(restored.aligned.position_m, stated_m);
    assert!((peak(&restored) / before - 1.0).abs() < 1e-4);
}

#[test]
fn positions_without_deviations_are_refused() {
    let mut flown = prepared(SWAYING);
    let refused = flown.autofocus(&AutofocusOptions::default(), &Control::default());
    assert!(matches!(refused, Err(AutofocusFailure::NoDeviations)));
}

/// Float positions err alike: a shift and its change are free, and the rest is as small as phases make it. Of a
/// track that is float in part all errors are taken from trace to trace.
#[test]
fn float_positions_have_their_errors_in_common() {
    let flown = |float_fixes| Flown {
        covariance_m2: Some([[0.04, 0.0, 0.0], [0.0, 0.04, 0.0], [0.0, 0.0, 0.09]]),
        float_fixes,
        ..SWAYING
    };
    let options = AutofocusOptions {
        correlation_s: Some(0.7),
        ..AutofocusOptions::default()
    };
    let mut float = prepared(flown(121));
    let before = peak(&float);
    let correction = float.autofocus(&options, &Control::default()).unwrap();
    assert!(correction.is_applied(), "{:?}", correction.found.decision);
    let up = correction
        .globals
        .iter()
        .find(|g| g.quantity == Quantity::TrackUp);
    assert!((up.unwrap().prior_sigma - 0.3).abs() < 1e-9, "{up:?}");
    let rate = correction
        .globals
        .iter()
        .find(|g| g.quantity == Quantity::TrackUpRate);
    let expected = 0.3 * 3_f64.sqrt() / 300.0;
    assert!(
        (rate.unwrap().prior_sigma - expected).abs() < 1e-9,
        "{rate:?}"
    );
    let after = peak(&float);
    assert!(20.0 * (after / before).log10() > 0.5, "{before} to {after}");

    let mut mixed = prepared(flown(100));
    let correction = mixed.autofocus(&options, &Control::default()).unwrap();
    assert!(correction.globals.is_empty(), "{:?}", correction.globals);
}

/// Points in a line along the flight tell one combination of north and up: the covariance between them, which the
/// trajectory states, tells the other.
#[test]
fn covariances_between_axes_tell_what_the_echoes_do_not() {
    let flown = Flown {
        targets_m: &[[-1.2, 2.5], [-0.4, 2.5], [0.4, 2.5], [1.2, 2.5]],
        sway_m: [0.010, 0.015],
        covariance_m2: Some([
            [1e-6, 0.0, 0.0],
            [0.0, 1e-4, 1.41e-4],
            [0.0, 1.41e-4, 2.25e-4],
        ]),
        float_fixes: 0,
    };
    let error_m = |sigma_m: Option<[f64; 3]>| {
        let mut found = prepared(flown);
        let options = AutofocusOptions {
            sigma_m,
            correlation_s: Some(0.7),
            ..AutofocusOptions::default()
        };
        let correction = found.autofocus(&options, &Control::default()).unwrap();
        assert!(correction.is_applied(), "{:?}", correction.found.decision);
        let places = found.aligned.position_m.iter().zip(&found.aligned.time_s);
        let square = |(p, t): (&[f64; 3], &f64)| {
            let right = flown.place_m(*t);
            (p[1] - right[1]).powi(2) + (p[2] - right[2]).powi(2)
        };
        let count = found.aligned.time_s.len() as f64;
        (places.map(square).sum::<f64>() / count).sqrt()
    };
    let (full, diagonal) = (error_m(None), error_m(Some([0.001, 0.010, 0.015])));
    assert!(full < 0.7 * diagonal, "{full} m and {diagonal} m");
}
