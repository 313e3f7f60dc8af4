//! What the pages hold, and that nothing breaks out of them.

use super::*;
use acerra_chain::inputs::InputFile;
use acerra_chain::stages::Stage;
use acerra_figure::{Drawing, ImageDb, PixelValues, Radargram, TargetMark};
use acerra_geo::trajectory::SolutionStatus;

fn findings() -> Vec<EvidenceRow> {
    let row = |name: &str, [value, expected, sigma]: [f64; 3], unit: &str, verdict| EvidenceRow {
        name: name.to_owned(),
        value: Some(value),
        expected: Some(expected),
        sigma: Some(sigma),
        unit: unit.to_owned(),
        verdict,
        explanation: "How it was found, and what to do about it where it does not agree."
            .to_owned(),
    };
    vec![
        row(
            "Surface echo against 2h/c",
            [0.012, 0.0, 0.021],
            "ns",
            Verdict::Agrees,
        ),
        row(
            "Clock offset by height",
            [6.541, 6.512, 0.012],
            "s",
            Verdict::Doubtful,
        ),
        EvidenceRow {
            name: "Scan spacing against aliasing".to_owned(),
            value: Some(0.062),
            expected: Some(0.02),
            unit: "m".to_owned(),
            verdict: Verdict::Contradicts,
            explanation: "Fly more slowly or raise the scan rate.".to_owned(),
            ..EvidenceRow::default()
        },
    ]
}

