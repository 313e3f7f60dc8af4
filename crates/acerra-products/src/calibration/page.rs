//! `report.html` of a calibration.

use acerra_figure::{Axis, Drawing, FigureError, LinePlot, Series};
use maud::{Markup, html};

use super::outcome::CalibrationOutcome;
use super::record::{CalibrationRecord, EstimateRecord, series};
use crate::report::html::{self, Fit, Table};

/// The page: values, what is not observable, correlation, residuals, reflectors.
///
/// # Errors
/// [`FigureError`] where a figure cannot be drawn.
pub(super) fn page(name: &str, outcome: &CalibrationOutcome) -> Result<String, FigureError> {
    let record = CalibrationRecord::of(outcome);
    let title = format!("Calibration of {name}");
    let residuals = residual_plot(outcome)?;
    let badge = html::warning_badge(record.warnings.len(), "#warnings");
    let body = html! {
        (html::heading(&title, "", record.version, &badge))
        section #result {
            h2 { "Result" }
            (estimates(&record.estimates))
        }
        (html::warnings(&record.warnings, &[]))
        section #observability {
            h2 { "What the geometry cannot determine" }
            (directions(&record))
            (sensitivities(&record))
            h3 { "Correlation of the estimates" }
            (correlation(&record))
        }
        section #evidence {
            h2 { "Evidence" }
            (html::drawing(
                residuals,
                Fit::Scrolled,
                "Range residuals of the echoes over radar time, by reflector",
                "Range residuals of the echoes that took part, by reflector.",
            ))
            (reflectors(&record))
        }
    };
    Ok(html::document(&title, &body))
}

fn estimates(estimates: &[EstimateRecord]) -> Markup {
    let rows = estimates.iter().map(|e| {
        let sigma = e
            .sigma
            .map_or("not observable, kept".to_owned(), |s| format!("±{s:.4}"));
        let numbers = [e.campaign, e.value].map(|v| format!("{v:.4}"));
        let [campaign, value] = numbers;
        vec![format!("{} ({})", e.name, e.unit), campaign, value, sigma]
    });
    table(
        &["unknown", "campaign", "found", "σ"],
        &rows.collect::<Vec<_>>(),
    )
}

fn directions(record: &CalibrationRecord) -> Markup {
    html! {
        @if record.not_observable.is_empty() {
            p.note.good { "All unknowns are observed." }
        } @else {
            p { "Changes along these directions leave the echoes where they are:" }
            ul {
                @for direction in &record.not_observable {
                    li {
                        @for (k, c) in direction.components.iter().enumerate() {
                            @if k > 0 { ", " }
                            (c.name) " " (format!("{:+.4}", c.change)) " " (c.unit)
                        }
                    }
                }
            }
        }
    }
}

fn sensitivities(record: &CalibrationRecord) -> Markup {
    html! {
        @if !record.sensitivity.is_empty() {
            h3 { "If a value that was kept is wrong" }
            (table(
                &["estimate", "kept", "change per unit"],
                &record.sensitivity.iter().map(|s| {
                    vec![s.of.clone(), s.to.clone(), format!("{:+.4} {}", s.slope, s.unit)]
                }).collect::<Vec<_>>(),
            ))
        }
    }
}

fn correlation(record: &CalibrationRecord) -> Markup {
    let mut head = vec![""];
    head.extend(record.estimated.iter().map(String::as_str));
    let rows = record.estimated.iter().zip(&record.correlation);
    let row = |(name, row): (&String, &Vec<f64>)| {
        let cells = row.iter().map(|c| format!("{c:+.2}"));
        std::iter::once(name.clone()).chain(cells).collect()
    };
    table(&head, &rows.map(row).collect::<Vec<_>>())
}

fn reflectors(record: &CalibrationRecord) -> Markup {
    let rows = record.reflectors.iter().map(|r| {
        let [x, y, z] = r.position_m;
        vec![
            format!("{x:.3}, {y:.3}, {z:.3}"),
            r.echoes.to_string(),
            r.kept.to_string(),
            format!("{:.1}", 1e3 * r.rms_m),
        ]
    });
    table(
        &["reflector (m)", "echoes", "took part", "rms (mm)"],
        &rows.collect::<Vec<_>>(),
    )
}

fn table(head: &[&str], rows: &[Vec<String>]) -> Markup {
    html::table(&Table {
        caption: "",
        head,
        rows,
    })
}

fn residual_plot(outcome: &CalibrationOutcome) -> Result<Drawing, FigureError> {
    let found = &outcome.calibrated;
    let lists: Vec<_> = (0..found.reflectors.len())
        .map(|k| series(&found.residuals, k))
        .collect();
    let axes = (Axis::new("radar time", "s"), Axis::new("residual", "mm"));
    let mut plot = LinePlot::new("", axes.0, axes.1).height(260.0);
    for (k, (time_s, residual_mm)) in lists.iter().enumerate() {
        if !time_s.is_empty() {
            plot = plot.with(Series::dots(
                format!("reflector {}", k + 1),
                time_s,
                residual_mm,
            ));
        }
    }
    plot.draw()
}
