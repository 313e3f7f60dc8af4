//! Observability: singular directions of the information matrix, and the unknowns held because of them.

use nalgebra::DMatrix;

use super::adjust::{invert, select};
use super::parameter::Parameter;

/// A direction in the space of the unknowns that the data determine too weakly.
#[derive(Clone, Debug)]
pub struct SingularDirection {
    /// Components, each in its unknown's limit of observation
    /// ([`Parameter::sigma_limit`]); those below a tenth are left out.
    pub component: Vec<(Parameter, f64)>,
    /// Standard deviation along the direction, in units of the limits; above 1.
    pub sigma: f64,
}

/// The directions whose standard deviation exceeds the limits, weakest first.
pub(super) fn singular_directions(
    information: &DMatrix<f64>,
    parameters: &[Parameter],
) -> Vec<SingularDirection> {
    /// Deviations beyond this are no number any more.
    const LARGEST: f64 = 1e6;
    let scaled = DMatrix::from_fn(parameters.len(), parameters.len(), |i, j| {
        information[(i, j)] * parameters[i].sigma_limit() * parameters[j].sigma_limit()
    });
    let eigen = scaled.symmetric_eigen();
    let mut directions: Vec<SingularDirection> = eigen
        .eigenvalues
        .iter()
        .enumerate()
        .filter(|(_, value)| **value < 1.0)
        .map(|(k, value)| SingularDirection {
            component: parameters
                .iter()
                .enumerate()
                .map(|(i, p)| (*p, eigen.eigenvectors[(i, k)]))
                .filter(|(_, c)| c.abs() >= 0.1)
                .collect(),
            sigma: value.max(LARGEST.powi(-2)).sqrt().recip(),
        })
        .collect();
    directions.sort_by(|a, b| b.sigma.total_cmp(&a.sigma));
    directions
}

/// The unknowns to hold so that all others are observed: first those of `held`, then the ones with the most
/// precise prior.
pub(super) fn unobserved(
    information: &DMatrix<f64>,
    parameters: &[Parameter],
    mut held: Vec<Parameter>,
) -> Vec<Parameter> {
    let mut free: Vec<usize> = (0..parameters.len())
        .filter(|i| !held.contains(&parameters[*i]))
        .collect();
    loop {
        let covariance = invert(&select(information, &free, &free));
        let next = free
            .iter()
            .enumerate()
            .filter(|(k, i)| {
                let sigma = covariance[(*k, *k)].max(0.0).sqrt();
                sigma.is_nan() || sigma > parameters[**i].sigma_limit()
            })
            .map(|(_, i)| *i)
            .min_by_key(|i| parameters[*i].hold_rank());
        match next {
            None => return held,
            Some(next) => {
                free.retain(|i| *i != next);
                held.push(parameters[next]);
            }
        }
    }
}
