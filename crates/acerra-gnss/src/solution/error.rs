//! Errors of the positioning of a rover's log.

use acerra_geo::geodesy::geodetic_from_ecef;
use acerra_geo::time::GpsTime;

/// First and last time of a log or of other data.
pub type TimeSpan = (GpsTime, GpsTime);

/// Reason for which there is no solution.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PpkError {
    /// The rover's log has no epochs.
    #[error("the rover's log holds no observation epochs")]
    NoRoverEpochs,
    /// None of the rover's epochs is within the requested time window.
    #[error(
        "no epoch of the rover's log ({} to {}) lies in the requested time window, {} to {}",
        rover.0, rover.1, end_text(*.start), end_text(*.end)
    )]
    NothingInWindow {
        /// Span of the rover's log.
        rover: TimeSpan,
        /// Start of the time window.
        start: Option<GpsTime>,
        /// End of the time window.
        end: Option<GpsTime>,
    },
    /// The base's log is needed and has no epochs.
    #[error("the base's log holds no observation epochs")]
    NoBaseEpochs,
    /// No satellite of the selected systems was observed.
    #[error("the rover observed no satellite of the selected systems")]
    NoSatellites,
    /// No usable ephemeris for any satellite observed.
    #[error(
        "no ephemeris for any satellite observed: observations {} to {}, navigation data {}",
        observations.0, observations.1, span_text(*.navigation)
    )]
    NoNavigation {
        /// Span of the rover's log.
        observations: TimeSpan,
        /// Span of the ephemerides' reference times; `None` when there are none.
        navigation: Option<TimeSpan>,
    },
    /// Rover and base logs share no time.
    #[error(
        "rover and base do not overlap: rover {} to {}, base {} to {}",
        rover.0, rover.1, base.0, base.1
    )]
    NoOverlap {
        /// Span of the rover's log.
        rover: TimeSpan,
        /// Span of the base's log.
        base: TimeSpan,
    },
    /// The required source of the base position contains none.
    #[error("the log does not hold the base position{}", suggestion(*.own_single_ecef_m))]
    BasePositionMissing {
        /// Median of the base's own single-point positions (ECEF, m), as a suggestion.
        own_single_ecef_m: Option<[f64; 3]>,
    },
    /// The base position is impossible.
    #[error(
        "base position {:.3} {:.3} {:.3} (ECEF, m) is impossible{}",
        position_ecef_m[0], position_ecef_m[1], position_ecef_m[2],
        suggestion(*.own_single_ecef_m)
    )]
    BasePositionImplausible {
        /// The position given.
        position_ecef_m: [f64; 3],
        /// The base's own single-point position (ECEF, m), as a suggestion.
        own_single_ecef_m: Option<[f64; 3]>,
    },
    /// The run was cancelled through its [`Control`](crate::Control).
    #[error("cancelled")]
    Cancelled,
    /// An option has a value that makes no sense.
    #[error("option {name}: expected {expected}, found {found}")]
    Option {
        /// Name of the field.
        name: &'static str,
        /// The valid values.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
}

fn span_text(span: Option<TimeSpan>) -> String {
    span.map_or_else(|| "none".to_owned(), |(from, to)| format!("{from} to {to}"))
}

fn end_text(end: Option<GpsTime>) -> String {
    end.map_or_else(|| "any".to_owned(), |time| time.to_string())
}

fn suggestion(own: Option<[f64; 3]>) -> String {
    own.map_or_else(String::new, |own_ecef_m| {
        let place = geodetic_from_ecef(own_ecef_m);
        format!(
            "; the median of its own single-point positions, accurate to metres, is {:.8}°, {:.8}°, {:.2} m \
             (ellipsoidal height)",
            place.latitude_deg(),
            place.longitude_deg(),
            place.height_m
        )
    })
}

impl From<acerra_control::Cancelled> for PpkError {
    fn from(_: acerra_control::Cancelled) -> Self {
        Self::Cancelled
    }
}
