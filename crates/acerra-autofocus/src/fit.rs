//! The maximum of the posterior, by Gauss–Newton steps.
//!
//! Objective: 2Σ|E − Σ_k c_k S e^{−jκR_k}|²/σ² + δᵀC⁻¹δ, the negative double logarithm of the
//! posterior for Gaussian noise. The amplitudes are nuisances: free in each pulse for the
//! [`Stage::Envelope`], of one phase along the flight for the [`Stage::Phase`]. A step that does not
//! lower the objective is shortened or dropped.

use acerra_imaging::{Control, ImagingError};
use nalgebra::Vector3;

use crate::globals::Global;
use crate::ground::{Ground, PixelPlace};
use crate::histories::Histories;
use crate::model::{Model, Posterior};
use crate::observe::{LinearisationPoint, Observing, Rows};
use crate::parts::Parts;
use crate::profiles::Profiles;
use crate::ranging::Ranging;
use crate::smoother::{Path, Smoothed};
use crate::template::Template;

/// Number of reweighted solutions within one step.
const WEIGHINGS: usize = 3;
/// Largest number of steps of one stage.
const STEPS: usize = 12;
/// Largest number of steps where globals make the objective's valley long and bent.
const STEPS_WITH_GLOBALS: usize = 25;
/// Shares of a step that are tried in turn.
const SHARES: [f64; 3] = [1.0, 0.5, 0.2];
/// Deviation of a change of a point's place from the place where the point was found (m).
const NEAR_M: f64 = 0.5;
/// Deviation of a change of place for a point that may lie anywhere in an image (m).
const ANYWHERE_M: f64 = 30.0;
/// Share of a step within which the problem is linear to good accuracy.
const LITTLE: f64 = 1e-6;
/// Gain of the objective below which a stage ends.
const LEAST_GAIN: f64 = 0.5;

/// Observables of echoes that enter the objective.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Delays alone, which have no ambiguity of half a wavelength.
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
    pub globals: &'a [Global],
    pub parts: &'a Parts,
    pub control: Control<'a>,
}

/// Ranges and separated echoes of a model's points.
pub(crate) struct Seen {
    /// Ranges of all points from all pulses, `[M][K]`, m.
    pub ranges_m: Vec<Vec<f64>>,
    pub histories: Histories,
}

