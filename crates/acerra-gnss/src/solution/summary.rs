//! The result of a run, and its summary.

use super::epoch::{EventPosition, LostEpoch, Solution};
use super::error_correlation::ErrorCorrelation;
use super::glonass::GlonassDecision;
use super::warning::PpkWarning;

/// Counts and remarks about a whole run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PpkSummary {
    /// Rover epochs in the time window.
    pub rover_epochs: usize,
    /// Epochs fixed.
    pub fixed: usize,
    /// Epochs float.
    pub float: usize,
    /// Epochs of other quality.
    pub other: usize,
    /// Reason (see [`key`](crate::NotFixedReason::key)) and number of epochs not fixed for this reason, most
    /// frequent first; epochs without any position included.
    pub not_fixed: Vec<(&'static str, usize)>,
    /// Smallest, mean and largest age of the base's data (s), where any was used.
    pub age_s: Option<[f64; 3]>,
    /// Decision about GLONASS ambiguities, where the options leave it to the run.
    pub glonass: Option<GlonassDecision>,
    /// Distance of the given base position from the base's single-point position (m), where the latter
    /// exists.
    pub base_from_single_m: Option<f64>,
    /// Correlation in time of the positions' errors, where there are enough fixes to measure it.
    pub error_correlation: Option<ErrorCorrelation>,
    /// Remarks.
    pub warnings: Vec<PpkWarning>,
}

/// The result of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct PpkSolution {
    /// Position used for the base antenna (ECEF, m); `None` in single mode and with a moving base.
    pub base_position_ecef_m: Option<[f64; 3]>,
    /// Solutions in ascending time order.
    pub epochs: Vec<Solution>,
    /// Epochs without a position.
    pub lost: Vec<LostEpoch>,
    /// Events with their positions.
    pub events: Vec<EventPosition>,
    /// Counts and remarks.
    pub summary: PpkSummary,
}
