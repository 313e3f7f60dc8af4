//! Information of linear observations on the pulses' positions and on further parameters.

use nalgebra::{DMatrix, Dyn, Matrix3, OMatrix, U3};

/// One value per axis for the observations and each parameter.
pub(crate) type Axes = OMatrix<f64, U3, Dyn>;

/// Information of one pulse's observations: HᵀR⁻¹H of its position and HᵀR⁻¹[y, A].
#[derive(Clone, Debug)]
pub(crate) struct PulseInformation {
    /// HᵀR⁻¹H, 1/m².
    pub information: Matrix3<f64>,
    /// HᵀR⁻¹[y, A], `[3, 1 + parameters]`.
    pub right: Axes,
}

impl PulseInformation {
    pub fn none(parameters: usize) -> Self {
        Self {
            information: Matrix3::zeros(),
            right: Axes::zeros(1 + parameters),
        }
    }

    /// This information in terms of z, δ = L z.
    pub fn scaled(&self, factor: &Matrix3<f64>) -> Self {
        let t = factor.transpose();
        Self {
            information: t * self.information * factor,
            right: t * &self.right,
        }
    }
}

/// All observations.
#[derive(Clone, Debug)]
pub(crate) struct Observations {
    /// Information of each pulse.
    pub pulses: Vec<PulseInformation>,
    /// [y, A]ᵀR⁻¹[y, A] over all pulses.
    pub cross: DMatrix<f64>,
    /// Prior variance of each parameter.
    pub variance: Vec<f64>,
    /// Number of last parameters whose covariances with the path are computed.
    pub shared: usize,
}
