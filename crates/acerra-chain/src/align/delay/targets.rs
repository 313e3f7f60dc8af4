//! The delay at which the strongest echoes are sharpest, each by itself.

use acerra_imaging::PlaneGrid;

use super::error::DelayError;
use super::scan::DelayScan;
use crate::control::Control;
use crate::echoes::sharpen::{Sharpest, log_fourth_moment, patches, sharpest};

/// Spacing of the delays tried on single targets, and how far about the best (s).
const STEP_S: f64 = 0.05e-9;
pub(super) const REACH_S: f64 = 0.6e-9;

impl DelayScan<'_> {
    /// The delay beyond that of the spectra at which the strongest echoes are sharpest.
    pub(super) fn sharpest_targets(
        &self,
        control: &Control<'_>,
    ) -> Result<Option<Sharpest>, DelayError> {
        let (position_m, speed_m_s) = (self.position_m, self.light_speed_m_s);
        let patches = patches(position_m, self.spectrum, self.grid, speed_m_s)?;
        let steps = (REACH_S / STEP_S).round() as i32;
        let tried_s: Vec<f64> = (-steps..=steps).map(|k| f64::from(k) * STEP_S).collect();
        let mut scores = Vec::new();
        for later_s in &tried_s {
            control.check()?;
            let score = |patch: &PlaneGrid| {
                self.image(*later_s, *patch)
                    .map(|image| log_fourth_moment(&image))
            };
            scores.push(patches.iter().map(score).collect::<Result<Vec<_>, _>>()?);
        }
        Ok(sharpest(&tried_s, &scores))
    }
}
