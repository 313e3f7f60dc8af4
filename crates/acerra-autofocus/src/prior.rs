//! The prior of the positions' errors.

use nalgebra::Matrix3;

use crate::error::AutofocusError;
use crate::globals::Global;

/// Correlation of the error of a position with those of its neighbours.
///
/// Distances are in the unit of [`PositionPrior::abscissa`]: seconds or metres.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Correlation {
    /// Independent errors.
    White,
    /// ρ(d) = e^{−d/ℓ}: a first-order Gauss–Markov process.
    Exponential {
        /// ℓ.
        length: f64,
    },
    /// Matérn of order 3/2, ρ(d) = (1 + a) e^{−a}, a = √3 d/ℓ: continuous velocity.
    Matern32 {
        /// ℓ.
        length: f64,
    },
    /// Matérn of order 5/2, ρ(d) = (1 + a + a²/3) e^{−a}, a = √5 d/ℓ: continuous acceleration.
    Matern52 {
        /// ℓ.
        length: f64,
    },
}

impl Correlation {
    /// Order of the process as a Markov process, 0 for white errors, and its rate 1/length scale.
    pub(crate) fn markov(self) -> (usize, f64) {
        match self {
            Self::White => (0, 0.0),
            Self::Exponential { length } => (1, 1.0 / length),
            Self::Matern32 { length } => (2, 3.0_f64.sqrt() / length),
            Self::Matern52 { length } => (3, 5.0_f64.sqrt() / length),
        }
    }

    /// Correlation of two errors `distance` apart.
    #[must_use]
    pub fn at(self, distance: f64) -> f64 {
        let (order, rate) = self.markov();
        let a = rate * distance.abs();
        match order {
            0 => f64::from(u8::from(distance == 0.0)),
            1 => (-a).exp(),
            2 => (1.0 + a) * (-a).exp(),
            _ => (1.0 + a + a * a / 3.0) * (-a).exp(),
        }
    }

    pub(crate) fn check(self) -> Result<(), AutofocusError> {
        match self {
            Self::White => Ok(()),
            Self::Exponential { length }
            | Self::Matern32 { length }
            | Self::Matern52 { length } => {
                check_positive("correlation length", std::iter::once(length))
            }
        }
    }
}

/// Gaussian prior of the errors of the antenna's positions: zero mean, a covariance at each pulse, and a
/// correlation between pulses.
///
/// The error of pulse m is C_m^½ z_m, with C_m^½ the symmetric root of its covariance and z three independent
/// processes of unit variance: so that the covariance of the errors of two pulses is C_m^½ C_n^½ ρ(d). Where
/// the principal axes are constant, each process acts along one of them.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionPrior {
    /// Covariance of each pulse's error, `[M]`, m², axes as the positions'.
    pub covariance_m2: Vec<[[f64; 3]; 3]>,
    /// Abscissa of each pulse for the correlation, `[M]`, non-decreasing: seconds, or metres of path.
    pub abscissa: Vec<f64>,
    /// Correlation between pulses.
    pub correlation: Correlation,
    /// Unknown quantities of the whole flight; empty by default.
    pub globals: Vec<Global>,
    /// Whether the errors are known to have neither mean nor trend over the abscissa. Otherwise errors that
    /// the echoes do not constrain follow from the others by the correlation.
    pub without_trend: bool,
}

impl PositionPrior {
    /// Independent axes of standard deviations `sigma_m`, `[M]` of `[x, y, z]`, and known globals.
    #[must_use]
    pub fn of_deviations(sigma_m: &[[f64; 3]], abscissa: &[f64], correlation: Correlation) -> Self {
        let diagonal = |s: &[f64; 3]| {
            let mut c = [[0.0; 3]; 3];
            (0..3).for_each(|i| c[i][i] = s[i] * s[i]);
            c
        };
        Self {
            covariance_m2: sigma_m.iter().map(diagonal).collect(),
            abscissa: abscissa.to_vec(),
            correlation,
            globals: Vec::new(),
            without_trend: false,
        }
    }

