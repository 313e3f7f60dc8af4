//! Column preconditioning: an operator whose pixels are weighted to equal norms.

use crate::error::{InvertError, check_length};
use crate::operator::LinearOperator;
use crate::vector::multiply;
use acerra_imaging::{Complex64, Control};

/// L·D, with a positive diagonal D: the scene is σ = D y.
///
/// With D = 1/‖Lᵢ‖ ([`even_weights`](crate::columns::even_weights)) every column has the norm 1: a unit point
/// has the same peak at every pixel, and a regularisation of ‖y‖ penalises near and far pixels equally,
/// unlike ‖σ‖ under 1/R².
pub struct Weighted<'a, L: ?Sized> {
    operator: &'a L,
    weight: &'a [f32],
}

impl<'a, L: LinearOperator + ?Sized> Weighted<'a, L> {
    /// Weights the pixels of `operator`.
    ///
    /// # Errors
    /// A wrong number of weights, or a weight that is not positive and finite.
    pub fn new(operator: &'a L, weight: &'a [f32]) -> Result<Self, InvertError> {
        check_length("weight", operator.pixels(), weight.len())?;
        if let Some(bad) = weight.iter().find(|w| !(w.is_finite() && **w > 0.0)) {
            return Err(InvertError::OutOfRange {
                what: "weight",
                expected: "above 0",
                found: f64::from(*bad),
            });
        }
        Ok(Self { operator, weight })
    }

    /// From y to the scene σ = D y, in place.
    pub fn scene_from(&self, y: &mut [Complex64]) {
        multiply(y, self.weight);
    }
}

impl<L: LinearOperator + ?Sized> LinearOperator for Weighted<'_, L> {
    fn pixels(&self) -> usize {
        self.operator.pixels()
    }

    fn samples(&self) -> usize {
        self.operator.samples()
    }

    fn forward(
        &self,
        scene: &[Complex64],
        data: &mut [Complex64],
        control: Control,
    ) -> Result<(), InvertError> {
        check_length("scene", self.pixels(), scene.len())?;
        let mut weighted = scene.to_vec();
        multiply(&mut weighted, self.weight);
        self.operator.forward(&weighted, data, control)
    }

    fn adjoint(
        &self,
        data: &[Complex64],
        scene: &mut [Complex64],
        control: Control,
    ) -> Result<(), InvertError> {
        self.operator.adjoint(data, scene, control)?;
        multiply(scene, self.weight);
        Ok(())
    }

    fn working_bytes(&self) -> u128 {
        self.operator.working_bytes() + self.pixels() as u128 * size_of::<Complex64>() as u128
    }
}
