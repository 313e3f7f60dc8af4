//! Tables 1, 4 (theory) and 5, Figures 6, 7, 8 and 14, and what positioning errors do.

use std::fmt::Write as _;
use std::path::Path;

use acerra_imaging::psf::{
    Analysis, PointSpread, TrackShape, psf_image, retrieve, synthetic_track,
};
use acerra_imaging::resolution::{Aperture, Band, Prediction, across_track_m, range_m};
use acerra_imaging::sensitivity::{ErrorModel, Estimate, MonteCarlo, predict, simulate};
use acerra_imaging::{Control, PlaneGrid};
use assert_cmd::Command;

use crate::page::Page;

const C: f64 = 3e8;

#[test]
#[ignore = "half a minute of draws and pictures; cargo xtask validate, as CI does"]
fn validation_book_resolution() {
    let mut page = Page::open("resolution.md");
    page.block("equation-9", &equation_9());
    page.block("table-4-theory", &table_4_theory());
    page.block("table-1", &table_1());
    page.block("table-5", &table_5());
    page.block("sensitivity", &sensitivity());
    pictures(&mut page);
    page.close();
}

fn near(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{what}: {found}, expected {expected} ± {tolerance}"
    );
}

fn equation_9() -> String {
    let step_m = range_m(1.7e9, C).unwrap();
    let cases = [
        (5.0, 0.0, 0.943),
        (5.0, 2.0, 0.227),
        (10.0, 0.0, 1.331),
        (10.0, 2.0, 0.410),
        (4.0, 0.0, 0.845),
    ];
    let mut rows = [
        "| Eq. (9), m |".to_owned(),
        "| --- |".to_owned(),
        "| expected |".to_owned(),
        "| Acerra (± 0.0005) |".to_owned(),
    ];
    for (h, d, expected) in cases {
        let found = across_track_m(step_m, h, d).unwrap();
        near("Eq. (9)", found, expected, 5e-4);
        let _ = write!(rows[0], " h {h}, d {d} |");
        rows[1].push_str(" --- |");
        let _ = write!(rows[2], " {expected:.3} |");
        let _ = write!(rows[3], " {found:.3} |");
    }
    rows.join("\n")
}

fn table_4_theory() -> String {
    let band = Band {
        low_hz: 3.1e9,
        high_hz: 4.8e9,
        light_speed_m_s: C,
    };
    let mut text = String::from(
        "| | along, paper | along, Acerra | across, paper | across, Acerra |\n\
         | --- | --- | --- | --- | --- |\n",
    );
    for (name, h, d, along, across) in [
        ("Track 1 (h 4 m, d 0)", 4.0, 0.0, 0.02, 0.85),
        ("Track 2 (h 10 m, d 2 m)", 10.0, 2.0, 0.03, 0.41),
    ] {
        let found = Prediction::of(Aperture::new(h, d).unwrap(), band, Some(9.0)).unwrap();
        let found_along = found.along_m.unwrap();
        near("Table 4, along", found_along, along, 0.005);
        near("Table 4, across", found.across_m, across, 0.006);
        let _ = writeln!(
            text,
            "| {name} | {along} | {found_along:.3} | {across} | {:.3} |",
            found.across_m
        );
    }
    text
}

/// Track (amplitude of its cosine), offset, height; the paper's along and across; an independent
/// evaluation's along, inner and outer; its ghost.
type Row = (f64, f64, f64, [f64; 2], f64, [f64; 2], Option<f64>);

const TABLE_1: [Row; 8] = [
    (0.0, 0.0, 5.0, [0.04, 0.95], 0.039, [0.960, 0.960], None),
    (
        0.0,
        2.0,
        5.0,
        [0.04, 0.25],
        0.041,
        [0.258, 0.236],
        Some(1.0),
    ),
    (0.15, 0.0, 5.0, [0.04, 0.95], 0.039, [0.840, 1.096], None),
    (
        0.15,
        2.0,
        5.0,
        [0.04, 0.25],
        0.041,
        [0.280, 0.250],
        Some(0.504),
    ),
    (-0.15, 0.0, 5.0, [0.04, 0.95], 0.039, [1.096, 0.840], None),
    (
        -0.15,
        2.0,
        5.0,
        [0.04, 0.25],
        0.041,
        [0.242, 0.224],
        Some(0.483),
    ),
    (0.15, 0.0, 10.0, [0.07, 1.30], 0.068, [1.228, 1.462], None),
    (
        0.15,
        2.0,
        10.0,
        [0.07, 0.47],
        0.069,
        [0.570, 0.440],
        Some(0.740),
    ),
];

