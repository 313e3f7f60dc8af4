//! Wrong settings of the ground: each row of the table gives the targets found and the finding that names the setting.

use std::collections::BTreeMap;

use acerra_chain::findings::Verdict;
use acerra_products::{Outcome, RunError};
use rayon::prelude::*;

use super::COUNTS;
use super::scene::{Compared, Scene, Stated};

const NOT_NOTICED: &str = "NOT NOTICED";

/// A setting made wrong, as the table calls it, in a scene.
struct Wrong {
    name: &'static str,
    scene: &'static str,
    change: fn(&mut Stated),
}

fn scaled(stated: &mut Stated, factor: f64) {
    for soil in &mut stated.scene.soil {
        soil.relative_permittivity *= factor;
    }
}

fn thicker(stated: &mut Stated, factor: f64) {
    for soil in &mut stated.scene.soil {
        soil.thickness_m = soil.thickness_m.map(|m| m * factor);
    }
}

fn with_conductivity(stated: &mut Stated, conductivity_s_m: f64) {
    for soil in &mut stated.scene.soil {
        soil.conductivity_s_m = conductivity_s_m;
    }
}

const fn wrong(name: &'static str, scene: &'static str, change: fn(&mut Stated)) -> Wrong {
    Wrong {
        name,
        scene,
        change,
    }
}

const WRONG: [Wrong; 16] = [
    wrong("permittivity 30 % too low", "level-1", |s| scaled(s, 0.7)),
    wrong("permittivity 30 % too high", "level-1", |s| scaled(s, 1.3)),
    wrong("permittivity half", "level-1", |s| scaled(s, 0.5)),
    wrong("permittivity twice", "level-1", |s| scaled(s, 2.0)),
    wrong("surface 3 cm too low", "level-1", |s| {
        s.surface_off_m = -0.03;
    }),
    wrong("surface 3 cm too high", "level-1", |s| {
        s.surface_off_m = 0.03;
    }),
    wrong("terrain 3 cm too low", "relief-2", |s| {
        s.surface_off_m = -0.03;
    }),
    wrong("zero of fast time 0.3 ns too late", "level-1", |s| {
        s.delay_off_ns = 0.3;
    }),
    wrong("first layer half as thick", "layers-2", |s| thicker(s, 0.5)),
    wrong("second layer left out", "layers-2", |s| {
        s.scene.soil.truncate(1);
    }),
    wrong("wet layer on top left out", "wet-1", |s| {
        s.scene.soil.remove(0);
    }),
    wrong("coupling and surface echo not removed", "level-1", |s| {
        s.background = Some("none");
    }),
    wrong("the mean removed, not the surface echo", "level-1", |s| {
        s.background = Some("mean");
    }),
    wrong("image from the surface downwards", "level-1", |s| {
        s.top_m = 0.0;
    }),
    wrong("conductivity a fifth", "lossy-1", |s| {
        with_conductivity(s, 0.002);
    }),
    wrong("conductivity a hundred times", "lossy-1", |s| {
        with_conductivity(s, 1.0);
    }),
];

/// Remarks of a run on its settings: findings that do not agree by name, and the settings that nothing checks.
pub fn remarks(outcome: &Outcome) -> [Vec<String>; 2] {
    let doubts = outcome.evidence.findings().iter();
    let doubts = doubts
        .filter(|finding| finding.verdict != Verdict::Agrees)
        .map(|finding| finding.name.clone());
    let unchecked = outcome.unchecked.iter().map(|one| one.setting.to_owned());
    [doubts.collect(), unchecked.collect()]
}

/// Findings that do not agree where the ground is stated right, by scene.
pub type RightDoubts = BTreeMap<String, Vec<String>>;

/// The table of wrong settings. A finding that the right campaign of a scene raises as well names no wrong setting.
pub fn table(right: &RightDoubts) -> String {
    let mut text = format!(
        "| wrong setting | scene | {COUNTS} | named by |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n"
    );
    let rows: Vec<String> = WRONG.par_iter().map(|wrong| wrong.row(right)).collect();
    text.push_str(&rows.concat());
    println!("{text}");
    assert!(!text.contains(NOT_NOTICED), "{text}");
    text
}

impl Wrong {
    /// The row of the table.
    fn row(&self, right: &RightDoubts) -> String {
        let Self { name, change, .. } = self;
        let scene = Scene::read(self.scene);
        let mut stated = Stated::of(&scene);
        change(&mut stated);
        match stated.run() {
            Ok(outcome) => {
                let compared = scene.compared(&outcome);
                let named = named(&compared, &outcome, &right[&scene.name]);
                format!(
                    "| {name} | {} | {} {named} |\n",
                    scene.name,
                    compared.cells()
                )
            }
            Err(RunError::Contradicted { found }) => {
                let names: Vec<&str> = (found.lines())
                    .filter_map(|line| Some(line.trim().split_once(':')?.0))
                    .collect();
                format!(
                    "| {name} | {} | – | – | – | – | – | refused: {} |\n",
                    scene.name,
                    names.join(", ")
                )
            }
            Err(error) => panic!("{name}: {error}"),
        }
    }
}

/// How a run names its wrong setting; `right` are the findings that the right campaign raises.
fn named(compared: &Compared, outcome: &Outcome, right: &[String]) -> String {
    let is_right = compared.found.iter().all(Option::is_some) && compared.others(true) <= 1;
    let [mut doubts, unchecked] = remarks(outcome);
    doubts.retain(|name| !right.contains(name));
    match (doubts.is_empty(), is_right) {
        (false, _) => doubts.join(", "),
        (true, true) => "harmless".to_owned(),
        (true, false) if unchecked.is_empty() => NOT_NOTICED.to_owned(),
        (true, false) => format!("unchecked: {}", unchecked.join(", ")),
    }
}
