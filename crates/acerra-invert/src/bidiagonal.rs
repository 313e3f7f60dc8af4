//! Golub–Kahan–Lanczos bidiagonalisation with reorthogonalisation.
//!
//! From u₁ = d/‖d‖ on, L V_k = U_{k+1} B_k and L⁺ U_{k+1} = V_k B_kᵀ + α_{k+1} v_{k+1} e_{k+1}ᵀ with
//! orthonormal U and V and a lower bidiagonal B_k (Golub & Kahan 1965; Paige & Saunders 1982, LSQR).
//! The singular values of B_k converge to the singular values of L that contribute to the data.
//!
//! Every new left vector is orthogonalised against all before it, so that B Bᵀ = U⁺ L L⁺ U holds to rounding
//! (one-sided reorthogonalisation: Simon & Zha 2000, Barlow 2013). Solutions are formed of the left vectors,
//! σ = V Bᵀ z = L⁺ U z − α v z with ‖σ‖ = ‖Bᵀ z‖. Only the last of the right vectors, which have the size of
//! a scene, is kept, at the cost of one more adjoint at the end.

use crate::error::{InvertError, check_length};
use crate::operator::LinearOperator;
use crate::vector::{add_scaled, inner, norm, scale};
use acerra_imaging::{Complex64, Control};

/// Norm of a new basis vector, relative to the matrix, below which the Krylov space is exhausted.
const BREAKDOWN: f64 = 1e-13;

/// A pass that leaves more than this share of a vector needs no second.
const ENOUGH: f64 = 0.7;

/// A bidiagonalisation in progress.
pub struct Bidiagonalization<'o, L: ?Sized> {
    operator: &'o L,
    left: Vec<Vec<Complex64>>,
    right: Vec<Complex64>,
    scratch: Vec<Complex64>,
    data_norm: f64,
    alpha: Vec<f64>,
    beta: Vec<f64>,
    is_exhausted: bool,
}

impl<'o, L: LinearOperator + ?Sized> Bidiagonalization<'o, L> {
    /// Starts from `data`.
    ///
    /// # Errors
    /// A wrong number of data, data that are zero, cancellation.
    pub fn start(
        operator: &'o L,
        data: &[Complex64],
        control: Control,
    ) -> Result<Self, InvertError> {
        check_length("data", operator.samples(), data.len())?;
        let data_norm = norm(data);
        if !(data_norm > 0.0 && data_norm.is_finite()) {
            return Err(InvertError::NoSignal { what: "the data" });
        }
        let first: Vec<Complex64> = data.iter().map(|v| v / data_norm).collect();
        let mut right = vec![Complex64::ZERO; operator.pixels()];
        operator.adjoint(&first, &mut right, control)?;
        let alpha = norm(&right);
        if !(alpha > 0.0 && alpha.is_finite()) {
            return Err(InvertError::NoSignal { what: "the image" });
        }
        scale(&mut right, alpha.recip());
        Ok(Self {
            operator,
            left: vec![first],
            scratch: vec![Complex64::ZERO; operator.pixels()],
            right,
            data_norm,
            alpha: vec![alpha],
            beta: Vec::new(),
            is_exhausted: false,
        })
    }

    /// One step: another left and right vector. False once the Krylov space is exhausted.
    ///
    /// # Errors
    /// Errors of the operator, cancellation.
    pub fn step(&mut self, control: Control) -> Result<bool, InvertError> {
        if self.is_exhausted {
            return Ok(false);
        }
        control.check()?;
        let mut left = vec![Complex64::ZERO; self.operator.samples()];
        self.operator.forward(&self.right, &mut left, control)?;
        self.orthogonalise(&mut left);
        let beta = norm(&left);
        self.beta.push(beta);
        if beta <= BREAKDOWN * self.scale() {
            self.is_exhausted = true;
            self.left.push(vec![Complex64::ZERO; left.len()]);
            self.alpha.push(0.0);
            return Ok(false);
        }
        scale(&mut left, beta.recip());
        self.operator.adjoint(&left, &mut self.scratch, control)?;
        add_scaled(&mut self.scratch, Complex64::new(-beta, 0.0), &self.right);
        self.left.push(left);
        let alpha = norm(&self.scratch);
        self.alpha.push(alpha);
        if alpha <= BREAKDOWN * self.scale() {
            self.is_exhausted = true;
            return Ok(false);
        }
        scale(&mut self.scratch, alpha.recip());
        std::mem::swap(&mut self.scratch, &mut self.right);
        Ok(true)
    }

