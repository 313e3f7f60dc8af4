//! Aperture and band.

use crate::checks::check_positive;
use crate::error::ImagingError;

/// Height and offset of a straight track over a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aperture {
    /// Height of the flight above the target, m.
    pub height_m: f64,
    /// Horizontal distance of the target from the track, m.
    pub offset_m: f64,
}

/// A band of frequencies and the speed of light used with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Lowest frequency, Hz.
    pub low_hz: f64,
    /// Highest frequency, Hz.
    pub high_hz: f64,
    /// Speed of light, m/s.
    pub light_speed_m_s: f64,
}

impl Band {
    /// Width, Hz.
    pub fn width_hz(&self) -> f64 {
        self.high_hz - self.low_hz
    }

    /// Middle, Hz.
    pub fn centre_hz(&self) -> f64 {
        0.5 * (self.low_hz + self.high_hz)
    }
}

impl Aperture {
    /// A straight level track h above a target d to its side.
    ///
    /// # Errors
    /// A height that is not positive (the target would not be below the drone), a negative offset.
    pub fn new(height_m: f64, offset_m: f64) -> Result<Self, ImagingError> {
        check_positive(
            "height_m",
            "above 0 m (the flight above the target)",
            height_m,
        )?;
        not_negative("offset_m", "at least 0 m", offset_m)?;
        Ok(Self { height_m, offset_m })
    }

    /// Least distance between track and target, m.
    pub fn range_m(&self) -> f64 {
        self.height_m.hypot(self.offset_m)
    }
}

fn not_negative(
    what: &'static str,
    expected: &'static str,
    found: f64,
) -> Result<(), ImagingError> {
    if found.is_finite() && found >= 0.0 {
        Ok(())
    } else {
        Err(ImagingError::OutOfRange {
            what,
            expected,
            found,
        })
    }
}
