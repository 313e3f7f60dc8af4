//! The delay at which the strongest echoes are sharpest, each on a separate patch.

use acerra_imaging::{PlaneGrid, TrialImages};
use rayon::prelude::*;

use super::error::DelayError;
use super::scan::DelayScan;
use crate::control::Control;
use crate::echoes::sharpen::{Sharpest, log_fourth_moment, patches, sharpest};

/// Spacing of the delays tried on single targets, and their range about the best (s).
const STEP_S: f64 = 0.05e-9;
pub(super) const REACH_S: f64 = 0.6e-9;

impl DelayScan<'_> {
    /// The delay, relative to the delay of the spectra, at which the strongest echoes are sharpest.
    pub(super) fn sharpest_targets(
        &self,
        control: &Control<'_>,
    ) -> Result<Option<Sharpest>, DelayError> {
        let (position_m, speed_m_s) = (self.position_m, self.light_speed_m_s);
        let patches = patches(position_m, self.spectrum, self.grid, speed_m_s)?;
        let steps = (REACH_S / STEP_S).round() as i32;
        let tried_s: Vec<f64> = (-steps..=steps).map(|k| f64::from(k) * STEP_S).collect();
        let searched = self.searched();
        let looks: Vec<TrialImages> = (patches.iter())
            .map(|patch| searched.looks(*patch, self.reach_m(REACH_S)))
            .collect::<Result<_, _>>()?;
        let scores_at = |later_s: &f64| {
            control.check()?;
            let score = |(patch, looks): (&PlaneGrid, &TrialImages)| {
                let image = self.tabulated_image(looks, *later_s, *patch)?;
                Ok::<_, DelayError>(log_fourth_moment(&image))
            };
            patches
                .iter()
                .zip(&looks)
                .map(score)
                .collect::<Result<Vec<f64>, DelayError>>()
        };
        let scores: Vec<Vec<f64>> = tried_s
            .par_iter()
            .map(scores_at)
            .collect::<Result<_, DelayError>>()?;
        Ok(sharpest(&tried_s, &scores))
    }
}
