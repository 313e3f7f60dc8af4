//! Quantities of the whole flight: found where the flight tells them, left at their priors where not,
//! with true deviations everywhere and no harm anywhere.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

mod wandering;

use acerra_autofocus::{Autofocused, Decision};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use wandering::{CLOCK, DELAY, DRIFT, FORWARD, Flight, HEIGHT, LEFT, Motion, NAMES, SPEED, UP};

const ALL: [usize; 8] = [DELAY, CLOCK, DRIFT, FORWARD, LEFT, UP, HEIGHT, SPEED];
const PATH_SIGMA_M: f64 = 0.003;

/// Errors of the globals in units of their posterior deviations, squared.
fn squares(flight: &Flight, found: &Autofocused) -> Vec<f64> {
    let of = |global: &acerra_autofocus::GlobalFound| {
        let j = NAMES.iter().position(|name| *name == global.name).unwrap();
        ((global.value - flight.truth.values[j]) / global.sigma).powi(2)
    };
    found.globals.iter().map(of).collect()
}

/// A flight that wanders, climbs and turns tells everything; the image is as sharp as with the truth, on the
/// plane where the targets are.
#[test]
fn a_wandering_flight_tells_its_globals() {
    for seed in [0, 1] {
        let flight = Flight::new(seed, Motion::Wandering, &ALL, PATH_SIGMA_M);
        let found = flight.focus(&flight.prior(&ALL, 1.0));
        assert_eq!(found.decision, Decision::Applied);
        for (global, square) in found.globals.iter().zip(squares(&flight, &found)) {
            assert!(square < 16.0, "seed {seed}: {global:?}");
            let told = if global.name == "drift" { 0.6 } else { 0.2 };
            assert!(global.sigma < told * global.prior_sigma, "{global:?}");
        }
        let [before, after] = flight.loss_db(&found);
        assert!(
            before > 3.0 && after < 0.1,
            "seed {seed}: {before} dB to {after} dB"
        );
    }
}

/// A straight flight at one speed sees neither clock nor lever arm along and across: they move the image.
/// The estimate holds still there, and says so.
#[test]
fn what_a_straight_flight_cannot_see_stays_at_its_prior() {
    let flight = Flight::new(1, Motion::Straight, &ALL, PATH_SIGMA_M);
    let found = flight.focus(&flight.prior(&ALL, 1.0));
    for name in ["clock", "forward", "left"] {
        let global = found.globals.iter().find(|g| g.name == name).unwrap();
        assert!(global.sigma > 0.99 * global.prior_sigma, "{global:?}");
        assert!(global.value.abs() < 0.05 * global.prior_sigma, "{global:?}");
    }
    // Up and height differ by what they do to the lever arm alone: nothing on a level flight.
    let of = |name| found.globals.iter().find(|g| g.name == name).unwrap();
    assert!(of("up").sigma > 0.9 * of("up").prior_sigma);
    assert!(of("delay").sigma < 0.2 * of("delay").prior_sigma);
}

/// Globals and errors of the path drawn from their priors: mean square error in units of the posterior
/// deviations, of each global and of all, on flights that tell much and on flights that tell little.
#[test]
fn posterior_deviations_of_globals_are_true() {
    let draws = 8;
    let mut of_global = [0.0; 8];
    let mut path = 0.0;
    for seed in 100..100 + draws {
        for motion in [Motion::Wandering, Motion::Straight] {
            let flight = Flight::new(seed, motion, &ALL, PATH_SIGMA_M);
            let found = flight.focus(&flight.prior(&ALL, 1.0));
            for (sum, square) in of_global.iter_mut().zip(squares(&flight, &found)) {
                *sum += square / (2 * draws) as f64;
            }
            path += flight.path_square(&found) / (2 * draws) as f64;
        }
    }
    // Above: 99.95 % of χ² of 16 and of 128 degrees of freedom, over these. Below: no more than three times
    // too wide (delays are about twice).
    for (name, square) in NAMES.iter().zip(of_global) {
        assert!((0.1..2.46).contains(&square), "{name}: {square}");
    }
    let all = of_global.iter().sum::<f64>() / 8.0;
    assert!((0.5..1.46).contains(&all), "{all}: {of_global:?}");
    assert!((0.3..2.0).contains(&path), "path: {path}");
}

/// Deviations three times too small or too large: never less sharp than as stated.
#[test]
fn wrong_priors_of_globals_do_no_harm() {
    for (seed, motion) in [
        (0, Motion::Wandering),
        (1, Motion::Wandering),
        (0, Motion::Straight),
        (1, Motion::Straight),
    ] {
        let flight = Flight::new(seed, motion, &ALL, PATH_SIGMA_M);
        for factor in [1.0 / 3.0, 3.0] {
            let found = flight.focus(&flight.prior(&ALL, factor));
            let [before, after] = flight.loss_db(&found);
            assert!(
                after < before + 0.1,
                "{motion:?} {seed}, {factor}: {before} dB to {after} dB, {:?}",
                found.decision
            );
        }
    }
}

/// Nothing is wrong: nothing changes, or nothing for the worse. Many points, three, one.
#[test]
fn right_globals_stay_or_do_no_harm() {
    for motion in [Motion::Wandering, Motion::Straight] {
        for count in [10, 3, 1] {
            let targets: Vec<[f64; 2]> = (0..count)
                .map(|k| [2.0 + 0.43 * f64::from(k), 1.5 + f64::from((7 * k) % 10)])
                .collect();
            let mut rng = ChaCha8Rng::seed_from_u64(7);
            let flight = Flight::over(&mut rng, motion, [0.0; 8], 1e-5, &targets);
            let mut prior = flight.prior(&ALL, 1.0);
            for c in &mut prior.covariance_m2 {
                (0..3).for_each(|i| c[i][i] = 1e-6);
            }
            let found = flight.focus(&prior);
            let [before, after] = flight.loss_db(&found);
            assert!(
                after < before + 0.1,
                "{motion:?}, {count} targets: {before} dB to {after} dB, {:?}",
                found.decision
            );
        }
    }
}

/// Without globals in the prior none are estimated.
#[test]
fn known_globals_are_not_estimated() {
    let flight = Flight::new(3, Motion::Wandering, &[], PATH_SIGMA_M);
    let found = flight.focus(&flight.prior(&[], 1.0));
    assert_eq!(found.decision, Decision::Applied);
    assert!(found.globals.is_empty());
    assert!(flight.loss_db(&found)[1] < 0.1);
}
