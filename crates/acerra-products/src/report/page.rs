//! The page of one campaign: heading, and the order of the sections.

use super::data::ReportData;
use super::{cuts, findings, html, inversion, provenance, result, track};
use acerra_figure::FigureError;
use maud::html;

/// Writes the report of one focused campaign as a complete HTML page.
///
/// # Errors
/// [`FigureError`] where lists that belong together differ in length.
pub fn report_page(data: &ReportData) -> Result<String, FigureError> {
    let badges = html! {
        (findings::badge(&data.evidence))
        (html::warning_badge(data.warnings.len(), "#warnings"))
    };
    let tracks = track::section(&data.tracks, &data.targets)?;
    let cuts = cuts::section(&data.targets)?;
    let inversion = inversion::section(data.inversion.as_ref())?;
    let radargrams: Vec<_> = data
        .radargram_raw
        .iter()
        .chain(&data.radargram_clean)
        .collect();
    let body = html! {
        (html::heading(&data.title, &data.summary, &data.version, &badges))
        @if let Some(image) = &data.image {
            section #image { (html::picture(image)) }
        }
        (findings::section(&data.evidence, &data.unchecked))
        (html::warnings(&data.warnings, &data.notes))
        (result::section(data))
        (inversion)
        section #measurements {
            h2 { "What it rests on" }
            (tracks)
            @if !radargrams.is_empty() {
                h3 { "Radargrams" }
            }
            @for picture in radargrams.into_iter().chain(&data.pictures) {
                (html::picture(picture))
            }
            (cuts)
        }
        (provenance::section(data))
    };
    Ok(html::document(&data.title, &body))
}
