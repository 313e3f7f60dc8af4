//! Error budget: the cheapest range tables and expansions that keep an accuracy.

use crate::control::Control;
use crate::engine::direct::DirectSpec;
use crate::engine::factorized::spec::{Demand, FactorizedSpec};
use crate::engine::tables::spec::TableSpec;
use crate::engine::travel_time::TravelTime;
use crate::error::ImagingError;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::level::SimdLevel;
use crate::pulses::Pulses;
use crate::sampling::Random;
use crate::vector::{dot, norm};

/// Mean power at each frequency over the weighted pulses.
pub(super) fn mean_power(pulses: &Pulses) -> Vec<f64> {
    let mut power = vec![0.0; pulses.frequency_hz().len()];
    for (m, w) in pulses.weight().iter().enumerate() {
        for (p, e) in power.iter_mut().zip(pulses.spectrum_of(m)) {
            *p += e.norm_sqr() * w * w;
        }
    }
    let total: f64 = power.iter().sum();
    if total > 0.0 && total.is_finite() {
        power.iter_mut().for_each(|p| *p /= total);
    } else {
        power.fill(1.0);
    }
    power
}

/// Lowest, carrier and highest frequency that matter at `accuracy`, given the power at each.
fn effective_band_hz(pulses: &Pulses, power: &[f64], accuracy: f64, table: &TableSpec) -> [f64; 3] {
    let f = pulses.frequency_hz();
    let carrier = f[table.carrier];
    let mut order: Vec<usize> = (0..f.len()).collect();
    order.sort_by(|a, b| (f[*b] - carrier).abs().total_cmp(&(f[*a] - carrier).abs()));
    // Frequencies at the edges may alias while what they hold stays well below the error allowed.
    let allowed = (0.2 * accuracy).powi(2) * power.iter().sum::<f64>();
    let mut dropped = 0.0;
    let widest = order
        .into_iter()
        .find(|k| {
            dropped += power[*k];
            dropped > allowed
        })
        .map_or(0.0, |k| (f[k] - carrier).abs());
    [carrier - widest, carrier, carrier + widest]
}

/// Random pairs of pulse and pixel: range and sine of the angle to the row.
struct Sample(Vec<(f64, f64)>);

impl Sample {
    fn draw(pulses: &Pulses, grid: &TiltedGrid) -> Self {
        let mut random = Random(0x9e37_79b9);
        let length = norm(grid.u_m).max(1e-12);
        Self(
            (0..256)
                .map(|_| {
                    let p = pulses.position_m()[random.below(pulses.len())];
                    let (i, j) = (random.below(grid.columns), random.below(grid.rows));
                    let point = grid.point_m(i as f64, j as f64);
                    let d = std::array::from_fn(|a| point[a] - p[a]);
                    let range = norm(d).max(1e-12);
                    (range, (dot(d, grid.u_m) / length / range).abs())
                })
                .collect(),
        )
    }

    fn share(&self, f: impl Fn(f64, f64) -> bool) -> f64 {
        self.0.iter().filter(|(r, s)| f(*r, *s)).count() as f64 / self.0.len() as f64
    }
}

/// Chooses parameters of the engines for given data, pixels and instruction set.
pub(crate) struct Budget<'a> {
    pulses: &'a Pulses<'a>,
    grid: &'a TiltedGrid,
    level: SimdLevel,
    /// Power at each frequency, by which errors are weighted.
    power: Vec<f64>,
    sample: Sample,
}

/// A partition of the aperture, the tables of its sub-apertures, and the cost of the direct engine.
pub(crate) struct FactorizedBudget {
    pub spec: FactorizedSpec,
    pub inner: DirectSpec,
    pub direct_cost: f64,
}

impl<'a> Budget<'a> {
    /// For data whose power at each frequency is `power` `[N]`.
    pub fn new(
        pulses: &'a Pulses<'a>,
        grid: &'a TiltedGrid,
        level: SimdLevel,
        power: Vec<f64>,
    ) -> Self {
        Self {
            pulses,
            grid,
            level,
            power,
            sample: Sample::draw(pulses, grid),
        }
    }

