//! The forward operator of neighbouring slices: one plan, and one transform of a pulse's range bins for all of them.

use super::super::forward::Forward;
use super::super::options::{Engine, PlanOptions, SelfCheck};
use super::super::planner::{SINGLE_PRECISION_FLOOR, next_share};
use super::super::request::Request;
use super::groups::nearest_slice;
use crate::control::Meter;
use crate::engine::forward::direct::DirectForward;
use crate::engine::forward::filling::Echo;
use crate::error::ImagingError;
use crate::grid::tilted::TiltedGrid;
use crate::grid::volume::VolumeGrid;
use crate::pulses::Pulses;
use acerra_control::Control;
use num_complex::{Complex32, Complex64};
use std::ops::Range;

/// Numbers of places, corners first, at which a slice is compared: at first, and where the first comparison
/// is undecided.
const PLACES: [usize; 2] = [6, 24];
/// Places are compared with about this fraction (one over the number) of the pulses.
const SHARE_OF_PULSES: usize = 16;
/// Least number of pulses that observe a place.
const LEAST_PULSES: usize = 32;
/// Bytes that range bins may take at most; more pulses are taken in batches.
const BIN_BYTES: u128 = 1 << 28;

/// One plan for neighbouring slices.
pub(crate) struct SlicesForward<'a> {
    plan: Forward<'a>,
    first: usize,
}

/// Outcome of a plan for neighbouring slices.
pub(crate) enum Shared<'a> {
    /// Every slice keeps the accuracy.
    Held(Box<SlicesForward<'a>>),
    /// Share of the accuracy that the next plan may aim at.
    Broken(f64),
    /// Each slice needs a separate plan.
    Alone,
}

impl<'a> SlicesForward<'a> {
    /// Makes a plan for the slice nearest to the antennas in height, which aims at a share of the accuracy,
    /// and compares every slice with the double-precision sum at some places.
    ///
    /// # Errors
    /// As [`Forward::new`], and cancellation.
    pub fn plan_for(
        volume: &VolumeGrid,
        slices: Range<usize>,
        aim: f64,
        pulses: Pulses<'a>,
        options: &PlanOptions,
        control: Control,
    ) -> Result<Shared<'a>, ImagingError> {
        let is_reference = options.engine == Engine::Reference;
        // Weights by incidence differ from slice to slice.
        if options.incidence.is_some()
            || (!is_reference && aim * options.accuracy < SINGLE_PRECISION_FLOOR)
        {
            return Ok(Shared::Alone);
        }
        let grids: Vec<TiltedGrid> = slices.clone().map(|k| volume.slice(k).into()).collect();
        let planned = volume.slice(nearest_slice(volume, &slices, &pulses));
        let request = Request::new(pulses, planned.into(), options)?.with_slices(grids)?;
        let plan = match Forward::of_request(Request { aim, ..request }, control) {
            // The bins of one slice cover fewer ranges than those of all slices.
            Err(ImagingError::TooLarge { .. }) => return Ok(Shared::Alone),
            plan => plan?,
        };
        if plan.engine() == Engine::Reference && !is_reference {
            return Ok(Shared::Alone);
        }
        let shared = Self {
            plan,
            first: slices.start,
        };
        if is_reference {
            return Ok(Shared::Held(Box::new(shared)));
        }
        let least = (pulses.len() / SHARE_OF_PULSES).max(LEAST_PULSES);
        let blocks = joined(shared.plan.units(), least);
        for (k, grid) in shared.plan.request.slices.iter().enumerate() {
            if let Some(check) = shared.broken(k as u64, *grid, &blocks, control)? {
                return Ok(Shared::Broken(
                    aim * next_share(shared.plan.allowed_error(), check),
                ));
            }
        }
        Ok(Shared::Held(Box::new(shared)))
    }

    /// The first failed check of a slice, if any slice does not keep the accuracy.
    fn broken(
        &self,
        slice: u64,
        grid: TiltedGrid,
        blocks: &[Range<usize>],
        control: Control,
    ) -> Result<Option<SelfCheck>, ImagingError> {
        let allowed = self.plan.allowed_error();
        let check = |turn: usize| {
            let draws = (PLACES[turn], 2 * slice + turn as u64);
            (self.plan).check_slice(grid.into(), draws, blocks.to_vec(), control)
        };
        let mut found = check(0)?;
        if found.error <= allowed && found.error_bound > allowed {
            found = check(1)?;
        }
        Ok((found.error_bound > allowed).then_some(found))
    }

    /// The slices that the plan models.
    pub fn slices(&self) -> Range<usize> {
        self.first..self.first + self.plan.request.slices.len()
    }

    /// The plan, made on the slice nearest to the antennas.
    pub fn plan(&self) -> &Forward<'a> {
        &self.plan
    }

    /// Bytes of a run in addition to a slice's image and the spectra.
    pub fn working_bytes(&self) -> u128 {
        let bins = self.plan.bins().map_or(0, |direct| {
            let pulses = self.batches(direct).iter().map(Range::len).max();
            pulses.unwrap_or(0) * direct.bins_of_pulse() * size_of::<f64>()
        });
        u128::from(self.plan.report.working_bytes) + bins as u128
    }

    /// Batches of pulses whose bins are held in memory at a time: at least one unit a batch.
    fn batches(&self, direct: &DirectForward) -> Vec<Range<usize>> {
        let bytes = (direct.bins_of_pulse().max(1) * size_of::<f64>()) as u128;
        let image = (self.plan.request.pixels() * size_of::<Complex32>()) as u128;
        let limit = self.plan.request.options.memory_limit_bytes;
        let left = limit.saturating_sub(self.plan.memory_bytes() + image);
        joined(self.plan.units(), (left.min(BIN_BYTES) / bytes) as usize)
    }

    /// Adds the spectra `[M, N]` of all slices to `spectrum`; `give` fills the image of a slice of the
    /// volume. After cancellation the spectra are incomplete.
    pub fn add(
        &self,
        give: &mut dyn FnMut(usize, &mut [Complex32]),
        image: &mut [Complex32],
        spectrum: &mut [Complex64],
        meter: &Meter,
    ) {
        let grids = &self.plan.request.slices;
        let Some(direct) = self.plan.bins() else {
            for (k, grid) in grids.iter().enumerate() {
                give(self.first + k, image);
                let spectra = Echo::Spectra(spectrum);
                self.plan
                    .add(&self.plan.all(), (grid, image), spectra, meter);
            }
            return;
        };
        let echoes = &self.plan.request.echoes;
        let n = echoes.pulses.frequency_hz().len();
        let mut sums = Vec::new();
        for which in self.batches(direct) {
            let spectra = &mut spectrum[which.start * n..which.end * n];
            sums.clear();
            sums.resize(which.len() * direct.bins_of_pulse(), 0.0);
            for (k, grid) in grids.iter().enumerate() {
                if meter.is_cancelled() {
                    return;
                }
                give(self.first + k, image);
                let bins = Echo::Bins {
                    sums: &mut sums,
                    near_spectra: spectra,
                };
                self.plan.add(&which, (grid, image), bins, meter);
            }
            direct.finish(echoes, which, &sums, spectra);
        }
    }
}

/// Neighbouring ranges joined as long as they hold no more than `most` pulses together.
fn joined(ranges: Vec<Range<usize>>, most: usize) -> Vec<Range<usize>> {
    let mut joined: Vec<Range<usize>> = Vec::new();
    for range in ranges {
        match joined.last_mut() {
            Some(last) if range.end - last.start <= most => last.end = range.end,
            _ => joined.push(range),
        }
    }
    joined
}
