//! Errors of the positions that change slowly, as those of carrier-phase positions do: a Gauss-Markov process
//! (Ornstein-Uhlenbeck) for each axis of each track, with the deviations that the trajectory states. The
//! values of the process at knots are unknowns of the adjustment, with the process as prior; the common error
//! of a whole track is included.

use super::knots::Knots;

/// Knots in a correlation time: the error of linear interpolation between knots has at most 1/64 of the
/// variance, an eighth of the deviation.
const KNOTS_PER_CORRELATION: f64 = 32.0;
/// Most knots of a track.
const MOST_KNOTS: f64 = 2000.0;

/// The position errors of one track.
#[derive(Clone, Debug)]
pub(super) struct Drift {
    /// First unknown among those of all tracks.
    first: usize,
    start_s: f64,
    step_s: f64,
    /// Standard deviation at each knot: east, north, up (m).
    sigma_m: Vec<[f64; 3]>,
    /// Correlation of neighbouring knots.
    neighbour: f64,
}

/// The share of a knot's error that a trace has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    /// The unknown of the knot's first axis; the two others follow.
    pub unknown: usize,
    /// Weight of it.
    pub weight: f64,
}

impl Drift {
    /// The process over traces at `time_s` (in order) with the deviations `sigma_m`; none where a
    /// trace's deviation is not stated or all are zero.
    pub fn over(
        time_s: &[f64],
        sigma_m: &[Option<[f64; 3]>],
        correlation_s: f64,
        first: usize,
    ) -> Option<Self> {
        let stated: Vec<[f64; 3]> = sigma_m.iter().copied().collect::<Option<_>>()?;
        let (start_s, end_s) = (*time_s.first()?, *time_s.last()?);
        if stated.iter().flatten().all(|s| *s == 0.0) {
            return None;
        }
        let step_s = (correlation_s / KNOTS_PER_CORRELATION).max((end_s - start_s) / MOST_KNOTS);
        let knots = ((end_s - start_s) / step_s).floor() as usize + 2;
        let sigma = |knot: usize| {
            let t = start_s + knot as f64 * step_s;
            let k = time_s.partition_point(|s| *s < t).min(stated.len() - 1);
            // A deviation of zero next to others would fix the process there.
            stated[k].map(|s| s.max(1e-5))
        };
        Some(Self {
            first,
            start_s,
            step_s,
            sigma_m: (0..knots).map(sigma).collect(),
            neighbour: (-step_s / correlation_s).exp(),
        })
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        3 * self.sigma_m.len()
    }

    /// Interpolation weights of a trace at a time within the process.
    pub fn shares(&self, time_s: f64) -> [Share; 2] {
        let at = ((time_s - self.start_s) / self.step_s).max(0.0);
        let knot = (at.floor() as usize).min(self.sigma_m.len() - 2);
        let after = (at - knot as f64).min(1.0);
        let share = |knot: usize, weight| Share {
            unknown: self.first + 3 * knot,
            weight,
        };
        [share(knot, 1.0 - after), share(knot + 1, after)]
    }

    /// Adds the inverse of the process's covariance, which is tridiagonal.
    pub fn add_prior(&self, information: &mut Knots) {
        let r = self.neighbour;
        let scale = 1.0 / (1.0 - r * r);
        let last = self.sigma_m.len() - 1;
        for (knot, sigma) in self.sigma_m.iter().enumerate() {
            let end = knot == 0 || knot == last;
            let own = if end { scale } else { scale * (1.0 + r * r) };
            for (axis, sigma) in sigma.iter().enumerate() {
                let i = self.first + 3 * knot + axis;
                information.add(i, i, own / (sigma * sigma));
                if knot < last {
                    let coupling = -scale * r / (sigma * self.sigma_m[knot + 1][axis]);
                    information.add(i, i + 3, coupling);
                }
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    #[test]
    fn the_prior_is_the_inverse_of_the_process_covariance() {
        let time_s: Vec<f64> = (0..21).map(f64::from).collect();
        let sigma = vec![Some([0.01, 0.02, 0.03]); 21];
        let drift = Drift::over(&time_s, &sigma, 16.0, 0).unwrap();
        let mut information = Knots::new(drift.len() / 3);
        drift.add_prior(&mut information);
        // A column of the covariance: the error up at the first knot, with all others.
        let mut first_up = DVector::zeros(drift.len());
        first_up[2] = 1.0;
        let covariance = information.factorised().solve(&first_up);
        // Knots 0.5 s apart: the error up at the first and at the thirteenth, 6 s later.
        assert!((covariance[2] - 9e-4).abs() < 1e-12);
        let expected = 9e-4 * (-6.0_f64 / 16.0).exp();
        assert!((covariance[38] - expected).abs() < 1e-12);
        let [a, b] = drift.shares(0.75);
        assert_eq!((a.unknown, b.unknown), (3, 6));
        assert!((a.weight - 0.5).abs() < 1e-12 && (b.weight - 0.5).abs() < 1e-12);
    }

    #[test]
    fn positions_without_deviations_have_none() {
        assert!(Drift::over(&[0.0, 1.0], &[None, Some([0.1; 3])], 10.0, 0).is_none());
        assert!(Drift::over(&[0.0, 1.0], &[Some([0.0; 3]); 2], 10.0, 0).is_none());
        assert!(Drift::over(&[], &[], 10.0, 0).is_none());
    }
}