    /// Full covariances, `[M]`, m², and known globals.
    ///
    /// Covariances written with few digits may not be positive definite. Correlations between axes are
    /// therefore reduced, by one factor a pulse and no further than needed to keep a part in a thousand of an
    /// axis' variance independent of the other axes; the variances are unchanged.
    ///
    /// ```
    /// use acerra_autofocus::{Correlation, PositionPrior};
    /// let rounded = [[4e-6, 0.0, 6.2e-6], [0.0, 4e-6, 0.0], [6.2e-6, 0.0, 9e-6]]; // east, up: 1.03
    /// let white = Correlation::White;
    /// let prior = PositionPrior::of_covariances(&[rounded], &[0.0], white);
    /// let [east, _, up] = prior.covariance_m2[0];
    /// assert_eq!((east[0], up[2]), (4e-6, 9e-6));
    /// assert!((east[2] / 6e-6 - 0.999).abs() < 1e-9);
    /// ```
    #[must_use]
    pub fn of_covariances(
        covariance_m2: &[[[f64; 3]; 3]],
        abscissa: &[f64],
        correlation: Correlation,
    ) -> Self {
        Self {
            covariance_m2: covariance_m2.iter().map(shortened).collect(),
            abscissa: abscissa.to_vec(),
            correlation,
            globals: Vec::new(),
            without_trend: false,
        }
    }

    /// Refuses a prior that does not fit `pulses` pulses.
    pub(crate) fn check(&self, pulses: usize) -> Result<(), AutofocusError> {
        check_length("covariance_m2", pulses, self.covariance_m2.len())?;
        check_length("abscissa", pulses, self.abscissa.len())?;
        self.correlation.check()?;
        let falls = |w: &[f64]| w[1] < w[0] || !w[0].is_finite() || !w[1].is_finite();
        if let Some(index) = self.abscissa.windows(2).position(falls) {
            return Err(AutofocusError::OutOfRange {
                what: "abscissa",
                index: index + 1,
                expected: "a finite value not below the one before",
                found: self.abscissa[index + 1],
            });
        }
        self.globals
            .iter()
            .try_for_each(|global| global.check(pulses))?;
        self.factors().map(|_| ())
    }

    /// Symmetric root L of each covariance, C = L Lᵀ.
    pub(crate) fn factors(&self) -> Result<Vec<Matrix3<f64>>, AutofocusError> {
        self.covariance_m2
            .iter()
            .enumerate()
            .map(|(index, c)| root(c).ok_or_else(|| not_a_covariance(index, c)))
            .collect()
    }
}

/// Symmetric root of a covariance that may be singular; `None` where the matrix is not positive semidefinite.
fn root(c: &[[f64; 3]; 3]) -> Option<Matrix3<f64>> {
    let trace = c[0][0] + c[1][1] + c[2][2];
    let symmetric = Matrix3::from_fn(|i, j| 0.5 * (c[i][j] + c[j][i]));
    if !symmetric.iter().all(|v| v.is_finite()) || (0..3).any(|i| c[i][i] < 0.0) {
        return None;
    }
    if symmetric == Matrix3::from_diagonal(&symmetric.diagonal()) {
        return Some(symmetric.map(f64::sqrt));
    }
    let axes = symmetric.symmetric_eigen();
    let lowest = axes.eigenvalues.min();
    let deviations = axes.eigenvalues.map(|v| v.max(0.0).sqrt());
    (lowest >= -1e-12 * trace).then(|| {
        let spread = Matrix3::from_diagonal(&deviations);
        axes.eigenvectors * spread * axes.eigenvectors.transpose()
    })
}

/// Least eigenvalue of the correlations that [`PositionPrior::of_covariances`] leaves.
const LEAST_INDEPENDENT: f64 = 1e-3;

