//! A report with every part.

use acerra_chain::journal::stages::Stage;
use acerra_chain::read::inputs::InputFile;
use acerra_figure::{Drawing, ImageDb, PixelValues, Radargram, TargetMark};
use acerra_geo::trajectory::SolutionStatus;

use super::*;

/// Three findings, one of each verdict.
pub(super) fn findings() -> Vec<EvidenceRow> {
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

fn picture(drawing: Drawing, caption: &str) -> Picture {
    Picture::drawn(|_| Ok(drawing.clone()), caption, caption).unwrap()
}

fn image() -> Drawing {
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
    image.draw().unwrap()
}

fn radargram(title: &str) -> Drawing {
    let samples: Vec<f32> = (0..120 * 300)
        .map(|i| ((i % 300) as f32 * 0.3).sin() * 100.0 / (1.0 + (i % 300) as f32))
        .collect();
    Radargram::new(title, &samples, 120, 300)
        .fast_time(0.0, 0.061)
        .draw()
        .unwrap()
}

fn targets() -> Vec<TargetRow> {
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
    vec![
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
    ]
}

fn track() -> TrackEvidence {
    let time_s: Vec<f64> = (0..300).map(|i| f64::from(i) * 0.1).collect();
    TrackEvidence {
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
            line_starts: Vec::new(),
            is_untimed: false,
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
            remark: "A constant difference is a delay, a drift is a tilt of the ground.".to_owned(),
        }),
    }
}

/// All of it.
pub(super) fn full() -> ReportData {
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
        notes: vec!["track-2.mrm: 1 of 4 messages of the last scan".to_owned()],
        image: Some(picture(image(), "Focused image, dB below its maximum.")),
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
        targets: targets(),
        remarks: vec!["Targets 1, 2 lie under the track <here>.".to_owned()],
        radargram_raw: Some(picture(radargram("Raw"), "As recorded.")),
        radargram_clean: Some(picture(radargram("Clean"), "As focused.")),
        pictures: Vec::new(),
        tracks: vec![track()],
        choices: vec![
            Fact::new("algorithm", "direct sum, AVX2").note("cheapest for this geometry"),
            Fact::new("time offset", "6.512 s"),
        ],
        plan: vec![Fact::new("Work", "1801 × 1801 pixels, 296 pulses")],
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