/// A maximum of the posterior with covariances about it.
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
    /// The model of the stated flight with points at `places`.
    pub fn nominal(&self, places: Vec<PixelPlace>) -> Model {
        Model::nominal(self.nominal_m.len(), self.globals.len(), places)
    }

    /// A model's positions, m.
    pub fn positions_m(&self, model: &Model) -> Vec<[f64; 3]> {
        model.positions_m(self.nominal_m, self.globals)
    }

    /// The ranging of a model with its values of the globals.
    pub fn ranging(&self, model: &Model) -> Ranging {
        Ranging::new(self.globals, &model.globals, self.nominal_m.len())
    }

    /// Ranges of all points from all pulses, `[M][K]`, m.
    pub fn ranges_m(&self, model: &Model) -> Vec<Vec<f64>> {
        let ranging = self.ranging(model);
        let points = model.points_m(&self.ground);
        let of = |(m, p): (usize, &[f64; 3])| {
            let from = Vector3::from(*p);
            points
                .iter()
                .map(|q| ranging.range_m(m, &from, q))
                .collect()
        };
        self.positions_m(model).iter().enumerate().map(of).collect()
    }

    /// The echoes of a model's points, separated.
    pub fn seen(&self, model: &Model) -> Seen {
        let ranges_m = self.ranges_m(model);
        let turn = self.ranging(model).turn;
        let data = (self.profiles, self.template);
        let histories = Histories::new(data, &ranges_m, turn, self.parts);
        Seen {
            ranges_m,
            histories,
        }
    }

    /// The objective without the constant Σ|E|², for noise of variance `noise`.
    pub fn objective(&self, model: &Model, seen: &Seen, stage: Stage, noise: f64) -> f64 {
        let misfit = match stage {
            Stage::Envelope => -seen.histories.captured(),
            Stage::Phase => {
                let amplitudes = seen.histories.coherent();
                amplitudes.misfit(self.profiles, self.template, &seen.ranges_m)
            }
        };
        2.0 * misfit / noise + model.prior_square(self.globals)
    }

    /// Steps to the maximum of the posterior from `start`; `guides` are the points that determine the path.
    pub fn fit(
        &self,
        start: Model,
        stage: Stage,
        guides: &[bool],
        steps: Option<usize>,
    ) -> Result<Fitted, ImagingError> {
        let (mut model, mut seen) = self.begin(start, stage, guides);
        let most = match self.globals {
            [] => STEPS,
            _ => STEPS_WITH_GLOBALS,
        };
        for _ in 0..steps.unwrap_or(most) {
            self.control.check()?;
            let better = self
                .place_sigmas_m()
                .iter()
                .find_map(|sigma_m| self.step(&model, &seen, (stage, guides), *sigma_m));
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

    /// Deviations of changes of place in trial steps, m. The places have no prior, and free places are needed
    /// for free globals; small deviations keep points from diverging along directions that their echoes do
    /// not constrain.
    pub fn place_sigmas_m(&self) -> &'static [f64] {
        match self.globals {
            [] => &[NEAR_M],
            _ => &[ANYWHERE_M, NEAR_M],
        }
    }

    /// A better model with the echoes of its points and its gain of the objective; `None` where no share of
    /// the step improves the objective.
    fn step(
        &self,
        model: &Model,
        seen: &Seen,
        (stage, guides): (Stage, &[bool]),
        place_sigma_m: f64,
    ) -> Option<(Model, Seen, f64)> {
        let (rows, found) = self.linearised(model, seen, (stage, guides), place_sigma_m)?;
        let noise = seen.histories.noise * typical(&rows, stage);
        let target = rows.apply(model, &found);
        let before = self.objective(model, seen, stage, noise);
        SHARES.iter().find_map(|share| {
            let tried = self.part_of_step(model, &target, guides, *share);
            let seen = self.seen(&tried);
            let gain = before - self.objective(&tried, &seen, stage, noise);
            (gain > 0.0).then_some((tried, seen, gain))
        })
    }

    /// The model after a share of a linear step, on the curve along which its points' ranges change as in the
    /// linear step: a rising plane moves all points on it sideways, more for points more nearly below. Other
    /// points than guides keep the ranges of their separate steps.
    fn part_of_step(&self, model: &Model, target: &Model, guides: &[bool], share: f64) -> Model {
        let straight = model.towards(target, share);
        if self.globals.is_empty() {
            return straight;
        }
        let little = model.towards(target, LITTLE);
        let alone_m = self.ranges_m(&model.with_places(little.places.clone()));
        let (before_m, little_m) = (self.ranges_m(model), self.ranges_m(&little));
        let wanted_m: Vec<Vec<f64>> = before_m
            .iter()
            .zip(little_m.iter().zip(&alone_m))
            .map(|(before, (little, alone))| {
                let changed = |k: usize| if guides[k] { little[k] } else { alone[k] };
                let wanted = |(k, b): (usize, &f64)| b + share / LITTLE * (changed(k) - b);
                before.iter().enumerate().map(wanted).collect()
            })
            .collect();
        let places = self.places_with(&straight, &wanted_m);
        straight.with_places(places)
    }

    /// The maximum of the posterior after several stages.
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

    pub fn linearised(
        &self,
        model: &Model,
        seen: &Seen,
        (stage, guides): (Stage, &[bool]),
        place_sigma_m: f64,
    ) -> Option<(Rows, Smoothed)> {
        let positions = self.seen_from_m(model);
        let reference = LinearisationPoint {
            model,
            histories: &seen.histories,
            parts: self.parts,
            position_m: &positions,
            ground: &self.ground,
            carrier: self.template.carrier,
            cell_m: self.template.cell_m,
        };
        let observing = Observing {
            phases: stage == Stage::Phase,
            guides,
            globals: self.globals,
            place_sigma_m,
        };
        let mut rows = Rows::about(&reference, observing);
        let mut found = self.path.smooth(&rows.observations())?;
        for _ in 0..WEIGHINGS {
            rows.weigh(&found);
            found = self.path.smooth(&rows.observations())?;
        }
        Some((rows, found))
    }

    /// Antenna positions from which lines of sight start, m. With globals, the positions are the nominal path
    /// moved by the globals: corrections of millimetres to a straight path would otherwise seem to determine
    /// quantities that a straight flight cannot observe, such as its height above the scene.
    fn seen_from_m(&self, model: &Model) -> Vec<[f64; 3]> {
        if self.globals.is_empty() {
            return self.positions_m(model);
        }
        let stated = Model {
            globals: model.globals.clone(),
            ..self.nominal(Vec::new())
        };
        self.positions_m(&stated)
    }
}

/// Median over the points of the ratio of residual variance to noise variance.
fn typical(rows: &Rows, stage: Stage) -> f64 {
    let kind = usize::from(stage == Stage::Envelope);
    let mut scales: Vec<f64> = rows.scale.iter().map(|s| s[kind]).collect();
    scales.sort_by(f64::total_cmp);
    scales.get(scales.len() / 2).copied().unwrap_or(1.0)
}