fn full() -> ReportData {
    let n = 200;
    let amplitude: Vec<f32> = (0..n * n)
        .map(|i| {
            let (x, y) = ((i % n) as f32 * 0.09 - 6.0, (i / n) as f32 * 0.09 - 11.0);
            let noise = 0.02 * ((i * 7919 % 1013) as f32 / 1013.0);
            (-(x * x * 6.0) - y * y * 1.5).exp() + noise
        })
        .collect();
    let mut image = ImageDb::new("", PixelValues::Amplitude(&amplitude), n, n).at(0.0, -9.0, 0.09);
    let track: Vec<[f64; 2]> = (0..400).map(|i| [f64::from(i) * 0.05 - 1.0, 0.2]).collect();
    image.track_m = &track;
    image.targets.push(TargetMark {
        x_m: 6.0,
        y_m: 2.0,
        label: "1".to_owned(),
    });
    let samples: Vec<f32> = (0..120 * 300)
        .map(|i| ((i % 300) as f32 * 0.3).sin() * 100.0 / (1.0 + (i % 300) as f32))
        .collect();
    let picture = |drawing: Drawing, caption: &str| Picture {
        png: drawing.to_png().unwrap(),
        alt: caption.to_owned(),
        caption: caption.to_owned(),
    };
    let time_s: Vec<f64> = (0..300).map(|i| f64::from(i) * 0.1).collect();
    let widths = Widths {
        rayleigh_m: Some(0.071),
        width_3db_m: Some(0.05),
        width_6db_m: Some(0.066),
        ..Widths::default()
    };
    let distance: Vec<f64> = (-100..=100).map(|i| f64::from(i) * 0.02).collect();
    let level: Vec<f64> = distance
        .iter()
        .map(|d| {
            if *d == 0.0 {
                0.0
            } else {
                20.0 * ((9.0 * d).sin() / (9.0 * d)).abs().log10()
            }
        })
        .collect();
    let radargram = |title| {
        Radargram::new(title, &samples, 120, 300)
            .fast_time(0.0, 0.061)
            .draw()
            .unwrap()
    };
    ReportData {
        inversion: None,
        title: "Track 2 of the campaign of 9 July".to_owned(),
        summary: "331 traces of a P440 at 10 m over two corner reflectors, positioned by PPK and \
                  focused on the ground plane."
            .to_owned(),
        version: "0.1.0".to_owned(),
        facts: vec![
            Fact::new("Targets", "2"),
            Fact::new("Positions fixed", "97.3 %").note("323 of 332 epochs"),
            Fact::new("Mean height", "10.02 m"),
            Fact::new("Track", "33.1 m in 21.7 s"),
        ],
        evidence: findings(),
        unchecked: vec![[
            "delay_ns".to_owned(),
            "An error of 1 ns is 0.15 m.".to_owned(),
        ]],
        warnings: vec![
            "9 of 332 epochs have float ambiguities: decimetres instead of centimetres".to_owned(),
            "2 scans were lost between traces 120 and 123".to_owned(),
        ],
        image: Some(picture(
            image.draw().unwrap(),
            "Focused image, dB below its maximum.",
        )),
        surveyed: vec![crate::surveyed::SurveyRecord {
            name: "east corner".to_owned(),
            x_m: 6.0,
            y_m: 2.0,
            z_m: 0.0,
            nearest: Some(crate::surveyed::NearestTarget {
                target: 1,
                distance_m: 0.0104,
                off_m: [0.003, 0.01],
            }),
        }],
        targets: vec![
            TargetRow {
                x_m: 6.003,
                y_m: 2.01,
                level_db: 0.0,
                along: widths,
                across: Widths {
                    rayleigh_m: Some(0.5),
                    inner_m: Some(0.55),
                    outer_m: Some(0.45),
                    ..widths
                },
                pslr_db: Some(-12.9),
                islr_db: Some(-8.2),
                ghost: Some(GhostRow {
                    level: 0.74,
                    x_m: 6.0,
                    y_m: -1.9,
                }),
                cuts: Some(CutLevels {
                    along: Cut {
                        distance_m: distance.clone(),
                        image_db: level.clone(),
                        theory_db: level.iter().map(|l| l * 1.2).collect(),
                    },
                    across: Cut {
                        distance_m: distance.clone(),
                        image_db: level.iter().map(|l| l * 0.4).collect(),
                        theory_db: Vec::new(),
                    },
                }),
                ..TargetRow::default()
            },
            TargetRow {
                x_m: 16.0,
                y_m: 2.02,
                level_db: -1.3,
                ..TargetRow::default()
            },
        ],
        remarks: vec!["Targets 1, 2 lie under the track <here>.".to_owned()],
        radargram_raw: Some(picture(radargram("Raw"), "As recorded.")),
        radargram_clean: Some(picture(radargram("Clean"), "As focused.")),
        pictures: Vec::new(),
        tracks: vec![TrackEvidence {
            name: String::new(),
            trajectory: Some(TrajectoryEvidence {
                position_m: time_s
                    .iter()
                    .map(|t| {
                        [
                            1.1 * t - 5.0,
                            0.3 * (0.4 * t).sin(),
                            10.0 + 0.2 * (0.7 * t).sin(),
                        ]
                    })
                    .collect(),
                sigma_m: time_s
                    .iter()
                    .map(|t| [0.006, 0.008, 0.01 + 0.001 * t])
                    .collect(),
                status: (0..300)
                    .map(|i| match i {
                        0..=4 => SolutionStatus::Single,
                        100..=130 => SolutionStatus::Float,
                        _ => SolutionStatus::Fixed,
                    })
                    .collect(),
                plane_z_m: 0.0,
                used_s: Some([6.0, 27.0]),
                time_s: time_s.clone(),
            }),
            alignment: Some(AlignmentEvidence {
                offset_s: (0..200).map(|i| f64::from(i) * 0.01 + 5.5).collect(),
                score: (0..200)
                    .map(|i| (-(f64::from(i) - 101.0).powi(2) / 90.0).exp())
                    .collect(),
                chosen_s: 6.51,
                score_name: "image contrast".to_owned(),
                remark: "Contrast of a coarse image against the offset.".to_owned(),
            }),
            surface: Some(SurfaceEvidence {
                picked_range_m: time_s
                    .iter()
                    .enumerate()
                    .map(|(i, t)| {
                        if i % 17 == 0 {
                            f64::NAN
                        } else {
                            10.03 + 0.2 * (0.7 * t).sin()
                        }
                    })
                    .collect(),
                height_m: time_s
                    .iter()
                    .map(|t| 10.0 + 0.2 * (0.7 * t).sin())
                    .collect(),
                time_s,
                shift_ns: -1.234,
                remark: "A constant difference is a delay, a drift is a tilt of the ground."
                    .to_owned(),
            }),
        }],
        choices: vec![
            Fact::new("algorithm", "direct sum, AVX2").note("cheapest for this geometry"),
            Fact::new("time offset", "6.512 s"),
        ],
        inputs: vec![InputFile {
            path: "flight/track-2.mrm".into(),
            bytes: 1_234_567,
            sha256: "ab".repeat(32),
            sources: None,
        }],
        stages: [
            "read", "position", "align", "clean", "focus", "measure", "deliver",
        ]
        .map(|name| Stage {
            name,
            seconds: 0.123,
            peak_memory_bytes: Some(50 << 20),
        })
        .to_vec(),
        configuration: "[radar]\nfile = \"track-2.mrm\"\n".to_owned(),
    }
}

