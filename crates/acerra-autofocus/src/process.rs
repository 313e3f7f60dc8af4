//! Errors of positions as a Markov process: three independent axes of unit variance, each with as
//! many derivatives as its correlation has.
//!
//! The state is `[value × 3, first derivative × 3, second derivative × 3]`, derivatives in units of the
//! process's rate; derivatives that a process does not have are zero. Hartikainen and Särkkä 2010 give the
//! Matérn processes in this form.

use nalgebra::{Matrix3, SMatrix};

use crate::prior::Correlation;

/// A matrix over the state.
pub(crate) type StateMatrix = SMatrix<f64, 9, 9>;

/// Covariance of the process at any one pulse.
pub(crate) fn stationary(correlation: Correlation) -> StateMatrix {
    spread(stationary_of_axis(correlation.markov().0))
}

/// Transition Φ over a distance, and the covariance Q of the innovation: P∞ = Φ P∞ Φᵀ + Q.
pub(crate) fn transition(correlation: Correlation, distance: f64) -> (StateMatrix, StateMatrix) {
    let (order, rate) = correlation.markov();
    let own = stationary_of_axis(order);
    let phi = transition_of_axis(order, rate * distance);
    (spread(phi), spread(own - phi * own * phi.transpose()))
}

fn stationary_of_axis(order: usize) -> Matrix3<f64> {
    let third = 1.0 / 3.0;
    match order {
        0 | 1 => Matrix3::from_diagonal(&[1.0, 0.0, 0.0].into()),
        2 => Matrix3::from_diagonal(&[1.0, 1.0, 0.0].into()),
        _ => Matrix3::new(1.0, 0.0, -third, 0.0, third, 0.0, -third, 0.0, 1.0),
    }
}

/// e^{Cu} of the companion matrix C of (s + 1)^order: C + I is nilpotent.
fn transition_of_axis(order: usize, u: f64) -> Matrix3<f64> {
    let decay = (-u).exp();
    match order {
        0 => Matrix3::zeros(),
        1 => Matrix3::from_diagonal(&[decay, 0.0, 0.0].into()),
        2 => decay * Matrix3::new(1.0 + u, u, 0.0, -u, 1.0 - u, 0.0, 0.0, 0.0, 0.0),
        _ => {
            let n = Matrix3::new(1.0, 1.0, 0.0, 0.0, 1.0, 1.0, -1.0, -3.0, -2.0);
            decay * (Matrix3::identity() + n * u + n * n * (0.5 * u * u))
        }
    }
}

/// The matrix of one axis applied to all three: element (3i + a, 3j + a) for each axis a.
fn spread(axis: Matrix3<f64>) -> StateMatrix {
    StateMatrix::from_fn(|r, c| {
        if r % 3 == c % 3 {
            axis[(r / 3, c / 3)]
        } else {
            0.0
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_process_has_the_correlation_it_stands_for() {
        for correlation in [
            Correlation::White,
            Correlation::Exponential { length: 0.7 },
            Correlation::Matern32 { length: 0.7 },
            Correlation::Matern52 { length: 0.7 },
        ] {
            let own = stationary(correlation);
            for distance in [0.05, 0.4, 1.1] {
                let (phi, q) = transition(correlation, distance);
                let cross = phi * own;
                assert!((cross[(1, 1)] - correlation.at(distance)).abs() < 1e-12);
                assert!(cross[(0, 1)].abs() < 1e-15);
                assert!(q.symmetric_eigenvalues().min() > -1e-12);
            }
        }
    }
}
