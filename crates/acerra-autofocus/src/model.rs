//! The state of an estimate: points, errors of the path, globals.

use nalgebra::{Matrix3, Vector3};

use crate::ground::{Ground, PixelPlace};

/// What an estimate takes the scene and the flight to be.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    /// Points, as places on the ground.
    pub places: Vec<PixelPlace>,
    /// Errors of the positions, true minus stated, m.
    pub error_m: Vec<Vector3<f64>>,
    /// C⁻¹ times these errors, with C their prior covariance.
    pub force: Vec<Vector3<f64>>,
    /// Range added to all, m.
    pub delay_m: f64,
}

/// Posterior covariances about a model.
#[derive(Clone, Debug)]
pub(crate) struct Posterior {
    /// Of each position's error, m².
    pub error_m2: Vec<Matrix3<f64>>,
}

impl Model {
    /// The flight as stated.
    pub fn nominal(pulses: usize, places: Vec<PixelPlace>) -> Self {
        Self {
            places,
            error_m: vec![Vector3::zeros(); pulses],
            force: vec![Vector3::zeros(); pulses],
            delay_m: 0.0,
        }
    }

    /// The same flight with other points.
    pub fn with_places(&self, places: Vec<PixelPlace>) -> Self {
        Self {
            places,
            ..self.clone()
        }
    }

    /// Positions in force, m.
    pub fn positions_m(&self, nominal_m: &[[f64; 3]]) -> Vec<[f64; 3]> {
        nominal_m
            .iter()
            .zip(&self.error_m)
            .map(|(p, e)| [p[0] + e[0], p[1] + e[1], p[2] + e[2]])
            .collect()
    }

    /// The points, m.
    pub fn points_m(&self, ground: &Ground) -> Vec<Vector3<f64>> {
        self.places.iter().map(|p| ground.point_m(*p)).collect()
    }

    /// Square of the errors in units of the prior: δᵀC⁻¹δ and the delay's.
    pub fn prior_square(&self, delay_sigma_m: f64) -> f64 {
        let path: f64 = self
            .error_m
            .iter()
            .zip(&self.force)
            .map(|(e, f)| e.dot(f))
            .sum();
        let delay = if delay_sigma_m > 0.0 {
            (self.delay_m / delay_sigma_m).powi(2)
        } else {
            0.0
        };
        path.max(0.0) + delay
    }

    /// The model this share of the way from `self` to `other`, which has as many points.
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        let mix = |a: &Vector3<f64>, b: &Vector3<f64>| a + (b - a) * share;
        let mix_all = |a: &[Vector3<f64>], b: &[Vector3<f64>]| {
            a.iter().zip(b).map(|(a, b)| mix(a, b)).collect()
        };
        Self {
            places: self
                .places
                .iter()
                .zip(&other.places)
                .map(|(a, b)| [0, 1].map(|i| a[i] + (b[i] - a[i]) * share))
                .collect(),
            error_m: mix_all(&self.error_m, &other.error_m),
            force: mix_all(&self.force, &other.force),
            delay_m: self.delay_m + (other.delay_m - self.delay_m) * share,
        }
    }
}
