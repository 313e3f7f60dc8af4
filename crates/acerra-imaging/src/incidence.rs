//! Weighting by incidence angle and antenna pattern.

use crate::error::ImagingError;
use std::f64::consts::{FRAC_PI_2, PI};

/// A weight by the angle θ from the vertical at which an antenna sees a pixel: a down-looking antenna's
/// pattern cosⁿ θ, and a limit of incidence with a soft edge.
///
/// Antennas that look down from a level flight see pixels of a level plane at an incidence equal to θ, and
/// the weight of a pulse is a function of range. This weight costs no time during imaging. Where pulses have
/// boresights ([`Pulses::with_boresight`](crate::Pulses::with_boresight)), the pattern's angle counts from
/// the boresights and the limit from the vertical.
///
/// ```
/// use acerra_imaging::IncidenceWeight;
/// let weight = IncidenceWeight { max_rad: 1.0, taper_rad: 0.2, cosine_power: 2.0 };
/// assert_eq!(weight.at(0.0), 1.0);
/// assert!((weight.at(0.6) - 0.6f64.cos().powi(2)).abs() < 1e-12);
/// assert!((weight.at(0.9) - 0.5 * 0.9f64.cos().powi(2)).abs() < 1e-12); // half way down the edge
/// assert_eq!(weight.at(1.1), 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IncidenceWeight {
    /// Greatest incidence, from which on the weight is 0, rad; π/2 for no limit.
    pub max_rad: f64,
    /// Width of the raised-cosine edge below the greatest incidence, rad.
    pub taper_rad: f64,
    /// The power n of cos θ: 0 for a weight of 1 inside the limit.
    pub cosine_power: f64,
}

impl Default for IncidenceWeight {
    /// No limit, no pattern, an edge of 5°.
    fn default() -> Self {
        Self {
            max_rad: FRAC_PI_2,
            taper_rad: 5f64.to_radians(),
            cosine_power: 0.0,
        }
    }
}

impl IncidenceWeight {
    /// The weight at `angle_rad` from the vertical.
    #[must_use]
    pub fn at(&self, angle_rad: f64) -> f64 {
        self.pattern(angle_rad.cos()) * self.edge(angle_rad)
    }

    /// The antenna's pattern at the cosine of an angle from its boresight.
    #[must_use]
    pub fn pattern(&self, cosine: f64) -> f64 {
        if self.cosine_power == 0.0 {
            1.0
        } else {
            cosine.max(0.0).powf(self.cosine_power)
        }
    }

    /// The soft edge of the limit at `angle_rad` from the vertical.
    #[must_use]
    pub fn edge(&self, angle_rad: f64) -> f64 {
        if self.max_rad >= FRAC_PI_2 || angle_rad <= self.max_rad - self.taper_rad {
            1.0
        } else if angle_rad >= self.max_rad {
            0.0
        } else {
            0.5 + 0.5 * (PI * (angle_rad - self.max_rad + self.taper_rad) / self.taper_rad).cos()
        }
    }

    /// This weight, if its angles are valid.
    pub(crate) fn checked(self) -> Result<Self, ImagingError> {
        let refuse = |what, expected, found| {
            Err(ImagingError::OutOfRange {
                what,
                expected,
                found,
            })
        };
        if !(self.max_rad > 0.0 && self.max_rad <= FRAC_PI_2) {
            return refuse("max_rad", "above 0 and at most π/2", self.max_rad);
        }
        if !(self.taper_rad > 0.0 && self.taper_rad.is_finite()) {
            return refuse("taper_rad", "above 0", self.taper_rad);
        }
        if !(0.0..=100.0).contains(&self.cosine_power) {
            return refuse("cosine_power", "from 0 to 100", self.cosine_power);
        }
        Ok(self)
    }
}
