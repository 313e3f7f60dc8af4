//! Solution for the scene: parameter, residual, convergence, resolution.

use super::html::{self, Fit, Table};
use super::numbers::fixed;
use acerra_chain::focus::inversion::InversionRecord;
use acerra_chain::focus::inversion::record::{Chosen, ResolutionRecord};
use acerra_figure::{Axis, FigureError, LinePlot, ReferenceLine, Series};
use acerra_invert::{PointResponse, Stop};
use maud::{Markup, html};

/// The section; empty for an image that is the adjoint.
pub(super) fn section(record: Option<&InversionRecord>) -> Result<Markup, FigureError> {
    let Some(record) = record else {
        return Ok(html! {});
    };
    Ok(html! {
        section #inversion {
            h2 { "Inversion" }
            p { "Method " code { (record.method.name()) } "; the image is " (record.meaning) "." }
            (numbers(record))
            (convergence(record)?)
            (resolution(&record.resolution))
        }
    })
}

fn numbers(record: &InversionRecord) -> Markup {
    let chosen = match record.parameter.choice {
        Chosen::Given => "as stated, or by default",
        Chosen::Noise => "by the noise measured",
        Chosen::LCurve => "by the corner of the L-curve",
        Chosen::Floor => "the least that is sensible: noise is lower, or not known",
    };
    let stop = match record.stop {
        Stop::Converged => "converged",
        Stop::Noise => "no residual above the threshold",
        Stop::Exhausted => "the data hold no further signal",
        Stop::Stalled => "no longer improving",
        _ => "iterations spent",
    };
    let decibel = |ratio: f64| fixed(20.0 * ratio.max(1e-15).log10(), 1);
    let mut rows = vec![
        vec![
            record.parameter.name.to_owned(),
            fixed(record.parameter.value, 4),
            chosen.to_owned(),
        ],
        vec![
            "iterations".to_owned(),
            record.iterations.last().map_or(0, |i| i.number).to_string(),
            stop.to_owned(),
        ],
        vec![
            "singular values, pixels or components in the image".to_owned(),
            fixed(record.parameters, 0),
            String::new(),
        ],
        vec![
            "residual of the data, dB".to_owned(),
            decibel(record.residual),
            "echoes that the image does not explain".to_owned(),
        ],
    ];
    if let Some(noise) = record.noise {
        rows.push(vec![
            "noise in the data, dB".to_owned(),
            decibel(noise.expected_residual),
            format!(
                "measured in {} range cells in front of the first echo",
                noise.cells
            ),
        ]);
    }
    html::table(&Table {
        caption: "How the scene was solved for.",
        head: &["quantity", "value", "how"],
        rows: &rows,
    })
}

fn convergence(record: &InversionRecord) -> Result<Markup, FigureError> {
    let number: Vec<f64> = record.iterations.iter().map(|i| i.number as f64).collect();
    let decibels = |value: fn(&acerra_invert::Iteration) -> f64| -> Vec<f64> {
        let of = |i| 20.0 * value(i).max(1e-12).log10();
        record.iterations.iter().map(of).collect()
    };
    let (residual, change) = (decibels(|i| i.residual), decibels(|i| i.change));
    let mut plot = LinePlot::new("", Axis::new("iteration", ""), Axis::new("level", "dB"))
        .height(200.0)
        .with(Series::line("residual of the data", &number, &residual))
        .with(Series::line("what the stop rule looks at", &number, &change).dashed());
    if let Some(noise) = record.noise {
        plot = plot.reference(ReferenceLine {
            at_x: false,
            value: 20.0 * noise.expected_residual.max(1e-12).log10(),
            label: "noise".to_owned(),
        });
    }
    let alt = "Residual of the data and the stop rule's measure over the iterations, in decibels";
    Ok(html::drawing(plot.draw()?, Fit::Scrolled, alt, ""))
}

fn resolution(points: &[ResolutionRecord]) -> Markup {
    let mut rows = Vec::new();
    for record in points {
        let place = record.point_m.map(|v| fixed(v, 2)).join(", ");
        for (name, response) in [("method", &record.method), ("adjoint", &record.adjoint)] {
            let of = |value: fn(&PointResponse) -> Option<f64>| response.as_ref().and_then(value);
            rows.push(vec![
                place.clone(),
                name.to_owned(),
                fixed(of(|r| r.along_3db_m), 3),
                fixed(of(|r| r.across_3db_m), 3),
                fixed(of(|r| Some(r.displacement_m)), 3),
                fixed(of(|r| r.artefact_db), 1),
                fixed(of(|r| Some(100.0 * r.main_share)), 0),
                fixed(of(|r| Some(r.peak)), 4),
            ]);
        }
    }
    html! {
        @if !rows.is_empty() {
            h3 { "Resolution" }
            (html::table(&Table {
                caption: "Images of the noise-free echoes of a single point at the strongest targets, by \
                          the method and by the adjoint: widths at −3 dB, the greatest value farther than \
                          two resolution distances from it, and the share of the energy within them. A \
                          narrower main lobe under higher artefacts is a prettier picture, not a better \
                          one.",
                head: &[
                    "point (m)",
                    "image",
                    "along (m)",
                    "across (m)",
                    "off by (m)",
                    "artefacts (dB)",
                    "main share (%)",
                    "peak",
                ],
                rows: &rows,
            }))
        }
    }
}
