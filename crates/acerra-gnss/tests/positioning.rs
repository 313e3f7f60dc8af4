//! Positions from real data, against RTKLIB 2.4.3 b34 and against known truth.
//!
//! `validation_ppk` writes its tables to the folder named by `ACERRA_DOCS`, if it is set.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod rtklib;

use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::{
    AmbiguityMode, BasePosition, FilterDirection, PpkOptions, PpkSolution, Quality, Solution,
    process,
};
use rtklib::deviations;
use rtklib::motion::{Flight, add_motion};
use rtklib::sets::{GEONET, LG69T, STATIC_1HZ, STATIC_M8P, Set, WALK, WETTZELL};
use rtklib::settings::{frequencies_table, sensitivity_table};
use rtklib::trust::{default_options, truth_of, windows_table};
use rtklib::{PosEpoch, data, distance, enu, onboard_fixes, percentile, position_file, read_pos};
use std::fmt::Write;

const FORWARD: &str = "b34_fixhold_forward.pos";
const BACKWARD: &str = "b34_fixhold_backward.pos";

/// Epochs of both solutions, paired by time.
fn pairs<'a>(
    ours: &'a [Solution],
    theirs: &'a [PosEpoch],
) -> impl Iterator<Item = (&'a Solution, &'a PosEpoch)> {
    theirs.iter().filter_map(|t| {
        let k = ours.partition_point(|o| o.time.seconds_since(t.time) < -0.02);
        let o = ours.get(k)?;
        (o.time.seconds_since(t.time).abs() < 0.02).then_some((o, t))
    })
}

/// Single-point heights of this set are metres off, at every epoch alike; counted as new each time,
/// they draw float heights down by a quarter of a metre.
#[test]
fn single_point_heights_do_not_draw_float_heights() {
    let Some(logs) = STATIC_M8P.read() else {
        return;
    };
    let options = default_options(&STATIC_M8P).with_ambiguity(AmbiguityMode::Off);
    let solution = process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
    let base = solution.base_position_ecef_m.unwrap();
    let truth = truth_of(&STATIC_M8P).unwrap();
    let float = solution
        .epochs
        .iter()
        .filter(|e| e.quality == Quality::Float);
    let up_m: Vec<f64> = float
        .map(|e| enu(base, e.position_ecef_m)[2] - truth[2])
        .collect();
    assert!(up_m.len() > 1_000, "{}", up_m.len());
    let mean_m = up_m.iter().sum::<f64>() / up_m.len() as f64;
    assert!(mean_m.abs() < 0.15, "{mean_m} m");
}

struct Agreement {
    epochs: usize,
    our_fixed: usize,
    their_fixed: usize,
    same_status: usize,
    median_m: f64,
    p99_m: f64,
    largest_m: f64,
}

/// Compares with a reference in east, north, up; `trusted` says which of its epochs count.
fn compare(
    solution: &PpkSolution,
    theirs: &[PosEpoch],
    trusted: impl Fn(&PosEpoch) -> bool,
) -> Agreement {
    let base = solution.base_position_ecef_m.unwrap();
    let (mut apart, mut same) = (Vec::new(), 0);
    for (ours, theirs) in pairs(&solution.epochs, theirs) {
        same += usize::from(ours.quality.number() == theirs.quality);
        if ours.quality == Quality::Fixed && theirs.quality == 1 && trusted(theirs) {
            apart.push(distance(enu(base, ours.position_ecef_m), theirs.position_m));
        }
    }
    Agreement {
        epochs: theirs.len(),
        our_fixed: solution.summary.fixed,
        their_fixed: theirs.iter().filter(|e| e.quality == 1).count(),
        same_status: same,
        median_m: percentile(&mut apart, 0.5),
        p99_m: percentile(&mut apart, 0.99),
        largest_m: percentile(&mut apart, 1.0),
    }
}

fn reference(set: &Set, file: &str) -> Option<Vec<PosEpoch>> {
    let path = data(set.folder)?.join("reference").join(file);
    path.exists().then(|| read_pos(path))
}

