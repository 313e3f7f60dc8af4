//! Contents of the pages.

use super::*;

#[test]
fn a_full_report_answers_in_order() {
    let html = report_page(&full()).unwrap();
    keep("report", &html);
    let order = [
        "id=\"image\"",
        "id=\"evidence\"",
        "Scan spacing against aliasing</th>",
        "Clock offset by height</th>",
        "Surface echo against 2h/c</th>",
        "Nothing in this flight checks: delay_ns",
        "id=\"warnings\"",
        "Left out without harm",
        "id=\"result\"",
        "id=\"measurements\"",
        "Target 1, along the track",
        "Target 1, across the track",
        "id=\"provenance\"",
        "1801 × 1801 pixels",
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
fn depths_are_a_column_of_images_below_ground() {
    let mut data = full();
    let head = "depth below the surface (m)";
    assert!(!report_page(&data).unwrap().contains(head));
    data.targets[0].depth_m = Some([0.123, 0.004]);
    let html = report_page(&data).unwrap();
    assert!(html.contains(head) && html.contains("0.123 ± 0.004"));
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

#[test]
fn an_inversion_is_shown_with_its_residual_and_resolution() {
    use acerra_chain::focus::inversion::record::{
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
        method: acerra_chain::focus::inversion::Method::Tsvd,
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
