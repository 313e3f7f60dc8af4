//! What a calibration found.

use acerra_chain::calibrate::Calibrated;
use acerra_chain::campaign::Campaign;

use super::keys;

/// A campaign's calibration.
#[derive(Clone, Debug)]
pub struct CalibrationOutcome {
    /// What the campaign said.
    pub campaign: Campaign,
    /// Text found.
    pub calibrated: Calibrated,
    /// What is doubtful.
    pub warnings: Vec<String>,
}

impl CalibrationOutcome {
    /// The keys that the campaign file should have.
    #[must_use]
    pub fn keys(&self) -> Vec<acerra_settings::Assignment> {
        keys::keys(&self.campaign, &self.calibrated)
    }
}