/// RTKLIB's combined solution in east, north, up.
fn combined_reference(set: &Set, base_ecef_m: [f64; 3]) -> Vec<PosEpoch> {
    if let Some(mut xyz) = reference(set, "b34_fixhold_combined_xyz.pos") {
        for e in &mut xyz {
            e.position_m = enu(base_ecef_m, e.position_m);
        }
        return xyz;
    }
    reference(set, "b34_fixhold_combined.pos").unwrap()
}

/// Guarded, but for the troposphere, which RTKLIB keeps at the single-point height.
fn guarded_in_b34s_troposphere() -> PpkOptions {
    PpkOptions::rtklib()
        .with_safeguards()
        .with_troposphere_follows_height(false)
}

#[test]
fn geodetic_receivers_agree_with_rtklib() {
    for set in [&WETTZELL, &GEONET] {
        let Some(logs) = set.read() else { return };
        for (direction, file) in [
            (FilterDirection::Forward, FORWARD),
            (FilterDirection::Backward, BACKWARD),
        ] {
            for (guarded, options) in [
                (false, PpkOptions::rtklib()),
                (true, guarded_in_b34s_troposphere()),
            ] {
                let options = set.adapt(options.with_direction(direction));
                let solution =
                    process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
                let a = compare(&solution, &reference(set, file).unwrap(), |_| true);
                if guarded {
                    // Codes are weighed by their measured noise: an epoch at the edge of a fix
                    // may fall to its other side.
                    let fewer = a.their_fixed.saturating_sub(a.our_fixed);
                    assert!(
                        50 * fewer <= a.epochs,
                        "{} {direction:?}: {} of {}",
                        set.name,
                        a.our_fixed,
                        a.their_fixed
                    );
                } else {
                    assert_eq!(a.same_status, a.epochs, "{} {direction:?}", set.name);
                }
                let limit_m = if guarded { 1e-3 } else { 2e-4 };
                assert!(
                    a.largest_m < limit_m,
                    "{} {direction:?} {}",
                    set.name,
                    a.largest_m
                );
            }
        }
    }
}

#[test]
fn the_model_documents_chain_of_one_pair_is_met() {
    let Some(logs) = GEONET.read() else { return };
    let run = |options: PpkOptions| {
        process(
            &logs.rover,
            &logs.base,
            &logs.navigation,
            &GEONET.adapt(options),
        )
        .unwrap()
    };
    let start = logs.rover.epochs[0].time;
    let check = |solution: &PpkSolution, minutes: f64, expected: [f64; 3], limit_m: f64| {
        let e = solution
            .epochs
            .iter()
            .find(|e| (e.time.seconds_since(start) - minutes * 60.0).abs() < 0.02)
            .unwrap();
        let apart = distance(e.position_ecef_m, expected);
        assert!(apart < limit_m, "{minutes} min: {apart} m");
    };
    let single = run(PpkOptions::rtklib().with_mode(acerra_gnss::PositioningMode::Single));
    check(
        &single,
        0.0,
        [-3_976_219.224_4, 3_382_373.392_0, 3_652_513.166_2],
        2e-3,
    );
    // The receiver's clock is 77 244.6832 m behind GPS time.
    let clock_m = start.seconds_since(single.epochs[0].time) * acerra_gnss::SPEED_OF_LIGHT_M_S;
    assert!((clock_m - -77_244.683_2).abs() < 1e-2, "{clock_m}");
    assert_eq!(single.epochs[0].satellites, 7);
    for (direction, fixed, points) in [
        (
            FilterDirection::Forward,
            114,
            [
                (0.0, [-3_976_219.231_8, 3_382_372.361_5, 3_652_511.473_7]),
                (0.5, [-3_976_219.179_9, 3_382_371.599_5, 3_652_511.135_8]),
                (57.0, [-3_976_219.227_7, 3_382_371.650_2, 3_652_511.230_4]),
            ],
        ),
        (
            FilterDirection::Backward,
            108,
            [
                (57.0, [-3_976_220.146_2, 3_382_373.424_4, 3_652_513.786_4]),
                (52.0, [-3_976_219.187_8, 3_382_371.603_1, 3_652_511.138_8]),
                (52.0, [-3_976_219.187_8, 3_382_371.603_1, 3_652_511.138_8]),
            ],
        ),
        (
            FilterDirection::Combined,
            115,
            [
                (0.0, [-3_976_219.183_1, 3_382_371.604_9, 3_652_511.141_6]),
                (5.0, [-3_976_219.183_5, 3_382_371.604_3, 3_652_511.149_4]),
                (5.0, [-3_976_219.183_5, 3_382_371.604_3, 3_652_511.149_4]),
            ],
        ),
    ] {
        let solution = run(PpkOptions::rtklib().with_direction(direction));
        assert_eq!(solution.summary.fixed, fixed);
        for (minutes, expected) in points {
            check(&solution, minutes, expected, 2e-4);
        }
    }
    let ambiguity = AmbiguityMode::Instantaneous;
    assert_eq!(
        run(PpkOptions::rtklib().with_ambiguity(ambiguity))
            .summary
            .fixed,
        32
    );
    let ambiguity = AmbiguityMode::Off;
    let float = run(PpkOptions::rtklib().with_ambiguity(ambiguity));
    check(
        &float,
        5.0,
        [-3_976_219.128_1, 3_382_371.669_7, 3_652_511.195_1],
        2e-4,
    );
}

