//! Error budget: the cheapest range tables and expansions that keep an accuracy.

use crate::control::Control;
use crate::engine::direct::DirectSpec;
use crate::engine::factorized::coarse::coarse_grid;
use crate::engine::factorized::spec::{Demand, FactorizedSpec};
use crate::engine::tables::spec::TableSpec;
use crate::engine::travel_time::TravelTime;
use crate::error::ImagingError;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::job::Shape;
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

/// A pulse seen from a pixel.
struct Sight {
    range_m: f64,
    /// Sines of the angles to row and column from the line of sight's normal plane.
    sine: [f64; 2],
}

/// Random pairs of pulse and pixel.
struct Sample(Vec<Sight>);

impl Sample {
    fn draw(pulses: &Pulses, grid: &TiltedGrid) -> Self {
        let mut random = Random(0x9e37_79b9);
        let axes = [grid.u_m, grid.v_m].map(|v| v.map(|x| x / norm(v).max(1e-12)));
        Self(
            (0..256)
                .map(|_| {
                    let p = pulses.position_m()[random.below(pulses.len())];
                    let (i, j) = (random.below(grid.columns), random.below(grid.rows));
                    let point = grid.point_m(i as f64, j as f64);
                    let d = std::array::from_fn(|a| point[a] - p[a]);
                    let range_m = norm(d).max(1e-12);
                    Sight {
                        range_m,
                        sine: axes.map(|axis| (dot(d, axis) / range_m).abs()),
                    }
                })
                .collect(),
        )
    }

    /// Root mean square of the sines along an axis.
    fn rms_sine(&self, axis: usize) -> f64 {
        let sum: f64 = self.0.iter().map(|s| s.sine[axis].powi(2)).sum();
        (sum / self.0.len() as f64).sqrt()
    }

    fn share(&self, f: impl Fn(&Sight) -> bool) -> f64 {
        self.0.iter().filter(|s| f(s)).count() as f64 / self.0.len() as f64
    }
}

/// Chooses parameters of the engines for given data, pixels and instruction set.
pub(crate) struct Budget<'a> {
    pulses: &'a Pulses<'a>,
    grid: &'a TiltedGrid,
    level: SimdLevel,
    /// Power at each frequency, by which errors are weighted.
    power: Vec<f64>,
}

