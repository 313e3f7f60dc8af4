//! How far fixes and stated standard deviations can be believed: tables over all static sets.

use super::enu;
use super::sets::{GEONET, Logs, STATIC_1HZ, STATIC_M8P, Set, WETTZELL};
use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::{AmbiguityMode, PpkOptions, PpkSolution, Quality, SystemSet, process};
use std::fmt::Write;

/// Fixes further than this from the truth are wrong (m).
const WRONG_M: f64 = 0.1;
const WINDOW_S: f64 = 300.0;
const STARTS: usize = 16;

/// A set whose rover stood still: east, north, up of the base, and where that is from.
struct Static {
    set: &'static Set,
    truth_enu_m: fn() -> [f64; 3],
}

fn mosaic_truth() -> [f64; 3] {
    let place = |file| super::position_file(STATIC_1HZ.folder, file);
    enu(place("base_position.txt"), place("rover_position.txt"))
}

/// Known coordinates; where there are none, the mean of RTKLIB's fixed epochs.
const SETS: [Static; 4] = [
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
        truth_enu_m: || M8P_TRUTH,
    },
];

/// Median of the fixed epochs by RTKLIB's rules with GLONASS resolved (1201 of 1202).
const M8P_TRUTH: [f64; 3] = [-0.237_1, 0.227_5, -0.004_3];

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

/// Epochs of one quality, and those of them whose horizontal error lies within the 68.3 % and the
/// 95.4 % ellipse of their stated covariance.
#[derive(Clone, Copy, Default)]
struct Within {
    epochs: usize,
    inside: [usize; 2],
}

impl Within {
    fn of(solution: &PpkSolution, truth_enu_m: [f64; 3], quality: Quality) -> Self {
        let frame = EnuFrame::from_ecef(solution.base_position_ecef_m.unwrap());
        let of_quality = solution.epochs.iter().filter(|e| e.quality == quality);
        let squares: Vec<f64> = of_quality
            .map(|e| {
                let found = frame.enu_from_ecef(e.position_ecef_m);
                let [x, y] = [found[0] - truth_enu_m[0], found[1] - truth_enu_m[1]];
                let q = frame.enu_covariance_from_ecef(&e.covariance_ecef_m2);
                let determinant = q[0][0] * q[1][1] - q[0][1] * q[1][0];
                (q[1][1] * x * x - 2.0 * q[0][1] * x * y + q[0][0] * y * y) / determinant
            })
            .collect();
        let up_to = |limit: f64| squares.iter().filter(|s| **s <= limit).count();
        Self {
            epochs: squares.len(),
            // Quantiles of χ² with two degrees of freedom.
            inside: [up_to(2.296), up_to(6.180)],
        }
    }

    fn add(&mut self, other: Self) {
        self.epochs += other.epochs;
        for (own, theirs) in self.inside.iter_mut().zip(other.inside) {
            *own += theirs;
        }
    }

    /// Shares in per cent.
    fn shares(self) -> [f64; 2] {
        self.inside
            .map(|n| 100.0 * n as f64 / self.epochs.max(1) as f64)
    }
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
         GPS alone. Wrong: further than {WRONG_M} m from the truth.\n\n\
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

/// Whole static logs: fixed, wrong, and errors against stated standard deviations.
pub fn sigma_table(text: &mut String) {
    text.push_str(
        "\n## Stated standard deviations\n\n\
         Whole static logs by defaults, and with ambiguities left float. Shares of the epochs whose \
         horizontal error lies within the 68.3 % and the 95.4 % ellipse of their stated covariance. \
         One log is one realisation of its multipath: float errors hardly change within it.\n\n\
         | set | epochs | fixed | wrong | fixed within 68 % | fixed within 95 % | float within 68 % | float within 95 % |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    let (mut counts, mut all) = ([0; 3], [Within::default(); 2]);
    let mut row = |name: &str, [epochs, fixed, wrong]: [usize; 3], of: [Within; 2]| {
        let [of_fixed, of_float] = of.map(Within::shares);
        writeln!(
            text,
            "| {name} | {epochs} | {fixed} | {wrong} | {:.1} | {:.1} | {:.1} | {:.1} |",
            of_fixed[0], of_fixed[1], of_float[0], of_float[1]
        )
        .unwrap();
    };
    for Static { set, truth_enu_m } in &SETS {
        let logs = set.read().unwrap();
        let truth = truth_enu_m();
        let solution = run(&logs, &default_options(set));
        let float = default_options(set).with_ambiguity(AmbiguityMode::Off);
        let float = run(&logs, &float);
        let (fixed, wrong) = fixed_and_wrong(&solution, truth);
        let own = [
            Within::of(&solution, truth, Quality::Fixed),
            Within::of(&float, truth, Quality::Float),
        ];
        let of_set = [solution.summary.rover_epochs, fixed, wrong];
        row(set.name, of_set, own);
        for (sum, one) in counts.iter_mut().zip(of_set) {
            *sum += one;
        }
        for (sum, one) in all.iter_mut().zip(own) {
            sum.add(one);
        }
        if set.folder == STATIC_M8P.folder {
            assert!(fixed >= 1195 && wrong == 0, "{fixed} fixed, {wrong} wrong");
        }
    }
    row("all", counts, all);
    let [of_fixed, of_all_fixed] = all[0].shares();
    assert!((of_fixed - 68.3).abs() < 5.0, "{of_fixed} %");
    assert!((of_all_fixed - 95.4).abs() < 3.0, "{of_all_fixed} %");
}
