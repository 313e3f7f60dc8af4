//! Result of a calibration, with its uncertainty.

use nalgebra::DMatrix;

use super::adjust::{Adjusted, invert, select};
use super::observe::{SingularDirection, singular_directions};
use super::parameter::{Parameter, Values};
use super::rounds::{Round, Survey};
use crate::journal::warnings::Warnings;

/// Result of a calibration.
#[derive(Clone, Debug)]
pub struct Calibrated {
    /// The values of all unknowns, those held included.
    pub values: Values,
    /// All unknowns, one by one.
    pub estimates: Vec<Estimate>,
    /// The unknowns estimated, in the order of `correlation`.
    pub free: Vec<Parameter>,
    /// Correlation matrix, row by row.
    pub correlation: Vec<Vec<f64>>,
    /// Covariance matrix, row by row (SI units), enlarged as the deviations are.
    pub covariance: Vec<Vec<f64>>,
    /// Combinations that the geometry does not determine.
    pub singular: Vec<SingularDirection>,
    /// Dependence of the estimates on held unknowns.
    pub sensitivity: Vec<Sensitivity>,
    /// Fit of each reflector.
    pub reflectors: Vec<ReflectorFit>,
    /// Residuals of all echoes.
    pub residuals: Vec<EchoResidual>,
}

/// Estimate of an unknown.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// The unknown.
    pub parameter: Parameter,
    /// The campaign's value (SI units).
    pub campaign: f64,
    /// The value found, or the campaign's where it is not observable (SI units). For a delay that the ranges
    /// do not determine, and the clock offsets: the value at which the reflectors are in focus.
    pub value: f64,
    /// Standard deviation, given the values held (SI units), enlarged where the echoes contradict a value held; none
    /// where the value is not observable.
    pub sigma: Option<f64>,
    /// For a held unknown: its estimate relative to the held value, and the deviation of the estimate (SI
    /// units).
    pub wanted: Option<(f64, f64)>,
}

/// Change of an estimate by the value of an unknown that is held.
#[derive(Clone, Copy, Debug)]
pub struct Sensitivity {
    /// The estimate.
    pub of: Parameter,
    /// Quantity held.
    pub to: Parameter,
    /// Change of the one per change of the other (SI units).
    pub slope: f64,
}

/// Fit of a reflector.
#[derive(Clone, Copy, Debug)]
pub struct ReflectorFit {
    /// Place (m).
    pub place_m: [f64; 3],
    /// Echoes found.
    pub echoes: usize,
    /// Echoes that took part; the others are outliers.
    pub kept: usize,
    /// Root mean square of the residuals that took part (m).
    pub rms_m: f64,
}

/// The residual of an echo.
#[derive(Clone, Copy, Debug)]
pub struct EchoResidual {
    /// Number of the track, from 0.
    pub track: usize,
    /// Number of the reflector, from 0.
    pub reflector: usize,
    /// Radar time (s).
    pub time_s: f64,
    /// Observed less adjusted range (m).
    pub residual_m: f64,
    /// Standard deviation (m).
    pub sigma_m: f64,
    /// Whether it took part.
    pub kept: bool,
}

impl Calibrated {
    pub(super) fn of(survey: &Survey<'_>, round: Round) -> Self {
        let Round {
            echoes, adjusted, ..
        } = round;
        let residuals: Vec<EchoResidual> = echoes
            .iter()
            .enumerate()
            .map(|(k, echo)| EchoResidual {
                track: echo.track,
                reflector: echo.reflector,
                time_s: echo.time_s,
                residual_m: adjusted.residual_m[k],
                sigma_m: adjusted.sigma_m[k],
                kept: adjusted.kept[k],
            })
            .collect();
        let parameters = survey.campaign.parameters();
        let mut estimates = estimates(&adjusted, survey.campaign);
        let enlarged = contradiction(&estimates);
        let own = |estimate: &mut Estimate| estimate.sigma = estimate.sigma.map(|s| enlarged * s);
        estimates.iter_mut().for_each(own);
        Self {
            estimates,
            correlation: rows(&correlation(&adjusted.covariance)),
            covariance: rows(&(&adjusted.covariance * enlarged.powi(2))),
            singular: singular_directions(&adjusted.normal.information, &parameters),
            sensitivity: sensitivities(&adjusted, &parameters),
            reflectors: survey
                .setting
                .reflector_m
                .iter()
                .enumerate()
                .map(|(k, place_m)| ReflectorFit::of(*place_m, k, &residuals))
                .collect(),
            residuals,
            free: adjusted.free,
            values: adjusted.values,
        }
    }

