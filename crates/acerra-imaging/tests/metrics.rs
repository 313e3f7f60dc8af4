//! Targets found and measured on pixel images of known scenes.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::f64::consts::PI;

use acerra_imaging::metrics::{ImageView, MeasureOptions, Measurement, measure_targets};
use acerra_imaging::psf::PointSpread;
use acerra_imaging::{Complex32, Complex64, Control, PlaneGrid};
use rayon::prelude::*;

fn spread(track: impl Fn(f64) -> [f64; 2], half_m: f64, height_m: f64, step_m: f64) -> PointSpread {
    let count = (2.0 * half_m / step_m).round() as usize;
    let position_m = (0..=count)
        .map(|m| {
            let [x, y] = track(-half_m + step_m * m as f64);
            [x, y, height_m]
        })
        .collect();
    // Steps of 20 MHz put the range ambiguity (7.5 m) beyond the small scenes here.
    let frequency_hz = (0..86).map(|n| 3.1e9 + 20e6 * f64::from(n)).collect();
    PointSpread::new(position_m, None, frequency_hz, 3e8).unwrap()
}

/// Amplitude, place.
type Scene<'a> = &'a [(f64, [f64; 2])];

fn image(spread: &PointSpread, scene: Scene, grid: PlaneGrid, noise: f64) -> Vec<Complex32> {
    let peak = spread.response([0.0, 1.5, 0.0], [0.0, 1.5, 0.0]).norm();
    (0..grid.len())
        .into_par_iter()
        .map(|k| {
            let at = grid.point_m(k);
            let mut sum = Complex64::default();
            for (amplitude, [x, y]) in scene {
                sum += amplitude * spread.response([*x, *y, 0.0], at) / peak;
            }
            let random = |salt: u64| {
                let mut h = (k as u64 ^ salt).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                h = (h ^ (h >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
                ((h ^ (h >> 29)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
            };
            sum += noise * Complex64::new(random(1), random(0xABCD_EF01));
            Complex32::new(sum.re as f32, sum.im as f32)
        })
        .collect()
}

fn measure(spread: &PointSpread, scene: Scene, grid: PlaneGrid, noise: f64) -> Measurement {
    let values = image(spread, scene, grid, noise);
    let view = ImageView::new(&values, grid).unwrap();
    measure_targets(
        &view,
        spread,
        &MeasureOptions::default(),
        Control::default(),
    )
    .unwrap()
}

#[test]
fn sidelobes_and_ghosts_are_not_targets() {
    let straight = spread(|s| [s, 0.0], 1.5, 3.0, 0.015);
    let grid = PlaneGrid::from_ranges([-0.8, 0.8], [-2.4, 2.4], 0.0, 0.0125).unwrap();
    let scene = [
        (1.0, [-0.303, 1.507]),
        (0.45, [0.412, 1.902]),
        (0.7, [0.35, -1.2]),
    ];
    let found = measure(&straight, &scene, grid, 0.02);
    println!("{found:#?}");
    assert_eq!(found.targets.len(), 3);
    assert!(found.sidelobes + found.ghosts + 3 == found.maxima && found.ghosts >= 3);
    // A straight track keeps the left one of two equal partners; the third target stood right.
    let expected = [[-0.303, 1.507], [0.35, 1.2], [0.412, 1.902]];
    for (target, [x, y]) in found.targets.iter().zip(expected) {
        assert!(
            (target.x_m - x).abs() < 0.01 && (target.y_m - y).abs() < 0.02,
            "{target:?}"
        );
        let ghost = target.ghost.unwrap();
        assert!(
            (ghost.level - 1.0).abs() < 0.05 && (ghost.y_m + y).abs() < 0.04,
            "{ghost:?}"
        );
        assert!(target.pslr_db.unwrap() < -6.0);
    }
    assert_eq!(found.targets[0].level_db, 0.0);
    assert!(found.statistics.median_db.unwrap() < -25.0);
}

#[test]
fn a_curved_track_tells_the_target_from_its_ghost() {
    let curved = spread(|s| [s, -0.4 * (PI * s / 6.0).cos()], 1.5, 3.0, 0.015);
    let grid = PlaneGrid::from_ranges([-0.6, 0.6], [-3.0, 2.2], 0.0, 0.0125).unwrap();
    // To the right of the flight: only the level can tell.
    let found = measure(&curved, &[(1.0, [0.1, -2.1])], grid, 0.01);
    println!("{found:#?}");
    assert_eq!(found.targets.len(), 1);
    let target = found.targets[0];
    assert!((target.y_m + 2.1).abs() < 0.02 && (target.x_m - 0.1).abs() < 0.01);
    assert!(target.ghost.unwrap().level < 0.95);
}

#[test]
fn pixels_give_what_the_exact_function_gives() {
    use acerra_imaging::metrics::{LocalTrack, measure_shape};
    use acerra_imaging::psf::{Cell, PsfField};
    // A diagonal flight: cuts run askew to the pixels.
    let diagonal = spread(|s| [0.8 * s, 0.6 * s], 1.5, 3.0, 0.015);
    let place = [-0.9, 1.2, 0.0];
    let grid = PlaneGrid::from_ranges([-1.6, -0.2], [0.5, 1.9], 0.0, 0.01).unwrap();
    let found = measure(&diagonal, &[(1.0, [place[0], place[1]])], grid, 0.0);
    let target = found.targets[0];
    let track = LocalTrack::at(diagonal.position_m(), place).unwrap();
    let cell = Cell::expected(&diagonal, &track, place);
    let scene = [place];
    let field = PsfField::new(&diagonal, &scene, 0.0);
    let exact = measure_shape(&field, &track, [target.x_m, target.y_m], cell).unwrap();
    let close = |a: Option<f64>, b: Option<f64>| {
        let (a, b) = (a.unwrap(), b.unwrap());
        assert!((a / b - 1.0).abs() < 0.01, "{a} {b}");
    };
    close(target.along.rayleigh_m, exact.along.rayleigh_m);
    close(target.along.width_3db_m, exact.along.width_3db_m);
    close(target.across.rayleigh_m, exact.across.rayleigh_m);
    close(target.across.inner_m, exact.across.inner_m);
    close(target.across.width_6db_m, exact.across.width_6db_m);
    close(target.pslr_db, exact.pslr_db);
}

#[test]
fn an_empty_image_has_no_targets() {
    let straight = spread(|s| [s, 0.0], 0.5, 3.0, 0.05);
    let grid = PlaneGrid::new([0.0, 0.0, 0.0], 0.1, [8, 4]).unwrap();
    let values = vec![Complex32::default(); grid.len()];
    let view = ImageView::new(&values, grid).unwrap();
    let found = measure_targets(
        &view,
        &straight,
        &MeasureOptions::default(),
        Control::default(),
    )
    .unwrap();
    assert!(found.targets.is_empty() && found.statistics.median_db.is_none());
    let silly = MeasureOptions::default().with_threshold_db(3.0);
    assert!(measure_targets(&view, &straight, &silly, Control::default()).is_err());
}

/// Echoes of `scene` taken from `truth_m`.
fn echoes(truth_m: &[[f64; 3]], frequency_hz: &[f64], scene: Scene) -> Vec<Complex64> {
    let range_m = |p: &[f64; 3], [x, y]: [f64; 2]| {
        ((p[0] - x).powi(2) + (p[1] - y).powi(2) + p[2].powi(2)).sqrt()
    };
    truth_m
        .iter()
        .flat_map(|p| {
            frequency_hz.iter().map(move |f| {
                scene
                    .iter()
                    .map(|(amplitude, at)| {
                        let r = range_m(p, *at);
                        Complex64::from_polar(amplitude / (r * r), -4.0 * PI * f * r / 3e8)
                    })
                    .sum()
            })
        })
        .collect()
}

/// Images `scene`, flown along `truth_m`, with the positions of `believed`, and measures it twice:
/// by Eq. (5) alone, and with the echoes at hand.
fn measure_blurred(
    believed: &PointSpread,
    truth_m: &[[f64; 3]],
    scene: Scene,
    grid: PlaneGrid,
) -> [Measurement; 2] {
    use acerra_imaging::metrics::measure_targets_in;
    use acerra_imaging::{ImagingPlan, PlanOptions, PulseArrays, Pulses};
    let spectrum = echoes(truth_m, believed.frequency_hz(), scene);
    let pulses = Pulses::new(PulseArrays {
        position_m: believed.position_m(),
        frequency_hz: believed.frequency_hz(),
        spectrum: &spectrum,
        weight: believed.weight(),
        light_speed_m_s: 3e8,
    })
    .unwrap();
    let plan = ImagingPlan::new(pulses, grid, &PlanOptions::default()).unwrap();
    let mut values = vec![Complex32::default(); grid.len()];
    plan.run(&mut values, Control::default()).unwrap();
    let view = ImageView::new(&values, grid).unwrap();
    let options = MeasureOptions::default();
    [
        measure_targets(&view, believed, &options, Control::default()).unwrap(),
        measure_targets_in(&view, &pulses, &options, Control::default()).unwrap(),
    ]
}

#[test]
fn pieces_of_a_blurred_target_are_no_targets() {
    // Errors of 4 mm along the line of sight that change over half a metre of path.
    let believed = spread(|s| [s, 0.15 * (PI * s / 6.0).cos()], 1.5, 3.0, 0.015);
    let error_m = |s: f64| 0.0035 * ((11.0 * s).sin() + (7.3 * s + 1.0).cos());
    let truth_m: Vec<[f64; 3]> = believed
        .position_m()
        .iter()
        .map(|p| [p[0], p[1], p[2] + error_m(p[0])])
        .collect();
    let grid = PlaneGrid::from_ranges([-0.8, 0.8], [-2.2, 2.4], 0.0, 0.0125).unwrap();
    let [ideal, told] = measure_blurred(&believed, &truth_m, &[(1.0, [0.1, 1.5])], grid);
    println!("{ideal:#?} {told:#?}");
    assert!(ideal.targets.len() > 1, "the errors break the image");
    assert_eq!(told.targets.len(), 1);
    assert!((told.targets[0].x_m - 0.1).abs() < 0.03 && (told.targets[0].y_m - 1.5).abs() < 0.1);
}

#[test]
fn a_weaker_target_beside_a_stronger_one_is_kept() {
    let flown = spread(|s| [s, 0.1 * (PI * s / 6.0).cos()], 1.5, 3.0, 0.015);
    let truth_m = flown.position_m().to_vec();
    let grid = PlaneGrid::from_ranges([-0.8, 0.8], [0.8, 2.2], 0.0, 0.0125).unwrap();
    // At the same range, so that both share a range cell all along the flight.
    for amplitude in [1.0, 0.7, 0.45, 0.35, 0.3] {
        let scene = [(1.0, [-0.15, 1.5]), (amplitude, [0.2, 1.5])];
        let [ideal, told] = measure_blurred(&flown, &truth_m, &scene, grid);
        let places = |m: &Measurement| m.targets.iter().map(|t| t.x_m).collect::<Vec<_>>();
        println!("{amplitude}: {:?} {:?}", places(&ideal), places(&told));
        assert_eq!(told.targets.len(), 2, "{amplitude}: {told:#?}");
        let mut x_m = places(&told);
        x_m.sort_by(f64::total_cmp);
        assert!((x_m[0] + 0.15).abs() < 0.02 && (x_m[1] - 0.2).abs() < 0.02);
    }
}
