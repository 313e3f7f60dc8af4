//! Result of a calibration.

use acerra_chain::calibrate::Calibrated;
use acerra_chain::campaign::Campaign;

use super::keys;

/// A campaign's calibration.
#[derive(Clone, Debug)]
pub struct CalibrationOutcome {
    /// The campaign's settings.
    pub campaign: Campaign,
    /// Text found.
    pub calibrated: Calibrated,
    /// Doubts about the calibration.
    pub warnings: Vec<String>,
}

impl CalibrationOutcome {
    /// The keys that the campaign file should have.
    #[must_use]
    pub fn keys(&self) -> Vec<acerra_settings::Assignment> {
        keys::keys(&self.campaign, &self.calibrated)
    }
}
