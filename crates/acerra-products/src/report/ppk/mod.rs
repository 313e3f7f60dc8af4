//! The page of a positioning run: positions of the rover, their accuracy, and the causes of poor accuracy.

mod figures;
mod input;
mod run;
mod tables;

use super::html::{self, Fit};
use super::provenance;
use acerra_figure::FigureError;
use maud::{Markup, html};
use run::Run;

pub use input::PpkReport;

/// Writes the page of a positioning run as a complete HTML page: trajectory, status over time,
/// height with ±1σ, satellites, residuals, and the reasons of epochs that are not fixed.
///
/// # Errors
/// [`FigureError`] where a figure cannot be drawn, or the pass differences are not one per epoch.
pub fn ppk_page(report: &PpkReport<'_>) -> Result<String, FigureError> {
    let run = Run::new(report)?;
    let own = &report.solution.summary.warnings;
    let mut warnings: Vec<String> = own.iter().map(ToString::to_string).collect();
    warnings.extend(report.warnings.iter().cloned());
    let (map, evidence) = if run.is_empty() {
        let nothing = html! { p.muted { "No epoch has a position." } };
        (nothing, html! {})
    } else {
        (map(&run)?, evidence(&run)?)
    };
    let badges = html::warning_badge(warnings.len(), "#warnings");
    let body = html! {
        (html::heading(&report.title, "", &report.version, &badges))
        section #result {
            h2 { "Result" }
            (html::tiles(&run.facts()))
            (map)
            (tables::not_fixed(report.solution))
        }
        (html::warnings(&warnings, &[]))
        (evidence)
        section #provenance {
            h2 { "How it was made" }
            (provenance::inputs(&report.inputs))
            (provenance::configuration(&report.configuration))
        }
    };
    Ok(html::document(&report.title, &body))
}

fn map(run: &Run<'_>) -> Result<Markup, FigureError> {
    let alt = "Map of the positions from above, coloured by quality";
    let drawing = figures::map(run)?;
    Ok(html::drawing(drawing, Fit::Whole, alt, &run.map_caption()))
}

fn evidence(run: &Run<'_>) -> Result<Markup, FigureError> {
    let satellites = run.satellites();
    let over_time = html::drawing(
        figures::over_time(run, &satellites)?,
        Fit::Scrolled,
        "Over one time axis: quality, ellipsoidal height, standard deviation against the \
         difference of the passes, ratio of the integer search, satellites used, phase residuals",
        "From the top: quality; ellipsoidal height with one standard deviation; standard deviation of the \
         position (root of the sum over east, north and up) and the distance between forward and backward \
         pass, which for passes that are independent and equally good is about twice as large; ratio of the \
         second-best to the best set of integers, up to 999.9, with the ratio needed; satellites used; \
         double-difference phase residuals after the update, one colour per satellite (cyclic).",
    );
    Ok(html! {
        section #evidence {
            h2 { "Evidence" }
            h3 { "Over time" }
            (over_time)
            h3 { "Satellites" }
            (tables::satellites(&satellites))
            (tables::events(run))
        }
    })
}
