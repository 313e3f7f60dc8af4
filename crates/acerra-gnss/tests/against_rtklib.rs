//! Epoch-by-epoch comparison with RTKLIB 2.4.3 b34 on real data.

#![allow(clippy::unwrap_used)]

mod rtklib;

use acerra_geo::geodesy::{Geodetic, ecef_from_geodetic};
use acerra_gnss::{
    BasePosition, FilterDirection, GlonassAmbiguity, PpkOptions, PpkSolution, Quality, System,
    process,
};
use rtklib::{PosEpoch, data, distance, enu, navigation, observations, percentile, read_pos};

struct Set {
    name: &'static str,
    rover: &'static str,
    base: &'static str,
    navigation: &'static [&'static str],
    /// Base position as given to RTKLIB.
    base_position: fn() -> BasePosition,
    systems: &'static [System],
    glonass_ambiguity: GlonassAmbiguity,
}

const SETS: [Set; 4] = [
    Set {
        name: "gnss-wettzell",
        rover: "rover_WTZZ.rnx",
        base: "base_WTZR.rnx",
        navigation: &["nav.rnx"],
        base_position: || BasePosition::Ecef([4_075_580.311_1, 931_854.054_3, 4_801_568.280_8]),
        systems: &[System::Gps],
        glonass_ambiguity: GlonassAmbiguity::Off,
    },
    Set {
        name: "gnss-geonet",
        rover: "rover_0759.05o",
        base: "base_3040.05o",
        navigation: &["nav.05n"],
        base_position: || BasePosition::Ecef([-3_978_241.958, 3_382_840.234, 3_649_900.853]),
        systems: &[System::Gps],
        glonass_ambiguity: GlonassAmbiguity::Off,
    },
    Set {
        name: "gnss-static-1hz",
        rover: "rover.obs",
        base: "base.obs",
        navigation: &["base.nav"],
        base_position: || {
            let place = Geodetic::from_degrees(35.134_707_705, 136.977_577_939, 104.853);
            BasePosition::Ecef(ecef_from_geodetic(&place))
        },
        systems: &[
            System::Gps,
            System::Glonass,
            System::Galileo,
            System::Qzss,
            System::Beidou,
        ],
        glonass_ambiguity: GlonassAmbiguity::Off,
    },
    Set {
        name: "gnss-walk-m8p",
        rover: "rover.obs",
        base: "base.obs",
        navigation: &["base.nav", "rover.nav"],
        base_position: || BasePosition::Header,
        systems: &[System::Gps, System::Glonass],
        glonass_ambiguity: GlonassAmbiguity::On,
    },
];

fn options(set: &Set) -> PpkOptions {
    let mut options = PpkOptions::rtklib();
    options.base_position = (set.base_position)();
    options.systems = set.systems.iter().copied().collect();
    options.glonass_ambiguity = set.glonass_ambiguity;
    options
}

fn run(set: &Set, options: &PpkOptions) -> Option<PpkSolution> {
    let folder = data(set.name)?;
    let rover = observations(folder.join(set.rover));
    let base = observations(folder.join(set.base));
    let files: Vec<_> = set.navigation.iter().map(|n| folder.join(n)).collect();
    Some(process(&rover, &base, &navigation(&files), options).unwrap())
}

#[derive(Debug)]
#[allow(dead_code)]
struct Comparison {
    theirs: usize,
    ours: usize,
    paired: usize,
    their_fixed: usize,
    our_fixed: usize,
    both_fixed: usize,
    same_status: usize,
    median_m: f64,
    p99_m: f64,
    largest_m: f64,
}

fn compare(solution: &PpkSolution, reference: &[PosEpoch], in_enu: bool) -> Comparison {
    let base = solution.base_position_ecef_m.unwrap();
    let mut distances = Vec::new();
    let (mut paired, mut same, mut both) = (0, 0, 0);
    let mut k = 0;
    for theirs in reference {
        while k < solution.epochs.len()
            && solution.epochs[k].time.seconds_since(theirs.time) < -0.02
        {
            k += 1;
        }
        let Some(ours) = solution.epochs.get(k) else {
            break;
        };
        if ours.time.seconds_since(theirs.time).abs() > 0.02 {
            continue;
        }
        paired += 1;
        let position = if in_enu {
            enu(base, ours.position_ecef_m)
        } else {
            ours.position_ecef_m
        };
        let apart = distance(position, theirs.position_m);
        if std::env::var("ACERRA_VERBOSE").is_ok() {
            println!(
                "{} {} {} {} {} {:.1} {:.1} {:.4}",
                ours.time,
                ours.quality.number(),
                theirs.quality,
                ours.satellites,
                theirs.satellites,
                ours.ratio,
                theirs.ratio,
                apart
            );
        }
        if ours.quality.number() == theirs.quality {
            same += 1;
        }
        if ours.quality == Quality::Fixed && theirs.quality == 1 {
            both += 1;
            distances.push(apart);
        }
    }
    Comparison {
        theirs: reference.len(),
        ours: solution.epochs.len(),
        paired,
        their_fixed: reference.iter().filter(|e| e.quality == 1).count(),
        our_fixed: solution.summary.fixed,
        both_fixed: both,
        same_status: same,
        median_m: percentile(&mut distances, 0.5),
        p99_m: percentile(&mut distances, 0.99),
        largest_m: percentile(&mut distances, 1.0),
    }
}

#[test]
fn validation_against_rtklib() {
    for set in &SETS {
        if std::env::var("ACERRA_SET").is_ok_and(|s| s != set.name) {
            continue;
        }
        let Some(folder) = data(set.name) else { return };
        for (direction, file) in [
            (FilterDirection::Forward, "b34_fixhold_forward.pos"),
            (FilterDirection::Backward, "b34_fixhold_backward.pos"),
            (FilterDirection::Combined, "b34_fixhold_combined.pos"),
            (FilterDirection::Combined, "b34_fixhold_combined_xyz.pos"),
        ] {
            let path = folder.join("reference").join(file);
            if !path.exists() {
                continue;
            }
            for defects in [true, false] {
                let mut options = options(set);
                options.direction = direction;
                options.reproduce_defects = defects;
                let solution = run(set, &options).unwrap();
                let c = compare(&solution, &read_pos(path.clone()), !file.contains("xyz"));
                println!("{} {file} defects {defects}: {c:?}", set.name);
            }
        }
    }
}
