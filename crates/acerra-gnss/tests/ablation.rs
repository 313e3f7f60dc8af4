//! What the rules beyond RTKLIB are worth: right and wrong fixes of derived logs with each of them
//! switched off alone, for `docs/validation/ppk-rules.md`.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod rtklib;

use acerra_gnss::{PpkOptions, process};
use rtklib::derived::{Known, variation};
use rtklib::sets::{GEONET, STATIC_1HZ, STATIC_M8P, Set, WETTZELL};

/// First seed, and number of draws of each set both ways.
const SEEDS: std::ops::Range<u64> = 2_000..2_020;

/// A rule, and how its option switches it off.
type Rule = (&'static str, fn(&mut PpkOptions));

const RULES: [Rule; 15] = [
    ("all rules", |_| {}),
    ("success rate and confirmation", |o| {
        o.min_success_rate = None
    }),
    ("residuals of phases", |o| o.max_phase_residual_sigma = None),
    ("residuals of codes", |o| o.max_code_residual_sigma = None),
    ("noise of codes measured", |o| o.measure_code_noise = false),
    ("integers beside the filter", |o| o.revisable_hold = false),
    ("alternatives", |o| o.try_alternatives = false),
    ("partial resolution", |o| o.partial_ambiguity = None),
    ("weak signals by their drop", |o| {
        o.weak_signal_drop_db = None
    }),
    ("weak signals by C/N₀", |o| o.weigh_weak_signals = false),
    ("base interpolated", |o| o.interpolate_base = false),
    ("single point without one satellite", |o| o.raim = false),
    ("troposphere of the height", |o| {
        o.troposphere_follows_height = false
    }),
    ("ambiguities of 50 cycles", |o| o.initial_bias_cycles = 30.0),
    ("no prior from single points", |o| {
        o.single_point_sigma_m = 30.0
    }),
];

/// Right and wrong fixes of the draws of every set.
fn counted(sets: &[Known], switch: fn(&mut PpkOptions)) -> [usize; 2] {
    let mut counts = [0; 2];
    for known in sets {
        for seed in SEEDS {
            let (logs, mut options, _) = variation(known, seed);
            switch(&mut options);
            // Draws may leave nothing in common.
            if let Ok(solution) = process(&logs.rover, &logs.base, &logs.navigation, &options) {
                let judged = known.judge(&solution);
                counts[0] += judged.fixed - judged.wrong;
                counts[1] += judged.wrong;
            }
        }
    }
    counts
}

#[test]
#[ignore = "thousands of solutions, for a table of the validation book"]
fn rules_switched_off_one_by_one() {
    let sets: [&'static Set; 4] = [&STATIC_M8P, &GEONET, &WETTZELL, &STATIC_1HZ];
    let mut known = Vec::new();
    for set in sets {
        let [Some(plain), Some(other)] = [Known::read(set), Known::read(set)] else {
            return;
        };
        known.extend([plain, other.exchanged()]);
    }
    println!("| rule switched off | right | wrong |\n| --- | --- | --- |");
    let mut found = Vec::new();
    for (name, switch) in RULES {
        let [right, wrong] = counted(&known, switch);
        println!("| {name} | {right} | {wrong} |");
        found.push([right, wrong]);
    }
    let [all, unconfirmed] = [found[0], found[1]];
    assert!(500 * all[1] < all[0], "{all:?}");
    assert!(unconfirmed[1] > 10 * all[1].max(1), "{unconfirmed:?}");
}
