//! Several tracks and several looks: what coherence gains, and what summing powers gains.
#![allow(clippy::unwrap_used)]

mod common;
use common::{Campaign, Random};

use acerra_imaging::looks::{LookWindow, add_power, looks};
use acerra_imaging::tracks::{Calibration, CalibrationOptions, calibrate_on_target};
use acerra_imaging::{
    Complex32, Complex64, Control, ImagingError, PlanOptions, PlaneGrid, Pulses, Spreading, image,
    reference,
};
use std::f64::consts::TAU;

/// 3.1–4.8 GHz in steps of 25 MHz.
fn frequencies() -> Vec<f64> {
    (0..69).map(|n| 3.1e9 + 2.5e7 * f64::from(n)).collect()
}

/// All tracks as one.
fn together(tracks: &[Campaign]) -> Campaign {
    Campaign {
        position_m: tracks.iter().flat_map(|t| t.position_m.clone()).collect(),
        frequency_hz: tracks[0].frequency_hz.clone(),
        spectrum: tracks.iter().flat_map(|t| t.spectrum.clone()).collect(),
        weight: tracks.iter().flat_map(|t| t.weight.clone()).collect(),
    }
}

const TRACKS_M: [f64; 5] = [0.0, -2.0, -1.0, 1.0, 2.0];

/// Five tracks 1 m apart at h = 5 m over a target at d = 2 m, with noise at −10 dB a sample.
fn five_tracks(target_m: [f64; 3], errors: &[Calibration; 5], seed: u64) -> Vec<Campaign> {
    let mut random = Random(seed);
    let scene = [reference::Scatterer {
        position_m: target_m,
        reflectivity: Complex64::ONE,
    }];
    TRACKS_M
        .iter()
        .zip(errors)
        .map(|(&x, error)| {
            let position = (0..101)
                .map(|m| [x, -2.0 + 0.04 * f64::from(m), 5.0])
                .collect();
            let mut data = Campaign::quiet(position, frequencies(), &scene);
            let rms = (data.spectrum.iter().map(|e| e.norm_sqr()).sum::<f64>()
                / data.spectrum.len() as f64)
                .sqrt();
            for row in data.spectrum.chunks_mut(69) {
                for (e, f) in row.iter_mut().zip(&data.frequency_hz) {
                    *e *= Complex64::cis(error.phase_rad - TAU * f * error.delay_s);
                    *e += Complex64::new(random.next(), random.next()) * (0.4 * rms);
                }
            }
            data
        })
        .collect()
}

fn peak(image: &[Complex32]) -> f32 {
    image.iter().map(|v| v.norm()).fold(0.0, f32::max)
}

/// Level of the ghost mirrored at the middle track under the target's, dB.
fn ghost_db(data: &Campaign) -> f64 {
    let at = |x: f64| PlaneGrid::new([x - 0.3, -0.3, 0.0], 0.02, [31, 31]).unwrap();
    let options = PlanOptions::default();
    let [ghost, there] = [-2.0, 2.0]
        .map(|x| peak(&image(data.pulses(), at(x), &options, Control::default()).unwrap()));
    f64::from(20.0 * (ghost / there).log10())
}

#[test]
fn calibrated_tracks_suppress_the_ghost_and_others_do_not() {
    let target = [2.0, 0.0, 0.0];
    let mut random = Random(2020);
    for seed in 1..=3 {
        let mut errors = [Calibration::default(); 5];
        for error in &mut errors[1..] {
            error.delay_s = 1.2e-9 * random.next();
            error.phase_rad = 3.1 * random.next();
        }
        let mut tracks = five_tracks(target, &errors, seed);
        let one = ghost_db(&tracks[0]);
        let raw = ghost_db(&together(&tracks));

        // Both maxima of the middle track, ghost first: the others tell which is the target.
        let candidates = [[-2.0, 0.0, 0.0], [2.0, 0.01, 0.0], [1.2, 0.7, 0.0]];
        let borrowed: Vec<_> = tracks.iter().map(Campaign::pulses).collect();
        let found = calibrate_on_target(
            &borrowed,
            &candidates,
            CalibrationOptions {
                window_s: 3e-9,
                spreading: Spreading::InverseSquare,
            },
            &|_, _| 0.0,
            Control::default(),
        )
        .unwrap();
        assert!((found.position_m[0] - 2.0).abs() < 0.01, "{found:?}");
        assert!(found.position_m[1].abs() < 0.01, "{found:?}");
        for ((track, error), estimate) in tracks.iter_mut().zip(&errors).zip(&found.estimates) {
            let delay = estimate.calibration.delay_s - error.delay_s;
            assert!(delay.abs() < 0.03e-9, "{delay:e} {estimate:?}");
            assert!(delay.abs() < 6.0 * estimate.delay_sigma_s.max(2e-12));
            assert!(estimate.contrast_db > 10.0 && estimate.phase_sigma_rad < 0.3);
            let frequency_hz = track.frequency_hz.clone();
            estimate
                .calibration
                .remove(&frequency_hz, &mut track.spectrum)
                .unwrap();
        }
        let calibrated = ghost_db(&together(&tracks));
        assert!(one.abs() < 0.7, "{one} dB");
        assert!(calibrated < one - 12.0, "{calibrated} dB of {one} dB");
        assert!(
            raw > calibrated + 4.0,
            "{raw} dB uncalibrated, {calibrated} dB calibrated"
        );
    }
}

