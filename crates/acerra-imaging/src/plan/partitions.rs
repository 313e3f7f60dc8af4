//! Partitions of the aperture: of the whole aperture, or of each of its segments.

use super::budget::{Budget, FactorizedBudget};
use super::operator::{Operator, Segment};
use super::report::{FactorizedChoice, ShorterChoice};
use super::request::Request;
use crate::engine::batches::Piece;
use crate::engine::factorized::cell::Cell;
use crate::engine::factorized::segments::segments;
use crate::error::ImagingError;
use crate::grid::roughness::Roughness;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::level::SimdLevel;
use acerra_control::Control;
use std::ops::Range;

/// Segments are used where their cost is below this share of the cost of the dearest segment's partition for
/// all pulses.
const WORTH_SEGMENTS: f64 = 0.9;

/// Pulses, and how they are divided into sub-apertures.
pub(super) struct Partition {
    pulses: Range<usize>,
    budget: FactorizedBudget,
}

/// Partitions that keep `accuracy`: one of the whole aperture, or one for each segment where segments cost
/// less; `None` where coarse grids do not pay.
///
/// # Errors
/// Cancellation.
pub(super) fn partitions<O: Operator>(
    request: &Request,
    accuracy: f64,
    power: &[f64],
    control: Control,
) -> Result<Option<Vec<Partition>>, ImagingError> {
    let (pulses, plane) = (&request.echoes.pulses, request.grid.plane());
    let roughness = Roughness::of(&request.grid);
    let partition = |which: Range<usize>| -> Result<Option<Partition>, ImagingError> {
        let of_segment = pulses.slice(which.clone())?;
        let budget = Budget::new(
            &of_segment,
            &request.grid,
            request.options.level,
            power.to_vec(),
        );
        let found = budget.factorized(
            accuracy,
            [O::WINDOWS, O::TWO_STAGES],
            roughness.as_ref(),
            control,
        )?;
        Ok(found.map(|budget| Partition {
            pulses: which,
            budget,
        }))
    };
    if O::SEGMENTS
        && let Some(found) = several(segments(pulses, plane), &partition)?
    {
        return Ok(Some(found));
    }
    Ok(partition(0..pulses.len())?.map(|whole| vec![whole]))
}

/// A partition for each of several segments; `None` where a segment has none, or where the segments together
/// cost no less than the dearest partition applied to all pulses, which bounds the cost of the whole
/// aperture's partition.
fn several(
    segments: Vec<Range<usize>>,
    partition: &dyn Fn(Range<usize>) -> Result<Option<Partition>, ImagingError>,
) -> Result<Option<Vec<Partition>>, ImagingError> {
    if segments.len() < 2 {
        return Ok(None);
    }
    let found: Option<Vec<_>> = (segments.into_iter())
        .map(partition)
        .collect::<Result<_, _>>()?;
    let is_worth = |found: &Vec<Partition>| {
        let costs = found.iter().map(|p| p.budget.spec.cost);
        mean_costs(found)[0] < WORTH_SEGMENTS * costs.fold(0.0, f64::max)
    };
    Ok(found.filter(is_worth))
}

/// Mean cost of a contribution with the factorized and with the direct engine.
pub(super) fn mean_costs(partitions: &[Partition]) -> [f64; 2] {
    let pulses: usize = partitions.iter().map(|p| p.pulses.len()).sum();
    let mean = |cost: &dyn Fn(&FactorizedBudget) -> f64| {
        let costs = (partitions.iter()).map(|p| p.pulses.len() as f64 * cost(&p.budget));
        costs.sum::<f64>() / pulses.max(1) as f64
    };
    [mean(&|b| b.spec.cost), mean(&|b| b.direct_cost)]
}

impl Partition {
    /// The segment for which an engine is built.
    pub fn segment(&self, request: &Request) -> Segment {
        let coarse = |plane: &TiltedGrid| self.budget.spec.table_grid(plane);
        Piece {
            pulses: self.pulses.clone(),
            spec: (self.budget.spec, self.budget.inner),
            ranges_m: request.ranges_m(self.pulses.clone(), coarse),
        }
    }

    /// The partition's entry in a report.
    pub fn choice(&self, level: SimdLevel) -> FactorizedChoice {
        let FactorizedBudget {
            spec,
            inner,
            direct_cost,
        } = &self.budget;
        FactorizedChoice {
            level,
            pulses: self.pulses.len(),
            sub_aperture_pulses: spec.outer.pulses,
            coarse: spec.outer.coarse.cells.map(Cell::interval),
            taps: spec.outer.coarse.taps,
            bandwidth_per_m: spec.outer.bandwidth_per_m,
            merged_from: spec.shorter.map(|shorter| ShorterChoice {
                sub_aperture_pulses: shorter.pulses,
                coarse: [0, 1].map(|axis| {
                    let stages = [spec.outer, shorter];
                    (stages.iter())
                        .map(|s| s.coarse.cells[axis].interval())
                        .product()
                }),
                taps: shorter.coarse.taps,
                bandwidth_per_m: shorter.bandwidth_per_m,
            }),
            interpolation_error: spec.interpolation_error,
            bin_m: inner.table.bin_m,
            degree: inner.table.degree,
            cost: spec.cost,
            direct_cost: *direct_cost,
        }
    }
}