    /// The cheapest table and expansion that keep `accuracy`, and their cost in vector operations a
    /// pixel.
    pub fn direct(&self, accuracy: f64) -> (DirectSpec, f64) {
        let mut best: Option<(DirectSpec, f64)> = None;
        // Narrower bins may need fewer terms of the carrier.
        let tries = (1..=3).flat_map(|degree| [0.7, 0.5, 0.35].map(|share| (degree, share)));
        for (degree, share) in tries {
            let table = choose_table(self.pulses, &self.power, degree, share * accuracy);
            let Some(found) = table.map(|table| self.expansion(table, accuracy)) else {
                continue;
            };
            if best.as_ref().is_none_or(|(_, cost)| found.1 < *cost) {
                best = Some(found);
            }
        }
        best.unwrap_or_else(|| {
            // Not reached for accuracies a plan accepts; a very fine cubic table is safe.
            let table = TableSpec {
                bin_m: fine_bin_m(self.pulses),
                degree: 3,
                period: None,
                carrier: self.pulses.frequency_hz().len() / 2,
                interleaved: false,
            };
            let spec = DirectSpec {
                table,
                fine_carrier: true,
                cubic: true,
                phase_tolerance_rad: 0.5 * accuracy,
                reference_below_m: table.folding_range_m(0.1 * accuracy),
            };
            (spec, 100.0)
        })
    }

    /// The expansion of the range that `table` needs, and the cost of both.
    fn expansion(&self, table: TableSpec, accuracy: f64) -> (DirectSpec, f64) {
        let lanes = self.level.lanes() as f64;
        let pixel = norm(self.grid.u_m).max(1e-12);
        let half = 0.5 * 15.0 * pixel; // groups are 16 pixels at every level
        let half_vector = 0.5 * (lanes - 1.0) * pixel;
        let phase_tolerance_rad = 0.5 * accuracy;
        let alpha = table.carrier_rad(self.pulses);
        let fine_carrier = carrier_error(alpha, 3) > 0.6 * accuracy || table.degree > 1;
        let wavenumber = alpha / table.bin_m; // rad per metre of range
        let third = |r: f64| 0.08 * half.powi(3) / (r * r) * wavenumber;
        let cubic = fine_carrier || self.sample.share(|r, _| third(r) > phase_tolerance_rad) > 0.02;
        let truncation_error = |r: f64| {
            if cubic {
                0.5 * half.powi(4) / (r * r * r) * wavenumber
            } else {
                third(r)
            }
        };
        let window = self.sample.share(|r, s| {
            let bend = half * (1.0 - s * s) / r;
            let span = half_vector * (2.0 * (s + bend) + half_vector * (1.0 - s * s) / (2.0 * r))
                / table.bin_m;
            span < lanes - 1.05 && truncation_error(r) < phase_tolerance_rad
        });
        // Vector operations for one vector of pixels, as counted in the kernel.
        let degree = table.degree as f64;
        let terms = if fine_carrier { 4.0 } else { 3.0 };
        let lookups = 2.0 * (degree + 1.0);
        let common = 5.0 + 2.0 * degree + 2.0 * terms + 4.0 + 6.0;
        let windowed = common + lookups + if cubic { 3.0 } else { 2.0 };
        let gathered = common + 20.0 + lookups * (4.0 + lanes);
        let cost = (window * windowed + (1.0 - window) * gathered) / lanes;
        let spec = DirectSpec {
            table,
            fine_carrier,
            cubic,
            phase_tolerance_rad,
            reference_below_m: table.folding_range_m(0.1 * accuracy),
        };
        (spec, cost)
    }

