//! Groups of slices, one plan a group.
//!
//! Slices near the antennas need a dearer plan than far slices. A tall volume is halved, and its halves
//! again, as long as separate plans save more than they cost.

use super::super::band::mean_power;
use super::super::budget::Budget;
use super::super::imaging::Imaging;
use super::super::options::{Engine, PlanOptions};
use super::super::partitions::{mean_costs, partitions};
use super::super::request::Request;
use super::super::sample::Sample;
use crate::error::ImagingError;
use crate::grid::terrain::Terrain;
use crate::grid::tilted::TiltedGrid;
use crate::grid::volume::VolumeGrid;
use crate::pulses::{Pulses, Spreading};
use acerra_control::Control;
use std::ops::Range;

/// Vector operations that take as long as making a plan and its tables.
const PLANNING: f64 = 1.5e8;
/// Ratio of the distances of two slices from the antennas' height from which their costs may differ.
const FARTHER: f64 = 1.25;
/// Vector operations of the direct engine a contribution, at most: below this cost of a volume no comparison
/// is worth its time.
const DEAREST: f64 = 4.0;

/// The groups of slices of a volume, in their order.
///
/// # Errors
/// An antenna exactly on a voxel (with 1/R²), cancellation.
pub(crate) fn groups(
    volume: &VolumeGrid,
    pulses: Pulses,
    options: &PlanOptions,
    control: Control,
) -> Result<Vec<Range<usize>>, ImagingError> {
    let slices: Vec<TiltedGrid> = (0..volume.nz).map(|k| volume.slice(k).into()).collect();
    let request = Request::new(pulses, volume.base.into(), options)?.with_slices(slices)?;
    let halving = Halving {
        volume,
        power: mean_power(&request.echoes.pulses),
        request,
        control,
    };
    let mut groups = Vec::new();
    if matches!(options.engine, Engine::Double | Engine::Reference) {
        groups.push(0..volume.nz);
    } else {
        halving.divide(0..volume.nz, None, &mut groups)?;
    }
    Ok(groups)
}

/// The slice among `slices` that is nearest to the mean height of the antennas.
pub(super) fn nearest_slice(volume: &VolumeGrid, slices: &Range<usize>, pulses: &Pulses) -> usize {
    let k = ((mean_height_m(pulses) - volume.base.z_m) / volume.step_m).round();
    k.clamp(slices.start as f64, (slices.end - 1) as f64) as usize
}

fn mean_height_m(pulses: &Pulses) -> f64 {
    pulses.position_m().iter().map(|p| p[2]).sum::<f64>() / pulses.len().max(1) as f64
}

struct Halving<'a> {
    volume: &'a VolumeGrid,
    /// The request of any slice.
    request: Request<'a>,
    /// Power at each frequency.
    power: Vec<f64>,
    control: Control<'a>,
}

impl Halving<'_> {
    /// Adds the groups of `slices`; `cost` is the cost of the nearest slice where it is known already.
    fn divide(
        &self,
        slices: Range<usize>,
        cost: Option<f64>,
        groups: &mut Vec<Range<usize>>,
    ) -> Result<(), ImagingError> {
        let middle = slices.start + slices.len() / 2;
        let [lower, upper] = [slices.start..middle, middle..slices.end];
        let contributions =
            |slices: &Range<usize>| slices.len() as f64 * self.request.contributions() as f64;
        let worth_looking = slices.len() > 1
            && DEAREST * contributions(&slices) > 2.0 * PLANNING
            && self.is_farther(&lower, &upper);
        if !worth_looking {
            groups.push(slices);
            return Ok(());
        }
        let cost = cost.map_or_else(|| self.cost_of(&slices), Ok)?;
        // The nearest slice of all is also that of one half.
        let nearest = self.nearest(&slices);
        let cost_of = |half: &Range<usize>| match half.contains(&nearest) {
            true => Ok(cost),
            false => self.cost_of(half),
        };
        let costs = [cost_of(&lower)?, cost_of(&upper)?];
        let saved =
            (cost - costs[0]) * contributions(&lower) + (cost - costs[1]) * contributions(&upper);
        if saved < PLANNING {
            groups.push(slices);
            return Ok(());
        }
        self.divide(lower, Some(costs[0]), groups)?;
        self.divide(upper, Some(costs[1]), groups)
    }

    fn nearest(&self, slices: &Range<usize>) -> usize {
        nearest_slice(self.volume, slices, &self.request.echoes.pulses)
    }

    /// Whether one of the halves is sufficiently farther from the antennas' height than the other.
    fn is_farther(&self, lower: &Range<usize>, upper: &Range<usize>) -> bool {
        let height_m = mean_height_m(&self.request.echoes.pulses);
        let [a, b] =
            [lower, upper].map(|half| (self.volume.slice(self.nearest(half)).z_m - height_m).abs());
        a.max(b) > FARTHER * a.min(b)
    }

    /// Vector operations a contribution of the cheaper engine on the nearest of `slices`.
    fn cost_of(&self, slices: &Range<usize>) -> Result<f64, ImagingError> {
        let slice = self.volume.slice(self.nearest(slices)).into();
        let options = &self.request.options;
        let pulses = self.request.echoes.pulses;
        let request = Request::new(pulses, slice, options)?;
        let plane = request.grid.plane();
        let budget = Budget::new(&pulses, &request.grid, options.level, self.power.clone());
        let (spec, direct_cost) = budget.direct(options.accuracy);
        // A term of the double-precision sum takes about as long as a vector operation.
        let near = match options.spreading {
            Spreading::None => 0.0,
            Spreading::InverseSquare => {
                let sample = Sample::draw(&pulses, plane, Terrain::LEVEL);
                sample.share(|sight| sight.range_m < spec.reference_below_m)
            }
        };
        let near_cost = near * pulses.frequency_hz().len() as f64;
        let factorized = match options.engine {
            Engine::Auto | Engine::Factorized => {
                partitions::<Imaging>(&request, options.accuracy, &self.power, self.control)?
            }
            _ => None,
        };
        let factorized_cost = factorized.map_or(f64::INFINITY, |p| mean_costs(&p)[0]);
        Ok(direct_cost.min(factorized_cost) + near_cost)
    }
}
