//! Draws of the errors of positions.

use std::f64::consts::TAU;

use acerra_autofocus::Correlation;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// A standard normal variable.
pub fn gaussian(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random::<f64>().max(1e-300), rng.random());
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}

/// `count` errors of unit variance, `interval` apart, drawn by the Cholesky factor of their correlation.
pub fn correlated(
    rng: &mut ChaCha8Rng,
    correlation: Correlation,
    (count, interval): (usize, f64),
) -> Vec<f64> {
    let mut factor = vec![vec![0.0; count]; count];
    let white: Vec<f64> = (0..count).map(|_| gaussian(rng)).collect();
    let mut values = Vec::with_capacity(count);
    for i in 0..count {
        for j in 0..=i {
            let done: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let left = correlation.at((i - j) as f64 * interval) - done;
            factor[i][j] = match i == j {
                true => left.max(1e-12).sqrt(),
                false => left / factor[j][j],
            };
        }
        values.push((0..=i).map(|j| factor[i][j] * white[j]).sum());
    }
    values
}
