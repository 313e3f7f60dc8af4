//! Norms of the operator's columns: amplitude of a unit point's echoes for every pixel.

use crate::flight::Flight;
use acerra_imaging::ImageGrid;
use rayon::prelude::*;

/// Pixels between the places where norms are evaluated; they vary as 1/R² does.
const STRIDE: usize = 8;
/// Norms below this share of the greatest are raised to it: pixels that no pulse sees keep a finite weight.
const LEAST_SHARE: f64 = 1e-3;

/// The weights 1/‖Lᵢ‖ of all pixels of `grids`, one after another: they make the point spread even.
///
/// Norms are evaluated on every eighth pixel and interpolated linearly; any positive weight is a valid
/// preconditioner, this one is even to a part in a thousand.
#[must_use]
pub fn even_weights(flight: &Flight, grids: &[ImageGrid]) -> Vec<f32> {
    let norms: Vec<Vec<f64>> = grids.iter().map(|grid| norms_on(flight, grid)).collect();
    let greatest = norms.iter().flatten().copied().fold(0.0, f64::max);
    let least = (LEAST_SHARE * greatest).max(f64::MIN_POSITIVE);
    norms
        .iter()
        .flatten()
        .map(|norm| norm.max(least).recip() as f32)
        .collect()
}

fn norms_on(flight: &Flight, grid: &ImageGrid) -> Vec<f64> {
    let (nx, ny) = (grid.columns(), grid.rows());
    let (at_x, at_y) = (knots(nx), knots(ny));
    let coarse: Vec<f64> = at_y
        .par_iter()
        .flat_map_iter(|j| {
            at_x.iter()
                .map(|i| flight.column_norm(grid.point_m(*i, *j)))
        })
        .collect();
    (0..ny)
        .into_par_iter()
        .flat_map_iter(|j| {
            let (row, v) = between(j, &at_y);
            let (coarse, at_x) = (&coarse, &at_x);
            (0..nx).map(move |i| {
                let (column, u) = between(i, at_x);
                let width = at_x.len();
                let last = coarse.len() / width - 1;
                let value = |r: usize, c: usize| coarse[r.min(last) * width + c.min(width - 1)];
                (1.0 - v) * ((1.0 - u) * value(row, column) + u * value(row, column + 1))
                    + v * ((1.0 - u) * value(row + 1, column) + u * value(row + 1, column + 1))
            })
        })
        .collect()
}

/// Every eighth index and the last.
fn knots(count: usize) -> Vec<usize> {
    let mut knots: Vec<usize> = (0..count).step_by(STRIDE).collect();
    if !(count - 1).is_multiple_of(STRIDE) {
        knots.push(count - 1);
    }
    knots
}

/// The knot at or before `index`, and the share of the way to the next.
fn between(index: usize, knots: &[usize]) -> (usize, f64) {
    let knot = index / STRIDE;
    match knots.get(knot + 1) {
        Some(next) => {
            let from = knots[knot];
            (knot, (index - from) as f64 / (next - from) as f64)
        }
        None => (knot.min(knots.len() - 1), 0.0),
    }
}
