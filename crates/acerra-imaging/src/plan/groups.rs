//! Shapes of the pixel groups that the forward operator sums in registers, and the range bins that receive
//! the sums.

use super::arrangement::Arrangements;
use super::bins::{carrier_error, choose_table};
use super::budget::{Budget, has_own_spreadings};
use super::request::Request;
use super::sample::Sample;
use crate::engine::direct::DirectSpec;
use crate::engine::forward::grouped::{GroupSpec, GroupWay, grouped_pixels};
use crate::engine::tables::fit_error::FitErrors;
use crate::engine::tables::spec::TableSpec;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::job::Shape;
use crate::kernel::spread_groups::{DEGREE, MAX_TERMS};
use crate::vector::norm;
use std::f64::consts::PI;

/// Shapes of a group, pixels along the row and across.
const SHAPES: [[usize; 2]; 3] = [[4, 4], [4, 2], [2, 2]];

/// Shares of the accuracy for the polynomials' fit and the carrier's polynomials over half a turn.
const FIT_SHARE: f64 = 0.5;
const TURN_SHARE: f64 = 0.15;

/// Least share of pixels among those of whole blocks of groups: small images are mostly padding.
const LEAST_FILLED: f64 = 0.5;

/// Vector operations for a pixel of a group, and for a group: expansion, move to the bin, and addition.
const PIXEL_COST: f64 = 36.0;
const GROUP_COST: f64 = 180.0;
/// Vector operations for a pixel of a group whose pixels go to separate bins, without the additions.
const SPREAD_PIXEL_COST: f64 = 30.0;
const SPREAD_GROUP_COST: f64 = 90.0;
/// Cost in vector operations of adding a pixel to a bin of four numbers and to one of eight.
const ADDITION_COST: [f64; 2] = [2.6, 4.0];
/// Vector operations for a pixel that is added by rows with exact ranges.
const ROW_COST: f64 = 16.0;

