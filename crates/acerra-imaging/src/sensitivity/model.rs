//! How positions may be wrong.

use crate::ImagingError;
use crate::pulses::{check_finite, check_length};

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
    /// A standard deviation that is negative or no number.
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

    /// Standard deviations of both parts for each pulse and axis, as a `.pos` file gives them.
    ///
    /// # Errors
    /// Lengths that differ, values that are no numbers, negative standard deviations, places that
    /// go backwards, a correlation that is not positive.
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
