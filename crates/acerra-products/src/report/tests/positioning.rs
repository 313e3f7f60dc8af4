//! The page of a positioning run.

use super::*;

/// A real run of the engine on two simulated receivers.
pub(super) fn simulated_run() -> acerra_gnss::PpkSolution {
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
