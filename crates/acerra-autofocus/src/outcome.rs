//! Results of an autofocus.

use serde::Serialize;

/// Whether a correction is applied, and the reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Decision {
    /// The correction is significant: points that were not used for it gained.
    Applied,
    /// The image has no prominent point.
    NoPoints,
    /// The positions' prior variance is zero: no error to correct.
    NothingToCorrect,
    /// Points not used for the correction did not gain significantly.
    NotSignificant,
    /// The image has one prominent point, whose own motion would look like the track's.
    LonePoint,
    /// A point used for the correction is weaker with the correction than without.
    Worsens,
    /// The correction is larger than the prior allows: the echoes do not move as fixed points would.
    AgainstPrior,
}

/// A point used for the correction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PointFound {
    /// `[x, y, z]`, m.
    pub position_m: [f64; 3],
    /// Posterior standard deviations along the image's columns and rows, m.
    pub sigma_m: [f64; 2],
    /// Rms of the point's remaining range errors by phase, m.
    pub residual_m: Option<f64>,
    /// Gain of the point's peak by a correction estimated without the point, dB; by the correction itself
    /// where there are too few points to hold some out.
    pub gain_db: f64,
}

/// A quantity of the whole flight.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GlobalFound {
    /// Name of the quantity.
    pub name: String,
    /// True less stated value, in the unit of the effect.
    pub value: f64,
    /// Posterior standard deviation.
    pub sigma: f64,
    /// Prior standard deviation.
    pub prior_sigma: f64,
}

/// Results of an autofocus.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Autofocused {
    /// Whether [`Autofocused::position_m`] is corrected.
    pub decision: Decision,
    /// Positions to image with, `[M]`, m: corrected, or as stated where no correction is applied.
    pub position_m: Vec<[f64; 3]>,
    /// The estimated errors, true minus stated, `[M]`, m, applied or not; movement by globals included.
    pub correction_m: Vec<[f64; 3]>,
    /// Posterior standard deviations of the errors, `[M]`, m.
    pub sigma_m: Vec<[f64; 3]>,
    /// Posterior covariances of the errors, `[M]`, m².
    pub covariance_m2: Vec<[[f64; 3]; 3]>,
    /// The globals that were left free, in the order of the prior, applied or not.
    pub globals: Vec<GlobalFound>,
    /// The points used.
    pub points: Vec<PointFound>,
    /// Points whose ranges differ from another point's by less than one range resolution rms: one of the two
    /// points is the other's ghost, and a ghost draws the path to the wrong side of the track.
    pub ghosts: usize,
    /// Mean of the points' [`PointFound::gain_db`], weighted by their amplitudes, dB.
    pub gain_db: f64,
    /// Standard error of the mean gain, dB.
    pub gain_sigma_db: f64,
    /// Loss that the prior alone predicts at the points, dB, before any correction.
    pub predicted_loss_db: f64,
    /// Rms of the corrections in units of their prior deviations.
    pub correction_in_sigmas: f64,
    /// Posterior over prior variance along each axis, mean over the pulses: near 1 where the data do not
    /// constrain an axis.
    pub unobserved: [f64; 3],
}