    /// The cheapest partition that keeps `accuracy`; `None` where coarse grids do not pay.
    ///
    /// # Errors
    /// Cancellation.
    pub fn factorized(
        &self,
        accuracy: f64,
        control: Control,
    ) -> Result<Option<FactorizedBudget>, ImagingError> {
        let (_, direct_cost) = self.direct(accuracy);
        let (mut inner, _) = self.direct(0.8 * accuracy);
        inner.table.interleaved = true;
        // Exact ranges, and coefficients read lane by lane, in operations a value as measured.
        let (lanes, fours) = (
            self.level.lanes() as f64,
            (inner.table.degree as f64 + 1.0) / 2.0,
        );
        let demand = Demand {
            band_hz: effective_band_hz(self.pulses, &self.power, accuracy, &inner.table),
            accuracy: 0.85 * accuracy,
            direct_cost: (60.0 + 25.0 * fours) / lanes + 4.4 * fours,
            lanes: self.level.lanes(),
        };
        let spec = FactorizedSpec::choose(self.pulses, self.grid, &demand, control)?;
        Ok(spec.map(|spec| FactorizedBudget {
            spec,
            inner,
            direct_cost,
        }))
    }
}

/// Largest error of the carrier's polynomials over a bin of phase advance `alpha`: cosine of `terms` terms
/// and sine of one less, interpolated at Chebyshev nodes.
fn carrier_error(alpha: f64, terms: i32) -> f64 {
    let x = 0.5 * alpha;
    let remainder = |power: i32| {
        let factorial: f64 = (1..=power).map(f64::from).product();
        x.powi(power) / factorial
    };
    let cosine = remainder(2 * terms) / 2f64.powi(2 * terms - 1);
    let sine = remainder(2 * terms - 1) / 2f64.powi(2 * terms - 3);
    cosine.max(sine)
}

fn fine_bin_m(pulses: &Pulses) -> f64 {
    let top = pulses.frequency_hz().iter().copied().fold(0.0, f64::max);
    pulses.light_speed_m_s() / top / 40.0
}

/// The widest bins of a degree that keep `accuracy`.
fn choose_table(pulses: &Pulses, power: &[f64], degree: usize, accuracy: f64) -> Option<TableSpec> {
    let f = pulses.frequency_hz();
    let centre = 0.5
        * (f.iter().copied().fold(f64::INFINITY, f64::min) + f.iter().copied().fold(0.0, f64::max));
    let carrier =
        (0..f.len()).min_by(|a, b| (f[*a] - centre).abs().total_cmp(&(f[*b] - centre).abs()))?;
    let good = |spec: &TableSpec| {
        let alpha = spec.carrier_rad(pulses);
        alpha < 2.6
            && carrier_error(alpha, 4) <= 0.3 * accuracy
            && spec.fit_error(pulses, power) <= accuracy
    };
    let spec = |bin_m, period| TableSpec {
        bin_m,
        degree,
        period,
        carrier,
        interleaved: false,
    };
    if let Some(step) = pulses.frequency_step_hz() {
        let period_m = TravelTime::of(pulses).period_m(step);
        let shortest = (f.len() + 1).max(16);
        return smooth_lengths(shortest, shortest * 4096)
            .into_iter()
            .map(|length| spec(period_m / length as f64, Some(length)))
            .find(good);
    }
    let mut bin_m = 20.0 * fine_bin_m(pulses);
    for _ in 0..80 {
        if good(&spec(bin_m, None)) {
            return Some(spec(bin_m, None));
        }
        bin_m *= 0.93;
    }
    None
}

/// Lengths 2^a·3^b·5^c from `from` to `to`, about 4 % apart, rising.
fn smooth_lengths(from: usize, to: usize) -> Vec<usize> {
    let mut lengths = Vec::new();
    for b in 0..3 {
        for c in 0..3 {
            let mut length = 4 * 3usize.pow(b) * 5usize.pow(c);
            while length <= to {
                if length >= from {
                    lengths.push(length);
                }
                length *= 2;
            }
        }
    }
    lengths.sort_unstable();
    lengths
}
