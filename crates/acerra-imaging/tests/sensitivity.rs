//! Theory and Monte Carlo of positioning errors agree.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests; what validation found

use acerra_imaging::Control;
use acerra_imaging::psf::{PointSpread, TrackShape, synthetic_track};
use acerra_imaging::sensitivity::{ErrorModel, Estimate, MonteCarlo, predict, simulate};

const TARGET: [f64; 3] = [0.0, 2.0, 0.0];
/// The 95 % intervals (1.96 standard errors) are stretched to 3.8: then all of some seventy figures
/// lie within theirs at once with a confidence of 99 %.
const STRETCH: f64 = 1.94;

fn spread(step_m: f64) -> PointSpread {
    let track = synthetic_track(TrackShape::Straight, 3.0, step_m, 5.0).unwrap();
    let frequency_hz = (0..171).map(|n| 3.1e9 + 1e7 * f64::from(n)).collect();
    PointSpread::new(track, None, frequency_hz, 3e8).unwrap()
}

fn compare(name: &str, spread: &PointSpread, model: &ErrorModel, trials: usize, seed: u64) -> bool {
    let theory = predict(spread, TARGET, model).unwrap();
    let drawn = simulate(
        spread,
        TARGET,
        model,
        MonteCarlo { trials, seed },
        Control::default(),
    )
    .unwrap();
    println!("{name}: coherence {:.1} dB", theory.coherence_db);
    let check = |what: &str, expected: Option<f64>, found: Option<Estimate>| {
        let (Some(expected), Some(found)) = (expected, found) else {
            return true;
        };
        let fine = found.covers(expected, STRETCH);
        println!(
            "  {what:<18}{expected:>10.4}  Monte Carlo {:>9.4} [{:.4}, {:.4}]{}",
            found.value,
            found.low,
            found.high,
            if fine { "" } else { "  DISAGREES" }
        );
        fine
    };
    let mm = |e: Estimate| Estimate {
        value: 1e3 * e.value,
        low: 1e3 * e.low,
        high: 1e3 * e.high,
    };
    let thousand = |v: Option<f64>| v.map(|v| 1e3 * v);
    [
        check(
            "loss at target, dB",
            Some(theory.loss_at_target_db),
            Some(drawn.loss_at_target_db),
        ),
        check(
            "loss at peak, dB",
            theory.peak_loss_db,
            Some(drawn.peak_loss_db),
        ),
        check(
            "shift along, mm",
            thousand(theory.shift_along_m),
            Some(mm(drawn.shift_along_m)),
        ),
        check(
            "shift across, mm",
            thousand(theory.shift_across_m),
            Some(mm(drawn.shift_across_m)),
        ),
        check(
            "widening along",
            theory.widening_along,
            drawn.widening_along,
        ),
        check(
            "widening across",
            theory.widening_across,
            drawn.widening_across,
        ),
    ]
    .iter()
    .all(|fine| *fine)
}

fn agree(white_cm: &[f64], drift_cm: &[f64], correlation_m: &[f64], trials: usize) {
    let spread = spread(0.03);
    let mut fine = true;
    // Draws of their own for each case: one unlucky set does not speak for all.
    let mut seed = 0;
    for sigma_cm in white_cm {
        seed += 1;
        let model = ErrorModel::white(0.01 * sigma_cm, spread.position_m().len()).unwrap();
        fine &= compare(
            &format!("white {sigma_cm} cm"),
            &spread,
            &model,
            trials,
            seed,
        );
    }
    for length_m in correlation_m {
        for sigma_cm in drift_cm {
            seed += 1;
            let place = spread.position_m().iter().map(|p| p[0]).collect();
            let model = ErrorModel::drifting(0.01 * sigma_cm, place, *length_m).unwrap();
            let name = format!("drifting {sigma_cm} cm over {length_m} m");
            fine &= compare(&name, &spread, &model, trials, seed);
        }
    }
    assert!(fine);
}

#[test]
fn theory_and_monte_carlo_agree() {
    agree(&[0.2, 0.8, 3.0], &[0.5, 3.0], &[20.0], 120);
}

/// All of 0.2 to 3 cm, with more draws.
#[test]
#[ignore = "half a minute of draws; cargo xtask validate, as CI does"]
fn validation_theory_and_monte_carlo_agree_from_2_mm_to_3_cm() {
    let sigma_cm = [0.2, 0.5, 0.8, 1.0, 1.5, 2.0, 3.0];
    agree(&sigma_cm, &sigma_cm, &[20.0, 2.0], 1000);
}
