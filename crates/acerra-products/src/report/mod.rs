//! The report: one HTML page that lets its reader decide whether to trust the image.
//!
//! [`report_page`] writes the page of one focused campaign from [`ReportData`], plain values that
//! the stages of the chain have found; [`index_page`] writes the page over several campaigns, and
//! [`ppk_page`] that of a positioning run alone. All are complete in themselves: pictures are data
//! URIs, plots inline SVG, there is no script, and a content policy forbids the browser to fetch
//! anything. They follow the reader's light or dark theme, fit a telephone and print well.
//!
//! The order is that of a reader's questions: what does the image show, can it be trusted and what speaks against it,
//! what was found, what it rests on, and how to do it again.
//!
//! ```
//! use acerra_products::report::{Fact, ReportData, report_page};
//!
//! let data = ReportData {
//!     title: "Track 1".to_owned(),
//!     facts: vec![Fact::new("Targets", "2")],
//!     warnings: vec!["12 traces lie in a gap of the trajectory".to_owned()],
//!     ..ReportData::default()
//! };
//! let html = report_page(&data)?;
//! assert!(html.starts_with("<!DOCTYPE html>") && html.contains("12 traces lie"));
//! # Ok::<(), acerra_figure::FigureError>(())
//! ```

mod cuts;
mod data;
mod findings;
pub(crate) mod html;
mod index;
mod inversion;
mod numbers;
mod page;
mod ppk;
mod provenance;
mod result;
mod status;
#[cfg(test)]
mod tests;
mod track;

pub use data::{
    AlignmentEvidence, Cut, CutLevels, EvidenceRow, Fact, GhostRow, Picture, ReportData,
    SurfaceEvidence, TargetRow, TrackEvidence, TrajectoryEvidence, Verdict, Widths,
};
pub use findings::verdict_line;
pub use index::{ComparisonTable, IndexEntry, IndexPage, index_page};
pub use page::report_page;
pub use ppk::{PpkReport, ppk_page};