/// Whether RTKLIB's combined position lies between its own two passes, as a mean must. Where its
/// covariances have lost their digits it does not, by up to 7 mm.
fn between_passes(combined: &PosEpoch, forward: &[PosEpoch], backward: &[PosEpoch]) -> bool {
    let at = |pass: &[PosEpoch]| {
        let k = pass.partition_point(|e| e.time.seconds_since(combined.time) < -0.02);
        pass.get(k)
            .filter(|e| e.time.seconds_since(combined.time).abs() < 0.02)
            .filter(|e| e.quality == combined.quality)
            .map(|e| e.position_m)
    };
    let (Some(f), Some(b)) = (at(forward), at(backward)) else {
        return true;
    };
    (0..3).all(|k| {
        let x = combined.position_m[k];
        x > f[k].min(b[k]) - 5e-4 && x < f[k].max(b[k]) + 5e-4
    })
}

fn agreement_table(text: &mut String) {
    text.push_str(
        "## Against RTKLIB 2.4.3 b34\n\n\
         Same files, same settings (L1, kinematic, fix-and-hold, ratio 3). Distances are between \
         positions of epochs that both fixed. \"plain\": `PpkOptions::rtklib()`; \"guarded\": the \
         same `.with_safeguards()`, but with the tropospheric delay of the single-point height, as \
         RTKLIB takes it.\n\n\
         | set | pass | settings | epochs | fixed, b34 | fixed, ours | same status | median (mm) | 99 % (mm) | largest (mm) |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for set in [&WETTZELL, &GEONET, &STATIC_1HZ, &WALK] {
        let logs = set.read().unwrap();
        let (forward, backward) = (
            reference(set, FORWARD).unwrap(),
            reference(set, BACKWARD).unwrap(),
        );
        for direction in [
            FilterDirection::Forward,
            FilterDirection::Backward,
            FilterDirection::Combined,
        ] {
            for (name, options) in [
                ("plain", PpkOptions::rtklib()),
                (
                    "b34's defects too",
                    PpkOptions::rtklib().with_reproduce_defects(true),
                ),
                ("guarded", guarded_in_b34s_troposphere()),
            ] {
                let on_walk = set.folder == WALK.folder;
                if options.reproduce_defects != on_walk {
                    continue; // elsewhere the two are the same
                }
                let options = set.adapt(options.with_direction(direction));
                let solution =
                    process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
                let combined;
                let theirs = match direction {
                    FilterDirection::Forward => &forward,
                    FilterDirection::Backward => &backward,
                    _ => {
                        combined = combined_reference(set, solution.base_position_ecef_m.unwrap());
                        &combined
                    }
                };
                let is_combined = direction == FilterDirection::Combined;
                let a = compare(&solution, theirs, |e| {
                    !is_combined || between_passes(e, &forward, &backward)
                });
                writeln!(
                    text,
                    "| {} | {direction:?} | {name} | {} | {} | {} | {} | {:.2} | {:.2} | {:.2} |",
                    set.name,
                    a.epochs,
                    a.their_fixed,
                    a.our_fixed,
                    a.same_status,
                    a.median_m * 1e3,
                    a.p99_m * 1e3,
                    a.largest_m * 1e3
                )
                .unwrap();
                assert!(
                    a.median_m < 1e-3 && a.p99_m < 1e-3,
                    "{} {direction:?}",
                    set.name
                );
                let rate = |fixed: usize| 100.0 * fixed as f64 / a.epochs as f64;
                assert!(
                    (rate(a.our_fixed) - rate(a.their_fixed)).abs() < 2.0,
                    "{} {direction:?}: fixed {} against {}",
                    set.name,
                    a.our_fixed,
                    a.their_fixed
                );
            }
        }
    }
    text.push_str(
        "\nCombined positions are compared where b34's own lies between its two passes, as a mean \
         must; at a few epochs of the 1 Hz set its covariances have lost their digits and it does \
         not, by up to 7 mm.\n",
    );
}

