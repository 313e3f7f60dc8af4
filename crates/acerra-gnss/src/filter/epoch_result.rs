//! Result of the filter for one epoch.

use crate::ambiguity::fixed_integers::FixedIntegers;
use crate::noise::calibration::{FloatMisfit, Misfit};
use crate::noise::phase_walk::{FixResiduals, NormalisedResidual};
use crate::solution::{NotFixedReason, Quality, SatelliteResidual};
use crate::stations::moving_base::MovedBase;
use acerra_geo::time::GpsTime;
use std::sync::Arc;

/// Result of the filter at an epoch.
#[derive(Debug, Clone)]
pub(crate) struct EpochResult {
    pub tag: GpsTime,
    pub time: GpsTime,
    pub position_ecef_m: [f64; 3],
    pub covariance_ecef_m2: [[f64; 3]; 3],
    pub velocity: Option<([f64; 3], [[f64; 3]; 3])>,
    /// `None`: no relative solution (the position is the single-point one).
    pub quality: Option<Quality>,
    pub satellites: usize,
    pub age_s: f64,
    pub ratio: f64,
    pub reason: Option<NotFixedReason>,
    pub residuals: Arc<Vec<SatelliteResidual>>,
    /// Squared phase residuals of a fix in units of their variance, and their degrees of freedom.
    pub phase_misfit: [f64; 2],
    /// Residuals of the phases at a fix, over the model's standard deviation.
    pub phase_residuals: Vec<NormalisedResidual>,
    /// Residuals of the codes at a fix, over the model's standard deviation.
    pub code_residuals: Vec<NormalisedResidual>,
    /// Distance of the float position from a fix by held integers.
    pub float_misfit: Option<FloatMisfit>,
    /// GLONASS inter-channel bias and standard deviation (m per channel) of a fix with GLONASS,
    /// where it is estimated.
    pub channel_slope_m: Option<[f64; 2]>,
    /// Whether a pass in the other direction fixed at the same place, or with the same integers.
    pub anchored: bool,
    /// The integers of a fix.
    pub integers: Option<Arc<FixedIntegers>>,
    /// Position of a moving base at this time.
    pub base: Option<MovedBase>,
}

impl EpochResult {
    /// Misfit between the epoch's fix and the measurements.
    pub(crate) fn misfit(&self) -> Misfit {
        Misfit {
            time: self.time,
            float: self.float_misfit,
            phase: (self.quality == Some(Quality::Fixed)).then_some(self.phase_misfit),
        }
    }

    /// The phases' residuals of the epoch's fix, if it is fixed.
    pub(crate) fn fix_residuals(&self) -> Option<FixResiduals<'_>> {
        (self.quality == Some(Quality::Fixed)).then_some(FixResiduals {
            time: self.time,
            residuals: &self.phase_residuals,
        })
    }

    /// The codes' residuals of the epoch's fix, if it is fixed.
    pub(crate) fn fix_codes(&self) -> Option<FixResiduals<'_>> {
        (self.quality == Some(Quality::Fixed)).then_some(FixResiduals {
            time: self.time,
            residuals: &self.code_residuals,
        })
    }

    /// Distance to another place (m).
    pub(crate) fn distance_m(&self, other: &Self) -> f64 {
        let (a, b) = (self.position_ecef_m, other.position_ecef_m);
        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
    }

    /// Moves to the mean of this place and another, of which one is wrong. The covariance reflects this: half
    /// the distance between the places is a standard deviation.
    pub(crate) fn widen_to(&mut self, other: &Self) {
        let (a, b) = (self.position_ecef_m, other.position_ecef_m);
        let half: [f64; 3] = std::array::from_fn(|k| (a[k] - b[k]) / 2.0);
        self.position_ecef_m = std::array::from_fn(|k| (a[k] + b[k]) / 2.0);
        self.covariance_ecef_m2 = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let own = (self.covariance_ecef_m2[i][j] + other.covariance_ecef_m2[i][j]) / 2.0;
                own + half[i] * half[j]
            })
        });
    }
}
