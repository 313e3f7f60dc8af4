//! Posterior covariances about a maximum, and prior covariances.

use nalgebra::{Matrix3, Vector3};

use crate::fit::{Fitted, Problem, Seen, Stage};
use crate::model::{Model, Posterior};
use crate::smoother::Smoothed;

impl Problem<'_> {
    /// The maximum `model` with the covariances about it.
    pub fn surroundings(&self, model: Model, seen: &Seen, stage: Stage, guides: &[bool]) -> Fitted {
        let place_sigma_m = self.place_sigmas_m()[0];
        let solved = self
            .linearised(&model, seen, (stage, guides), place_sigma_m)
            .and_then(|(mut rows, found)| {
                rows.widen_by_correlation(&found);
                let widened = self.path.smooth(&rows.observations())?;
                Some((rows, found, widened))
            });
        let points = model.places.len();
        match solved {
            Some((rows, found, widened)) => Fitted {
                place_sigma_m: (0..points)
                    .map(|k| rows.place_sigma_m(&widened.parameter_covariance, k))
                    .collect(),
                residual_m: (0..points).map(|k| rows.phase_rms_m(&found, k)).collect(),
                posterior: self.posterior(&model, &widened),
                model,
            },
            None => Fitted {
                place_sigma_m: vec![[f64::INFINITY; 2]; points],
                residual_m: vec![None; points],
                posterior: Posterior {
                    error_m2: self.prior_m2(),
                    global_sigma: self.globals.iter().map(|g| g.sigma).collect(),
                },
                model,
            },
        }
    }

    /// Prior covariance of each position, movement by globals included, m².
    pub fn prior_m2(&self) -> Vec<Matrix3<f64>> {
        let of = |(m, l): (usize, &Matrix3<f64>)| {
            let own = l * l.transpose();
            self.globals.iter().fold(own, |sum, global| {
                let moved = global.velocity(m, 0.0) * global.sigma;
                sum + moved * moved.transpose()
            })
        };
        self.path.factor.iter().enumerate().map(of).collect()
    }

    /// Posterior covariances: a position is the sum of the path's error and the movement by globals, which
    /// are correlated.
    fn posterior(&self, model: &Model, found: &Smoothed) -> Posterior {
        let count = self.globals.len();
        let first = found.parameter.len() - count;
        let shared = found
            .parameter_covariance
            .view((first, first), (count, count));
        let of = |(m, own): (usize, &Matrix3<f64>)| {
            let each = self.globals.iter().zip(&model.globals);
            let columns: Vec<Vector3<f64>> = each.map(|(g, v)| g.velocity(m, *v)).collect();
            let mut total = *own;
            for (i, a) in columns.iter().enumerate() {
                let crossed = found.with_shared[m].column(i) * a.transpose();
                total += crossed + crossed.transpose();
                for (j, b) in columns.iter().enumerate() {
                    total += a * b.transpose() * shared[(i, j)];
                }
            }
            total
        };
        Posterior {
            error_m2: found.covariance_m2.iter().enumerate().map(of).collect(),
            global_sigma: (0..count).map(|i| shared[(i, i)].max(0.0).sqrt()).collect(),
        }
    }
}
