//! Cuts through the targets, compared with those of an ideal point.

use super::data::{Cut, TargetRow};
use super::html::{self, Fit};
use acerra_figure::{FigureError, cut_plot};
use maud::{Markup, html};

/// Lowest level shown, in dB of the peak.
const FLOOR_DB: f64 = -40.0;

pub(super) fn section(targets: &[TargetRow]) -> Result<Markup, FigureError> {
    let mut plots = Vec::new();
    for (i, target) in targets.iter().enumerate() {
        if let Some(cuts) = &target.cuts {
            plots.push(plot(
                &format!("Target {}, along the track", i + 1),
                &cuts.along,
            )?);
            plots.push(plot(
                &format!("Target {}, across the track", i + 1),
                &cuts.across,
            )?);
        }
    }
    Ok(html! {
        @if !plots.is_empty() {
            h3 { "Cuts through the targets" }
            p {
                "Each cut is drawn together with that of an ideal point seen from the same flight: where "
                "the image is wider or its sidelobes are higher, the antennas or the target see "
                "less of the flight than an ideal point does, or the positions are off."
            }
            @for plot in plots { (plot) }
        }
    })
}

fn plot(title: &str, cut: &Cut) -> Result<Markup, FigureError> {
    let mut curves = vec![("image", cut.distance_m.as_slice(), cut.image_db.as_slice())];
    if !cut.theory_db.is_empty() {
        curves.push((
            "ideal point, Eq. (5)",
            cut.distance_m.as_slice(),
            cut.theory_db.as_slice(),
        ));
    }
    let plot = cut_plot(title, &curves, FLOOR_DB).height(210.0);
    let alt = format!("{title}: level in dB of the peak over distance from it");
    Ok(html::drawing(plot.draw()?, Fit::Scrolled, &alt, ""))
}
