//! Wrong settings, one at a time: how many are refused, doubted with their cause named, harmless, or
//! silent and wrong.
//!
//! `cargo xtask wrong-settings` runs the whole table and writes
//! `docs/validation/wrong-settings.md`.

#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)] // tests, and helpers of tests

mod edit;
#[path = "../validation_book/page.rs"]
#[expect(dead_code, reason = "these pages have no pictures")]
mod page;
mod subjects;
mod table;
mod trajectories;
mod verdict;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use page::Page;
use subjects::{Subject, Subjects};
use table::{Row, Size};
use verdict::{Outcome, Run};

/// Side of a pixel of the whole table, and of the part that every test run covers (m).
const PIXEL_M: f64 = 0.03;
const COARSE_PIXEL_M: f64 = 0.03;

/// One cell of the table; none where the setting does not exist in the campaign.
fn cell(subject: &Subject, right: &Run, row: &Row, size: &Size) -> Option<Outcome> {
    let campaign = subject.settings.edited(&size.edits)?;
    let run = verdict::run(&campaign, &subject.folder);
    let (what, label) = (&row.what, &size.label);
    println!("{what} {label}: {:?}", run.findings);
    Some(run.outcome(right, &subject.truth, &row.causes))
}

/// Outcomes of a row's sizes.
type Cells = Vec<Option<Outcome>>;

fn word(outcome: &Option<Outcome>) -> &'static str {
    outcome.as_ref().map_or("–", Outcome::word)
}

/// Every row tried on a subject.
fn tried_on(subject: &Subject, rows: &[&Row]) -> Vec<Cells> {
    let right = right(subject);
    let tried = |row: &&Row| -> Cells {
        let cell = |size: &Size| {
            let outcome = cell(subject, &right, row, size);
            let (name, what, label) = (subject.name, &row.what, &size.label);
            println!("{name:8} {what} {label}: {outcome:?}");
            outcome
        };
        row.sizes.iter().map(cell).collect()
    };
    rows.iter().map(tried).collect()
}

fn right(subject: &Subject) -> Run {
    let run = verdict::run(&subject.settings.campaign, &subject.folder);
    let targets = run.targets.as_ref().unwrap();
    assert_eq!(
        subject.truth.wrong(targets, targets),
        None,
        "{}",
        subject.name
    );
    assert!(!run.contradicts);
    println!("{}: {:#?}\n{:#?}", subject.name, run.findings, run.doubts);
    run
}

#[test]
fn no_wrong_setting_of_a_kind_each_goes_unnoticed() {
    const COVERED: [(&str, usize); 12] = [
        ("`time_offset_s` too great", 1),
        ("`delay_ns` too short", 2),
        ("`light_speed_m_s`", 2),
        ("`origin_deg_m` too high", 1),
        ("no `origin_deg_m`", 0),
        ("`lever_arm_m` (up)", 2),
        ("image to the north", 0),
        ("`band_ghz`", 1),
        ("`frequencies`", 2),
        ("`gate_ns`", 2),
        ("another flight's logs", 0),
        ("trajectory in another unit of length", 2),
    ];
    let subjects = Subjects::new(COARSE_PIXEL_M, |name| name == "track-2");
    let subject = subjects.all.iter().find(|s| s.name == "track-2").unwrap();
    let right = right(subject);
    let rows = table::rows();
    for (what, size) in COVERED {
        let row = rows.iter().find(|row| row.what == what).unwrap();
        let outcome = cell(subject, &right, row, &row.sizes[size]).unwrap();
        assert!(
            !matches!(outcome, Outcome::Silent(_) | Outcome::Misled(_)),
            "{what} {}: {outcome:?}",
            row.sizes[size].label
        );
    }
}

#[test]
#[ignore = "hundreds of runs: cargo xtask wrong-settings"]
fn the_whole_table_of_wrong_settings() {
    // Parts of the table: a campaign, or, while something is looked into, words of rows.
    let only = std::env::var("ACERRA_SWEEP_ONLY").unwrap_or_default();
    let one = std::env::var("ACERRA_SWEEP_SUBJECT").unwrap_or_default();
    let subjects = Subjects::new(PIXEL_M, |name| name.contains(&one));
    let all_rows = table::rows();
    let rows: Vec<&Row> = all_rows
        .iter()
        .filter(|row| only.split(',').any(|word| row.what.contains(word)))
        .collect();
    let tried: Vec<Vec<Cells>> = std::thread::scope(|scope| {
        let running: Vec<_> = subjects
            .all
            .iter()
            .map(|subject| scope.spawn(|| tried_on(subject, &rows)))
            .collect();
        running.into_iter().map(|run| run.join().unwrap()).collect()
    });
    let names: Vec<&str> = subjects.all.iter().map(|s| s.name).collect();
    let mut text = format!(
        "| setting | {} |\n| --- |{}\n",
        names.join(" | "),
        " --- |".repeat(names.len())
    );
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let mut unnoticed = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        let labels: Vec<&str> = row.sizes.iter().map(|size| size.label.as_str()).collect();
        let _ = write!(text, "| {}: {} |", row.what, labels.join("; "));
        for (subject, cells) in subjects.all.iter().zip(&tried) {
            let words: Vec<&str> = cells[k].iter().map(word).collect();
            let _ = write!(text, " {} |", words.join(", "));
            for (size, outcome) in row.sizes.iter().zip(&cells[k]) {
                let Some(outcome) = outcome else { continue };
                let is_unnoticed = matches!(outcome, Outcome::Silent(_) | Outcome::Misled(_));
                let word = outcome.word();
                *counts.entry(word).or_default() += 1;
                if is_unnoticed {
                    let (name, what, label) = (subject.name, &row.what, &size.label);
                    unnoticed.push(format!("- {name}: {what}, {label} ({word})"));
                    println!("{name}: {what} {label}: {outcome:?}");
                }
            }
        }
        text.push('\n');
    }
    println!("{counts:?}\n{text}\n{}", unnoticed.join("\n"));
    if !only.is_empty() {
        return;
    }
    let total: Vec<String> = counts
        .iter()
        .map(|(word, n)| format!("{n} {word}"))
        .collect();
    let mut page = Page::open("wrong-settings.md");
    page.block("counts", &total.join(", "));
    page.block("table", &text);
    let open = if unnoticed.is_empty() {
        "None.".to_owned()
    } else {
        unnoticed.join("\n")
    };
    page.block("open", &open);
    page.close();
    assert!(unnoticed.is_empty(), "{open}");
}
