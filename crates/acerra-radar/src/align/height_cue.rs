//! Result of the height cue for one echo, and the grid of offsets.

use super::curve::LikelihoodCurve;

/// Likelihood of the offset by the surface echo.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightCue {
    /// Log-likelihood of each offset.
    pub curve: LikelihoodCurve,
    /// Most likely offset by this cue alone, s.
    pub offset_s: f64,
    /// Fast time at which range is zero, s, at the most likely offset: the delay of the echo after 2h/c.
    pub delay_s: f64,
    /// Standard deviation of the delay, s, without the error of the height.
    pub delay_sigma_s: f64,
    /// Standard deviation of the residuals, s.
    pub residual_s: f64,
    /// Share of the picks that do not belong to the surface.
    pub stray_share: f64,
    /// Share of strays among the picks within a second of the surface's picks.
    pub(super) strays_about: f64,
    /// Number of picks used.
    pub picks: usize,
    /// Number of picks that are equivalent to one independent pick.
    pub correlation_length: f64,
    /// Standard deviation of the offset by [stated](crate::align::FlightProfile::with_stated_error_m) errors of the heights
    /// that do not appear in the scatter about the echo, s; not included in the curve.
    pub stated_sigma_s: f64,
    /// Log-likelihood of the most likely offset over an echo that ignores the height, less the logarithm of
    /// the number of independent offsets that agree with motion, and less a prior log-odds of 4.
    pub evidence: f64,
    /// The evidence without lasting errors, for choosing among echoes.
    pub(super) preference: f64,
    /// Median envelope of the surface's picks, in units of the samples.
    pub(super) envelope: f64,
}

/// Offsets tried and delays allowed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    pub start_s: f64,
    pub step_s: f64,
    pub count: usize,
    pub delay_s: [f64; 2],
}
