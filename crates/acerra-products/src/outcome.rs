//! Everything that a run found.

use acerra_chain::campaign::Campaign;
use acerra_chain::findings::{Evidence, Unchecked};
use acerra_chain::read::inputs::InputFile;
use acerra_chain::{Focused, Prepared};
use acerra_geo::geodesy::Geodetic;
use acerra_geo::geoid::GeoidGrid;
use acerra_imaging::metrics::Measurement;

use crate::surveyed::SurveyRecord;

/// Everything that a run found, stage by stage.
#[derive(Debug)]
pub struct Outcome {
    /// Name of the campaign, for titles.
    pub name: String,
    /// The campaign, every default filled in.
    pub campaign: Campaign,
    /// The files that were read.
    pub inputs: Vec<InputFile>,
    /// Clean spectra of the tracks at their places.
    pub prepared: Prepared,
    /// The image.
    pub focused: Focused,
    /// The image with the positions as stated, where an autofocus corrected them.
    pub uncorrected: Option<Focused>,
    /// Measurement of the image.
    pub measured: Measurement,
    /// Whether each target exceeds the clutter at its depth below ground; empty above ground.
    pub exceeds_clutter: Vec<bool>,
    /// Heights of the geoid, where a grid is given.
    pub geoid: Option<GeoidGrid>,
    /// Surveyed points, and the target nearest to each.
    pub surveyed: Vec<SurveyRecord>,
    /// Findings of the run on its settings.
    pub evidence: Evidence,
    /// Settings that no data check.
    pub unchecked: Vec<Unchecked>,
    /// Remarks on the result.
    pub warnings: Vec<String>,
    /// Harmless omissions, one sentence each.
    pub notes: Vec<String>,
}

impl Outcome {
    /// Height of a place above the geoid (m), where a grid is given that covers it.
    #[must_use]
    pub fn above_sea_m(&self, place: &Geodetic) -> Option<f64> {
        let geoid = self.geoid.as_ref()?;
        let geoid_m = geoid.height_m(place.latitude_deg(), place.longitude_deg())?;
        Some(place.height_m - geoid_m)
    }

    /// One line on the radar data.
    #[must_use]
    pub fn radar_summary(&self) -> String {
        let first = &self.prepared.first().radar.summary;
        match self.campaign.track.len() {
            0 => first.clone(),
            tracks => format!("{tracks} tracks; the first: {first}"),
        }
    }

    /// The tracks of a campaign that lists tracks; none for a campaign with one flight.
    #[must_use]
    pub fn listed_tracks(&self) -> &[acerra_chain::Track] {
        if self.campaign.track.is_empty() {
            &[]
        } else {
            &self.prepared.tracks
        }
    }
}