/// For looking at: ACERRA_FIGURES=/some/dir cargo test -p acerra report
fn keep(name: &str, html: &str) {
    if let Ok(dir) = std::env::var("ACERRA_FIGURES") {
        std::fs::write(format!("{dir}/{name}.html"), html).unwrap();
    }
}

#[test]
fn surveyed_points_stand_beside_the_nearest_target() {
    let html = report_page(&full()).unwrap();
    assert!(html.contains("Surveyed points") && html.contains("east corner"));
    assert!(html.contains("<td>0.010</td>"));
    let none = report_page(&ReportData::default()).unwrap();
    assert!(!none.contains("Surveyed points"));
}

#[test]
fn a_full_report_answers_in_order() {
    let html = report_page(&full()).unwrap();
    keep("report", &html);
    let order = [
        "id=\"evidence\"",
        "Scan spacing against aliasing</th>",
        "Clock offset by height</th>",
        "Surface echo against 2h/c</th>",
        "Nothing in this flight checks: delay_ns",
        "id=\"result\"",
        "id=\"warnings\"",
        "id=\"measurements\"",
        "Target 1, along the track",
        "Target 1, across the track",
        "id=\"provenance\"",
    ];
    assert!(html.contains("under the track &lt;here&gt;"));
    assert!(html.contains("ideal point, Eq. (5)"));
    let places: Vec<_> = order.iter().map(|mark| html.find(mark).unwrap()).collect();
    assert!(places.is_sorted());
    for text in [
        "6.003",
        "0.071",
        "−12.9",
        "0.740",
        "−2.6", // the ghost's level in dB
        "9 of 332 epochs",
        &"ab".repeat(32),
        "1.2 MiB",
        "file = &quot;track-2.mrm&quot;",
        "fixed 88.0 %",
        "median 0.030 m",
        "Picked in 282 of 300",
        "1 of 3 findings contradicts this result: Scan spacing against aliasing. Doubtful: Clock",
        "<span class=\"muted\">(2.4 σ off)</span>",
        "6.541\u{a0}s",
    ] {
        assert!(html.contains(text), "{text} is missing");
    }
}

#[test]
fn a_report_asks_nothing_from_outside() {
    let html = report_page(&full()).unwrap();
    assert!(!html.contains("<script"));
    for attribute in ["src=\"", "href=\""] {
        for part in html.split(attribute).skip(1) {
            let inside = part.starts_with("data:") || part.starts_with('#');
            assert!(inside, "{attribute}{}", &part[..60]);
        }
    }
    assert!(!html.contains("url(") && !html.contains("@import"));
}

#[test]
fn tags_are_balanced() {
    let pages = [
        report_page(&full()).unwrap(),
        index_page(&IndexPage::default()),
    ];
    for html in pages {
        for tag in [
            "section", "figure", "div", "table", "tr", "td", "th", "svg", "text", "dl", "ul", "p",
        ] {
            let opened = html.matches(&format!("<{tag}>")).count()
                + html.matches(&format!("<{tag} ")).count();
            let closed = html.matches(&format!("</{tag}>")).count();
            assert_eq!(opened, closed, "<{tag}>");
        }
    }
}