fn table_1() -> String {
    let mut text = String::from(
        "| track | d | h | along: paper | evaluated | Acerra | across: paper | evaluated | Acerra \
         | inner / outer | ghost: evaluated | Acerra |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for (cosine_m, d, h, paper, along, sides, ghost) in TABLE_1 {
        let (name, shape) = if cosine_m == 0.0 {
            ("straight", TrackShape::Straight)
        } else {
            let shape = TrackShape::Cosine {
                amplitude_m: cosine_m,
                period_m: 24.0,
            };
            (if cosine_m > 0.0 { "+cos" } else { "−cos" }, shape)
        };
        let track = synthetic_track(shape, 3.0, 0.01, h).unwrap();
        let frequency_hz = (0..341).map(|n| 3.1e9 + 5e6 * f64::from(n)).collect();
        let spread = PointSpread::new(track, None, frequency_hz, C).unwrap();
        let found = Analysis::of(&spread, [0.0, d, 0.0], 0.0).unwrap();
        let [found_along, found_across, inner, outer] = [
            found.along.rayleigh_m,
            found.across.rayleigh_m,
            found.across.inner_m,
            found.across.outer_m,
        ]
        .map(Option::unwrap);
        let across = 0.5 * (sides[0] + sides[1]);
        near("Table 1, along", found_along, along, 0.03 * along);
        near("Table 1, across", found_across, across, 0.03 * across);
        near("Table 1, inner", inner, sides[0], 0.03 * sides[0]);
        near("Table 1, outer", outer, sides[1], 0.03 * sides[1]);
        // The paper rounds to two digits and read its figures.
        near("Table 1, along, paper", found_along, paper[0], 0.005);
        near(
            "Table 1, across, paper",
            found_across,
            paper[1],
            0.08 * paper[1],
        );
        let found_ghost = found.ghost.map(|g| g.level);
        assert_eq!(found_ghost.is_some(), ghost.is_some());
        if let (Some(found), Some(expected)) = (found_ghost, ghost) {
            near("Table 1, ghost", found, expected, 0.01);
        }
        let level =
            |v: Option<f64>, digits: usize| v.map_or("–".to_owned(), |v| format!("{v:.digits$}"));
        let _ = writeln!(
            text,
            "| {name} | {d} | {h} | {:.2} | {along:.3} | {found_along:.4} | {:.2} | {across:.3} | \
             {found_across:.3} | {inner:.3} / {outer:.3} | {} | {} |",
            paper[0],
            paper[1],
            level(ghost, 3),
            level(found_ghost, 3)
        );
    }
    text
}