/// The cheapest groups that keep `accuracy`, with separate tables instead of the tables of `imaging`, and the
/// cost in vector operations a pixel. `None` where pixels are added one by one: coarse pixels, accuracies
/// beyond the single-precision expansion, weights by incidence (their expansion about a bin is no wider than
/// the bin), and antennas far apart.
pub(super) fn choose_groups(
    request: &Request,
    power: &[f64],
    accuracy: f64,
    imaging: &DirectSpec,
) -> Option<(DirectSpec, f64)> {
    if request.options.incidence.is_some() {
        return None;
    }
    let (pulses, grid) = (&request.echoes.pulses, request.grid.plane());
    let lanes = request.options.level.lanes() as f64;
    let errors = FitErrors::new(pulses, power)?;
    let sample = Sample::draw(pulses, grid, request.grid.terrain());
    let choice = |shape: [usize; 2]| {
        if has_own_spreadings(pulses, grid, shape, &sample, accuracy) {
            return None;
        }
        let reach_m = half_diagonal_m(grid, shape);
        let table = choose_table(
            pulses,
            &errors,
            DEGREE,
            (FIT_SHARE * accuracy, 2.0 * reach_m),
        )?;
        let wavenumber = table.carrier_rad(pulses) / table.bin_m;
        let block_m = 0.5 * norm(grid.u_m) * shape[0] as f64 * lanes;
        let rounding_rad = wavenumber * block_m * f64::from(f32::EPSILON);
        let terms = (MAX_TERMS - 1..=MAX_TERMS)
            .find(|terms| turn_error(*terms as i32) <= TURN_SHARE * accuracy)?;
        if rounding_rad >= 0.2 * imaging.phase_tolerance_rad || filled(grid, shape) < LEAST_FILLED {
            return None;
        }
        let spec = DirectSpec {
            table,
            fine_carrier: true,
            reference_below_m: table.folding_range_m(0.1 * accuracy),
            groups: Some(GroupSpec {
                shape,
                way: GroupWay::Summed {
                    terms,
                    // Curvature adds a little to the slope.
                    reach_m: 1.01 * reach_m,
                },
            }),
            ..*imaging
        };
        let pixels = (shape[0] * shape[1]) as f64;
        Some((
            spec,
            (PIXEL_COST + GROUP_COST / pixels) / (lanes * filled(grid, shape)),
        ))
    };
    SHAPES
        .into_iter()
        .filter_map(choice)
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The cheapest table and group shape that keep `accuracy` where each pixel of a group goes to its own bin,
/// and the cost in vector operations a pixel. `None` for antennas that do not look straight down and for
/// antennas far apart, whose weights change from pixel to pixel, and where single precision does not carry
/// ranges.
pub(super) fn choose_spread(
    request: &Request,
    power: &[f64],
    accuracy: f64,
) -> Option<(DirectSpec, f64)> {
    let (pulses, grid) = (&request.echoes.pulses, request.grid.plane());
    let level = request.options.level;
    if request.echoes.weights.tilt().is_some() {
        return None;
    }
    let tables = Budget::new(pulses, &request.grid, level, power.to_vec()).tables(accuracy);
    let arrange = Arrangements { pulses, level };
    let sample = Sample::draw(pulses, grid, request.grid.terrain());
    let lanes = level.lanes() as f64;
    let choice = |(table, shape): (TableSpec, [usize; 2])| {
        if has_own_spreadings(pulses, grid, shape, &sample, accuracy) {
            return None;
        }
        let spec = DirectSpec {
            groups: Some(GroupSpec {
                shape,
                way: GroupWay::Spread,
            }),
            ..arrange.spec(table, accuracy, Shape::Row)
        };
        let wavenumber = table.carrier_rad(pulses) / table.bin_m;
        let block_m = 0.5 * norm(grid.u_m) * shape[0] as f64 * lanes;
        let rounding_rad = wavenumber * block_m * f64::from(f32::EPSILON);
        let filled = filled(grid, shape);
        if rounding_rad >= 0.2 * spec.phase_tolerance_rad || filled < LEAST_FILLED {
            return None;
        }
        // The remainder after the third order is largest where the group is seen from the side and from
        // above.
        let half_m = half_diagonal_m(grid, shape);
        let held = sample.share(|sight| {
            let bend = half_m / sight.range_m;
            wavenumber * half_m * 0.25 * bend.powi(3) < spec.phase_tolerance_rad
        });
        let pixels = (shape[0] * shape[1]) as f64;
        let terms = if spec.fine_carrier { 2.0 } else { 0.0 };
        let operations = SPREAD_PIXEL_COST + terms + SPREAD_GROUP_COST / pixels;
        let addition = ADDITION_COST[usize::from(table.degree > 1)];
        let cost = (operations / lanes + addition) / filled;
        Some((spec, held * cost + (1.0 - held) * ROW_COST))
    };
    tables
        .into_iter()
        .flat_map(|table| [[4, 4], [2, 2]].map(|shape| (table, shape)))
        .filter_map(choice)
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Share of pixels among those of whole blocks of groups.
fn filled(grid: &TiltedGrid, shape: [usize; 2]) -> f64 {
    grid.columns as f64 * grid.rows as f64 / grouped_pixels(grid, shape) as f64
}

/// Distance of the farthest pixel from the middle of a group, m.
fn half_diagonal_m(grid: &TiltedGrid, shape: [usize; 2]) -> f64 {
    let [i, j] = shape.map(|side| 0.5 * (side - 1) as f64);
    let diagonal = |sign: f64| {
        norm(std::array::from_fn(|a| {
            i * grid.u_m[a] + sign * j * grid.v_m[a]
        }))
    };
    diagonal(1.0).max(diagonal(-1.0))
}

/// Largest error over half a turn of a cosine polynomial of `terms` terms and a sine polynomial of one term
/// fewer, interpolated at Chebyshev nodes.
fn turn_error(terms: i32) -> f64 {
    carrier_error(PI, terms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::polynomials::even_polynomial;

    #[test]
    fn polynomials_over_half_a_turn_err_as_said() {
        for terms in [4, 5] {
            let cosine: [f32; MAX_TERMS] = even_polynomial(|r| (PI * r).cos(), terms);
            let sine: [f32; MAX_TERMS] = even_polynomial(|r| (PI * r).sin() / r, terms - 1);
            let at = |c: &[f32; MAX_TERMS], q: f64| {
                c.iter().rev().fold(0.0, |sum, c| sum * q + f64::from(*c))
            };
            let bound = turn_error(terms as i32) + 2e-6; // and roundings of the coefficients
            for k in 0..=1000 {
                let r = f64::from(k) / 1000.0 - 0.5;
                let cosine_error = (at(&cosine, r * r) - (PI * r).cos()).abs();
                let sine_error = (at(&sine, r * r) * r - (PI * r).sin()).abs();
                assert!(
                    cosine_error.max(sine_error) <= bound,
                    "{terms} terms at {r}: {cosine_error:e} {sine_error:e} for {bound:e}"
                );
            }
        }
    }

    #[test]
    fn the_farthest_pixel_of_a_skewed_group_is_at_the_longer_diagonal() {
        let grid = TiltedGrid::new([0.0; 3], [0.02, 0.0, 0.0], [-0.01, 0.01, 0.0], 9, 9).unwrap();
        // 1.5 · (0.02 + 0.01, −0.01)
        let expected = 1.5 * f64::hypot(0.03, 0.01);
        assert!((half_diagonal_m(&grid, [4, 4]) - expected).abs() < 1e-12);
    }
}
