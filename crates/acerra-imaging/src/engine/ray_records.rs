//! Rays from antennas apart to a level plane below level ground, in the form that the direct kernel reads.

use super::level_law::LevelLaw;
use super::level_ways::RayTable;
use super::weights::WeightedPulses;
use crate::kernel::direct::rays::{MOST_RECORDS, RayRecord, RayRow, RaysView};

/// Tabulated rays of all pulses.
#[derive(Debug)]
pub(crate) struct RayRecords {
    records: Vec<RayRecord>,
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
        let farthest_m = farthest_m(echoes, half_ways_m);
        let (knots, of_antenna) = law.tabulated(0..echoes.len(), farthest_m);
        let mut records = Vec::new();
        let mut rows = Vec::with_capacity(knots.len());
        for knots in &knots {
            let table = RayTable::of(knots, &echoes.weights);
            let start = records.len();
            rows.push(row(&table, start, law));
            records.extend(of_table(&table, bin_m));
        }
        let of_kind = |kind: usize| {
            let antennas = of_antenna.iter().skip(kind).step_by(2);
            antennas.map(|k| rows[*k]).collect()
        };
        Self {
            rows: [0, 1].map(of_kind),
            records,
        }
    }

    /// Bytes of [`RayRecords::new`].
    pub fn bytes_for(echoes: &WeightedPulses, law: &LevelLaw, half_ways_m: &[[f64; 2]]) -> u128 {
        let rays = law.rays(0..echoes.len(), farthest_m(echoes, half_ways_m));
        let rows = 2 * echoes.len() * size_of::<RayRow>();
        rays * size_of::<RayRecord>() as u128 + rows as u128
    }

    /// The rays as the kernel reads them.
    pub fn view(&self, weight_tolerance: f64) -> RaysView<'_> {
        RaysView {
            records: &self.records,
            rows: [&self.rows[0], &self.rows[1]],
            weight_tolerance: weight_tolerance as f32,
        }
    }
}

/// The straight distance of every pulse up to which its antennas need rays: no ray is shorter than its straight line,
/// and the optical lengths from two antennas differ by the distance between these at most.
fn farthest_m<'a>(
    echoes: &WeightedPulses,
    half_ways_m: &'a [[f64; 2]],
) -> impl Fn(usize) -> f64 + use<'a> {
    let half_apart_m = echoes.pulses.half_apart_m();
    move |m| half_ways_m[m][1] + half_apart_m
}

fn row(table: &RayTable, start: usize, law: &LevelLaw) -> RayRow {
    // The first record lies half a record beyond the vertical, 1/32 of the height apart.
    let height_m = law.knots_height_m(table.bins_per_m);
    RayRow {
        start,
        last: table.bins.len().saturating_sub(1).min(MOST_RECORDS),
        first: table.first_bin,
        per_m: table.bins_per_m,
        beyond_m: beyond_m(table),
        inverse_height: (1.0 / height_m) as f32,
        inverse_apparent: (1.0 / law.apparent_m(height_m)) as f32,
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
