//! `calibration.json`.

use acerra_chain::calibrate::{EchoResidual, Estimate, Parameter, ReflectorFit};
use serde::Serialize;

use super::outcome::CalibrationOutcome;

/// Result of a calibration, as JSON. Each value is in the unit next to it.
#[derive(Clone, Debug, Serialize)]
pub struct CalibrationRecord {
    /// Version of the program.
    pub version: &'static str,
    /// The unknowns.
    pub estimates: Vec<EstimateRecord>,
    /// Names of the unknowns that were estimated, in the order of `correlation`.
    pub estimated: Vec<String>,
    /// Correlation matrix.
    pub correlation: Vec<Vec<f64>>,
    /// Combinations that the geometry cannot determine.
    pub not_observable: Vec<DirectionRecord>,
    /// Dependence of the estimates on held unknowns.
    pub sensitivity: Vec<SensitivityRecord>,
    /// Fit of the reflectors.
    pub reflectors: Vec<ReflectorRecord>,
    /// Doubts about the calibration.
    pub warnings: Vec<String>,
}

/// Estimate of an unknown.
#[derive(Clone, Debug, Serialize)]
pub struct EstimateRecord {
    /// Name.
    pub name: String,
    /// Unit of the numbers.
    pub unit: &'static str,
    /// The campaign's value.
    pub campaign: f64,
    /// The value found, or the campaign's.
    pub value: f64,
    /// Standard deviation; none where the value is not observable.
    pub sigma: Option<f64>,
    /// Whether the data determine it.
    pub observable: bool,
}

/// A combination that the data do not determine.
#[derive(Clone, Debug, Serialize)]
pub struct DirectionRecord {
    /// Changes of the unknowns along it, for one limit of observation in all.
    pub components: Vec<ComponentRecord>,
    /// Standard deviation along it, in such limits.
    pub sigma: f64,
}

/// Component of a direction along one unknown.
#[derive(Clone, Debug, Serialize)]
pub struct ComponentRecord {
    /// The unknown.
    pub name: String,
    /// Change.
    pub change: f64,
    /// Unit of it.
    pub unit: &'static str,
}

/// Change of an estimate by the value of an unknown that is held.
#[derive(Clone, Debug, Serialize)]
pub struct SensitivityRecord {
    /// The estimate.
    pub of: String,
    /// Quantity held.
    pub to: String,
    /// Change of the one per change of the other.
    pub slope: f64,
    /// Unit of the slope.
    pub unit: String,
}

/// Fit of a reflector.
#[derive(Clone, Debug, Serialize)]
pub struct ReflectorRecord {
    /// Place.
    pub position_m: [f64; 3],
    /// Echoes found.
    pub echoes: usize,
    /// Echoes that took part.
    pub kept: usize,
    /// Root mean square of their residuals.
    pub rms_m: f64,
}

impl CalibrationRecord {
    /// The record of an outcome.
    #[must_use]
    pub fn of(outcome: &CalibrationOutcome) -> Self {
        let found = &outcome.calibrated;
        Self {
            version: env!("CARGO_PKG_VERSION"),
            estimates: found.estimates.iter().map(EstimateRecord::of).collect(),
            estimated: found.free.iter().map(|p| p.name()).collect(),
            correlation: found.correlation.clone(),
            not_observable: found
                .singular
                .iter()
                .map(|direction| DirectionRecord {
                    components: direction.component.iter().map(component).collect(),
                    sigma: direction.sigma,
                })
                .collect(),
            sensitivity: found
                .sensitivity
                .iter()
                .filter(|s| s.slope.is_finite())
                .map(|s| {
                    let (of, per_of) = s.of.unit();
                    let (to, per_to) = s.to.unit();
                    SensitivityRecord {
                        of: s.of.name(),
                        to: s.to.name(),
                        slope: s.slope * per_of / per_to,
                        unit: format!("{of} per {to}"),
                    }
                })
                .collect(),
            reflectors: found.reflectors.iter().map(ReflectorRecord::of).collect(),
            warnings: outcome.warnings.clone(),
        }
    }
}

fn component((parameter, part): &(Parameter, f64)) -> ComponentRecord {
    let (unit, per_si) = parameter.unit();
    ComponentRecord {
        name: parameter.name(),
        change: part * parameter.sigma_limit() * per_si,
        unit,
    }
}

impl EstimateRecord {
    fn of(estimate: &Estimate) -> Self {
        let (unit, per_si) = estimate.parameter.unit();
        Self {
            name: estimate.parameter.name(),
            unit,
            campaign: estimate.campaign * per_si,
            value: estimate.value * per_si,
            sigma: estimate.sigma.map(|s| s * per_si),
            observable: estimate.sigma.is_some(),
        }
    }
}

impl ReflectorRecord {
    fn of(fit: &ReflectorFit) -> Self {
        Self {
            position_m: fit.place_m,
            echoes: fit.echoes,
            kept: fit.kept,
            rms_m: fit.rms_m,
        }
    }
}

/// Residuals of one reflector over time, for a figure: those used in the adjustment.
pub(super) fn series(residuals: &[EchoResidual], reflector: usize) -> (Vec<f64>, Vec<f64>) {
    residuals
        .iter()
        .filter(|r| r.kept && r.reflector == reflector)
        .map(|r| (r.time_s, 1e3 * r.residual_m))
        .unzip()
}
