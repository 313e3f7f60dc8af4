//! A ray and its lengths in the media.

use crate::vector::range_m;

/// Largest number of layers of a ground.
pub const MAX_LAYERS: usize = 8;

/// A ray from an antenna to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Optical length Σ n ℓ, m: the delay times the speed of light in air.
    pub optical_m: f64,
    /// Length within each layer of ground, m; 0 where the ray stays in air.
    pub soil_m: [f64; MAX_LAYERS],
    /// Unit vector of the ray's direction at the antenna.
    pub departure: [f64; 3],
    /// Gradient of the optical length with respect to the point: the refractive index at the point times the
    /// unit vector of the ray's direction there (Fermat's principle).
    pub gradient: [f64; 3],
    /// One-way amplitude at the point by transmission and spreading, without absorption, 1/m: 1/R in air.
    pub amplitude: f64,
}

impl Ray {
    /// The ray of a homogeneous medium.
    pub(crate) fn straight(antenna_m: [f64; 3], point_m: [f64; 3]) -> Self {
        let range = range_m(antenna_m, point_m);
        let per_m = 1.0 / range.max(f64::MIN_POSITIVE);
        let direction = std::array::from_fn(|axis| (point_m[axis] - antenna_m[axis]) * per_m);
        Self {
            optical_m: range,
            soil_m: [0.0; MAX_LAYERS],
            departure: direction,
            gradient: direction,
            amplitude: 1.0 / range,
        }
    }
}
