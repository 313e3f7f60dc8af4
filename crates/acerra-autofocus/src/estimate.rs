//! The estimation, from data to corrected positions.

use std::ops::Range;

use acerra_imaging::{Control, ImageGrid, Pulses};
use nalgebra::Vector3;

use crate::decide::{Limits, outcome, unchanged};
use crate::error::AutofocusError;
use crate::fit::Problem;
use crate::ground::Ground;
use crate::outcome::{Autofocused, Decision};
use crate::parts::Parts;
use crate::prior::PositionPrior;
use crate::profiles::Profiles;
use crate::reach::{Reached, best_fit};
use crate::search::Search;
use crate::significance::held_out_gains;
use crate::smoother::Path;
use crate::template::{Template, mean_amplitudes};

/// Requirements on an autofocus.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct AutofocusOptions {
    /// Largest number of points used; 24 by default.
    pub most_points: usize,
    /// Least mean gain of held-out points, in standard errors; 2 by default.
    pub significance: f64,
    /// Rms correction, in prior deviations, beyond which the echoes are not attributed to fixed points; 4 by
    /// default.
    pub most_sigmas: f64,
    /// Parts of the flight, in order, whose images are summed by power: a point has a separate phase in each
    /// part, and gains are measured on the sum. Empty for one image of all pulses, the default.
    pub coherent_parts: Vec<Range<usize>>,
}

impl Default for AutofocusOptions {
    fn default() -> Self {
        Self {
            most_points: 24,
            significance: 2.0,
            most_sigmas: 4.0,
            coherent_parts: Vec::new(),
        }
    }
}

/// Estimates the positions' errors from the echoes of prominent points on `grid`.
///
/// `grid` is the search area of points; pixels of half the finest resolution suffice. The frequencies must be
/// evenly spaced.
///
/// # Errors
/// Frequencies that are not even, a prior that does not fit the pulses or is no covariance, pixels
/// that cannot be imaged, cancellation.
pub fn autofocus<'a>(
    pulses: Pulses<'a>,
    grid: impl Into<ImageGrid<'a>>,
    prior: &PositionPrior,
    options: &AutofocusOptions,
    control: Control,
) -> Result<Autofocused, AutofocusError> {
    prior.check(pulses.len())?;
    let parts = Parts::new(&options.coherent_parts, pulses.len())?;
    if pulses.frequency_step_hz().is_none() || pulses.frequency_hz().len() < 8 {
        return Err(AutofocusError::UnevenFrequencies);
    }
    let ground = Ground::new(grid.into());
    let factor = prior.factors()?;
    let nothing = |decision| unchanged(&pulses, prior, &factor, decision);
    let has_echo = pulses.spectrum().iter().any(|v| v.norm_sqr() > 0.0);
    if !has_echo {
        return Ok(nothing(Decision::NoPoints));
    }
    if factor.iter().all(|l| l.norm() == 0.0) && prior.globals.is_empty() {
        return Ok(nothing(Decision::NothingToCorrect));
    }
    let path = Path::new(factor.clone(), &prior.abscissa, prior.correlation);
    let path = if prior.without_trend {
        path.without_trend(&prior.abscissa)
    } else {
        path
    };
    let range_m = ranges_m(&pulses, &ground, prior);
    let amplitudes = mean_amplitudes(pulses.spectrum(), pulses.frequency_hz().len());
    let template = Template::new(
        amplitudes,
        pulses.frequency_hz(),
        pulses.light_speed_m_s(),
        range_m[1] - range_m[0],
    );
    let profiles = Profiles::new(&pulses, &template, range_m, control)?;
    let problem = Problem {
        profiles: &profiles,
        template: &template,
        ground,
        nominal_m: pulses.position_m(),
        path: &path,
        globals: &prior.globals,
        parts: &parts,
        control,
    };
    let search = Search {
        problem,
        pulses,
        most_points: options.most_points.max(1),
    };
    let Some(reached) = best_fit(&search)? else {
        return Ok(nothing(Decision::NoPoints));
    };
    let Reached {
        start,
        stages,
        fitted,
    } = reached;
    let gains = held_out_gains(&problem, &start, stages, &fitted)?;
    let limits = Limits {
        significance: options.significance,
        most_sigmas: options.most_sigmas,
    };
    Ok(outcome(&pulses, &problem, fitted, &gains, limits))
}

/// Least and greatest range (m) that range profiles must cover.
fn ranges_m(pulses: &Pulses, ground: &Ground, prior: &PositionPrior) -> [f64; 2] {
    let grid = ground.grid();
    let corners: Vec<Vector3<f64>> = (0..=16)
        .flat_map(|a| (0..=16).map(move |b| (a, b)))
        .map(|(a, b)| {
            let at = |share: usize, size: usize| share * (size - 1) / 16;
            Vector3::from(grid.point_m(at(a, grid.columns()), at(b, grid.rows())))
        })
        .collect();
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for p in pulses.position_m() {
        for q in &corners {
            let range = (q - Vector3::from(*p)).norm();
            least = least.min(range);
            most = most.max(range);
        }
    }
    let sigma = prior
        .covariance_m2
        .iter()
        .map(|c| (c[0][0] + c[1][1] + c[2][2]).sqrt())
        .fold(0.0, f64::max);
    let spacing = (corners[0] - corners[18]).norm();
    let shared: f64 = prior.globals.iter().map(|g| g.reach_m(most)).sum();
    let margin = 1.0 + 6.0 * sigma + 6.0 * shared + spacing;
    [(least - margin).max(0.0), most + margin]
}