/// Pixels that the direct engine images, and how it sees them.
struct Target<'a> {
    grid: &'a TiltedGrid,
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
        }
    }

    /// The cheapest table and expansion that keep `accuracy`, and their cost in vector operations a
    /// pixel.
    pub fn direct(&self, accuracy: f64) -> (DirectSpec, f64) {
        self.cheapest(&self.target(self.grid), &self.tables(accuracy), accuracy)
    }

    fn target<'g>(&self, grid: &'g TiltedGrid) -> Target<'g> {
        Target {
            grid,
            sample: Sample::draw(self.pulses, grid),
        }
    }

    /// Tables that keep `accuracy`: narrower bins may need fewer terms of the carrier, and higher
    /// degrees take wider ones.
    fn tables(&self, accuracy: f64) -> Vec<TableSpec> {
        (1..=3)
            .flat_map(|degree| [0.7, 0.5, 0.35].map(|share| (degree, share)))
            .filter_map(|(degree, share)| {
                choose_table(self.pulses, &self.power, degree, share * accuracy)
            })
            .collect()
    }

    /// The cheapest of some tables and arrangements, and its cost.
    fn cheapest(&self, on: &Target, tables: &[TableSpec], accuracy: f64) -> (DirectSpec, f64) {
        let found = tables.iter().flat_map(|table| {
            [
                self.by_rows(on, *table, accuracy),
                self.by_squares(on, *table, accuracy, Shape::Square),
                self.by_squares(on, *table, accuracy, Shape::WideSquare),
            ]
        });
        found
            .reduce(|best, found| if found.1 < best.1 { found } else { best })
            .unwrap_or_else(|| self.fallback(accuracy))
    }

    /// Not reached for accuracies a plan accepts: a very fine cubic table is safe.
    fn fallback(&self, accuracy: f64) -> (DirectSpec, f64) {
        let table = TableSpec {
            bin_m: fine_bin_m(self.pulses),
            degree: 3,
            period: None,
            carrier: self.pulses.frequency_hz().len() / 2,
            interleaved: false,
        };
        (self.spec(table, accuracy, Shape::Row), 100.0)
    }

    /// What a table needs whatever the arrangement: with the third order of the range.
    fn spec(&self, table: TableSpec, accuracy: f64, shape: Shape) -> DirectSpec {
        let alpha = table.carrier_rad(self.pulses);
        DirectSpec {
            table,
            fine_carrier: carrier_error(alpha, 3) > 0.6 * accuracy || table.degree > 1,
            cubic: true,
            phase_tolerance_rad: 0.5 * accuracy,
            reference_below_m: table.folding_range_m(0.1 * accuracy),
            shape,
            windows: true,
        }
    }

    /// Phase error of ranges carried in single precision over `reach_m` from a point where they are
    /// exact, rad: two roundings, uniform over the reach.
    fn rounding_rad(&self, table: TableSpec, reach_m: f64) -> f64 {
        let wavenumber = table.carrier_rad(self.pulses) / table.bin_m;
        wavenumber * reach_m * 0.5 * f64::from(f32::EPSILON) * (2.0 / 3.0)
    }

    /// Vector operations for one vector of pixels whatever the arrangement, as counted in the kernel.
    fn operations(&self, spec: &DirectSpec) -> Operations {
        let degree = spec.table.degree as f64;
        let terms = if spec.fine_carrier { 4.0 } else { 3.0 };
        let lookups = 2.0 * (degree + 1.0);
        let common = 5.0 + 2.0 * degree + 2.0 * terms + 4.0 + 6.0;
        let gathered = common + 20.0 + lookups * (4.0 + self.level.lanes() as f64);
        Operations {
            common,
            lookups,
            gathered,
        }
    }

    /// Groups of sixteen pixels of a row.
    fn by_rows(&self, on: &Target, table: TableSpec, accuracy: f64) -> (DirectSpec, f64) {
        let lanes = self.level.lanes() as f64;
        let mut spec = self.spec(table, accuracy, Shape::Row);
        let pixel = norm(on.grid.u_m).max(1e-12);
        let half = 0.5 * 15.0 * pixel; // groups are 16 pixels at every level
        let half_vector = 0.5 * (lanes - 1.0) * pixel;
        let tolerance = spec.phase_tolerance_rad;
        let wavenumber = table.carrier_rad(self.pulses) / table.bin_m; // rad per metre of range
        let third = |r: f64| 0.08 * half.powi(3) / (r * r) * wavenumber;
        let bent = on.sample.share(|s| third(s.range_m) > tolerance);
        spec.cubic = spec.fine_carrier || bent > 0.02;
        let truncation_error = |r: f64| {
            if spec.cubic {
                0.5 * half.powi(4) / (r * r * r) * wavenumber
            } else {
                third(r)
            }
        };
        let window = on.sample.share(|sight| {
            let (r, s) = (sight.range_m, sight.sine[0]);
            let bend = half * (1.0 - s * s) / r;
            let span = half_vector * (2.0 * (s + bend) + half_vector * (1.0 - s * s) / (2.0 * r))
                / table.bin_m;
            span < lanes - 1.05 && truncation_error(r) < tolerance
        });
        let operations = self.operations(&spec);
        let windowed = operations.common + operations.lookups + if spec.cubic { 3.0 } else { 2.0 };
        let block = Shape::Row.block_width(self.level.lanes()) as f64;
        let costs = Costs {
            window,
            windowed,
            gathered: operations.gathered,
            reach_m: [0.5 * block * pixel, half_vector].map(|r| r * on.sample.rms_sine(0)),
        };
        self.judged(spec, accuracy, &costs)
    }

    /// Groups of 4 × 4 pixels.
    fn by_squares(
        &self,
        on: &Target,
        table: TableSpec,
        accuracy: f64,
        shape: Shape,
    ) -> (DirectSpec, f64) {
        let lanes = self.level.lanes() as f64;
        let mut spec = self.spec(table, accuracy, shape);
        let [along, across] = [on.grid.u_m, on.grid.v_m].map(|v| 1.5 * norm(v).max(1e-12));
        let rows = if lanes > 8.0 { 1.0 } else { 1.0 / 3.0 };
        let tolerance = spec.phase_tolerance_rad;
        let wavenumber = table.carrier_rad(self.pulses) / table.bin_m;
        let square = |r: f64| 0.5 * (along + across).powi(2) / r;
        let third = |r: f64| square(r) * 0.4 * (along + across) / r * wavenumber;
        let bent = on.sample.share(|s| third(s.range_m) > tolerance);
        spec.cubic = spec.fine_carrier || bent > 0.02;
        let entries = shape.window(self.level.lanes()) as f64;
        let window = on.sample.share(|sight| {
            let r = sight.range_m;
            let slopes = along * sight.sine[0] + across * rows * sight.sine[1];
            let span = (2.0 * slopes + 3.0 * square(r)) / table.bin_m;
            let truncation_error = if spec.cubic {
                square(r) * (along * along + across * across) / (r * r) * wavenumber
            } else {
                third(r)
            };
            span < entries - 1.05 && truncation_error < tolerance
        });
        let operations = self.operations(&spec);
        let loads = match (shape, self.level) {
            (Shape::WideSquare, SimdLevel::Avx512) => 1.6,
            (Shape::WideSquare, _) => 3.0,
            _ => 1.0,
        };
        let windowed =
            operations.common + loads * operations.lookups + if spec.cubic { 8.0 } else { 7.0 };
        let block = shape.block_width(self.level.lanes()) as f64 / 3.0 * along;
        let sines = [on.sample.rms_sine(0), on.sample.rms_sine(1)];
        let costs = Costs {
            window,
            windowed,
            gathered: operations.gathered,
            reach_m: [
                block * sines[0],
                (along * sines[0]).hypot(across * sines[1]),
            ],
        };
        self.judged(spec, accuracy, &costs)
    }

    /// A spec without what single precision cannot carry, and its cost.
    fn judged(&self, mut spec: DirectSpec, accuracy: f64, costs: &Costs) -> (DirectSpec, f64) {
        let [windows, gathers] = [0, 1].map(|k| {
            let found = self.rounding_rad(spec.table, costs.reach_m[k]);
            found < ROUNDING_SHARES[k] * accuracy
        });
        spec.windows = windows;
        let window = if windows { costs.window } else { 0.0 };
        let operations = window * costs.windowed + (1.0 - window) * costs.gathered;
        let hopeless = if gathers { 0.0 } else { HOPELESS };
        (spec, operations / self.level.lanes() as f64 + hopeless)
    }

    /// The cheapest partition that keeps `accuracy`; `None` where coarse grids do not pay. With
    /// `windows` the direct engine may image coarse grids through windows of bins.
    ///
    /// # Errors
    /// Cancellation.
    pub fn factorized(
        &self,
        accuracy: f64,
        windows: bool,
        control: Control,
    ) -> Result<Option<FactorizedBudget>, ImagingError> {
        let (_, direct_cost) = self.direct(accuracy);
        let inner_accuracy = 0.8 * accuracy;
        let tables = self.tables(inner_accuracy);
        let inner_on = |coarse: &TiltedGrid| {
            let on = windows.then(|| self.target(coarse));
            self.inner(on, &tables, inner_accuracy)
        };
        // The carrier is that of every table.
        let (first, _) = inner_on(self.grid);
        let demand = Demand {
            band_hz: effective_band_hz(self.pulses, &self.power, accuracy, &first.table),
            accuracy: 0.85 * accuracy,
            direct_cost: &|coarse| inner_on(coarse).1,
            lanes: self.level.lanes(),
        };
        let spec = FactorizedSpec::choose(self.pulses, self.grid, &demand, control)?;
        Ok(spec.map(|spec| FactorizedBudget {
            inner: inner_on(&coarse_grid(self.grid, spec.coarse)).0,
            spec,
            direct_cost,
        }))
    }

    /// What images coarse pixels, and its cost a value: windows where they are allowed and fit, or
    /// coefficients side by side for gathers.
    fn inner(
        &self,
        windows_on: Option<Target>,
        tables: &[TableSpec],
        accuracy: f64,
    ) -> (DirectSpec, f64) {
        let windowed = windows_on.map(|on| self.cheapest(&on, tables, accuracy));
        // Exact ranges, and coefficients read lane by lane, in operations a value as measured.
        let lanes = self.level.lanes() as f64;
        let gathered = |table: &TableSpec| {
            let fours = (table.degree as f64 + 1.0) / 2.0;
            let spec = self.spec(
                TableSpec {
                    interleaved: true,
                    ..*table
                },
                accuracy,
                Shape::Row,
            );
            (spec, (60.0 + 25.0 * fours) / lanes + 4.4 * fours)
        };
        tables
            .iter()
            .map(gathered)
            .chain(windowed)
            .reduce(|best, found| if found.1 < best.1 { found } else { best })
            .unwrap_or_else(|| self.fallback(accuracy))
    }
}

/// Shares of the accuracy up to which roundings of the range are worth a try: with windows, which
/// narrower bins do not help, and with gathers, beside errors of the table.
const ROUNDING_SHARES: [f64; 2] = [0.9, 0.6];
/// Added to the cost of what cannot keep the accuracy: it is chosen where nothing else is left.
pub(super) const HOPELESS: f64 = 1e3;

/// What an arrangement of pixels costs.
struct Costs {
    /// Share of vectors read from windows, and vector operations for one such vector and for one that
    /// gathers.
    window: f64,
    windowed: f64,
    gathered: f64,
    /// Changes of range over which windows and gathers carry it in single precision, m.
    reach_m: [f64; 2],
}

/// Vector operations for a vector of pixels.
struct Operations {
    /// Range, polynomial, carrier and sum.
    common: f64,
    /// Reads of coefficients.
    lookups: f64,
    /// All of a vector that gathers.
    gathered: f64,
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
        // Longer periods have narrower bins and less error.
        let lengths = smooth_lengths(shortest, shortest * 4096);
        let of = |length: usize| spec(period_m / length as f64, Some(length));
        let first = lengths.partition_point(|length| !good(&of(*length)));
        return lengths.get(first).map(|length| of(*length));
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
