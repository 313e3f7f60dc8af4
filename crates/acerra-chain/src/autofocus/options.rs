//! Parameters of an autofocus, and why an autofocus is refused.

use acerra_autofocus::AutofocusError;
use acerra_geo::lever_arm::LeverArmError;
use acerra_imaging::ImagingError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::choices::Sum;
use crate::control::Cancelled;

/// `[autofocus]`: positions are corrected from the echoes of prominent points, where that is
/// significant.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "AutofocusSection")]
pub struct AutofocusOptions {
    /// Whether positions are corrected; also by `acerra focus --autofocus`.
    pub enabled: bool,
    /// Standard deviations of the positions, east, north, up (metres), whose errors are then assumed
    /// independent; by default the covariances that the positions state.
    pub sigma_m: Option<[f64; 3]>,
    /// Correlation time of the errors of the positions, in seconds; by default two sampling intervals of the
    /// positions, at least 0.25 s.
    pub correlation_s: Option<f64>,
    /// Standard deviation of the fast time at which range is zero, in nanoseconds: above 0, the autofocus
    /// estimates the delay. By default the deviation of a delay found from the data, and 0 for a stated
    /// delay.
    pub delay_sigma_ns: Option<f64>,
    /// Standard deviation of each track's clock offset, in seconds: above 0, the autofocus estimates the
    /// offset; likewise for the quantities that follow. By default the deviation of an offset found from the
    /// data or recorded with the radar log, and 0 for a stated offset.
    pub clock_offset_sigma_s: Option<f64>,
    /// Standard deviation of the drift of each track's clock offset, in parts per million.
    pub clock_drift_sigma_ppm: f64,
    /// Standard deviations of each track's lever arm, forward, left, up (metres).
    pub lever_arm_sigma_m: [f64; 3],
    /// Standard deviation of the height of all traces above the scene, in metres: a common error of the
    /// positions' heights or of the scene's height.
    pub height_sigma_m: f64,
    /// Standard deviation of the propagation speed, in metres per second.
    pub light_speed_sigma_m_s: f64,
    /// Standard deviation of each instrument's delay relative to the first track's, in nanoseconds; used with
    /// several tracks only. By default the deviation of delays found from the data, and 0 for stated delays.
    pub track_delay_sigma_ns: Option<f64>,
    /// Standard deviation of each track's phase relative to the first track's, in degrees, 104 for an unknown
    /// phase; used with several tracks summed coherently only.
    pub track_phase_sigma_deg: f64,
    /// Standard deviations of an error that each track's positions have in common, east, north, up (metres).
    /// By default the deviations that float positions state, whose errors are equal for minutes, and 0 for
    /// other positions.
    pub track_shift_sigma_m: Option<[f64; 3]>,
    /// Most points used; 24 by default.
    pub max_points: Option<usize>,
    /// How the tracks are summed, as `[tracks] sum` states: summed by powers, a point has a separate phase in
    /// each track.
    #[serde(skip)]
    pub sum: Sum,
}

/// Reasons for the absence of an autofocus.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AutofocusFailure {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The positions state no deviations.
    #[error(
        "[autofocus] sigma_m: expected standard deviations of the positions, here or in the trajectory, \
         found none"
    )]
    NoDeviations,
    /// A clock or a lever arm is left free, but positions came trace by trace.
    #[error(
        "[autofocus] clock_offset_sigma_s, clock_drift_sigma_ppm, lever_arm_sigma_m: expected a trajectory, \
         found positions that came with the traces, which have neither clock nor lever arm"
    )]
    PlacedByTrace,
    /// The heading of the lever arm is unknown.
    #[error("[autofocus] lever_arm_sigma_m: {0}")]
    LeverArm(LeverArmError),
    /// Data that it refuses.
    #[error("[autofocus]: {0}")]
    Refused(AutofocusError),
}

impl From<AutofocusError> for AutofocusFailure {
    fn from(error: AutofocusError) -> Self {
        match error {
            AutofocusError::Imaging(ImagingError::Cancelled) => Self::Cancelled(Cancelled),
            error => Self::Refused(error),
        }
    }
}