#[test]
fn hostile_names_stay_text() {
    let evil = "</title><script>alert(1)</script>\"'&".to_owned();
    let mut data = full();
    data.title = evil.clone();
    data.summary = evil.clone();
    data.warnings = vec![evil.clone()];
    data.configuration = evil.clone();
    data.facts = vec![Fact::new(evil.clone(), evil.clone()).note(evil.clone())];
    data.choices = data.facts.clone();
    data.inputs[0].path = evil.clone().into();
    data.tracks[0].alignment.as_mut().unwrap().score_name = evil.clone();
    data.tracks[0].alignment.as_mut().unwrap().remark = evil.clone();
    data.image.as_mut().unwrap().alt = evil.clone();
    data.evidence[0].name = evil.clone();
    data.evidence[0].unit = evil.clone();
    data.evidence[0].explanation = evil.clone();
    data.unchecked[0] = [evil.clone(), evil.clone()];
    data.tracks[0].name = evil.clone();
    assert!(!report_page(&data).unwrap().contains("<script"));
    let entry = IndexEntry {
        title: evil.clone(),
        report: "x\" onclick=\"y".to_owned(),
        ..IndexEntry::default()
    };
    let html = index_page(&IndexPage {
        title: evil.clone(),
        entries: vec![entry],
        remarks: vec![evil],
        ..IndexPage::default()
    });
    assert!(!html.contains("<script") && !html.contains("onclick=\"y\""));
}

#[test]
fn tracks_stand_on_time_axes_of_their_own() {
    let mut data = full();
    let mut later = data.tracks[0].clone();
    data.tracks[0].name = "morning".to_owned();
    later.name = "evening".to_owned();
    let trajectory = later.trajectory.as_mut().unwrap();
    trajectory.time_s.iter_mut().for_each(|t| *t += 36_000.0);
    trajectory.used_s = None;
    data.tracks.push(later);
    let html = report_page(&data).unwrap();
    keep("tracks", &html);
    let at = |text: &str| html.find(text).unwrap_or_else(|| panic!("no {text}"));
    let (morning, evening) = (at("<h3>Track morning"), at("<h3>Track evening"));
    assert!(
        html[..morning].contains(">Track morning<") && html[..morning].contains(">Track evening<")
    );
    // Ten hours later: ticks of the second axis, and only of the second.
    assert!(!html[morning..evening].contains(">36010<"));
    assert!(html[evening..].contains(">36010<") && !html[evening..].contains(">10</text><text"));
}

#[test]
fn every_picture_is_described() {
    let mut data = full();
    data.pictures = vec![data.image.clone().unwrap()];
    let pages = [
        report_page(&data).unwrap(),
        ppk_page(&PpkReport {
            title: String::new(),
            version: String::new(),
            solution: &simulated_run(),
            ratio_threshold: None,
            pass_difference_m: Vec::new(),
            warnings: Vec::new(),
            inputs: Vec::new(),
            configuration: String::new(),
        })
        .unwrap(),
    ];
    for html in pages {
        let words = |mark: &str, attribute: &str| -> Vec<usize> {
            let parts = html.split(mark).skip(1);
            parts
                .map(|part| {
                    let tag = part.split('>').next().unwrap_or_default();
                    let value = tag.split(attribute).nth(1).unwrap_or_default();
                    let text = value.split('"').next().unwrap_or_default();
                    text.split_whitespace().count()
                })
                .collect()
        };
        let images = words("<img ", "alt=\"");
        let drawings = words("<svg xmlns", "aria-label=\"");
        assert!(images.len() + drawings.len() >= 2);
        assert!(images.iter().chain(&drawings).all(|count| *count >= 2));
    }
}

#[test]
fn the_verdict_names_what_is_wrong() {
    let mut rows = findings();
    assert!(verdict_line(&rows).starts_with("1 of 3 findings contradicts"));
    rows.pop();
    assert_eq!(
        verdict_line(&rows),
        "1 of 2 findings is doubtful: Clock offset by height."
    );
    rows.pop();
    assert_eq!(
        verdict_line(&rows),
        "The one finding agrees with this result."
    );
    let mut data = full();
    data.evidence = Vec::new();
    assert!(!report_page(&data).unwrap().contains("id=\"evidence\""));
}

#[test]
fn an_empty_report_is_a_page_and_odd_lists_are_refused() {
    let html = report_page(&ReportData::default()).unwrap();
    assert!(html.contains("No targets") && html.contains("No warnings"));
    let mut data = full();
    data.tracks[0].trajectory.as_mut().unwrap().status.pop();
    assert!(report_page(&data).is_err());
    let mut data = full();
    data.tracks[0].surface.as_mut().unwrap().height_m.pop();
    assert!(report_page(&data).is_err());
    let mut data = full();
    data.tracks[0].trajectory = Some(TrajectoryEvidence::default());
    assert!(report_page(&data).unwrap().contains("holds no positions"));
}

