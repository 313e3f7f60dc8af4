//! Rays from antennas apart to a level plane below level ground, in the form that the direct kernel reads.

use super::level_law::{LawPoint, LevelLaw};
use super::level_ways::RayTable;
use super::weights::{WeightedPulses, Weights};
use crate::kernel::direct::job::HALF;
use crate::kernel::direct::rays::{MOST_RECORDS, RECORD_PADDING, RayRecord, RayRow, RaysView};
use crate::kernel::tabulated::Bin;
use std::collections::VecDeque;

/// Height below which every second knot suffices, m: cubics then deviate by 2·10⁻⁷ of the height, and blocks of
/// pixels span few records.
const LOW_M: f64 = 1.5;

/// Least weight of one way: products of two inverse weights are single-precision numbers.
const LEAST_WEIGHT: f64 = 1e-15;

/// Tabulated rays of all pulses.
#[derive(Debug)]
pub(crate) struct RayRecords {
    numbers: Vec<f32>,
    /// Rows of the transmitter and of the receiver of each pulse.
    rows: [Vec<RayRow>; 2],
}

impl RayRecords {
    /// The rays of antennas apart to places at most as far as `half_ways_m`, bounds of half the optical lengths of each
    /// pulse, tell; lengths are in bins of `bin_m`.
    pub fn new(
        echoes: &WeightedPulses,
        law: &LevelLaw,
        half_ways_m: &[[f64; 2]],
        bin_m: f64,
    ) -> Self {
        let farthest_m = farthest_m(echoes, law, half_ways_m);
        let (knots, of_antenna) = law.tabulated(0..echoes.len(), farthest_m);
        let reach_m = f64::from(HALF) * law.pixel_m().iter().sum::<f64>();
        let mut numbers = Vec::new();
        let mut rows = Vec::with_capacity(knots.len());
        for knots in &knots {
            let height_m = knots.height_m();
            let step = if height_m < LOW_M { 2 } else { 1 };
            let table = RayTable::of(knots, step, |point| of_way(point, &echoes.weights));
            let stride = RayRow::stride_of(table.bins.len());
            rows.push(RayRow {
                start: numbers.len() + RECORD_PADDING,
                stride,
                last: table.bins.len().saturating_sub(1).min(MOST_RECORDS),
                first: table.first_bin,
                per_m: table.bins_per_m,
                record_m: (1.0 / table.bins_per_m) as f32,
                record_bins: (1.0 / (table.bins_per_m * bin_m)) as f32,
                beyond_m: beyond_m(&table),
            });
            let reach = (reach_m * table.bins_per_m).ceil() as usize;
            let records = of_table(&table, bin_m, reach);
            for k in 0..size_of::<RayRecord>() / size_of::<f32>() {
                let padded = (0..stride).map(|i| {
                    let i = i
                        .saturating_sub(RECORD_PADDING)
                        .min(records.len().saturating_sub(1));
                    records.get(i).map_or(0.0, |record| record[k])
                });
                numbers.extend(padded);
            }
        }
        let of_kind = |kind: usize| {
            let antennas = of_antenna.iter().skip(kind).step_by(2);
            antennas.map(|k| rows[*k]).collect()
        };
        Self {
            rows: [0, 1].map(of_kind),
            numbers,
        }
    }

    /// Bytes of [`RayRecords::new`].
    pub fn bytes_for(echoes: &WeightedPulses, law: &LevelLaw, half_ways_m: &[[f64; 2]]) -> u128 {
        let [rays, tables] = law.rays(0..echoes.len(), farthest_m(echoes, law, half_ways_m));
        let padded = rays + tables * 2 * RECORD_PADDING as u128;
        let rows = 2 * echoes.len() * size_of::<RayRow>();
        padded * size_of::<RayRecord>() as u128 + rows as u128
    }

    /// The rays as the kernel reads them.
    pub fn view(&self, weight_tolerance: f64) -> RaysView<'_> {
        RaysView {
            numbers: &self.numbers,
            rows: [&self.rows[0], &self.rows[1]],
            weight_tolerance: weight_tolerance as f32,
        }
    }
}

