//! The small problem of a bidiagonalisation: min ‖B_k c − ‖d‖ e₁‖ with filtered singular values.

use crate::error::InvertError;
use nalgebra::DMatrix;

/// How the singular values s of the operator enter a solution: Σ f(s)/s ⟨u, d⟩ v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Filter {
    /// f = 1 from this singular value on, 0 below it: truncated SVD.
    Truncated {
        /// The least singular value kept.
        least: f64,
    },
    /// f = s²/(s² + μ²): Tikhonov.
    Tikhonov {
        /// μ.
        mu: f64,
    },
}

impl Filter {
    /// f(s)/s².
    fn over_power(self, s: f64) -> f64 {
        match self {
            Self::Truncated { least } if s >= least && s > 0.0 => (s * s).recip(),
            Self::Truncated { .. } => 0.0,
            Self::Tikhonov { mu } => (s * s + mu * mu).max(f64::MIN_POSITIVE).recip(),
        }
    }

    /// f(s).
    fn at(self, s: f64) -> f64 {
        s * s * self.over_power(s)
    }
}

/// Singular values and vectors of B_k.
#[derive(Debug, Clone)]
pub struct Projected {
    singular: Vec<f64>,
    /// (k+1) × k, orthonormal columns.
    left: DMatrix<f64>,
    /// k × k, a singular vector a row.
    right: DMatrix<f64>,
    /// ‖d‖ times the first component of each left vector.
    data: Vec<f64>,
    data_power: f64,
}

/// A solution of the small problem.
#[derive(Debug, Clone)]
pub struct SmallSolution {
    /// Coefficients over the right vectors; their norm is the solution's.
    pub right: Vec<f64>,
    /// Coefficients z over the left vectors with σ = V Bᵀ z.
    pub left: Vec<f64>,
    /// ‖σ‖².
    pub power: f64,
    /// ‖d − Lσ‖².
    pub residual_power: f64,
    /// Σ f(s): effective number of parameters.
    pub parameters: f64,
}

impl Projected {
    /// Decomposes B_k with the diagonal `alpha` and the lower diagonal `beta`, both of length k, for
    /// data of the norm `data_norm`.
    ///
    /// # Errors
    /// A decomposition that does not converge.
    pub fn new(alpha: &[f64], beta: &[f64], data_norm: f64) -> Result<Self, InvertError> {
        let order = alpha.len();
        let matrix = DMatrix::from_fn(order + 1, order, |i, j| {
            if i == j {
                alpha[j]
            } else if i == j + 1 {
                beta[j]
            } else {
                0.0
            }
        });
        let found = matrix.try_svd(true, true, f64::EPSILON, 10_000);
        let (singular, left, right) = found
            .and_then(|svd| Some((svd.singular_values, svd.u?, svd.v_t?)))
            .ok_or(InvertError::NoConvergence { order })?;
        Ok(Self {
            data: (0..order).map(|i| data_norm * left[(0, i)]).collect(),
            singular: singular.iter().copied().collect(),
            left,
            right,
            data_power: data_norm * data_norm,
        })
    }

    /// Singular values of B_k, in no order.
    #[must_use]
    pub fn singular(&self) -> &[f64] {
        &self.singular
    }

    /// The greatest of them: ‖L‖ as far as the data excite it.
    #[must_use]
    pub fn greatest(&self) -> f64 {
        self.singular.iter().copied().fold(0.0, f64::max)
    }

    /// The least of them.
    #[must_use]
    pub fn least(&self) -> f64 {
        self.singular.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The solution with filtered singular values.
    #[must_use]
    pub fn solve(&self, filter: Filter) -> SmallSolution {
        let order = self.singular.len();
        let mut solution = SmallSolution {
            right: vec![0.0; order],
            left: vec![0.0; order + 1],
            power: 0.0,
            residual_power: self.residual_power(filter),
            parameters: 0.0,
        };
        for (i, (s, data)) in self.singular.iter().zip(&self.data).enumerate() {
            let z = filter.over_power(*s) * data;
            if z == 0.0 {
                continue;
            }
            let c = s * z;
            solution.parameters += filter.at(*s);
            solution.power += c * c;
            for (j, right) in solution.right.iter_mut().enumerate() {
                *right += c * self.right[(i, j)];
            }
            for (j, left) in solution.left.iter_mut().enumerate() {
                *left += z * self.left[(j, i)];
            }
        }
        solution
    }

    /// ‖d − Lσ‖² of the filtered solution.
    #[must_use]
    pub fn residual_power(&self, filter: Filter) -> f64 {
        let held: f64 = self.data.iter().map(|g| g * g).sum();
        let rest = (self.data_power - held).max(0.0);
        let left = self.singular.iter().zip(&self.data);
        rest + left
            .map(|(s, g)| ((1.0 - filter.at(*s)) * g).powi(2))
            .sum::<f64>()
    }
}
