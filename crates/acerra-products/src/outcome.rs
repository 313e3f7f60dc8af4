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
    /// What it shows.
    pub measured: Measurement,
    /// Heights of the geoid, where a grid is given.
    pub geoid: Option<GeoidGrid>,
    /// Surveyed points beside its targets.
    pub surveyed: Vec<SurveyRecord>,
    /// What the run found of its own settings.
    pub evidence: Evidence,
    /// Settings that nothing in the data checks.
    pub unchecked: Vec<Unchecked>,
    /// What there is to say beside the result.
    pub warnings: Vec<String>,
    /// What was left out without harm, one sentence each.
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

    /// The tracks of a campaign that lists them; none of one that describes its only flight.
    #[must_use]
    pub fn listed_tracks(&self) -> &[acerra_chain::Track] {
        if self.campaign.track.is_empty() {
            &[]
        } else {
            &self.prepared.tracks
        }
    }
}