#[test]
fn the_same_data_make_the_same_page() {
    assert_eq!(report_page(&full()).unwrap(), report_page(&full()).unwrap());
}

#[test]
fn the_index_links_its_reports() {
    let data = full();
    let entry = |title: &str, report: &str, warnings| IndexEntry {
        title: title.to_owned(),
        report: report.to_owned(),
        png: data.image.clone().unwrap().png,
        facts: data.facts.clone(),
        warnings,
    };
    let html = index_page(&IndexPage {
        title: "The campaign, simulated and processed".to_owned(),
        summary: "Two tracks over two corner reflectors.".to_owned(),
        entries: vec![
            entry("Track 1", "track-1/report.html", 0),
            entry("Track 2", "track-2/report.html", 2),
        ],
        tables: vec![ComparisonTable {
            caption: "Resolution (m)".to_owned(),
            head: ["track", "along", "theory"].map(str::to_owned).to_vec(),
            rows: vec![["1", "0.04", "0.02"].map(str::to_owned).to_vec()],
        }],
        remarks: vec!["Simulated: the truth is known.".to_owned()],
    });
    keep("index", &html);
    assert!(html.contains("href=\"track-2/report.html#warnings\">2 warnings"));
    assert!(html.contains("<td>0.04</td>"));
}

/// A real run of the engine on two simulated receivers.
fn simulated_run() -> acerra_gnss::PpkSolution {
    use acerra_geo::geodesy::{EnuFrame, Geodetic};
    use acerra_geo::time::{Calendar, GpsTime};
    use acerra_gnss::input::Limits;
    use acerra_simulate::gnss::{GnssModel, Setting, constellation, simulate};

    let start = GpsTime::from_calendar(&Calendar::new(2018, 7, 9, 9, 30, 0.0).unwrap());
    let navigation = constellation(start, 120.0, 5);
    let mut model = GnssModel::default();
    model.rover.slips_per_hour = 30.0;
    model.base.outages_s = vec![[60.0, 95.0]];
    let logs = simulate(
        &model,
        &Setting {
            frame: EnuFrame::new(Geodetic::from_degrees(40.95, 14.35, 60.0)),
            start,
            duration_s: 120.0,
            rover_m: &|t| {
                [
                    10.0 * (0.1 * t).sin(),
                    4.0 * (0.07 * t).cos(),
                    5.0 + 0.02 * t,
                ]
            },
            base_m: [-20.0, 5.0, 1.5],
            navigation: &navigation,
            seed: 5,
        },
    )
    .unwrap();
    let read = |text: String| {
        acerra_gnss::read_observations(text.as_bytes(), Limits::default())
            .unwrap()
            .0
    };
    let options = acerra_gnss::PpkOptions::default()
        .with_base_position(acerra_gnss::BasePosition::Ecef(logs.base.position_ecef_m));
    let (rover, base) = (
        read(logs.rover.to_rinex("R")),
        read(logs.base.to_rinex("B")),
    );
    acerra_gnss::process(&rover, &base, &navigation, &options).unwrap()
}

#[test]
fn the_page_of_a_positioning_run_tells_its_story() {
    let solution = simulated_run();
    let html = ppk_page(&PpkReport {
        title: "Flight <1>".to_owned(),
        version: "0.1.0".to_owned(),
        solution: &solution,
        ratio_threshold: Some(3.5),
        pass_difference_m: Vec::new(),
        warnings: vec!["1 line was skipped".to_owned()],
        inputs: full().inputs,
        configuration: "elevation_mask_deg = 15".to_owned(),
    })
    .unwrap();
    keep("ppk", &html);
    let summary = &solution.summary;
    for text in [
        format!("{} of {} epochs", summary.fixed, summary.rover_epochs),
        "1 line was skipped".to_owned(),
        "Flight &lt;1&gt;".to_owned(),
        "phase residual (mm)".to_owned(),
        "needed: 3.5".to_owned(),
        "the base's log has a gap from 2018/07/09 09:31:00".to_owned(),
        solution.epochs[0].residuals[0].satellite.to_string(),
    ] {
        assert!(html.contains(&text), "{text} is missing");
    }
    for (reason, count) in &summary.not_fixed {
        assert!(html.contains(&format!("<th scope=\"row\">{reason}</th><td>{count}</td>")));
    }
    assert!(!html.contains("<script"));
}