/// The straight distance of every pulse up to which its antennas need rays: no ray is shorter than its straight line,
/// the optical lengths from two antennas differ by the distance between these at most, and the last of every second knot
/// lies a few knots beyond.
fn farthest_m<'a>(
    echoes: &WeightedPulses,
    law: &'a LevelLaw,
    half_ways_m: &'a [[f64; 2]],
) -> impl Fn(usize) -> f64 + use<'a> {
    let half_apart_m = echoes.pulses.half_apart_m();
    move |m| {
        let height_m = law.heights_m(m).iter().copied().fold(0.0, f64::max);
        half_ways_m[m][1] + half_apart_m + 0.25 * height_m
    }
}

/// Half the optical length, m, and one over the weight of one way.
fn of_way(point: &LawPoint, weights: &Weights) -> [f64; 2] {
    let weight = weights.of_law(point).sqrt().max(LEAST_WEIGHT);
    [0.5 * point.optical_m, 1.0 / weight]
}

/// Excess of the first record's optical length over its straight distance, m.
fn beyond_m(table: &RayTable) -> f64 {
    let first = table.bins.first().map_or(0.0, |bin| 2.0 * bin[0][0]);
    first - table.first_bin / table.bins_per_m
}

/// The records of a table; squares of pixels reach so many records far.
fn of_table(table: &RayTable, bin_m: f64, reach: usize) -> Vec<RayRecord> {
    let beyond_m = beyond_m(table);
    let third = |k: usize| 2.0 * table.bins[k.min(table.bins.len() - 1)][3][0] / bin_m;
    // From a record to the next the third coefficient changes by four times the fourth.
    let fourth: Vec<f64> = (0..table.bins.len())
        .map(|k| 0.25 * (third(k + 1) - third(k)).abs())
        .collect();
    let greatest = greatest_within(&fourth, reach);
    let of_bin = |(k, (bin, greatest)): (usize, (&Bin, f64))| {
        let straight_m = (table.first_bin + k as f64) / table.bins_per_m;
        let less_m = [straight_m + beyond_m, 1.0 / table.bins_per_m, 0.0, 0.0];
        let excess = |p: usize| ((2.0 * bin[p][0] - less_m[p]) / bin_m) as f32;
        std::array::from_fn(|k| match k {
            0..4 => excess(k),
            4..8 => bin[k - 4][1] as f32,
            _ => greatest as f32,
        })
    };
    let bins = table.bins.iter().zip(greatest);
    bins.enumerate().map(of_bin).collect()
}

/// The greatest of the values up to `reach` places away, for every place.
fn greatest_within(values: &[f64], reach: usize) -> Vec<f64> {
    // Places of values that are greater than all that follow them in the window.
    let mut falling: VecDeque<usize> = VecDeque::new();
    let mut greatest = Vec::with_capacity(values.len());
    let mut next = 0;
    for k in 0..values.len() {
        while next < values.len() && next <= k + reach {
            while falling.back().is_some_and(|j| values[*j] <= values[next]) {
                falling.pop_back();
            }
            falling.push_back(next);
            next += 1;
        }
        while falling.front().is_some_and(|j| j + reach < k) {
            falling.pop_front();
        }
        greatest.push(falling.front().map_or(0.0, |j| values[*j]));
    }
    greatest
}

#[cfg(test)]
mod tests {
    use super::greatest_within;

    #[test]
    fn the_greatest_is_found_within_the_reach() {
        let values = [1.0, 5.0, 2.0, 3.0, 0.0, 4.0, 1.0];
        assert_eq!(greatest_within(&values, 0), values);
        let expected = [5.0, 5.0, 5.0, 3.0, 4.0, 4.0, 4.0];
        assert_eq!(greatest_within(&values, 1), expected);
        assert_eq!(greatest_within(&values, 9), [5.0; 7]);
    }
}
