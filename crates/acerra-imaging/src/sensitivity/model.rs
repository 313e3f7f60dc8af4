//! Stochastic model of position errors.

use crate::checks::{check_finite, check_length};
use crate::error::ImagingError;

/// Gaussian errors of the positions of a flight: a white part, new at every pulse, and a drifting
/// part, a first-order Gauss–Markov process along the flight. Axes are independent.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorModel {
    white_m: Vec<[f64; 3]>,
    drift_m: Vec<[f64; 3]>,
    place: Vec<f64>,
    correlation: f64,
}

impl ErrorModel {
    /// White errors of standard deviation `sigma_m` on each axis at each of `pulses` pulses.
    ///
    /// # Errors
    /// A standard deviation that is negative or not a number.
    pub fn white(sigma_m: f64, pulses: usize) -> Result<Self, ImagingError> {
        let sigma = vec![[sigma_m; 3]; pulses];
        let place = (0..pulses).map(|m| m as f64).collect();
        Self::new(sigma, vec![[0.0; 3]; pulses], place, 1.0)
    }

    /// Drifting errors of standard deviation `sigma_m` on each axis, whose correlation falls to 1/e
    /// over `correlation`, in the unit of `place` (path in metres, or time in seconds, one per
    /// pulse).
    ///
    /// # Errors
    /// As [`ErrorModel::new`].
    pub fn drifting(sigma_m: f64, place: Vec<f64>, correlation: f64) -> Result<Self, ImagingError> {
        let pulses = place.len();
        Self::new(
            vec![[0.0; 3]; pulses],
            vec![[sigma_m; 3]; pulses],
            place,
            correlation,
        )
    }

    /// Standard deviations of both parts for each pulse and axis, as in a `.pos` file.
    ///
    /// # Errors
    /// Lengths that differ, values that are not numbers, negative standard deviations, decreasing places, a
    /// correlation that is not positive.
    pub fn new(
        white_m: Vec<[f64; 3]>,
        drift_m: Vec<[f64; 3]>,
        place: Vec<f64>,
        correlation: f64,
    ) -> Result<Self, ImagingError> {
        check_length("drift_m", white_m.len(), drift_m.len())?;
        check_length("place", white_m.len(), place.len())?;
        check_finite("place", place.iter().copied())?;
        for (what, sigma) in [("white_m", &white_m), ("drift_m", &drift_m)] {
            if let Some(&found) = sigma
                .iter()
                .flatten()
                .find(|s| !(s.is_finite() && **s >= 0.0))
            {
                return Err(ImagingError::OutOfRange {
                    what,
                    expected: "at least 0 m",
                    found,
                });
            }
        }
        if let Some(pair) = place.windows(2).find(|p| p[1] < p[0]) {
            let found = pair[1];
            let expected = "never before its predecessor";
            return Err(ImagingError::OutOfRange {
                what: "place",
                expected,
                found,
            });
        }
        if !(correlation.is_finite() && correlation > 0.0) {
            let (what, expected) = ("correlation", "above 0");
            return Err(ImagingError::OutOfRange {
                what,
                expected,
                found: correlation,
            });
        }
        Ok(Self {
            white_m,
            drift_m,
            place,
            correlation,
        })
    }

    /// Number of pulses.
    #[must_use]
    #[allow(clippy::len_without_is_empty)] // a count, not a collection
    pub fn len(&self) -> usize {
        self.place.len()
    }

    /// Covariance, m², of the errors of pulses `a` and `b` along the unit vectors `ua`, `ub`.
    pub(super) fn covariance_m2(&self, a: usize, b: usize, ua: [f64; 3], ub: [f64; 3]) -> f64 {
        let fading = (-(self.place[a] - self.place[b]).abs() / self.correlation).exp();
        (0..3)
            .map(|i| {
                let drift = self.drift_m[a][i] * self.drift_m[b][i] * fading;
                let white = if a == b {
                    self.white_m[a][i].powi(2)
                } else {
                    0.0
                };
                ua[i] * ub[i] * (drift + white)
            })
            .sum()
    }

    /// One draw of the errors, m; `normal` gives independent standard normal numbers.
    pub(super) fn draw(&self, mut normal: impl FnMut() -> f64) -> Vec<[f64; 3]> {
        let mut state = [0.0; 3];
        (0..self.len())
            .map(|m| {
                let kept = if m == 0 {
                    0.0
                } else {
                    (-(self.place[m] - self.place[m - 1]) / self.correlation).exp()
                };
                let fresh = (1.0 - kept * kept).max(0.0).sqrt();
                [0, 1, 2].map(|i| {
                    state[i] = kept * state[i] + fresh * normal();
                    self.drift_m[m][i] * state[i] + self.white_m[m][i] * normal()
                })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    use super::super::normal::Normal;
    use super::*;

    /// Draws have the covariance that the theory uses.
    #[test]
    fn draws_have_the_stated_covariance() {
        let place = vec![0.0, 0.1, 0.5, 2.0];
        let white = vec![[0.3, 0.0, 0.1]; 4];
        let drift = vec![
            [1.0, 2.0, 0.5],
            [1.0, 2.0, 0.5],
            [0.5, 2.0, 0.5],
            [1.0, 2.0, 0.5],
        ];
        let model = ErrorModel::new(white, drift, place, 0.7).unwrap();
        let unit = [0.6, 0.0, 0.8];
        const DRAWS: u64 = 20_000;
        let mut sum = [[0.0; 4]; 4];
        for trial in 0..DRAWS {
            let mut random = ChaCha8Rng::seed_from_u64(7);
            random.set_stream(trial);
            let mut normal = Normal::new(random);
            let e = model.draw(|| normal.draw());
            let along =
                [0, 1, 2, 3].map(|m: usize| -> f64 { (0..3).map(|i| unit[i] * e[m][i]).sum() });
            for a in 0..4 {
                for b in 0..4 {
                    sum[a][b] += along[a] * along[b] / DRAWS as f64;
                }
            }
        }
        for (a, row) in sum.iter().enumerate() {
            for (b, found) in row.iter().enumerate() {
                let expected = model.covariance_m2(a, b, unit, unit);
                let scale = (model.covariance_m2(a, a, unit, unit)
                    * model.covariance_m2(b, b, unit, unit))
                .sqrt();
                // Standard error of a sample covariance: at most √2 of the scale over √draws.
                let error = scale * (2.0 / DRAWS as f64).sqrt();
                assert!(
                    (found - expected).abs() < 4.0 * error,
                    "{a} {b}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn nonsense_is_refused() {
        assert!(ErrorModel::white(-0.01, 3).is_err());
        assert!(ErrorModel::drifting(f64::NAN, vec![0.0, 1.0], 1.0).is_err());
        assert!(ErrorModel::drifting(0.01, vec![1.0, 0.0], 1.0).is_err());
        assert!(ErrorModel::drifting(0.01, vec![0.0, 1.0], 0.0).is_err());
        assert!(ErrorModel::new(vec![[0.0; 3]; 2], vec![[0.0; 3]; 3], vec![0.0; 2], 1.0).is_err());
    }
}
