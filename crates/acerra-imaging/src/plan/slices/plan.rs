//! The plan of neighbouring slices.

use super::super::imaging::ImagingPlan;
use super::super::options::{Engine, PlanOptions, SelfCheck};
use super::super::planner::{SINGLE_PRECISION_FLOOR, next_share};
use super::super::report::{Decision, PlanReport};
use super::super::request::{Propagation, Request};
use super::groups::nearest_slice;
use super::proof::Proof;
use crate::engine::weights::{WeightedPulses, Weights};
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::grid::tilted::TiltedGrid;
use crate::grid::volume::VolumeGrid;
use crate::pulses::Pulses;
use acerra_control::Control;
use num_complex::Complex32;
use std::ops::Range;

/// One plan and its tables for neighbouring slices of a volume. Weights by incidence and rays into the ground
/// differ from slice to slice: the plan then serves all slices, and each slice has separate tables.
pub(crate) struct SlicesPlan<'a> {
    plan: ImagingPlan<'a>,
    first: usize,
    /// Whether every slice has separate weights, and so separate tables.
    has_own_weights: bool,
    proof: Option<Proof>,
    worst: Option<SelfCheck>,
}

impl<'a> SlicesPlan<'a> {
    /// Makes the plan on the slice nearest to the antennas in height, where directions change fastest from
    /// pixel to pixel; the plan aims at a share of the accuracy. `None` where single precision cannot keep
    /// that accuracy.
    ///
    /// # Errors
    /// As [`ImagingPlan::new`], and cancellation.
    pub fn new(
        volume: &VolumeGrid,
        slices: Range<usize>,
        aim: f64,
        pulses: Pulses<'a>,
        options: &PlanOptions,
        control: Control,
    ) -> Result<Option<Self>, ImagingError> {
        if aim < 1.0 && aim * options.accuracy < SINGLE_PRECISION_FLOOR {
            return Ok(None);
        }
        let grids: Vec<TiltedGrid> = slices.clone().map(|k| volume.slice(k).into()).collect();
        let planned = volume.slice(nearest_slice(volume, &slices, &pulses));
        let request = Request::new(pulses, planned.into(), options)?.with_slices(grids)?;
        let mut plan = ImagingPlan::of_request(Request { aim, ..request }, control)?;
        let is_reference = plan.engine() == Engine::Reference;
        // Separate rays of every pixel are summed in double precision, whatever the accuracy.
        if plan.is_double_precision()
            && !matches!(
                plan.request.propagation(),
                Propagation::Any | Propagation::UnevenGround
            )
            && !matches!(options.engine, Engine::Double | Engine::Reference)
            && options.accuracy >= SINGLE_PRECISION_FLOOR
        {
            return Ok(None);
        }
        if slices.len() < volume.nz {
            plan.report.decisions.push(Decision::Slices {
                from: slices.start,
                to: slices.end,
                of: volume.nz,
            });
        }
        let has_own_weights = options.incidence.is_some() || pulses.ground().is_some();
        if has_own_weights {
            plan.forget_tables();
        }
        Ok(Some(Self {
            first: slices.start,
            has_own_weights,
            proof: (!is_reference).then(|| Proof::new(&plan.request)),
            worst: None,
            plan,
        }))
    }

    /// Images slice `k` of the volume, and compares some of the slice's pixels with the reference; the result
    /// is `None` where the reference itself is run.
    ///
    /// # Errors
    /// As [`ImagingPlan::run`].
    pub fn run(
        &mut self,
        k: usize,
        image: &mut [Complex32],
        control: Control,
    ) -> Result<Option<SelfCheck>, ImagingError> {
        let grid = self.plan.request.slices[k - self.first].into();
        let own = self.own_weights(&grid)?;
        let echoes = own.as_ref().unwrap_or(&self.plan.request.echoes);
        self.plan.run_on(echoes, &grid, image, control)?;
        let Some(proof) = &mut self.proof else {
            return Ok(None);
        };
        let check = proof.of_slice(echoes, &grid, image, control)?;
        if self.keeps(check) {
            self.worst = Some(worse(self.worst, check));
        }
        Ok(Some(check))
    }

    /// The pulses with the weights of a slice, where they differ from those of the planned slice.
    fn own_weights(&self, grid: &ImageGrid) -> Result<Option<WeightedPulses<'a>>, ImagingError> {
        if !self.has_own_weights {
            return Ok(None);
        }
        let options = &self.plan.request.options;
        let pulses = self.plan.request.echoes.pulses;
        let weights = Weights::new(&pulses, grid, options.spreading, options.incidence)?;
        Ok(Some(WeightedPulses::new(pulses, weights)))
    }

    /// Whether a slice keeps the accuracy.
    pub fn keeps(&self, check: SelfCheck) -> bool {
        (self.proof.as_ref()).is_none_or(|proof| proof.accepts(check))
    }

    /// Share of the accuracy that the next plan aims at after a slice that did not keep it.
    pub fn next_aim(&self, broken: SelfCheck) -> f64 {
        let request = &self.plan.request;
        request.aim * next_share(request.options.accuracy, broken)
    }

    /// Bytes that tables, coarse images and one slice take together.
    pub fn memory_bytes(&self) -> u128 {
        self.plan.memory_bytes()
    }

    /// The plan's report, with the largest error found on the slices imaged so far.
    pub fn report(&self) -> PlanReport {
        PlanReport {
            self_check: self.worst.or(self.plan.report.self_check),
            ..self.plan.report.clone()
        }
    }

    /// The largest error found on the slices imaged so far.
    pub fn worst(&self) -> Option<SelfCheck> {
        self.worst
    }
}

/// The larger errors of two checks, and the pixels of both.
fn worse(before: Option<SelfCheck>, check: SelfCheck) -> SelfCheck {
    let Some(before) = before else { return check };
    SelfCheck {
        pixels: before.pixels + check.pixels,
        error: before.error.max(check.error),
        error_bound: before.error_bound.max(check.error_bound),
    }
}
