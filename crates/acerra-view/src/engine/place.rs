//! Numbers that a page sends: checked here, before any work is done with them.

use crate::error::RequestError;

/// Farthest place from the frame's origin (m): a campaign's images lie as near.
const FARTHEST_M: f64 = 1e7;

/// The coordinates (m), if each is near a flight.
///
/// # Errors
/// A coordinate that is not a number, or farther than any flight.
pub fn checked_place<const N: usize>(place_m: [f64; N]) -> Result<[f64; N], RequestError> {
    if place_m.iter().all(|v| v.abs() <= FARTHEST_M) {
        return Ok(place_m);
    }
    Err(RequestError::Invalid {
        what: "x_m, y_m, z_m",
        expected: "finite numbers within 1e7 m".to_owned(),
        found: place_m.map(|v| v.to_string()).join(", "),
    })
}

/// The fast time of an echo (ns), where light comes back from so near within it.
///
/// # Errors
/// A coordinate that is not a number, or of a place farther than any flight.
pub fn checked_echo(fast_time_ns: f64) -> Result<f64, RequestError> {
    if (0.15 * fast_time_ns).abs() <= FARTHEST_M {
        return Ok(fast_time_ns);
    }
    Err(RequestError::Invalid {
        what: "fast_time_ns",
        expected: "a finite number within 6e7 ns".to_owned(),
        found: fast_time_ns.to_string(),
    })
}
