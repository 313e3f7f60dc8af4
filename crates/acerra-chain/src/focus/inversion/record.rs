//! Record of an inversion.

use acerra_invert::{Iteration, ParameterChoice, PointResponse, Stop};
use serde::Serialize;

use super::options::Method;

/// Method, convergence and residual of an inversion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InversionRecord {
    /// The method.
    pub method: Method,
    /// Meaning of the pixels.
    pub meaning: &'static str,
    /// The parameter in force.
    pub parameter: ParameterRecord,
    /// Number of effective parameters, of non-zero pixels, or of components.
    pub parameters: f64,
    /// Reason for which the solver stopped.
    pub stop: Stop,
    /// Iterations of the solver: residual ‖d − Lσ‖/‖d‖, and the quantity of the stop rule.
    pub iterations: Vec<Iteration>,
    /// ‖d − Lσ‖/‖d‖ of the image.
    pub residual: f64,
    /// The noise, where the data determine it.
    pub noise: Option<NoiseRecord>,
    /// Images of single points at the strongest targets, by the method and by the adjoint.
    pub resolution: Vec<ResolutionRecord>,
    /// Relative error of the operators, forward and adjoint.
    pub operator_accuracy: f64,
}

/// The parameter of a method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ParameterRecord {
    /// Name of the parameter.
    pub name: &'static str,
    /// Value of the parameter.
    pub value: f64,
    /// Origin of the value.
    pub choice: Chosen,
}

/// Origin of a parameter's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Chosen {
    /// Given by the campaign, or the default.
    Given,
    /// Choice by the measured noise.
    Noise,
    /// Choice by the L-curve.
    LCurve,
    /// The least sensible value, where noise is lower or not known.
    Floor,
}

impl From<ParameterChoice> for Chosen {
    fn from(choice: ParameterChoice) -> Self {
        match choice {
            ParameterChoice::Discrepancy => Self::Noise,
            ParameterChoice::LCurve => Self::LCurve,
            _ => Self::Given,
        }
    }
}

/// The noise of the data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NoiseRecord {
    /// Standard deviation of a spectral value.
    pub sigma: f64,
    /// ‖noise‖/‖d‖: the residual that noise alone would leave.
    pub expected_residual: f64,
    /// Number of range cells before the first echo from which the noise was measured.
    pub cells: usize,
}

/// The images of a unit point by the method and by the adjoint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ResolutionRecord {
    /// Place of the point, m.
    pub point_m: [f64; 3],
    /// Response by the method; `None` where the method's image is empty.
    pub method: Option<PointResponse>,
    /// Response by the adjoint, normalised to the reflectivity of a point.
    pub adjoint: Option<PointResponse>,
}
