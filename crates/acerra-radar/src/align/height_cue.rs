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
    /// Number of picks used.
    pub picks: usize,
    /// Number of picks that are equivalent to one independent pick.
    pub correlation_length: f64,
    /// Standard deviation of the offset by [stated](crate::align::FlightProfile::with_stated_error_m) errors of the heights
    /// that do not appear in the scatter about the echo, s; not included in the curve.
    pub stated_sigma_s: f64,
    /// Log-likelihood of the most likely offset over an echo that ignores the height, or over picks by chance, the
    /// smaller, less the logarithm of the number of independent offsets that agree with motion, and less a prior
    /// log-odds of 4.
    pub evidence: f64,
    /// Log-likelihood over an echo that ignores the height, for choosing among ridges.
    pub(super) preference: f64,
    /// Log-likelihood of the picks over an echo that ignores the height, or over picks by chance, the smaller, as if
    /// all picks were independent: echoes of the same traces are compared by it.
    pub(super) explained: f64,
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

impl Grid {
    /// Offset of an index, s.
    pub fn offset_s(self, index: usize) -> f64 {
        self.start_s + index as f64 * self.step_s
    }

    /// Every `stride`-th offset; the last one lies at the end of the grid or beyond it.
    pub fn every(self, stride: usize) -> Self {
        Self {
            step_s: stride as f64 * self.step_s,
            count: (self.count + stride - 1).div_ceil(stride),
            ..self
        }
    }
}

/// Difference of the offsets, s, and of the delays, s, below which two cues follow one echo.
const SAME_OFFSET_S: f64 = 0.02;
const SAME_DELAY_S: f64 = 0.3e-9;

impl HeightCue {
    /// Whether two cues follow one echo at one offset.
    pub(super) fn is_same_echo(&self, other: &Self) -> bool {
        (self.offset_s - other.offset_s).abs() <= SAME_OFFSET_S
            && (self.delay_s - other.delay_s).abs() <= SAME_DELAY_S
    }
}
