//! How far fixes can be believed: tables over all static sets.

use super::enu;
use super::sets::{GEONET, Logs, M8P_ROVER_ENU_M, STATIC_1HZ, STATIC_M8P, Set, WETTZELL};
use acerra_gnss::{PpkOptions, PpkSolution, Quality, SystemSet, process};
use std::fmt::Write;

/// Fixes further than this from the truth are wrong (m).
const WRONG_M: f64 = 0.1;
const WINDOW_S: f64 = 300.0;
const STARTS: usize = 16;

/// A set whose rover stood still: east, north, up of the base, and where that is from.
pub struct Static {
    pub set: &'static Set,
    pub truth_enu_m: fn() -> [f64; 3],
}

fn mosaic_truth() -> [f64; 3] {
    let place = |file| super::position_file(STATIC_1HZ.folder, file);
    enu(place("base_position.txt"), place("rover_position.txt"))
}

/// Known coordinates; where there are none, the mean of RTKLIB's fixed epochs.
pub const SETS: [Static; 4] = [
    Static {
        set: &WETTZELL,
        truth_enu_m: || [-0.417_88, 1.535_23, 0.081_42],
    },
    Static {
        set: &GEONET,
        truth_enu_m: || [-953.336_8, 3_196.239_1, -6.396_4],
    },
    Static {
        set: &STATIC_1HZ,
        truth_enu_m: mosaic_truth,
    },
    Static {
        set: &STATIC_M8P,
        truth_enu_m: || M8P_ROVER_ENU_M,
    },
];

/// East, north, up of a set's rover from its base (m), where that stood still.
pub fn truth_of(set: &Set) -> Option<[f64; 3]> {
    let known = SETS.iter().find(|s| s.set.folder == set.folder)?;
    Some((known.truth_enu_m)())
}

/// Fixed epochs and wrong ones among them.
pub fn fixed_and_wrong(solution: &PpkSolution, truth_enu_m: [f64; 3]) -> (usize, usize) {
    let base = solution.base_position_ecef_m.unwrap();
    let fixed = solution
        .epochs
        .iter()
        .filter(|e| e.quality == Quality::Fixed);
    let wrong = fixed
        .clone()
        .filter(|e| super::distance(enu(base, e.position_ecef_m), truth_enu_m) > WRONG_M);
    (fixed.count(), wrong.count())
}

/// Defaults, with the base's position of the set.
pub fn default_options(set: &Set) -> PpkOptions {
    let defaults = PpkOptions::default();
    set.adapt(defaults.clone())
        .with_systems(defaults.systems)
        .with_glonass_ambiguity(defaults.glonass_ambiguity)
}

pub fn run(logs: &Logs, options: &PpkOptions) -> PpkSolution {
    process(&logs.rover, &logs.base, &logs.navigation, options).unwrap()
}

/// Windows of 300 s from every static set: fixed and wrong.
pub fn windows_table(text: &mut String) {
    writeln!(
        text,
        "\n## Short logs\n\n\
         Windows of {WINDOW_S} s at {STARTS} starts evenly through each static log, by defaults, and by \
         GPS alone. Wrong: further than {WRONG_M} m from the truth. RTKLIB-EX is not among the \
         programs that the page is made with: its shares are not known.\n\n\
         | set | systems | epochs | fixed | wrong |\n| --- | --- | --- | --- | --- |"
    )
    .unwrap();
    for Static { set, truth_enu_m } in &SETS {
        let logs = set.read().unwrap();
        let (first, last) = (
            logs.rover.epochs[0].time,
            logs.rover.epochs.last().unwrap().time,
        );
        let spare_s = (last.seconds_since(first) - WINDOW_S).max(0.0);
        for (name, systems) in [("all", None), ("GPS", Some(SystemSet::GPS))] {
            let (mut epochs, mut fixed, mut wrong) = (0, 0, 0);
            for k in 0..STARTS {
                let start = first + spare_s * k as f64 / (STARTS - 1) as f64;
                let mut options = default_options(set)
                    .with_start(Some(start))
                    .with_end(Some(start + WINDOW_S));
                options.systems = systems.unwrap_or(options.systems);
                let solution = run(&logs, &options);
                let (f, w) = fixed_and_wrong(&solution, truth_enu_m());
                epochs += solution.summary.rover_epochs;
                fixed += f;
                wrong += w;
            }
            assert_eq!(wrong, 0, "{} {name}", set.name);
            writeln!(
                text,
                "| {} | {name} | {epochs} | {fixed} ({:.1} %) | {wrong} |",
                set.name,
                100.0 * fixed as f64 / epochs as f64
            )
            .unwrap();
        }
    }
}
