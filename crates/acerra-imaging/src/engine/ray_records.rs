//! Rays from antennas apart to a level plane below level ground, in the form that the direct kernel reads.

use super::level_law::LevelLaw;
use super::level_ways::RayTable;
use super::weights::WeightedPulses;
use crate::kernel::direct::rays::{
    MOST_RECORDS, RECORD_PADDING, RayRecord, RayRow, RaysView, TERMS,
};

/// Height below which every second knot suffices, m: cubics then deviate by 2·10⁻⁷ of the height, and blocks of
/// pixels span few records.
const LOW_M: f64 = 1.5;

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
        let mut numbers = Vec::new();
        let mut rows = Vec::with_capacity(knots.len());
        for knots in &knots {
            let height_m = knots.height_m();
            let step = if height_m < LOW_M { 2 } else { 1 };
            let table = RayTable::of(knots, step, &echoes.weights);
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
                inverse_height: (1.0 / height_m) as f32,
                inverse_apparent: (1.0 / law.apparent_m(height_m)) as f32,
            });
            let records: Vec<RayRecord> = of_table(&table, bin_m).collect();
            for k in 0..2 * TERMS {
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

/// Excess of the first record's optical length over its straight distance, m.
fn beyond_m(table: &RayTable) -> f64 {
    let first = table.bins.first().map_or(0.0, |bin| 2.0 * bin[0][0]);
    first - table.first_bin / table.bins_per_m
}

fn of_table(table: &RayTable, bin_m: f64) -> impl Iterator<Item = RayRecord> + '_ {
    let beyond_m = beyond_m(table);
    table.bins.iter().enumerate().map(move |(k, bin)| {
        let straight_m = (table.first_bin + k as f64) / table.bins_per_m;
        let less_m = [straight_m + beyond_m, 1.0 / table.bins_per_m, 0.0, 0.0];
        let excess = |p: usize| ((2.0 * bin[p][0] - less_m[p]) / bin_m) as f32;
        std::array::from_fn(|k| match k {
            0..4 => excess(k),
            _ => bin[k - 4][1] as f32,
        })
    })
}
