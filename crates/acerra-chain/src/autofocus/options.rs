//! Parameters of an autofocus, and why there is none.

use acerra_autofocus::AutofocusError;
use acerra_geo::lever_arm::LeverArmError;
use acerra_imaging::ImagingError;

use crate::choices::Sum;
use crate::control::Cancelled;

/// Parameters of the autofocus.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AutofocusOptions {
    /// Standard deviations of the places, east, north, up (m), whose errors are then independent; by
    /// default the covariances that the positions state.
    pub sigma_m: Option<[f64; 3]>,
    /// How long errors last (s): the length of a Matérn process of order 3/2; by default two sampling
    /// intervals of the positions, at least 0.25 s.
    pub correlation_s: Option<f64>,
    /// Standard deviation of the fast time at which range is zero (ns); by default that of one found from
    /// the data of a single track, and none where it was stated.
    pub delay_sigma_ns: Option<f64>,
    /// Standard deviation of each track's clock offset (s); by default that of one found from the data or
    /// recorded, and none where it was stated.
    pub clock_offset_sigma_s: Option<f64>,
    /// Standard deviation of the drift of that offset (ppm); none by default.
    pub clock_drift_sigma_ppm: f64,
    /// Standard deviations of each track's lever arm, forward, left, up (m); known by default.
    pub lever_arm_sigma_m: [f64; 3],
    /// Standard deviation of the height of all traces above the scene (m), beyond that of the places; known
    /// by default.
    pub height_sigma_m: f64,
    /// Standard deviation of the propagation speed (m/s); known by default.
    pub light_speed_sigma_m_s: f64,
    /// Standard deviation of what each track's instrument delays beside the others' (ns); by default that of
    /// delays found from the data; of one track, none.
    pub track_delay_sigma_ns: Option<f64>,
    /// Standard deviation of each track's phase against the first's (degrees), of tracks summed coherently.
    pub track_phase_sigma_deg: f64,
    /// Standard deviations of an error that each track's positions have in common, east, north, up (m); by
    /// default those that float positions state, and none of others.
    pub track_shift_sigma_m: Option<[f64; 3]>,
    /// How the tracks are summed: by powers, a point has a phase of its own in each.
    pub sum: Sum,
    /// Most points used.
    pub most_points: Option<usize>,
}

/// Why there is no autofocus.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AutofocusFailure {
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Nothing says how good the positions are.
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
    /// Nothing tells where a lever arm points.
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
