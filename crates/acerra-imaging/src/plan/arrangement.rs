//! Arrangements of pixels in vectors: rows or squares, read through windows of bins or by gathers, and their
//! cost.

use super::bins::carrier_error;
use super::sample::Sample;
use crate::engine::direct::DirectSpec;
use crate::engine::tables::spec::TableSpec;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::job::Shape;
use crate::kernel::level::SimdLevel;
use crate::pulses::Pulses;
use crate::vector::norm;

/// Pixels that the direct engine images, and the lines of sight to the pixels.
pub(super) struct Target<'a> {
    pub grid: &'a TiltedGrid,
    pub sample: Sample,
    /// Whether every pixel has a separate height.
    pub is_uneven: bool,
}

/// Judges arrangements for given data and instruction set.
#[derive(Clone, Copy)]
pub(super) struct Arrangements<'a> {
    pub pulses: &'a Pulses<'a>,
    pub level: SimdLevel,
}

impl Arrangements<'_> {
    /// Requirements on a table that suffice for every arrangement: the third order of the range is included.
    pub fn spec(&self, table: TableSpec, accuracy: f64, shape: Shape) -> DirectSpec {
        let alpha = table.carrier_rad(self.pulses);
        DirectSpec {
            table,
            fine_carrier: carrier_error(alpha, 3) > 0.6 * accuracy || table.degree > 1,
            cubic: true,
            phase_tolerance_rad: 0.5 * accuracy,
            reference_below_m: table.folding_range_m(0.1 * accuracy),
            shape,
            windows: true,
            is_below_relief: false,
            groups: None,
        }
    }

    /// Lower bound of an arrangement's cost: all vectors are read from windows, without the third order of
    /// the range.
    pub fn least_cost(&self, table: TableSpec, accuracy: f64, shape: Shape) -> f64 {
        let spec = DirectSpec {
            cubic: false,
            ..self.spec(table, accuracy, shape)
        };
        let operations = self.operations(&spec);
        self.windowed(&spec, &operations).min(operations.gathered) / self.level.lanes() as f64
    }

    /// Parameters and cost of the arrangement `shape`.
    pub fn by(
        &self,
        on: &Target,
        table: TableSpec,
        accuracy: f64,
        shape: Shape,
    ) -> (DirectSpec, f64) {
        match shape {
            Shape::Row => self.by_rows(on, table, accuracy),
            _ => self.by_squares(on, table, accuracy, shape),
        }
    }

    /// Parameters and cost of groups of sixteen pixels of a row.
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
        let windowed = self.windowed(&spec, &operations);
        let block = Shape::Row.block_width(self.level.lanes()) as f64;
        let costs = Costs {
            window,
            windowed,
            gathered: operations.gathered,
            reach_m: [0.5 * block * pixel, half_vector].map(|r| r * on.sample.rms_sine(0)),
        };
        self.judged(spec, accuracy, &costs)
    }

    /// Parameters and cost of groups of 4 × 4 pixels.
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
        let uneven = if on.is_uneven { UNEVEN } else { 0.0 };
        let windowed = self.windowed(&spec, &operations) + uneven;
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

    /// Vector operations for one vector of pixels that reads windows.
    fn windowed(&self, spec: &DirectSpec, operations: &Operations) -> f64 {
        let (loads, range) = match (spec.shape, self.level) {
            (Shape::Row, _) => (1.0, 2.0),
            (Shape::WideSquare, SimdLevel::Avx512) => (1.6, 7.0),
            (Shape::WideSquare, _) => (3.0, 7.0),
            _ => (1.0, 7.0),
        };
        let third_order = if spec.cubic { 1.0 } else { 0.0 };
        operations.common + loads * operations.lookups + range + third_order
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

    /// Phase error of ranges carried in single precision over `reach_m` from a point where they are
    /// exact, rad: two roundings, uniform over the reach.
    fn rounding_rad(&self, table: TableSpec, reach_m: f64) -> f64 {
        let wavenumber = table.carrier_rad(self.pulses) / table.bin_m;
        wavenumber * reach_m * 0.5 * f64::from(f32::EPSILON) * (2.0 / 3.0)
    }

    /// The spec restricted to the ranges that single precision carries, and the spec's cost.
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
}

/// Share of the accuracy that rounding of the range may take with windows (narrower bins do not reduce this
/// error) and with gathers (where the table's errors add to it).
const ROUNDING_SHARES: [f64; 2] = [0.9, 0.6];
/// Penalty on the cost of arrangements that exceed the accuracy, which are chosen only without an
/// alternative.
pub(super) const HOPELESS: f64 = 1e3;

/// Vector operations for the heights of a vector of pixels above the plane of their square.
const UNEVEN: f64 = 6.0;

/// Cost of an arrangement of pixels.
struct Costs {
    /// Share of vectors read from windows; vector operations of a vector read from a window, and of one that
    /// gathers.
    window: f64,
    windowed: f64,
    gathered: f64,
    /// Changes of range over which windows and gathers carry the range in single precision, m.
    reach_m: [f64; 2],
}

/// Vector operations for a vector of pixels.
struct Operations {
    /// Range, polynomial, carrier and sum.
    common: f64,
    /// Reads of coefficients.
    lookups: f64,
    /// All operations of a vector that gathers.
    gathered: f64,
}
