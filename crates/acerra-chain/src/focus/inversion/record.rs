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
    /// Effective number of parameters, pixels that are not zero, or components.
    pub parameters: f64,
    /// Why the solver stopped.
    pub stop: Stop,
    /// Its iterations: residual ‖d − Lσ‖/‖d‖, and the quantity of the stop rule.
    pub iterations: Vec<Iteration>,
    /// ‖d − Lσ‖/‖d‖ of the image.
    pub residual: f64,
    /// The noise, where the data determine it.
    pub noise: Option<NoiseRecord>,
    /// The method's image of single points at the strongest targets, and the adjoint's.
    pub resolution: Vec<ResolutionRecord>,
    /// Relative error of the operators, forward and adjoint.
    pub operator_accuracy: f64,
}

/// The parameter of a method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ParameterRecord {
    /// What it is.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// How it was chosen.
    pub choice: Chosen,
}

/// How a parameter was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Chosen {
    /// By the campaign, or its default.
    Given,
    /// By the noise measured.
    Noise,
    /// By the L-curve.
    LCurve,
    /// The least that is sensible, where noise is lower or not known.
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
    /// Range cells in front of the first echo that determined it.
    pub cells: usize,
}

/// The images of a unit point by the method and by the adjoint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ResolutionRecord {
    /// Where the point is, m.
    pub point_m: [f64; 3],
    /// By the method; none where its image is empty.
    pub method: Option<PointResponse>,
    /// By the adjoint, normalised to the reflectivity of a point.
    pub adjoint: Option<PointResponse>,
}
