//! Whole runs of the command, stage by stage: what a user waits for.
//!
//! `cargo bench -p acerra --bench whole_runs` prints the table of `docs/speed.md`. Arguments: `runs=5`;
//! `against=PATH`, another `acerra` that runs in turn with this one; `only=spectra-1000`; `sizes` runs images of
//! growing size instead; `check` fails where a whole run takes more than its share of the stages that cannot be done
//! without.
#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program for the page alone

mod case;
mod command;
mod spectra;

use case::Case;
use command::{Cost, run};

/// Whole runs of logs, and of spectra, at most so many times what reading, positioning and focusing take.
const MOST_OF_LOGS: f64 = 4.0;
const MOST_OF_SPECTRA: f64 = 6.0;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |name: &str| {
        let named = |a: &String| a.strip_prefix(name)?.strip_prefix('=').map(str::to_owned);
        arguments.iter().find_map(named)
    };
    let runs: usize = value("runs").map_or(3, |text| text.parse().unwrap());
    let other = value("against");
    let only = value("only");
    let is_checked = arguments.iter().any(|a| a == "check");
    let cases = if arguments.iter().any(|a| a == "sizes") {
        Case::sizes()
    } else {
        Case::all()
    };
    let folder = tempfile::tempdir().unwrap();
    println!("{}", Cost::HEAD);
    let mut exceeded = Vec::new();
    for case in cases {
        if only.as_ref().is_some_and(|name| *name != case.name) {
            continue;
        }
        let place = folder.path().join(case.name);
        std::fs::create_dir(&place).unwrap();
        let campaign = case.write(&place);
        let mut own = Vec::new();
        let mut others = Vec::new();
        // In turn, so that both meet the machine at its other work alike.
        for _ in 0..runs {
            own.push(run(env!("CARGO_BIN_EXE_acerra"), &campaign));
            others.extend(other.as_ref().map(|program| run(program, &campaign)));
        }
        let own = Cost::median(&own);
        println!("{}", own.row(case.name));
        if !others.is_empty() {
            let others = Cost::median(&others);
            println!("{}", others.row(&format!("{}, other", case.name)));
            println!("{}", own.ratios(&others));
        }
        let most = if case.is_of_logs {
            MOST_OF_LOGS
        } else {
            MOST_OF_SPECTRA
        };
        let share = own.over_needed();
        if share > most {
            exceeded.push(format!("{}: {share:.1} times, at most {most}", case.name));
        }
    }
    for line in &exceeded {
        println!("more than its share: {line}");
    }
    assert!(
        !is_checked || exceeded.is_empty(),
        "whole runs take more than their share"
    );
}
