//! Tables of a positioning run.

use super::super::html::{self, Table};
use super::super::numbers::fixed;
use super::run::{Run, SatelliteUse, status};
use acerra_gnss::PpkSolution;
use maud::{Markup, html};

/// Reasons why epochs are not fixed, and the number for each.
pub(super) fn not_fixed(solution: &PpkSolution) -> Markup {
    let reasons = solution.summary.not_fixed.iter();
    let row = |(reason, count): &(&str, usize)| vec![(*reason).to_owned(), count.to_string()];
    let rows: Vec<Vec<String>> = reasons.map(row).collect();
    html! {
        @if !rows.is_empty() {
            (html::table(&Table {
                caption: "Why epochs are not fixed.",
                head: &["reason", "epochs"],
                rows: &rows,
            }))
        }
    }
}

/// Contribution of each satellite.
pub(super) fn satellites(satellites: &[SatelliteUse]) -> Markup {
    let rms = |values: &[f64]| {
        let finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        let mean = finite.iter().map(|v| v * v).sum::<f64>() / finite.len() as f64;
        (!finite.is_empty()).then(|| mean.sqrt())
    };
    let row = |one: &SatelliteUse| {
        let [low, high] = one.elevation_deg.map(|deg| fixed(deg, 0));
        vec![
            one.satellite.to_string(),
            one.epochs.to_string(),
            one.fixed.to_string(),
            one.slips.to_string(),
            format!("{low}–{high}"),
            fixed(rms(&one.phase_mm), 1),
            fixed(rms(&one.code_m), 2),
        ]
    };
    html::table(&Table {
        caption: "Satellites: epochs used and fixed, slips, elevation, and root mean square of the \
                  double-difference residuals.",
        head: &[
            "satellite",
            "epochs",
            "fixed",
            "slips",
            "elevation (°)",
            "phase (mm)",
            "code (m)",
        ],
        rows: &satellites.iter().map(row).collect::<Vec<_>>(),
    })
}

/// Positions at the recorded events, folded: a camera leaves thousands.
pub(super) fn events(run: &Run<'_>) -> Markup {
    let events = &run.solution.events;
    let rows: Vec<Vec<String>> = events
        .iter()
        .map(|event| {
            let enu = event.position_ecef_m.map(|p| run.frame.enu_from_ecef(p));
            let coordinate = |i: usize| fixed(enu.map(|e| e[i]), 3);
            let quality = event.quality.map_or("–", |q| status(q).name());
            vec![
                event.time.format_calendar(6),
                coordinate(0),
                coordinate(1),
                coordinate(2),
                quality.to_owned(),
            ]
        })
        .collect();
    let without = events
        .iter()
        .filter(|e| e.position_ecef_m.is_none())
        .count();
    let summary = match (events.len(), without) {
        (1, 0) => "Position at 1 recorded event".to_owned(),
        (n, 0) => format!("Positions at {n} recorded events"),
        (n, lost) => format!("Positions at {n} recorded events, {lost} of them without one"),
    };
    html! {
        @if !events.is_empty() {
            h3 { "Events" }
            (html::folded(&summary, &html::table(&Table {
                caption: "",
                head: &["time (GPST)", "east (m)", "north (m)", "up (m)", "quality"],
                rows: &rows,
            })))
        }
    }
}
