//! Burials in full-wave scenes: every scene imaged with its ground stated right, and what a wrong ground becomes.

mod grid;
mod scene;
mod settings;

use std::fmt::Write as _;

use acerra_products::Outcome;
use acerra_products::display::Shown;
use acerra_products::pictures;
use rayon::prelude::*;

use crate::page::Page;
use scene::{Scene, Stated};

/// Columns on the targets of a scene.
const COUNTS: &str = "found | weak | others | weak others | largest error across, in depth (m)";

/// Scenes whose sections are shown.
const SHOWN: [&str; 4] = ["level-1", "layers-1", "relief-4", "lossy-1"];

/// The section of a scene, seen from the south.
fn section(outcome: &Outcome) -> Vec<u8> {
    let made = pictures::of_stacks(outcome).unwrap();
    let front = made
        .into_iter()
        .find(|(name, _)| name == "volume-front.png");
    front.unwrap().1.png
}

#[test]
#[ignore = "some thirty images; cargo xtask validate, as CI does"]
fn validation_book_ground() {
    let mut page = Page::open("ground.md");
    let mut text = format!(
        "| scene | permittivity | conductivity (S/m) | {COUNTS} |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n"
    );
    let (mut cylinders, mut found, mut listed, mut most_others) = (0, 0, 0, 0);
    let mut right = settings::RightDoubts::new();
    let images: Vec<(Scene, Outcome)> = (Scene::all().into_par_iter())
        .map(|scene| {
            let outcome = Stated::of(&scene).run().unwrap();
            (scene, outcome)
        })
        .collect();
    for (scene, outcome) in images {
        let compared = scene.compared(&outcome);
        if SHOWN.contains(&scene.name.as_str()) {
            page.speckled_picture(&format!("ground-{}", scene.name), &section(&outcome), 3);
        }
        let _ = writeln!(
            text,
            "| {} | {} | {} | {}",
            scene.name,
            scene.permittivities(),
            scene.soil[0].conductivity_s_m,
            compared.cells(),
        );
        let [doubts, _] = settings::remarks(&outcome);
        cylinders += scene.cylinders.len();
        found += compared.cylinders(true);
        listed += compared.cylinders(true) + compared.cylinders(false);
        most_others = most_others.max(compared.others(true));
        right.insert(scene.name, doubts);
    }
    let _ = write!(
        text,
        "| all | | | {found} of {cylinders} | {} | | | |",
        listed - found
    );
    println!("{text}");
    // The goal: 25 of 30 burials, and no more than one other target that exceeds the clutter in a scene.
    assert!(6 * found >= 5 * cylinders, "{found} of {cylinders}");
    assert!(most_others <= 1, "{most_others}");
    page.block("scenes", &text);
    let of_grid = grid::run();
    page.block("grid", &grid::table(&of_grid));
    let above = pictures::image(&of_grid, &Shown::of(&of_grid)).unwrap();
    page.speckled_picture("ground-grid-above", &above.png, 3);
    page.speckled_picture("ground-grid-front", &section(&of_grid), 3);
    page.block("settings", &settings::table(&right));
    page.close();
}