#[test]
fn impossible_calibrations_are_refused() {
    let tracks = five_tracks([2.0, 0.0, 0.0], &[Calibration::default(); 5], 1);
    let pulses = [tracks[0].pulses()];
    let run = |tracks: &[Pulses], candidates: &[[f64; 3]], window_s| {
        let options = CalibrationOptions {
            window_s,
            spreading: Spreading::None,
        };
        calibrate_on_target(tracks, candidates, options, &|_, _| 0.0, Control::default())
            .unwrap_err()
    };
    assert_eq!(
        run(&[], &[[0.0; 3]], 1e-9),
        ImagingError::Empty { what: "tracks" }
    );
    assert!(matches!(
        run(&pulses, &[], 1e-9),
        ImagingError::Empty { .. }
    ));
    assert!(matches!(
        run(&pulses, &[[0.0; 3]], 0.0),
        ImagingError::OutOfRange { .. }
    ));
    let bad = Calibration {
        delay_s: f64::NAN,
        ..Default::default()
    };
    assert!(bad.remove(&[1e9], &mut [Complex64::ONE]).is_err());
    let good = Calibration::default();
    assert!(good.remove(&[1e9, 2e9], &mut [Complex64::ONE; 3]).is_err());
}

#[test]
fn looks_lower_speckle_by_their_number() {
    // Ground of many small scatterers; each look images it from its own direction.
    let mut random = Random(7);
    let scene: Vec<_> = (0..4000)
        .map(|_| reference::Scatterer {
            position_m: [3.5 + 1.6 * random.next(), 1.6 * random.next(), 0.0],
            reflectivity: Complex64::new(random.next(), random.next()),
        })
        .collect();
    let track: Vec<[f64; 3]> = (0..128)
        .map(|m| [0.0, -2.54 + 0.04 * f64::from(m), 4.0])
        .collect();
    let data = Campaign::quiet(track.clone(), frequencies(), &scene);
    // Every 12 cm, farther apart than a cell: independent samples.
    let grid = PlaneGrid::new([2.5, -1.0, 0.0], 0.04, [51, 51]).unwrap();
    let options = PlanOptions::default();
    let multilook = |count: usize, overlap: f64, window| {
        let mut power = vec![0f32; grid.len()];
        for look in looks(&track, count, overlap, window).unwrap() {
            let mut part = data.pulses().slice(look.pulses.clone()).unwrap();
            part = part.with_weight(&look.weight).unwrap();
            let image = image(part, grid, &options, Control::default()).unwrap();
            add_power(&mut power, &image).unwrap();
        }
        // Range falls off over the patch: compare within a row's neighbourhood by normalising columns.
        let mut even = power.clone();
        for i in 0..grid.nx {
            let column = (0..grid.ny).map(|j| power[j * grid.nx + i]);
            let mean = column.sum::<f32>() / grid.ny as f32;
            for j in 0..grid.ny {
                even[j * grid.nx + i] /= mean;
            }
        }
        equivalent_looks(&even)
    };
    let one = multilook(1, 0.0, LookWindow::Rectangular);
    let four = multilook(4, 0.0, LookWindow::Rectangular);
    let eight = multilook(8, 0.0, LookWindow::Rectangular);
    let overlapping = multilook(7, 0.5, LookWindow::Hann);
    assert!((0.8..1.3).contains(&one), "{one}");
    assert!((3.2..5.0).contains(&four), "{four}");
    assert!((5.8..10.0).contains(&eight), "{eight}");
    // Half-overlapping Hann looks are partly correlated, but seven of them beat four.
    assert!(
        (4.0..7.5).contains(&overlapping) && overlapping > four,
        "{overlapping} {four}"
    );
}

/// Equivalent number of looks of an image of power over even ground: mean² over variance.
fn equivalent_looks(power: &[f32]) -> f64 {
    let n = power.len().max(1) as f64;
    let mean = power.iter().map(|p| f64::from(*p)).sum::<f64>() / n;
    let variance = power
        .iter()
        .map(|p| (f64::from(*p) - mean).powi(2))
        .sum::<f64>()
        / n;
    mean * mean / variance
}
