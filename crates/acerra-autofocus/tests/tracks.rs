//! Several tracks together: their delays, phases and places against each other.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

mod passes;

use std::f64::consts::PI;

use acerra_autofocus::{Autofocused, Decision};
use passes::{PULSES, Passes, SECOND, Truth};

/// Errors of the globals in units of their posterior deviations; phases by their turn.
fn errors(passes: &Passes, found: &Autofocused) -> Vec<f64> {
    let each = found.globals.iter().zip(passes.values());
    each.map(|(global, truth)| {
        let apart = global.value - truth;
        let apart = match global.name.as_str() {
            "phase" => (apart + PI).rem_euclid(2.0 * PI) - PI,
            _ => apart,
        };
        apart / global.sigma
    })
    .collect()
}

/// Delay, phase and place of the second pass against the first are found, and the image of both is as sharp as
/// with the truth.
#[test]
fn two_passes_become_one_aperture() {
    for seed in 0..3 {
        let passes = Passes::new(seed, Truth::drawn);
        let found = passes.focus(&passes.prior(), &[]);
        assert_eq!(found.decision, Decision::Applied, "seed {seed}");
        for (global, error) in found.globals.iter().zip(errors(&passes, &found)) {
            assert!(error.abs() < 4.0, "seed {seed}, {error}: {global:?}");
            let is_told = global.sigma < 0.5 * global.prior_sigma;
            assert!(is_told, "seed {seed}: {global:?}");
        }
        let [before, after] = passes.loss_db(&found, true);
        assert!(
            before > 2.0 && after < 0.1,
            "seed {seed}: {before} dB to {after} dB"
        );
    }
}

/// Mean square errors of what the second pass has for its own, in units of their posterior deviations.
#[test]
fn posterior_deviations_of_tracks_are_true() {
    let draws = 8;
    let mut sums = [0.0; 5];
    for seed in 200..200 + draws {
        let passes = Passes::new(seed, Truth::drawn);
        let found = passes.focus(&passes.prior(), &[]);
        for (sum, error) in sums.iter_mut().zip(errors(&passes, &found)) {
            *sum += error * error / draws as f64;
        }
    }
    // 99.95 % of χ² of 8 and of 40 degrees of freedom, over these; no more than three times too wide.
    for (name, square) in ["delay", "phase", "east", "north", "up"].iter().zip(sums) {
        assert!((0.1..3.49).contains(&square), "{name}: {square}, {sums:?}");
    }
    let all = sums.iter().sum::<f64>() / 5.0;
    assert!((0.4..1.86).contains(&all), "{all}: {sums:?}");
}

/// Targets that turn their phase between the passes, each its own: the passes' powers are summed, each point has
/// a phase a pass, and the sum is as sharp as with the truth.
#[test]
fn targets_may_turn_between_tracks_that_are_summed_by_power() {
    for seed in 10..13 {
        let passes = Passes::new(seed, |rng| Truth {
            phase_rad: 0.0,
            targets_turn: true,
            ..Truth::drawn(rng)
        });
        let mut prior = passes.prior();
        prior.globals.retain(|global| global.name != "phase");
        let found = passes.focus(&prior, &[0..SECOND.start, SECOND]);
        assert_eq!(found.decision, Decision::Applied, "seed {seed}");
        let [before, after] = passes.loss_db(&found, false);
        assert!(
            before > 1.0 && after < 0.1,
            "seed {seed}: {before} dB to {after} dB"
        );
    }
}

/// Passes that have nothing for their own lose nothing.
#[test]
fn right_tracks_stay_or_do_no_harm() {
    for seed in 20..22 {
        let passes = Passes::new(seed, |_| Truth::default());
        for (parts, together) in [(vec![], true), (vec![0..SECOND.start, SECOND], false)] {
            let found = passes.focus(&passes.prior(), &parts);
            let [before, after] = passes.loss_db(&found, together);
            assert!(after < before + 0.1, "{seed}: {before} dB to {after} dB");
        }
    }
}

/// Parts that leave pulses out are refused.
#[test]
#[should_panic(expected = "Parts")]
fn parts_hold_every_pulse() {
    let passes = Passes::new(30, |_| Truth::default());
    passes.focus(
        &passes.prior(),
        &[0..SECOND.start, SECOND.start..PULSES - 1],
    );
}
