//! The maximum of the posterior, by Gauss–Newton steps.
//!
//! Objective: 2Σ|E − Σ_k c_k S e^{−jκR_k}|²/σ² + δᵀC⁻¹δ, the negative double logarithm of the
//! posterior for Gaussian noise. The amplitudes are nuisances: free in each pulse for the
//! [`Stage::Envelope`], of one phase along the flight for the [`Stage::Phase`]. A step that does not
//! lower the objective is shortened or dropped.

use acerra_imaging::{Control, ImagingError};
use nalgebra::Vector3;

use crate::ground::Ground;
use crate::histories::Histories;
use crate::model::{Model, Posterior};
use crate::observe::{Observing, Rows, Standpoint};
use crate::profiles::Profiles;
use crate::smoother::{Path, Smoothed};
use crate::template::Template;

/// Solutions with new weights within one step.
const WEIGHINGS: usize = 3;
/// Most steps of one stage.
const STEPS: usize = 12;
/// Shares of a step that are tried.
const SHARES: [f64; 3] = [1.0, 0.5, 0.2];
/// Gain of the objective below which a stage is over.
const LEAST_GAIN: f64 = 0.5;

/// Which of an echo's properties count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Delays alone, whatever the phases: no ambiguity of half a wavelength.
    Envelope,
    /// Phases and delays.
    Phase,
}

/// The data and priors of an estimate.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a> {
    pub profiles: &'a Profiles,
    pub template: &'a Template,
    pub ground: Ground<'a>,
    pub nominal_m: &'a [[f64; 3]],
    pub path: &'a Path,
    pub delay_sigma_m: f64,
    pub control: Control<'a>,
}

/// A model's points in the data.
pub(crate) struct Seen {
    /// Ranges of all points from all pulses, `[M][K]`, m.
    pub ranges_m: Vec<Vec<f64>>,
    pub histories: Histories,
}

/// A maximum with what surrounds it.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub model: Model,
    pub posterior: Posterior,
    /// Posterior deviations of the places along columns and rows, m.
    pub place_sigma_m: Vec<[f64; 2]>,
    /// Rms of each point's residual range by phase, m.
    pub residual_m: Vec<Option<f64>>,
}

impl<'a> Problem<'a> {
    /// Ranges of all points from all pulses, `[M][K]`, m.
    pub fn ranges_m(&self, model: &Model) -> Vec<Vec<f64>> {
        let points = model.points_m(&self.ground);
        model
            .positions_m(self.nominal_m)
            .iter()
            .map(|p| {
                let from = Vector3::from(*p);
                points
                    .iter()
                    .map(|q| (q - from).norm() + model.delay_m)
                    .collect()
            })
            .collect()
    }

    /// The echoes of a model's points, separated.
    pub fn seen(&self, model: &Model) -> Seen {
        let ranges_m = self.ranges_m(model);
        let histories = Histories::new(self.profiles, self.template, &ranges_m);
        Seen {
            ranges_m,
            histories,
        }
    }

    /// The objective without the constant Σ|E|², for noise of this variance.
    pub fn objective(&self, model: &Model, seen: &Seen, stage: Stage, noise: f64) -> f64 {
        let misfit = match stage {
            Stage::Envelope => -seen.histories.captured(),
            Stage::Phase => {
                let amplitudes = seen.histories.coherent();
                amplitudes.misfit(self.profiles, self.template, &seen.ranges_m)
            }
        };
        2.0 * misfit / noise + model.prior_square(self.delay_sigma_m)
    }

    /// Steps to the maximum of the posterior from `start`; `guides` are the points that tell of the
    /// path.
    pub fn fit(
        &self,
        start: Model,
        stage: Stage,
        guides: &[bool],
        steps: Option<usize>,
    ) -> Result<Fitted, ImagingError> {
        let mut model = start;
        let mut seen = self.seen(&model);
        for _ in 0..steps.unwrap_or(STEPS) {
            self.control.check()?;
            let Some((rows, found)) = self.linearised(&model, &seen, stage, guides) else {
                break;
            };
            let noise = seen.histories.noise * typical(&rows, stage);
            let target = rows.apply(&model, &found);
            let before = self.objective(&model, &seen, stage, noise);
            let better = SHARES.iter().find_map(|share| {
                let tried = model.towards(&target, *share);
                let seen = self.seen(&tried);
                let gain = before - self.objective(&tried, &seen, stage, noise);
                (gain > 0.0).then_some((tried, seen, gain))
            });
            let Some((next, next_seen, gain)) = better else {
                break;
            };
            (model, seen) = (next, next_seen);
            if gain < LEAST_GAIN {
                break;
            }
        }
        self.control.check()?;
        Ok(self.surroundings(model, &seen, stage, guides))
    }

    /// The maximum reached through several stages.
    pub fn fit_through(
        &self,
        start: Model,
        stages: &[Stage],
        guides: &[bool],
    ) -> Result<Fitted, ImagingError> {
        let (last, before) = stages.split_last().unwrap_or((&Stage::Phase, &[]));
        let mut model = start;
        for stage in before {
            model = self.fit(model, *stage, guides, None)?.model;
        }
        self.fit(model, *last, guides, None)
    }

    fn linearised(
        &self,
        model: &Model,
        seen: &Seen,
        stage: Stage,
        guides: &[bool],
    ) -> Option<(Rows, Smoothed)> {
        let positions = model.positions_m(self.nominal_m);
        let stand = Standpoint {
            model,
            histories: &seen.histories,
            position_m: &positions,
            ground: &self.ground,
            carrier: self.template.carrier,
            cell_m: self.template.cell_m,
        };
        let observing = Observing {
            phases: stage == Stage::Phase,
            guides,
            delay_sigma_m: self.delay_sigma_m,
        };
        let mut rows = Rows::about(&stand, observing);
        let mut found = self.path.smooth(&rows.observations())?;
        for _ in 0..WEIGHINGS {
            rows.weigh(&found);
            found = self.path.smooth(&rows.observations())?;
        }
        Some((rows, found))
    }

    /// Covariances about a maximum.
    fn surroundings(&self, model: Model, seen: &Seen, stage: Stage, guides: &[bool]) -> Fitted {
        let solved = self
            .linearised(&model, seen, stage, guides)
            .and_then(|(mut rows, found)| {
                rows.widen_by_correlation(&found);
                let widened = self.path.smooth(&rows.observations())?;
                Some((rows, found, widened))
            });
        let points = model.places.len();
        match solved {
            Some((rows, found, widened)) => Fitted {
                place_sigma_m: (0..points)
                    .map(|k| rows.place_sigma_m(&widened.parameter_covariance, k))
                    .collect(),
                residual_m: (0..points).map(|k| rows.phase_rms_m(&found, k)).collect(),
                posterior: Posterior {
                    error_m2: widened.covariance_m2,
                },
                model,
            },
            None => Fitted {
                place_sigma_m: vec![[f64::INFINITY; 2]; points],
                residual_m: vec![None; points],
                posterior: Posterior {
                    error_m2: self.path.factor.iter().map(|l| l * l.transpose()).collect(),
                },
                model,
            },
        }
    }
}

/// Median over the points of how much larger residual variances are than noise makes them.
fn typical(rows: &Rows, stage: Stage) -> f64 {
    let kind = usize::from(stage == Stage::Envelope);
    let mut scales: Vec<f64> = rows.scale.iter().map(|s| s[kind]).collect();
    scales.sort_by(f64::total_cmp);
    scales.get(scales.len() / 2).copied().unwrap_or(1.0)
}