    /// The estimate of an unknown.
    #[must_use]
    pub fn estimate(&self, parameter: Parameter) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.parameter == parameter)
    }

    /// Reasons to doubt the result.
    pub(super) fn doubts(&self, warnings: &mut Warnings) {
        for estimate in &self.estimates {
            let (unit, per_si) = estimate.parameter.unit();
            if let Some((shift, sigma)) = estimate.wanted
                && shift.abs() > CONTRADICTS * sigma
            {
                warnings.add(format!(
                    "{} is kept at {:.4} {unit}, but the echoes prefer {:.4} ± {:.4}: the deviations of all values \
                     are enlarged by that",
                    estimate.parameter.name(),
                    estimate.value * per_si,
                    (estimate.value + shift) * per_si,
                    sigma * per_si
                ));
            }
        }
        for (k, reflector) in self.reflectors.iter().enumerate() {
            let place = reflector.place_m;
            if reflector.echoes == 0 {
                warnings.add(format!(
                    "reflector {} at {place:?} m shows no echo where it is expected",
                    k + 1
                ));
            } else if 2 * reflector.kept < reflector.echoes {
                warnings.add(format!(
                    "reflector {} at {place:?} m: {} of {} echoes are outliers",
                    k + 1,
                    reflector.echoes - reflector.kept,
                    reflector.echoes
                ));
            }
        }
    }
}

impl ReflectorFit {
    fn of(place_m: [f64; 3], number: usize, residuals: &[EchoResidual]) -> Self {
        let own = residuals.iter().filter(|r| r.reflector == number);
        let kept: Vec<f64> = own
            .clone()
            .filter(|r| r.kept)
            .map(|r| r.residual_m)
            .collect();
        let squares: f64 = kept.iter().map(|r| r * r).sum();
        Self {
            place_m,
            echoes: own.count(),
            kept: kept.len(),
            rms_m: (squares / (kept.len() as f64).max(1.0)).sqrt(),
        }
    }
}

/// Deviations between a held value and what the echoes prefer from which they contradict: of a few held values by
/// chance in one calibration of a hundred.
const CONTRADICTS: f64 = 3.0;

/// Factor on all deviations: echoes that contradict a held value by so many deviations have errors that their scatter
/// does not show, or the held value is wrong.
fn contradiction(estimates: &[Estimate]) -> f64 {
    let wanted = estimates.iter().filter_map(|estimate| estimate.wanted);
    let deviations = wanted.map(|(shift, sigma)| shift.abs() / sigma);
    let greatest = deviations.fold(0.0, f64::max);
    if greatest > CONTRADICTS {
        greatest
    } else {
        1.0
    }
}

fn estimates(adjusted: &Adjusted, campaign: &Values) -> Vec<Estimate> {
    let parameters = campaign.parameters();
    let index = |p: &Parameter| parameters.iter().position(|q| q == p);
    let free: Vec<usize> = adjusted.free.iter().filter_map(index).collect();
    parameters
        .iter()
        .enumerate()
        .map(|(i, parameter)| {
            let place = adjusted.free.iter().position(|p| p == parameter);
            let sigma = place.map(|k| adjusted.covariance[(k, k)].sqrt());
            let wanted = adjusted.normal.wanted(i, &free);
            let is_finite = wanted.0.is_finite() && wanted.1.is_finite();
            Estimate {
                parameter: *parameter,
                campaign: campaign.get(*parameter),
                value: adjusted.values.get(*parameter),
                sigma,
                wanted: (place.is_none() && is_finite).then_some(wanted),
            }
        })
        .collect()
}

fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let sigma = |i: usize| covariance[(i, i)].sqrt();
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        covariance[(i, j)] / (sigma(i) * sigma(j))
    })
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix
        .row_iter()
        .map(|row| row.iter().copied().collect())
        .collect()
}

/// −S_ff⁻¹·S_fh: dependence of the estimates on the held unknowns.
fn sensitivities(adjusted: &Adjusted, parameters: &[Parameter]) -> Vec<Sensitivity> {
    let is_free = |i: &usize| adjusted.free.contains(&parameters[*i]);
    let (free, held): (Vec<usize>, Vec<usize>) = (0..parameters.len()).partition(is_free);
    let information = &adjusted.normal.information;
    let slope = -invert(&select(information, &free, &free)) * select(information, &free, &held);
    let mut all = Vec::new();
    for (j, to) in held.iter().enumerate() {
        for (i, of) in free.iter().enumerate() {
            all.push(Sensitivity {
                of: parameters[*of],
                to: parameters[*to],
                slope: slope[(i, j)],
            });
        }
    }
    all
}