/// The covariance with its correlations limited to those of a valid covariance, and zero with an axis that
/// has no variance; unchanged where a value is not finite or a variance negative.
fn shortened(c: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let usable = |i: usize| c[i][i] >= 0.0 && c[i].iter().all(|v| v.is_finite());
    if !(0..3).all(usable) {
        return *c;
    }
    let between = |i: usize, j: usize| match c[i][i] > 0.0 && c[j][j] > 0.0 {
        true => 0.5 * (c[i][j] + c[j][i]),
        false => 0.0,
    };
    let correlations = Matrix3::from_fn(|i, j| match i == j {
        true => 1.0,
        false => between(i, j) / (c[i][i] * c[j][j]).sqrt().max(f64::MIN_POSITIVE),
    });
    // The eigenvalues of I + s (R − I) are 1 + s (λ − 1).
    let lowest = correlations.symmetric_eigenvalues().min();
    let share = ((1.0 - LEAST_INDEPENDENT) / (1.0 - lowest).max(f64::MIN_POSITIVE)).min(1.0);
    let of = |i: usize, j: usize| match i == j {
        true => c[i][i],
        false => share * between(i, j),
    };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| of(i, j)))
}

fn not_a_covariance(index: usize, c: &[[f64; 3]; 3]) -> AutofocusError {
    AutofocusError::OutOfRange {
        what: "covariance_m2",
        index,
        expected: "a finite, positive semidefinite matrix",
        found: c[0][0].min(c[1][1]).min(c[2][2]),
    }
}

fn check_length(what: &'static str, expected: usize, found: usize) -> Result<(), AutofocusError> {
    if expected == found {
        Ok(())
    } else {
        Err(AutofocusError::Length {
            what,
            expected,
            found,
        })
    }
}

fn check_positive(
    what: &'static str,
    mut values: impl Iterator<Item = f64>,
) -> Result<(), AutofocusError> {
    match values.find(|v| !(v.is_finite() && *v > 0.0)) {
        None => Ok(()),
        Some(found) => Err(AutofocusError::OutOfRange {
            what,
            index: 0,
            expected: "a finite value above 0",
            found,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn roots_turn_with_the_axes() {
        let turn = Rotation3::from_euler_angles(0.3, -0.7, 1.1);
        let own = Matrix3::from_diagonal(&[4.0, 1.0, 0.0].into());
        let turned = turn * own * turn.inverse();
        let found = root(&[0, 1, 2].map(|i| [0, 1, 2].map(|j| turned[(i, j)]))).unwrap();
        let expected = turn * Matrix3::from_diagonal(&[2.0, 1.0, 0.0].into()) * turn.inverse();
        assert!((found - expected).norm() < 1e-6);
        assert!((found * found - turned).norm() < 1e-12);
    }

    #[test]
    fn what_is_no_covariance_is_refused_or_shortened() {
        let beyond = [[1.0, 0.0, -1.4], [0.0, 1.0, 0.0], [-1.4, 0.0, 1.0]];
        assert!(root(&beyond).is_none());
        let prior = PositionPrior::of_covariances(&[beyond], &[0.0], Correlation::White);
        assert!(prior.check(1).is_ok());
        assert!((prior.covariance_m2[0][0][2] + 0.999).abs() < 1e-12);
        let fine = [[1.0, 0.3, 0.0], [0.3, 2.0, -0.5], [0.0, -0.5, 1.0]];
        let prior = PositionPrior::of_covariances(&[fine], &[0.0], Correlation::White);
        assert_eq!(prior.covariance_m2[0], fine);
        let lost = [[1.0, 0.0, 0.1], [0.0, 1.0, 0.0], [0.1, 0.0, 0.0]];
        let prior = PositionPrior::of_covariances(&[lost], &[0.0], Correlation::White);
        assert_eq!(prior.covariance_m2[0][0], [1.0, 0.0, 0.0]);
        assert!(prior.check(1).is_ok());
        for hostile in [f64::NAN, f64::INFINITY, -1.0] {
            let c = [[hostile, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let prior = PositionPrior::of_covariances(&[c], &[0.0], Correlation::White);
            assert!(prior.check(1).is_err(), "{hostile}");
        }
    }
}
