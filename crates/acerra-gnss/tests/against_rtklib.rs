//! Epoch-by-epoch comparison with RTKLIB 2.4.3 b34 on real data.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod rtklib;

use acerra_geo::geodesy::{Geodetic, ecef_from_geodetic};
use acerra_geo::time::GpsTime;
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
#[ignore = "compares at length; CI runs it in release mode"]
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
            for (defects, safe) in [(true, false), (false, false), (false, true)] {
                let mut options = options(set);
                if safe {
                    options = options.with_safeguards();
                }
                options.direction = direction;
                options.reproduce_defects = defects;
                let solution = run(set, &options).unwrap();
                let c = compare(&solution, &read_pos(path.clone()), !file.contains("xyz"));
                println!("{} {file} defects {defects} safe {safe}: {c:?}", set.name);
            }
        }
    }
}

/// The receiver's own real-time fixed solution: GPS time and east, north, up from the base (m).
fn onboard_fixes() -> Option<Vec<(GpsTime, [f64; 3])>> {
    let path = data("gnss-walk-m8p")?.join("reference/onboard_rtk.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let rows = text.lines().skip(1).filter_map(|line| {
        let f: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        (f[4] == 4.0).then(|| {
            let whole = f[0].floor();
            let since_1980 = whole as i64 - 315_964_800;
            (GpsTime::new(since_1980, f[0] - whole), [f[1], f[2], f[3]])
        })
    });
    Some(rows.collect())
}

#[test]
#[ignore = "compares at length; CI runs it in release mode"]
fn validation_walk() {
    let Some(truth) = onboard_fixes() else { return };
    for (name, defects, rules) in [
        ("rtklib", true, 0),
        ("ours", false, 0),
        ("default", false, 1),
        ("demo5", false, 2),
    ] {
        let mut options = match rules {
            2 => PpkOptions::demo5(),
            1 => PpkOptions::default(),
            _ => options(&SETS[3]),
        };
        options.code_phase_ratio = [300.0; 3];
        options.direction = FilterDirection::Combined;
        options.reproduce_defects = defects;
        let solution = run(&SETS[3], &options).unwrap();
        let base = solution.base_position_ecef_m.unwrap();
        let mut horizontal = Vec::new();
        for (time, place) in &truth {
            let near = solution
                .epochs
                .iter()
                .find(|e| e.quality == Quality::Fixed && e.time.seconds_since(*time).abs() < 0.02);
            let Some(e) = near else { continue };
            let found = enu(base, e.position_ecef_m);
            let off = (found[0] - place[0]).hypot(found[1] - place[1]);
            horizontal.push(off);
            if off > 0.03 && std::env::var("ACERRA_VERBOSE").is_ok() {
                let o = std::array::from_fn::<f64, 3, _>(|k| found[k] - place[k]);
                println!(
                    "{} {:.3} {:.3} {:.3} age {:.2} ns {} ratio {:.1} sd {:.4}",
                    e.time,
                    o[0],
                    o[1],
                    o[2],
                    e.age_s,
                    e.satellites,
                    e.ratio,
                    e.covariance_ecef_m2[0][0].sqrt()
                );
                if std::env::var("ACERRA_RESIDUALS").is_ok() {
                    for r in &e.residuals {
                        print!(
                            " {}{}{} {:.1}°:{:.3}/{:.2}",
                            r.satellite,
                            if r.fixed { "*" } else { "" },
                            if r.slipped { "!" } else { "" },
                            r.elevation_rad.to_degrees(),
                            r.phase_m.unwrap_or(f64::NAN),
                            r.code_m.unwrap_or(f64::NAN)
                        );
                    }
                    println!();
                }
            }
        }
        let n = horizontal.len();
        let far = horizontal.iter().filter(|&&d| d > 0.1).count();
        println!(
            "{name}: {} of {} epochs ({} out) fixed; {n} checked: median {:.4} p95 {:.4} \
             max {:.4}, {far} beyond 10 cm; {:?}",
            solution.summary.fixed,
            solution.summary.rover_epochs,
            solution.epochs.len(),
            percentile(&mut horizontal, 0.5),
            percentile(&mut horizontal, 0.95),
            percentile(&mut horizontal, 1.0),
            solution.summary.not_fixed,
        );
    }
}
