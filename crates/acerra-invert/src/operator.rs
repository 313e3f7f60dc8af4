//! The linear operator that every solver works on, known by its action alone.

use crate::error::InvertError;
use acerra_imaging::{Complex64, Control};

/// A linear map from scenes (one complex reflectivity a pixel) to data (one complex value a pulse and
/// frequency), and its adjoint under the plain inner products Σ a*b of both spaces.
///
/// Solvers require ⟨Lσ, d⟩ = ⟨σ, L⁺d⟩: an implementation states the accuracy of this identity.
pub trait LinearOperator: Sync {
    /// Number of pixels.
    fn pixels(&self) -> usize;

    /// Number of data.
    fn samples(&self) -> usize;

    /// Computes `data` = L `scene`.
    ///
    /// # Errors
    /// Arrays of other lengths; cancellation, after which `data` is incomplete.
    fn forward(
        &self,
        scene: &[Complex64],
        data: &mut [Complex64],
        control: Control,
    ) -> Result<(), InvertError>;

    /// Computes `scene` = L⁺ `data`.
    ///
    /// # Errors
    /// Arrays of other lengths; cancellation, after which `scene` is incomplete.
    fn adjoint(
        &self,
        data: &[Complex64],
        scene: &mut [Complex64],
        control: Control,
    ) -> Result<(), InvertError>;

    /// Working memory while the operator is applied, excluding its argument and result, bytes.
    fn working_bytes(&self) -> u128 {
        0
    }
}
