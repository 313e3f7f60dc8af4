//! A second stage: images of sub-apertures merged from those of shorter sub-apertures.
//!
//! Long sub-apertures are merged seldom, but contain so many directions that their grids are fine; short ones
//! have coarse grids, but are many. With both, range tables are summed on the coarse grids, and few images
//! are merged on the fine one.

use super::aperture::{divided, partition_aperture};
use super::spec::{COUNTS, Demand, FactorizedSpec, Stage, Way, share};
use crate::error::ImagingError;
use crate::grid::tilted::TiltedGrid;
use crate::pulses::Pulses;
use acerra_control::Control;

/// Vector operations of an image below which a second stage is not searched for.
const WORTH_SEARCHING: f64 = 1e8;
/// A second stage is used below this share of the one-stage cost: it takes longer to plan, and images of few
/// million pixels gain less than estimated.
const WORTH_A_STAGE: f64 = 0.85;
/// Least number of pulses of the shorter sub-apertures.
const LEAST_PULSES: usize = 12;
/// Least number of shorter sub-apertures in a longer one.
const LEAST_RATIO: usize = 2;

/// Sub-apertures of one length on the image's grid.
struct Candidate {
    count: usize,
    merges: f64,
    bandwidth_per_m: [f64; 2],
}

/// The partition with a second stage where it is cheaper than the one-stage partition `one`.
///
/// # Errors
/// Cancellation.
pub(crate) fn with_second_stage(
    pulses: &Pulses,
    grid: &TiltedGrid,
    demand: &Demand,
    one: FactorizedSpec,
    control: Control,
) -> Result<FactorizedSpec, ImagingError> {
    let contributions = (grid.columns * grid.rows) as f64 * pulses.len() as f64;
    if one.cost * contributions < WORTH_SEARCHING {
        return Ok(one);
    }
    let mut candidates: Vec<Candidate> = Vec::new();
    for count in COUNTS {
        control.check()?;
        let parts = partition_aperture(pulses, count);
        let merges = parts.len() as f64 / pulses.len() as f64;
        let is_open = count >= LEAST_PULSES && count <= 2 * pulses.len();
        if is_open && candidates.last().is_none_or(|c| c.merges != merges) {
            candidates.push(Candidate {
                count,
                merges,
                bandwidth_per_m: demand.bandwidth_per_m(pulses, grid, (count, &parts)),
            });
        }
    }
    let ways = Way::all(demand, 2);
    let search = Search {
        pulses,
        grid,
        demand,
    };
    let mut found = WORTH_A_STAGE * one.cost;
    let mut pair = None;
    for inner in &candidates {
        for inner_way in &ways {
            let direct_cost = search.direct_cost(inner_way, inner);
            for outer in candidates
                .iter()
                .filter(|c| c.count >= LEAST_RATIO * inner.count)
            {
                control.check()?;
                for outer_way in &ways {
                    let ways = [outer_way, inner_way];
                    let cost = search.cost(ways, [outer, inner], direct_cost);
                    if cost.is_some_and(|cost| cost < found) {
                        found = cost.unwrap_or(found);
                        pair = Some((ways, [outer, inner]));
                    }
                }
            }
        }
    }
    let two = pair.and_then(|(ways, candidates)| search.exact(ways, candidates));
    Ok(two
        .filter(|two| two.cost < WORTH_A_STAGE * one.cost)
        .unwrap_or(one))
}

/// Data for comparing all pairs of stages.
struct Search<'a> {
    pulses: &'a Pulses<'a>,
    grid: &'a TiltedGrid,
    demand: &'a Demand<'a>,
}

impl Search<'_> {
    /// Vector operations of the direct engine a value, on grids about as coarse as the grids of `inner`.
    fn direct_cost(&self, way: &Way, inner: &Candidate) -> f64 {
        match way.stage(inner.count, self.grid, inner.bandwidth_per_m) {
            Some(stage) => (self.demand.direct_cost)(&stage.coarse.grid(self.grid)),
            None => f64::INFINITY,
        }
    }

    /// Estimated cost of two stages.
    fn cost(
        &self,
        ways: [&Way; 2],
        [outer, inner]: [&Candidate; 2],
        direct_cost: f64,
    ) -> Option<f64> {
        let first = ways[0].stage(outer.count, self.grid, outer.bandwidth_per_m)?;
        let coarse = first.coarse.grid(self.grid);
        let second = ways[1].stage(inner.count, &coarse, inner.bandwidth_per_m)?;
        let merges = [outer.merges, inner.merges];
        Some(self.of_stages(ways, [&first, &second], merges, direct_cost))
    }

    /// Vector operations a contribution, given the number of sub-apertures a pulse in either stage.
    fn of_stages(
        &self,
        ways: [&Way; 2],
        stages: [&Stage; 2],
        merges: [f64; 2],
        direct_cost: f64,
    ) -> f64 {
        let [merge, merge_on_coarse] = [0, 1].map(|k| ways[k].merge(stages[k]) * merges[k]);
        let coarse = stages[0].coarse.grid(self.grid);
        let of_tables = share(&stages[1].coarse.grid(&coarse), &coarse) * direct_cost;
        merge + share(&coarse, self.grid) * (merge_on_coarse + of_tables)
    }

    /// The stages with exact bandwidths, computed for their sub-apertures on the grids on which these are
    /// imaged.
    fn exact(&self, ways: [&Way; 2], [outer, inner]: [&Candidate; 2]) -> Option<FactorizedSpec> {
        let first = ways[0].stage(outer.count, self.grid, outer.bandwidth_per_m)?;
        let coarse = first.coarse.grid(self.grid);
        let parts = divided(&partition_aperture(self.pulses, outer.count), inner.count);
        let bandwidth = (self.demand).bandwidth_on(self.pulses, &coarse, &parts);
        let second = ways[1].stage(inner.count, &coarse, bandwidth)?;
        let direct_cost = (self.demand.direct_cost)(&second.coarse.grid(&coarse));
        let merges = [outer.merges, parts.len() as f64 / self.pulses.len() as f64];
        let mut spec = FactorizedSpec {
            outer: first,
            shorter: Some(second),
            interpolation_error: 0.0,
            cost: self.of_stages(ways, [&first, &second], merges, direct_cost),
        };
        spec.interpolation_error = spec.error_on(self.grid);
        Some(spec)
    }
}
