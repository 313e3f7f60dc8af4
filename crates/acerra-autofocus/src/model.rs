//! The state of an estimate: points, errors of the path, globals.

use nalgebra::{Matrix3, Vector3};

use crate::globals::Global;
use crate::ground::{Ground, PixelPlace};

/// An estimate's model of the scene and the flight.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    /// Points, as places on the ground.
    pub places: Vec<PixelPlace>,
    /// Errors of the positions, true minus stated, m.
    pub error_m: Vec<Vector3<f64>>,
    /// C⁻¹ times the errors, with C their prior covariance.
    pub force: Vec<Vector3<f64>>,
    /// Values of the globals.
    pub globals: Vec<f64>,
}

/// Posterior covariances about a model.
#[derive(Clone, Debug)]
pub(crate) struct Posterior {
    /// Covariance of each position's error, movement by globals included, m².
    pub error_m2: Vec<Matrix3<f64>>,
    /// Standard deviations of the globals.
    pub global_sigma: Vec<f64>,
}

impl Model {
    /// The model of the stated flight, without errors.
    pub fn nominal(pulses: usize, globals: usize, places: Vec<PixelPlace>) -> Self {
        Self {
            places,
            error_m: vec![Vector3::zeros(); pulses],
            force: vec![Vector3::zeros(); pulses],
            globals: vec![0.0; globals],
        }
    }

    /// This model with points at other places.
    pub fn with_places(&self, places: Vec<PixelPlace>) -> Self {
        Self {
            places,
            ..self.clone()
        }
    }

    /// Positions with the errors and globals of the model, m.
    pub fn positions_m(&self, nominal_m: &[[f64; 3]], globals: &[Global]) -> Vec<[f64; 3]> {
        let moved = |(m, (p, e)): (usize, (&[f64; 3], &Vector3<f64>))| {
            let mut at = Vector3::from(*p) + e;
            for (global, value) in globals.iter().zip(&self.globals) {
                at += global.moved_m(m, *value);
            }
            at.into()
        };
        nominal_m
            .iter()
            .zip(&self.error_m)
            .enumerate()
            .map(moved)
            .collect()
    }

    /// The points, m.
    pub fn points_m(&self, ground: &Ground) -> Vec<Vector3<f64>> {
        self.places.iter().map(|p| ground.point_m(*p)).collect()
    }

    /// Square of the errors in units of the prior: δᵀC⁻¹δ and the squares of the globals.
    pub fn prior_square(&self, globals: &[Global]) -> f64 {
        let path: f64 = self
            .error_m
            .iter()
            .zip(&self.force)
            .map(|(e, f)| e.dot(f))
            .sum();
        let own = globals.iter().zip(&self.globals);
        path.max(0.0) + own.map(|(g, v)| (v / g.sigma).powi(2)).sum::<f64>()
    }

    /// The model interpolated from `self` (share 0) to `other` (share 1), which has as many points.
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
            globals: self
                .globals
                .iter()
                .zip(&other.globals)
                .map(|(a, b)| a + (b - a) * share)
                .collect(),
        }
    }
}
