//! Calibration of a campaign's instrument: run, keys for the campaign file, record, report page.

mod keys;
mod outcome;
mod page;
mod record;

use std::path::{Path, PathBuf};

use acerra_chain::calibrate::{
    AtRest, CalibrateError, CalibrateOptions, RestDelay, calibrate, delay_at_rest,
};
use acerra_chain::campaign::Campaign;
use acerra_chain::read::{RadarContent, read_radar};
use acerra_chain::{Control, Journal};
use acerra_settings::assign;
use anyhow::Context;

use crate::staging::Staging;

pub use keys::keys_at_rest;
pub use outcome::CalibrationOutcome;
pub use record::CalibrationRecord;

/// A campaign file as it was read.
#[derive(Clone, Debug)]
pub struct CampaignFile {
    /// Path.
    pub path: PathBuf,
    /// Text.
    text: String,
    /// Content, with paths resolved.
    pub campaign: Campaign,
}

impl CampaignFile {
    /// Reads a campaign file.
    ///
    /// # Errors
    /// An unreadable file or an invalid campaign, with its name and the place.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let at = || path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(at)?;
        let campaign = Campaign::parse(&text).with_context(at)?;
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        Ok(Self {
            path: path.to_owned(),
            campaign: campaign.resolved_in(folder),
            text,
        })
    }

    /// Calibrates on reflectors at places that are known to `survey_sigma_m`.
    ///
    /// # Errors
    /// Logs that cannot be read, or do not show the reflectors.
    pub fn calibrate(
        &self,
        reflector_m: Vec<[f64; 3]>,
        survey_sigma_m: f64,
        journal: &mut Journal,
        control: &Control<'_>,
    ) -> anyhow::Result<CalibrationOutcome> {
        let mut survey = self.campaign.survey();
        let arms: Vec<[f64; 3]> = survey
            .tracks
            .iter()
            .map(|t| t.positions.lever_arm_m)
            .collect();
        let lever_arm_m = arms.first().copied().unwrap_or_default();
        if arms.iter().any(|arm| *arm != lever_arm_m) {
            anyhow::bail!(
                "{}: [trajectory] lever_arm_m: expected the same in all tracks, found {arms:?}",
                self.path.display()
            );
        }
        // The calibration applies the lever arm itself.
        for track in &mut survey.tracks {
            track.positions.lever_arm_m = [0.0; 3];
        }
        let (recordings, scene) = survey.recordings(journal, control)?;
        let options = CalibrateOptions {
            survey_sigma_m,
            lever_arm_m,
            delay_s: self.delay_ns() * 1e-9,
            band_hz: self.campaign.image.band_ghz.map(|f| f * 1e9),
            ..CalibrateOptions::on(reflector_m)
        };
        let calibrated = journal
            .stage("calibrate", |warnings| {
                calibrate(&recordings, &scene, &options, warnings, control)
            })
            .with_context(|| self.path.display().to_string())?;
        Ok(CalibrationOutcome {
            campaign: self.campaign.clone(),
            calibrated,
            warnings: journal.warnings.said().to_vec(),
        })
    }

    /// Finds the delay from a log at rest before a reflector at a measured range.
    ///
    /// # Errors
    /// A log that cannot be read, or shows no echo at that range.
    pub fn delay_at_rest(
        &self,
        range_m: f64,
        range_sigma_m: f64,
        journal: &mut Journal,
    ) -> anyhow::Result<RestDelay> {
        let one = self.campaign.each_track().remove(0);
        let file = &one.radar.file;
        let radar = journal.stage("read", |warnings| read_radar(file, warnings))?;
        let RadarContent::Radargram(radargram) = radar.content else {
            let track = "1".to_owned();
            return Err(CalibrateError::Spectra { track }.into());
        };
        let rest = AtRest {
            range_m,
            range_sigma_m,
            light_speed_m_s: one.image.light_speed_m_s,
            band_hz: one.image.band_ghz.map(|f| f * 1e9),
        };
        let found = delay_at_rest(&radargram, &rest).with_context(|| file.display().to_string())?;
        if !found.coupling_seen {
            journal.warnings.add(
                "no direct coupling of the antennas is seen where this delay puts it: the echo may \
                 be another one's, or the antennas are well isolated",
            );
        }
        Ok(found)
    }

    /// The file's text with keys changed, its comments kept.
    ///
    /// # Errors
    /// A place in the file that should be a table and is none, or values that make no campaign.
    pub fn with_keys(&self, keys: &[acerra_settings::Assignment]) -> anyhow::Result<String> {
        let at = || self.path.display().to_string();
        let text = assign(&self.text, keys).with_context(at)?;
        // The written file must be readable.
        Campaign::parse(&text).with_context(at)?;
        Ok(text)
    }

    /// Replaces the file by one with these keys, at once.
    ///
    /// # Errors
    /// As [`Self::with_keys`], or a file that cannot be written.
    pub fn write_keys(&self, keys: &[acerra_settings::Assignment]) -> anyhow::Result<()> {
        use std::io::Write;
        let at = || format!("{}: cannot write", self.path.display());
        let text = self.with_keys(keys)?;
        let folder = match self.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let permissions = std::fs::metadata(&self.path)
            .with_context(at)?
            .permissions();
        let mut aside = tempfile::Builder::new()
            .prefix(".acerra-")
            .tempfile_in(folder)
            .with_context(at)?;
        aside.write_all(text.as_bytes()).with_context(at)?;
        aside
            .as_file()
            .set_permissions(permissions)
            .with_context(at)?;
        aside.persist(&self.path).with_context(at)?;
        Ok(())
    }

    fn delay_ns(&self) -> f64 {
        let first = self.campaign.each_track().into_iter().next();
        first
            .and_then(|one| one.radar.delay_ns?.given_ns())
            .unwrap_or(0.0)
    }
}

impl CalibrationOutcome {
    /// Writes `calibration.json` and `report.html` into a directory.
    ///
    /// # Errors
    /// A directory that cannot be written.
    pub fn deliver(&self, name: &str, directory: &Path) -> anyhow::Result<()> {
        let staging = Staging::new(directory)?;
        let record = CalibrationRecord::of(self);
        staging.write("calibration.json", serde_json::to_vec_pretty(&record)?)?;
        staging.write("report.html", page::page(name, self)?)?;
        staging.publish()
    }
}
