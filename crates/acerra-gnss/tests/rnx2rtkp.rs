//! Every mode against RTKLIB's own program, where it is installed (Debian's package `rtklib`).

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod rtklib;

use acerra_gnss::{
    AmbiguityMode, BaselineLength, FilterDirection, GlonassAmbiguity, PositioningMode, PpkOptions,
    System, SystemSet, process,
};
use rtklib::sets::{STATIC_1HZ, Set, WALK, WETTZELL};
use rtklib::{PosEpoch, data, distance, read_pos};
use std::path::Path;
use std::process::Command;

/// A case: name, lines that replace those of the set's configuration, and the same as options.
type Case = (&'static str, &'static [&'static str], fn(&mut PpkOptions));

const CASES: [Case; 12] = [
    ("float", &["pos2-armode=off"], |o| {
        o.ambiguity = AmbiguityMode::Off
    }),
    ("three iterations", &["pos2-niter=3"], |o| o.iterations = 3),
    ("instantaneous", &["pos2-armode=instantaneous"], |o| {
        o.ambiguity = AmbiguityMode::Instantaneous;
    }),
    ("continuous", &["pos2-armode=continuous"], |o| {
        o.ambiguity = AmbiguityMode::Continuous
    }),
    ("GLONASS float", &["pos2-gloarmode=off"], |o| {
        o.glonass_ambiguity = GlonassAmbiguity::Off;
    }),
    ("GLONASS resolved", &["pos2-gloarmode=on"], |o| {
        o.glonass_ambiguity = GlonassAmbiguity::On;
    }),
    ("two frequencies", &["pos1-frequency=l1+2"], |o| {
        o.frequencies = 2
    }),
    (
        "two frequencies, five systems",
        &["pos1-frequency=l1+2", "pos1-navsys=61"],
        |o| {
            o.frequencies = 2;
            o.systems = SystemSet::ALL.without(System::Sbas).without(System::Navic);
        },
    ),
    ("static", &["pos1-posmode=static"], |o| {
        o.mode = PositioningMode::Static
    }),
    ("differential", &["pos1-posmode=dgps"], |o| {
        o.mode = PositioningMode::Dgps
    }),
    ("single", &["pos1-posmode=single"], |o| {
        o.mode = PositioningMode::Single
    }),
    ("backward", &["pos1-soltype=backward"], |o| {
        o.direction = FilterDirection::Backward
    }),
];

fn run_rtklib(set: &Set, changes: &[&str], folder: &Path) -> Vec<PosEpoch> {
    let input = data(set.folder).unwrap();
    let mut text =
        std::fs::read_to_string(input.join("reference/b34_fixhold_forward.conf")).unwrap();
    for change in ["out-solformat=xyz"].iter().chain(changes) {
        let (key, value) = change.split_once('=').unwrap();
        let kept: Vec<&str> = text
            .lines()
            .filter(|l| l.split('=').next().unwrap().trim() != key)
            .collect();
        text = format!("{}\n{key} ={value}\n", kept.join("\n"));
    }
    let (conf, out) = (folder.join("case.conf"), folder.join("case.pos"));
    std::fs::write(&conf, text).unwrap();
    let status = Command::new("rnx2rtkp")
        .arg("-k")
        .arg(&conf)
        .arg("-o")
        .arg(&out)
        .args(set.files().iter().map(|f| input.join(f)))
        .output()
        .unwrap();
    assert!(status.status.success());
    read_pos(out)
}

/// A handed-out pair treated as if its base moved: the vector between the antennas against
/// RTKLIB's. RTKLIB moves a base to the rover's time by its velocity and leaves the vector where it
/// was, so that receivers whose epochs are apart differ by the noise of the velocity over that time.
#[test]
#[ignore = "runs another program many times; cargo xtask validate, as CI does"]
fn validation_moving_base_against_rnx2rtkp() {
    if Command::new("rnx2rtkp").arg("-?").output().is_err() {
        println!("skipped: rnx2rtkp is not installed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // Largest distance (m) of fixed vectors, and the known length with its deviation (m).
    let cases = [
        (&WETTZELL, 1e-3, None),
        (&STATIC_1HZ, 1e-3, None),
        // RTKLIB repeats the update of an epoch twice where it knows the length.
        (&STATIC_1HZ, 5e-3, Some((0.9867, 0.005))),
    ];
    for (set, tolerance_m, known) in cases {
        let Some(logs) = set.read() else { return };
        let mut changes = vec![
            "pos1-posmode=movingbase".to_owned(),
            "out-solformat=enu".into(),
        ];
        if let Some((length_m, sigma_m)) = known {
            changes.push(format!("pos2-baselen={length_m}"));
            changes.push(format!("pos2-basesig={sigma_m}"));
        }
        let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        let theirs = run_rtklib(set, &changes, folder.path());
        let options = set
            .adapt(PpkOptions::rtklib().with_reproduce_defects(true))
            .with_mode(PositioningMode::MovingBase)
            .with_baseline_length(
                known.map(|(length_m, sigma_m)| BaselineLength { length_m, sigma_m }),
            );
        let solution = process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
        let (mut alike, mut fixed, mut distances) = (0, 0, Vec::new());
        for t in &theirs {
            let k = solution
                .epochs
                .partition_point(|e| e.time.seconds_since(t.time) < -0.02);
            let ours = solution.epochs.get(k);
            let Some(e) = ours.filter(|e| e.time.seconds_since(t.time).abs() < 0.02) else {
                continue;
            };
            fixed += usize::from(t.quality == 1);
            if e.quality.number() == t.quality {
                alike += 1;
                if t.quality == 1 {
                    distances.push(distance(e.baseline.unwrap().enu_m(), t.position_m));
                }
            }
        }
        distances.sort_by(f64::total_cmp);
        let largest_m = distances.last().copied().unwrap();
        println!(
            "{}, moving base{}: {alike} of {} alike, {fixed} fixed there; fixed vectors {:.2} mm \
             apart in the median, {:.2} mm at most",
            set.name,
            known.map_or("", |_| " of known length"),
            theirs.len(),
            1e3 * distances[distances.len() / 2],
            1e3 * largest_m
        );
        assert!(largest_m < tolerance_m, "{}: {largest_m} m", set.name);
        assert!(100 * alike >= 99 * theirs.len(), "{}", set.name);
    }
}

#[test]
#[ignore = "runs another program many times; cargo xtask validate, as CI does"]
fn validation_against_rnx2rtkp() {
    if Command::new("rnx2rtkp").arg("-?").output().is_err() {
        println!("skipped: rnx2rtkp is not installed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for set in [&WETTZELL, &STATIC_1HZ, &WALK] {
        let Some(logs) = set.read() else { return };
        for (name, changes, change) in CASES {
            let mut options = set.adapt(PpkOptions::rtklib().with_reproduce_defects(true));
            change(&mut options);
            let solution = process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
            let theirs = run_rtklib(set, changes, folder.path());
            let (mut same, mut largest) = (0, 0.0f64);
            for t in &theirs {
                let k = solution
                    .epochs
                    .partition_point(|e| e.time.seconds_since(t.time) < -0.02);
                let ours = solution.epochs.get(k);
                if let Some(e) = ours.filter(|e| {
                    e.time.seconds_since(t.time).abs() < 0.02 && e.quality.number() == t.quality
                }) {
                    same += 1;
                    largest = largest.max(distance(e.position_ecef_m, t.position_m));
                }
            }
            println!(
                "{}, {name}: {same} of {} alike, {largest:.5} m",
                set.name,
                theirs.len()
            );
            // Two epochs of the walk backward hang on memory that RTKLIB reads by mistake.
            assert!(same + 2 >= theirs.len(), "{}, {name}", set.name);
            assert_eq!(solution.epochs.len(), theirs.len(), "{}, {name}", set.name);
            assert!(largest < 5e-4, "{}, {name}: {largest} m", set.name);
        }
    }
}