/// The paper's words, and |y| by Eq. (14).
type Expected = (&'static str, Option<f64>);

fn table_5() -> String {
    const TARGETS: [[f64; 3]; 3] = [[-2.0, 0.0, 0.0], [0.0, 0.0, 0.2], [2.0, 0.0, 0.4]];
    let planes: [(f64, [Expected; 3]); 3] = [
        (
            0.0,
            [("(−2, 0)", Some(0.0)), ("absent", None), ("absent", None)],
        ),
        (
            0.2,
            [
                ("(−2, ±1.4)", Some(1.4)),
                ("(0, 0)", Some(0.0)),
                ("absent", None),
            ],
        ),
        (
            0.4,
            [
                ("(−2, ±1.99)", Some(1.96)),
                ("(0, ±1.4)", Some(1.371)),
                ("(2, 0)", Some(0.0)),
            ],
        ),
    ];
    let track = synthetic_track(TrackShape::Straight, 3.0, 0.01, 5.0).unwrap();
    let frequency_hz = (0..341).map(|n| 3.1e9 + 5e6 * f64::from(n)).collect();
    let spread = PointSpread::new(track, None, frequency_hz, C).unwrap();
    let mut text = String::from(
        "| plane | T1: paper | T1: Eq. (14) | T1: Acerra | T2: paper | T2: Eq. (14) | T2: Acerra \
         | T3: paper | T3: Eq. (14) | T3: Acerra |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for (z_m, expected) in planes {
        let grid = PlaneGrid::from_ranges([-3.0, 3.0], [-3.0, 3.0], z_m, 0.02).unwrap();
        let image = psf_image(&spread, &TARGETS, grid, Control::default()).unwrap();
        let retrieved = retrieve(&spread, &TARGETS, &image, grid).unwrap();
        let _ = write!(text, "| z = {z_m} m |");
        for (r, (paper, y_m)) in retrieved.iter().zip(expected) {
            assert_eq!(r.detected, y_m.is_some(), "{r:?}");
            let (theory, found) = match (r.expected_m, y_m) {
                (Some(theory), Some(y_m)) => {
                    near("Eq. (14)", theory[1].abs(), y_m, 0.01);
                    near("Table 5, x", r.found_m[0], r.target_m[0], 0.01);
                    near("Table 5, |y|", r.found_m[1].abs(), theory[1].abs(), 0.05);
                    let sign = if r.mirrored { "±" } else { "" };
                    let x = r.target_m[0];
                    (
                        format!("({x}, {sign}{:.3})", theory[1].abs()),
                        format!("({:.2}, {sign}{:.3})", r.found_m[0], r.found_m[1].abs()),
                    )
                }
                _ => {
                    assert!(r.level_db < -20.0, "{r:?}");
                    ("absent".to_owned(), format!("absent, {:.1} dB", r.level_db))
                }
            };
            let _ = write!(text, " {paper} | {theory} | {found} |");
        }
        text.push('\n');
    }
    text
}

/// How many standard errors beyond their 95 % intervals let all figures of the table agree at once.
const STRETCH: f64 = 1.94;

fn sensitivity() -> String {
    let track = synthetic_track(TrackShape::Straight, 3.0, 0.03, 5.0).unwrap();
    let place: Vec<f64> = track.iter().map(|p| p[0]).collect();
    let frequency_hz = (0..171).map(|n| 3.1e9 + 1e7 * f64::from(n)).collect();
    let spread = PointSpread::new(track, None, frequency_hz, C).unwrap();
    let white = |cm: f64| {
        let model = ErrorModel::white(0.01 * cm, place.len()).unwrap();
        (format!("white, {cm} cm"), model)
    };
    let drifting = |metres: f64, cm: f64| {
        let model = ErrorModel::drifting(0.01 * cm, place.clone(), metres).unwrap();
        (format!("drifting over {metres} m, {cm} cm"), model)
    };
    let models = [
        white(0.2),
        white(0.5),
        white(1.0),
        white(2.0),
        white(3.0),
        drifting(20.0, 0.5),
        drifting(20.0, 1.0),
        drifting(20.0, 3.0),
        drifting(2.0, 1.0),
        drifting(2.0, 3.0),
    ];
    let mut text = String::from(
        "| errors | loss at the target, dB | loss at the peak, dB | shift along, mm | shift \
         across, mm | width along, × ideal |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    for (seed, (name, model)) in models.into_iter().enumerate() {
        let target = [0.0, 2.0, 0.0];
        let theory = predict(&spread, target, &model).unwrap();
        let drawn = simulate(
            &spread,
            target,
            &model,
            MonteCarlo {
                trials: 1000,
                seed: seed as u64,
            },
            Control::default(),
        )
        .unwrap();
        let cell = |theory: Option<f64>, drawn: Option<Estimate>, scale: f64, digits: usize| {
            let (Some(theory), Some(drawn)) = (theory, drawn) else {
                return "–".to_owned();
            };
            assert!(drawn.covers(theory, STRETCH), "{name}: {theory} {drawn:?}");
            let [t, a, b] = [theory, drawn.low, drawn.high].map(|v| v * scale);
            format!("{t:.digits$} [{a:.digits$}, {b:.digits$}]")
        };
        let peak = match theory.peak_loss_db {
            Some(_) => cell(theory.peak_loss_db, Some(drawn.peak_loss_db), 1.0, 2),
            None => "lost in its speckle".to_owned(),
        };
        let _ = writeln!(
            text,
            "| {name} | {} | {peak} | {} | {} | {} |",
            cell(
                Some(theory.loss_at_target_db),
                Some(drawn.loss_at_target_db),
                1.0,
                2
            ),
            cell(theory.shift_along_m, Some(drawn.shift_along_m), 1e3, 1),
            cell(theory.shift_across_m, Some(drawn.shift_across_m), 1e3, 1),
            cell(theory.widening_along, drawn.widening_along, 1.0, 3),
        );
    }
    text
}

/// Figures 6, 7, 8 and 14, drawn by the commands as a user would.
fn pictures(page: &mut Page) {
    let here = tempfile::tempdir().unwrap();
    let folder = here.path();
    std::fs::write(folder.join("targets.csv"), "-2,0,0\n0,0,0.2\n2,0,0.4\n").unwrap();
    acerra(
        folder,
        "resolution --height 5 --offset 2 --light-speed 3e8 -o 6",
    );
    let map = std::fs::read(folder.join("6/resolution-map.png")).unwrap();
    page.picture("figure-6", &map);
    for (name, options) in [
        ("7a", "--height 5 --offset 0"),
        ("7b", "--height 5 --offset 2"),
        ("7c", "--height 5 --offset 0 --track cosine:0.15:24"),
        ("7d", "--height 5 --offset 2 --track cosine:0.15:24"),
        ("7e", "--height 5 --offset 0 --track cosine:-0.15:24"),
        ("7f", "--height 5 --offset 2 --track cosine:-0.15:24"),
        ("8a", "--height 10 --offset 0 --track cosine:0.15:24"),
        ("8b", "--height 10 --offset 2 --track cosine:0.15:24"),
        ("14a", "--height 5 --targets targets.csv --plane-z 0"),
        ("14b", "--height 5 --targets targets.csv --plane-z 0.2"),
        ("14c", "--height 5 --targets targets.csv --plane-z 0.4"),
    ] {
        let common = "--light-speed 3e8 --pixel-m 0.02";
        acerra(folder, &format!("psf {common} {options} -o {name}"));
        let png = std::fs::read(folder.join(name).join("psf.png")).unwrap();
        page.picture(&format!("figure-{name}"), &png);
    }
}

fn acerra(folder: &Path, arguments: &str) {
    Command::cargo_bin("acerra")
        .unwrap()
        .current_dir(folder)
        .args(arguments.split_whitespace())
        .assert()
        .success();
}