fn truth_table(text: &mut String) {
    text.push_str(
        "\n## Against known coordinates\n\n\
         Errors of fixed epochs, forward, east/north/up: mean and standard deviation in mm. \
         \"guarded\": the tropospheric delay follows the height.\n\n\
         | set | b34 mean | b34 std | plain mean | plain std | guarded mean | guarded std |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    let wettzell_m = [-0.417_88, 1.535_23, 0.081_42];
    let base = position_file(STATIC_1HZ.folder, "base_position.txt");
    let static_m = enu(base, position_file(STATIC_1HZ.folder, "rover_position.txt"));
    for (set, truth) in [(&WETTZELL, wettzell_m), (&STATIC_1HZ, static_m)] {
        let logs = set.read().unwrap();
        let fixed = |options: PpkOptions| -> Vec<[f64; 3]> {
            let options = set.adapt(options);
            let solution = process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
            let base = solution.base_position_ecef_m.unwrap();
            let fixed = solution
                .epochs
                .iter()
                .filter(|e| e.quality == Quality::Fixed);
            fixed.map(|e| enu(base, e.position_ecef_m)).collect()
        };
        let plain = fixed(PpkOptions::rtklib());
        let guarded = fixed(PpkOptions::rtklib().with_safeguards());
        let theirs: Vec<[f64; 3]> = reference(set, FORWARD)
            .unwrap()
            .iter()
            .filter(|e| e.quality == 1)
            .map(|e| e.position_m)
            .collect();
        let mut cells = String::new();
        for positions in [&theirs, &plain, &guarded] {
            let n = positions.len() as f64;
            let mean: [f64; 3] =
                std::array::from_fn(|k| positions.iter().map(|p| p[k] - truth[k]).sum::<f64>() / n);
            let std: [f64; 3] = std::array::from_fn(|k| {
                let sum: f64 = positions
                    .iter()
                    .map(|p| (p[k] - truth[k] - mean[k]).powi(2))
                    .sum();
                (sum / n).sqrt()
            });
            for v in [mean, std] {
                write!(
                    cells,
                    " {:.1} / {:.1} / {:.1} |",
                    v[0] * 1e3,
                    v[1] * 1e3,
                    v[2] * 1e3
                )
                .unwrap();
            }
            assert!(mean.iter().all(|m| m.abs() < 0.005));
        }
        writeln!(text, "| {} |{cells}", set.name).unwrap();
    }
}

fn walk_table(text: &mut String) {
    text.push_str(
        "\n## A walk with cheap receivers\n\n\
         `gnss-walk-m8p`, combined, code/phase ratio 300, against the receiver's own fixed \
         real-time solution (about 2 cm), horizontally. Fixed epochs in per cent of epochs with a \
         position; guarded runs also position epochs without phases, by codes.\n\n\
         | settings | positions | fixed | compared | median (cm) | 95 % (cm) | beyond 10 cm |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    let logs = WALK.read().unwrap();
    let truth = onboard_fixes();
    let ratio = |o: PpkOptions| {
        WALK.adapt(
            o.with_code_phase_ratio([300.0; 3])
                .with_direction(FilterDirection::Combined),
        )
    };
    let b34 = ratio(PpkOptions::rtklib().with_reproduce_defects(true));
    // Kinematic without a motion model, and what else its configuration of the data set says.
    let ex = ratio(
        PpkOptions::demo5()
            .with_dynamics(None)
            .with_min_fixes_to_hold(10)
            .with_max_outage_epochs(5)
            .with_max_phase_innovation_m(30.0),
    );
    for (name, options) in [
        ("as RTKLIB 2.4.3 b34", b34),
        (
            "RTKLIB's rules, without its defects",
            ratio(PpkOptions::rtklib()),
        ),
        ("demo5 rules", ratio(PpkOptions::demo5())),
        ("demo5 rules, with RTKLIB-EX's configuration", ex),
        (
            "RTKLIB's rules, guarded",
            ratio(PpkOptions::rtklib().with_safeguards()),
        ),
        ("default", PpkOptions::default()),
    ] {
        let solution = process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap();
        let base = solution.base_position_ecef_m.unwrap();
        let mut off: Vec<f64> = truth
            .iter()
            .filter_map(|(time, place)| {
                let e = solution.epochs.iter().find(|e| {
                    e.quality == Quality::Fixed && e.time.seconds_since(*time).abs() < 0.02
                })?;
                let found = enu(base, e.position_ecef_m);
                Some((found[0] - place[0]).hypot(found[1] - place[1]))
            })
            .collect();
        let n = off.len() as f64;
        let far = 100.0 * off.iter().filter(|&&d| d > 0.1).count() as f64 / n;
        // Positions from codes alone are given beyond those of phases.
        let by_phases = |e: &&Solution| matches!(e.quality, Quality::Fixed | Quality::Float);
        let by_phases = solution.epochs.iter().filter(by_phases).count();
        let fixed = 100.0 * solution.summary.fixed as f64;
        let (rate, rate_by_phases) = (
            fixed / solution.epochs.len() as f64,
            fixed / by_phases as f64,
        );
        let p95 = percentile(&mut off, 0.95);
        writeln!(
            text,
            "| {name} | {} | {} ({rate:.1} %) | {n} | {:.1} | {:.1} | {far:.1} % |",
            solution.epochs.len(),
            solution.summary.fixed,
            percentile(&mut off, 0.5) * 1e2,
            p95 * 1e2
        )
        .unwrap();
        if name.ends_with("RTKLIB-EX's configuration") {
            assert!(
                (rate - 90.3).abs() < 2.0,
                "{name}: {rate} % fixed, EX 90.3 %"
            );
        }
        if name == "default" || name.ends_with("guarded") {
            assert!(rate_by_phases > 90.0, "{name}: {rate_by_phases} % fixed");
            assert!(solution.summary.fixed >= 1780 || name != "default");
            assert!(p95 < 0.03, "{name}: {p95} m");
            assert!(far < 1.0, "{name}: {far} %");
            assert!(far <= 0.3 || name != "default", "{far} %");
        }
    }
    text.push_str(
        "\nRTKLIB-EX 2.5.1, from its own output in the data set: 1852 of 2052 (90.3 %), 1.1 cm, \
         3.0 cm, 2 %.\n\n\
         From 12:51:13 to 12:51:28 the default's fixes lie 0.05 to 0.27 m off RTKLIB-EX's. The \
         default's are right; a program of its own that shares no code with this one (broadcast \
         orbits, double differences, integers of 12:50:45 to 12:51:10 kept along arcs without a slip, \
         least squares) shows why:\n\n\
         - At the default's places G09, G17, G19, G23, R05, R19 and R20 (most of them 40 to 51 dB-Hz) \
         stay within 4 cm of those integers, mostly 1 cm. The phases of G01, G22 and, until it is \
         lost, G11 (26 to 38 dB-Hz) come 2 to 23 cm too late, in a slow drift without a slip: \
         signals bent about an edge. A longer path is what bending gives; none comes too early.\n\
         - At RTKLIB-EX's places signals of 48 dB-Hz are off by up to 7 cm, and to both sides. The \
         same least squares with the bent signals at equal weight gives RTKLIB-EX's places to \
         2.5 cm horizontally and 6 cm in height, with residuals of 20 to 67 mm; without them it \
         gives the default's, to 2.5 cm horizontally from 12:51:15 on, with 6 to 13 mm.\n\
         - The forward and the backward pass, GPS alone, and the default without those three \
         satellites give the same places to 5 cm (test \
         `fixes_beside_bent_signals_hang_on_no_satellite_and_no_pass`).\n\
         - The receiver's own fixes lie 3 to 14 cm from the default's horizontally, 12 to 20 cm from \
         RTKLIB-EX's after 12:51:20; the default's are between the two.\n\
         - At 12:51:20 and 12:51:21, and from 12:51:30 on, when too few satellites remain, the default \
         states no fix.\n",
    );
}

fn motion_table(text: &mut String) {
    text.push_str(
        "\n## Drone motion with exact truth\n\n\
         A flight (hover, legs of 1–8 m/s, turns, climbs, vibration) added to the ranges and \
         phases of a real receiver that stood still, along each satellite's line of sight. Errors \
         of fixed epochs at 95 %.\n\n\
         | set | settings | epochs | fixed | horizontal (mm) | vertical (mm) | largest (mm) |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    let wettzell_base = [4_075_580.311_1, 931_854.054_3, 4_801_568.280_8];
    let wettzell =
        EnuFrame::from_ecef(wettzell_base).ecef_from_enu([-0.417_88, 1.535_23, 0.081_42]);
    let static_base = position_file(STATIC_1HZ.folder, "base_position.txt");
    let static_rover = position_file(STATIC_1HZ.folder, "rover_position.txt");
    for (set, base, place) in [
        (&STATIC_1HZ, static_base, static_rover),
        (&WETTZELL, wettzell_base, wettzell),
    ] {
        let logs = set.read().unwrap();
        let start = logs.rover.epochs[0].time;
        let last = logs.rover.epochs[logs.rover.epochs.len() - 1].time;
        let flight = Flight::new(last.seconds_since(start));
        let moved = add_motion(
            &logs.rover,
            &logs.navigation,
            place,
            &PpkOptions::default(),
            &flight,
        );
        let frame = EnuFrame::from_ecef(place);
        for (name, options) in [
            ("RTKLIB's rules, forward", set.adapt(PpkOptions::rtklib())),
            ("default", PpkOptions::default()),
        ] {
            let options = options.with_base_position(BasePosition::Ecef(base));
            let solution = process(&moved, &logs.base, &logs.navigation, &options).unwrap();
            let (mut horizontal, mut vertical) = (Vec::new(), Vec::new());
            for e in solution
                .epochs
                .iter()
                .filter(|e| e.quality == Quality::Fixed)
            {
                let truth = flight.at(e.time.seconds_since(start));
                let found = frame.enu_from_ecef(e.position_ecef_m);
                horizontal.push((found[0] - truth[0]).hypot(found[1] - truth[1]));
                vertical.push((found[2] - truth[2]).abs());
            }
            let (h95, v95) = (
                percentile(&mut horizontal, 0.95),
                percentile(&mut vertical, 0.95),
            );
            let largest = percentile(&mut horizontal, 1.0).max(percentile(&mut vertical, 1.0));
            writeln!(
                text,
                "| {} | {name} | {} | {} | {:.1} | {:.1} | {:.1} |",
                set.name,
                moved.epochs.len(),
                solution.summary.fixed,
                h95 * 1e3,
                v95 * 1e3,
                largest * 1e3
            )
            .unwrap();
            let rate = solution.summary.fixed as f64 / moved.epochs.len() as f64;
            assert!(rate > 0.9, "{} {name}: {rate}", set.name);
            assert!(h95 < 0.02 && v95 < 0.04, "{} {name}: {h95} {v95}", set.name);
        }
    }
}

#[test]
#[ignore = "processes every set many times; cargo xtask validate, as CI does"]
fn validation_ppk() {
    if [&WETTZELL, &GEONET, &STATIC_1HZ, &STATIC_M8P, &WALK, &LG69T]
        .iter()
        .any(|s| data(s.folder).is_none())
    {
        return;
    }
    let mut text = String::from(
        "# Positions from carrier phase: validation\n\n\
         Written by the test `validation_ppk` of `acerra-gnss`, which fails where a figure leaves \
         its tolerance.\n\n",
    );
    agreement_table(&mut text);
    truth_table(&mut text);
    walk_table(&mut text);
    motion_table(&mut text);
    windows_table(&mut text);
    deviations::tables(&mut text);
    frequencies_table(&mut text);
    sensitivity_table(&mut text);
    println!("{text}");
    if let Some(folder) = std::env::var_os("ACERRA_DOCS") {
        std::fs::write(std::path::Path::new(&folder).join("ppk.md"), text).unwrap();
    }
}