    /// Removes the part within the basis from `left`: by the recurrence, by a pass over the whole basis, and
    /// by a second pass where the first removed much (Kahan's "twice is enough", Parlett 1998).
    fn orthogonalise(&self, left: &mut [Complex64]) {
        if let (Some(alpha), Some(last)) = (self.alpha.last(), self.left.last()) {
            add_scaled(left, Complex64::new(-alpha, 0.0), last);
        }
        for _ in 0..2 {
            let before = norm(left);
            for basis in self.left.iter().rev() {
                let part = inner(basis, left);
                add_scaled(left, -part, basis);
            }
            if norm(left) > ENOUGH * before {
                break;
            }
        }
    }

    /// Steps done, the order k of B_k.
    #[must_use]
    pub fn order(&self) -> usize {
        self.beta.len()
    }

    /// Whether no further step brings anything.
    #[must_use]
    pub fn is_exhausted(&self) -> bool {
        self.is_exhausted
    }

    /// ‖d‖.
    #[must_use]
    pub fn data_norm(&self) -> f64 {
        self.data_norm
    }

    /// α₁ … α_k, the diagonal of B_k.
    #[must_use]
    pub fn alpha(&self) -> &[f64] {
        &self.alpha[..self.order()]
    }

    /// β₂ … β_{k+1}, its lower diagonal.
    #[must_use]
    pub fn beta(&self) -> &[f64] {
        &self.beta
    }

    /// The left vectors u₁ … u_{k+1}.
    #[must_use]
    pub fn left(&self) -> &[Vec<Complex64>] {
        &self.left
    }

    /// V_k B_kᵀ z, the scene of a solution given by its `coefficients` z over the left vectors:
    /// L⁺ U_{k+1} z less its part along v_{k+1}, which the Krylov space does not hold yet.
    ///
    /// # Errors
    /// Errors of the operator, cancellation.
    pub fn scene_of(
        mut self,
        coefficients: &[f64],
        control: Control,
    ) -> Result<Vec<Complex64>, InvertError> {
        let mut data = vec![Complex64::ZERO; self.operator.samples()];
        for (z, left) in coefficients.iter().zip(&self.left) {
            add_scaled(&mut data, Complex64::new(*z, 0.0), left);
        }
        self.operator.adjoint(&data, &mut self.scratch, control)?;
        let (alpha, z) = (self.alpha.last(), coefficients.get(self.order()));
        if let (Some(alpha), Some(z), false) = (alpha, z, self.is_exhausted) {
            add_scaled(
                &mut self.scratch,
                Complex64::new(-alpha * z, 0.0),
                &self.right,
            );
        }
        Ok(self.scratch)
    }

    /// An estimate of ‖L‖ so far.
    fn scale(&self) -> f64 {
        let entries = self.alpha.iter().chain(&self.beta);
        entries.copied().fold(0.0, f64::max)
    }
}

/// Bytes that `steps` steps on `operator` take, excluding data and result.
#[must_use]
pub fn bidiagonalization_bytes(operator: &(impl LinearOperator + ?Sized), steps: usize) -> u128 {
    const VALUE: u128 = size_of::<Complex64>() as u128;
    let left = operator.samples() as u128 * (steps as u128 + 2) * VALUE;
    left + 2 * operator.pixels() as u128 * VALUE + operator.working_bytes()
}
