//! The figures and costs of `docs/validation/inversion.md` that take too long for a test: Figures 7 and 12 of
//! Catapano et al. (2020) by every method, and a volume of five tracks.
//!
//! `ACERRA_DOCS=$PWD/docs/validation cargo bench -p acerra --bench inversion -- figure-7 figure-12 costs memory`
//! writes tables and pictures into the page; without `ACERRA_DOCS` the tables are printed only. `volume`
//! prints its table alone.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program for the page alone

mod cost;
mod measure;
#[allow(dead_code, reason = "shared with the tests of the book")]
#[path = "../../tests/validation_book/page.rs"]
mod page;
mod picture;
mod point_spread;
mod scene;
mod solve;
mod survey;
mod table;
mod volume;

use acerra_chain::focus::inversion::Method;
use page::Page;
use picture::{View, picture};
use scene::Scene;
use solve::{Run, run};
use std::process::Command;

/// The methods of the page, in its order.
const METHODS: [Method; 5] = [
    Method::Adjoint,
    Method::Tsvd,
    Method::Cgls,
    Method::Sparse,
    Method::Clean,
];

/// A scene and its images by every method.
type Imaged = (Scene, Vec<Run>);

/// Under this setting glibc gives every freed array back to the system at once, so that no peak hides in memory
/// that was freed before; it doubles the time.
const GIVE_BACK: [&str; 2] = ["MALLOC_MMAP_THRESHOLD_", "262144"];

fn main() {
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "figure-7" => figure_7(),
            "figure-12" => figure_12(),
            "costs" => costs(),
            "memory" => memory(),
            "volume" => volume::volume(),
            "--bench" => {}
            other => panic!("expected figure-7, figure-12, costs, memory or volume, found {other}"),
        }
    }
}

fn figure_7() {
    let imaged = by_every_method(point_spread::scenes());
    let rows = imaged
        .iter()
        .map(|(scene, runs)| (scene, runs.as_slice(), View::Whole));
    let png = picture(rows);
    let blocks = [
        ("figure-7", table::targets(&imaged)),
        ("figure-7-costs", table::costs(&imaged[3..4])),
    ];
    publish(&blocks, Some(("inversion-figure-7", png, 2)));
}

fn figure_12() {
    let imaged = by_every_method(survey::scenes());
    let whole = imaged
        .iter()
        .map(|(scene, runs)| (scene, runs.as_slice(), View::Marked));
    let near = imaged
        .iter()
        .map(|(scene, runs)| (scene, runs.as_slice(), View::FirstTarget));
    let png = picture(whole.chain(near));
    let table = table::targets(&imaged);
    publish(
        &[("figure-12", table)],
        Some(("inversion-figure-12", png, 2)),
    );
}

/// Times on the paper's grid of Figure 12b.
fn costs() {
    let imaged = by_every_method(vec![survey::track_2()]);
    publish(&[("costs", table::costs(&imaged))], None);
}

/// Greatest memory on the same grid, by a process of its own.
fn memory() {
    if std::env::var_os(GIVE_BACK[0]).is_none() {
        let mut again = Command::new(std::env::current_exe().unwrap());
        let again = again.arg("memory").env(GIVE_BACK[0], GIVE_BACK[1]);
        assert!(again.status().unwrap().success());
        return;
    }
    let imaged = by_every_method(vec![survey::track_2()]);
    publish(&[("memory", table::memory(&imaged))], None);
}

fn by_every_method(scenes: Vec<Scene>) -> Vec<Imaged> {
    let solve = |scene: Scene| {
        let runs = METHODS.iter().map(|method| {
            let run = run(&scene, *method, None).unwrap();
            println!("{}", table::progress(&scene, &run));
            run
        });
        let runs = runs.collect();
        (scene, runs)
    };
    scenes.into_iter().map(solve).collect()
}

/// Writes blocks and a picture (name, PNG, reduction) into the page where `ACERRA_DOCS` names the book's folder.
fn publish(blocks: &[(&str, String)], picture: Option<(&str, Vec<u8>, usize)>) {
    for (name, content) in blocks {
        println!("{name}\n{content}");
    }
    if std::env::var_os("ACERRA_DOCS").is_none() {
        return;
    }
    let mut page = Page::open("inversion.md");
    for (name, content) in blocks {
        page.block(name, content);
    }
    if let Some((name, png, reduction)) = picture {
        page.speckled_picture(name, &png, reduction);
    }
    page.close();
}