#[test]
fn events_are_folded_and_pass_differences_shown() {
    use acerra_gnss::{EventKind, EventPosition, EventRecord};
    let mut solution = simulated_run();
    let epoch = solution.epochs[10].clone();
    solution.events = (0..500)
        .map(|i| EventPosition {
            event: EventRecord {
                time: epoch.time,
                kind: EventKind::External,
                count: Some(i),
                accuracy_s: None,
            },
            time: epoch.time,
            position_ecef_m: (i > 0).then_some(epoch.position_ecef_m),
            covariance_ecef_m2: epoch.covariance_ecef_m2,
            quality: None,
        })
        .collect();
    let mut report = PpkReport {
        title: "Events".to_owned(),
        version: String::new(),
        solution: &solution,
        ratio_threshold: Some(3.0),
        pass_difference_m: vec![0.02; solution.epochs.len()],
        warnings: Vec::new(),
        inputs: Vec::new(),
        configuration: String::new(),
    };
    let html = ppk_page(&report).unwrap();
    keep("ppk-events", &html);
    let folded = html.find("<details class=\"long\"><summary>").unwrap();
    let rows = html[folded..].split("</details>").next().unwrap();
    assert!(rows.contains("Positions at 500 recorded events, 1 of them without one"));
    assert_eq!(rows.matches("<tr>").count(), 501);
    assert!(html.contains(">forward against backward pass<"));
    report.pass_difference_m.pop();
    assert!(ppk_page(&report).is_err());
}

#[test]
fn a_positioning_run_without_positions_is_a_page() {
    let solution = acerra_gnss::PpkSolution {
        base_position_ecef_m: None,
        epochs: Vec::new(),
        lost: Vec::new(),
        events: Vec::new(),
        summary: acerra_gnss::PpkSummary::default(),
    };
    let report = PpkReport {
        title: "Nothing".to_owned(),
        version: String::new(),
        solution: &solution,
        ratio_threshold: None,
        pass_difference_m: Vec::new(),
        warnings: Vec::new(),
        inputs: Vec::new(),
        configuration: String::new(),
    };
    assert!(
        ppk_page(&report)
            .unwrap()
            .contains("No epoch has a position")
    );
}

#[test]
fn an_inversion_is_shown_with_its_residual_and_resolution() {
    use acerra_chain::inversion::record::{
        Chosen, InversionRecord, NoiseRecord, ParameterRecord, ResolutionRecord,
    };
    use acerra_invert::{Iteration, PointResponse, Stop};
    let response = |across_m| PointResponse {
        point_m: [4.0, 0.0, 0.0],
        displacement_m: 0.004,
        peak: 0.02,
        along_3db_m: Some(0.055),
        across_3db_m: Some(across_m),
        artefact_db: Some(-13.5),
        main_share: 0.91,
    };
    let record = InversionRecord {
        method: acerra_chain::inversion::Method::Tsvd,
        meaning: "reflectivity",
        parameter: ParameterRecord {
            name: "threshold",
            value: -20.0,
            choice: Chosen::Given,
        },
        parameters: 321.0,
        stop: Stop::Iterations,
        iterations: vec![Iteration {
            number: 120,
            residual: 0.1,
            change: 0.2,
        }],
        residual: 0.1,
        noise: Some(NoiseRecord {
            sigma: 1.0,
            expected_residual: 0.05,
            cells: 700,
        }),
        resolution: vec![ResolutionRecord {
            point_m: [4.0, 0.0, 0.0],
            method: Some(response(0.41)),
            adjoint: Some(response(0.52)),
        }],
        operator_accuracy: 3e-4,
    };
    let data = ReportData {
        inversion: Some(record),
        ..ReportData::default()
    };
    let page = report_page(&data).unwrap();
    for part in [
        "id=\"inversion\"",
        "−20.0",
        "iterations spent",
        "−26.0",
        "0.410",
        "0.520",
        "−13.5",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(
        !report_page(&ReportData::default())
            .unwrap()
            .contains("id=\"inversion\"")
    );
}
