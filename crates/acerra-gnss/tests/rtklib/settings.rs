//! What hangs on frequencies and on settings that nobody measures: tables.

use super::sets::{LG69T, STATIC_1HZ, STATIC_M8P, WALK, WETTZELL};
use super::trust::{default_options, fixed_and_wrong, run, truth_of};
use acerra_gnss::{Cn0Mask, PpkOptions};
use std::fmt::Write;

/// Sets with more than one frequency, by the first alone and by all.
pub fn frequencies_table(text: &mut String) {
    text.push_str(
        "\n## One frequency and all\n\n\
         By defaults with one, two and three frequencies. Wrong: further than 0.1 m from the truth, \
         where that is known.\n\n\
         | set | L1: fixed, wrong | L1 + L2 | L1 + L2 + L5 |\n| --- | --- | --- | --- |\n",
    );
    for set in [&WETTZELL, &STATIC_1HZ, &LG69T] {
        let logs = set.read().unwrap();
        let mut cells = String::new();
        for frequencies in 1..=3 {
            let options = default_options(set).with_frequencies(frequencies);
            let solution = run(&logs, &options);
            let wrong = truth_of(set).map(|truth| fixed_and_wrong(&solution, truth).1);
            assert!(wrong.unwrap_or(0) == 0, "{} {frequencies}", set.name);
            let wrong = wrong.map_or(String::from("–"), |n| n.to_string());
            let (fixed, of) = (solution.summary.fixed, solution.summary.rover_epochs);
            write!(cells, " {fixed} of {of}, {wrong} |").unwrap();
        }
        writeln!(text, "| {} |{cells}", set.name).unwrap();
    }
}

/// Fixes of three single-frequency sets by other values of settings that no log says.
pub fn sensitivity_table(text: &mut String) {
    text.push_str(
        "\n## Settings that no log says\n\n\
         The initial standard deviation of an ambiguity must exceed the worst code, or the first \
         code would count twice; beyond that nothing should hang on it. The carrier-to-noise masks \
         that are tried where fixing is poor (35 and 40 dB-Hz) are replaced here by one mask \
         throughout. Fixed epochs, of which off by more than 0.1 m.\n\n\
         | settings | still (NEO-M8P) | walk (NEO-M8P) | walk (LG69T) |\n\
         | --- | --- | --- | --- |\n",
    );
    type Change = fn(PpkOptions) -> PpkOptions;
    let changes: [(&str, Change); 7] = [
        ("default (50 cycles, no mask of one's own)", |o| o),
        ("initial ambiguity: 30 cycles", |o| {
            o.with_initial_bias_cycles(30.0)
        }),
        ("initial ambiguity: 100 cycles", |o| {
            o.with_initial_bias_cycles(100.0)
        }),
        ("initial ambiguity: 300 cycles", |o| {
            o.with_initial_bias_cycles(300.0)
        }),
        ("mask of 30 dB-Hz", |o| {
            o.with_cn0_mask(Some(Cn0Mask::uniform(30.0)))
        }),
        ("mask of 34 dB-Hz", |o| {
            o.with_cn0_mask(Some(Cn0Mask::uniform(34.0)))
        }),
        ("mask of 38 dB-Hz", |o| {
            o.with_cn0_mask(Some(Cn0Mask::uniform(38.0)))
        }),
    ];
    for (name, change) in changes {
        let mut cells = String::new();
        for set in [&STATIC_M8P, &WALK, &LG69T] {
            let logs = set.read().unwrap();
            let solution = run(&logs, &change(default_options(set)));
            let wrong = truth_of(set).map(|truth| fixed_and_wrong(&solution, truth).1);
            assert!(wrong.unwrap_or(0) == 0, "{} {name}", set.name);
            let wrong = wrong.map_or(String::new(), |n| format!(", {n}"));
            write!(cells, " {}{wrong} |", solution.summary.fixed).unwrap();
        }
        writeln!(text, "| {name} |{cells}").unwrap();
    }
}
