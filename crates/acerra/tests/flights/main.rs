//! Random flights with right settings, their clock offset left to the data: how many are imaged right, and
//! whether any is wrong without a word.
//!
//! `cargo xtask validate flights` runs them and writes `docs/validation/right-settings.md`.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // tests, and helpers of tests

mod flight;
mod judge;
#[path = "../validation_book/page.rs"]
#[expect(dead_code, reason = "this page has no pictures")]
mod page;
mod path;
mod random;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::RangeInclusive;

use flight::RandomFlight;
use judge::{Class, Errors, Judged};
use page::Page;
use path::{SHAPES, Shape};

/// Flights of the page, and of the quick draw.
const WHOLE: RangeInclusive<u64> = 421..=620;
const QUICK: RangeInclusive<u64> = 3..=12;

/// Simulates and processes the flights of some seeds.
fn flown(seeds: RangeInclusive<u64>) -> Vec<(u64, String, Judged)> {
    let home = tempfile::tempdir().unwrap();
    let fly = |seed: u64| {
        let folder = home.path().join(seed.to_string());
        let mut flight = RandomFlight::of(seed);
        let started = std::time::Instant::now();
        let (campaign, offset_s) = flight.written(&folder);
        let simulated_s = started.elapsed().as_secs_f64();
        let judged = judge::judged(&flight, &campaign, offset_s, &folder);
        let total_s = started.elapsed().as_secs_f64();
        println!(
            "{seed} ({}): {} {} {:?} [{simulated_s:.1} of {total_s:.1} s]",
            flight.what,
            judged.class.word(),
            judged.details,
            judged.offset_s
        );
        if std::env::var_os("ACERRA_FLIGHTS_KEEP").is_none() {
            std::fs::remove_dir_all(&folder).unwrap();
        }
        (seed, flight.what, judged)
    };
    let all = seeds.map(fly).collect();
    if std::env::var_os("ACERRA_FLIGHTS_KEEP").is_some() {
        println!("kept in {}", home.keep().display());
    }
    all
}

/// Shares of errors within one and two deviations, along and across.
fn coverage(flights: &[(u64, String, Judged)]) -> String {
    let errors: Vec<&Errors> = flights
        .iter()
        .flat_map(|(_, _, judged)| &judged.errors)
        .collect();
    let percent = |axis: usize, sigmas: f64| {
        let within = errors.iter().filter(|e| e[axis].abs() <= sigmas).count();
        100.0 * within as f64 / errors.len().max(1) as f64
    };
    let shares = |axis: usize| format!("{:.0} / {:.0} %", percent(axis, 1.0), percent(axis, 2.0));
    let offsets: Vec<[f64; 2]> = flights
        .iter()
        .filter_map(|(_, _, judged)| judged.offset_s)
        .collect();
    let held = |sigmas: f64| {
        offsets
            .iter()
            .filter(|[off, sigma]| off.abs() <= sigmas * sigma)
            .count()
    };
    format!(
        "{} reflectors: {} within 1 σ / 2 σ along the track, {} across. {} clock offsets: {} / {} within 1 σ / 2 σ.",
        errors.len(),
        shares(0),
        shares(1),
        offsets.len(),
        held(1.0),
        held(2.0)
    )
}

fn counts<'a>(
    flights: impl IntoIterator<Item = &'a (u64, String, Judged)>,
) -> BTreeMap<Class, usize> {
    let mut counts = BTreeMap::new();
    for (_, _, judged) in flights {
        *counts.entry(judged.class).or_default() += 1;
    }
    counts
}

fn in_words(counts: &BTreeMap<Class, usize>) -> String {
    let each = counts
        .iter()
        .map(|(class, count)| format!("{count} {}", class.word()));
    each.collect::<Vec<_>>().join(", ")
}

/// Counts of the outcomes, a row a shape.
fn by_shape(flights: &[(u64, String, Judged)]) -> String {
    let mut table = String::from("| shape | flights | outcomes |\n| --- | --- | --- |\n");
    for shape in SHAPES.map(Shape::name) {
        let of_shape: Vec<&(u64, String, Judged)> = flights
            .iter()
            .filter(|(_, what, _)| what.starts_with(shape))
            .collect();
        let words = in_words(&counts(of_shape.iter().copied()));
        let _ = writeln!(table, "| {shape} | {} | {words} |", of_shape.len());
    }
    table
}

/// Every flight whose outcome is not right, a row each.
fn not_right(flights: &[(u64, String, Judged)]) -> String {
    let mut table =
        String::from("| seed | flight | offset | outcome |\n| --- | --- | --- | --- |\n");
    let others = flights
        .iter()
        .filter(|(_, _, judged)| judged.class != Class::Right);
    for (seed, what, judged) in others {
        let offset = judged.offset_s.map_or(String::new(), |[off_s, sigma_s]| {
            format!("{:+.1} ± {:.1} ms", 1e3 * off_s, 1e3 * sigma_s)
        });
        let word = judged.class.word();
        let _ = writeln!(table, "| {seed} | {what} | {offset} | {word} |");
    }
    table
}

#[test]
fn a_quick_draw_is_never_silently_wrong() {
    let flights = flown(QUICK);
    let counts = counts(&flights);
    println!("{}; {}", in_words(&counts), coverage(&flights));
    assert_eq!(counts.get(&Class::Silent), None);
    let right = counts.get(&Class::Right).copied().unwrap_or(0);
    // What is right today: a floor, not the aim.
    assert!(right >= 7, "{}", in_words(&counts));
}

/// `ACERRA_FLIGHTS=41-60` tries other seeds than those of the page, and writes none.
#[test]
#[ignore = "minutes: cargo xtask validate flights"]
fn random_flights() {
    let asked = std::env::var("ACERRA_FLIGHTS").ok();
    let seeds = asked.as_deref().map_or(WHOLE, |text| {
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        first.parse().unwrap()..=last.parse().unwrap()
    });
    let flights = flown(seeds);
    let words = in_words(&counts(&flights));
    let coverage = coverage(&flights);
    println!("{words}\n{coverage}");
    if asked.is_none() {
        let mut page = Page::open("right-settings.md");
        page.block("counts", &format!("{words}.\n\n{coverage}"));
        page.block("shapes", &by_shape(&flights));
        page.block("flights", &not_right(&flights));
        page.close();
    }
    assert_eq!(counts(&flights).get(&Class::Silent), None, "{words}");
}
