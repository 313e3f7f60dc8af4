//! Curvature of a hyperbola by the phases of its traces, and its deviation.

use std::f64::consts::TAU;

use nalgebra::{Matrix4, Vector4};
use num_complex::Complex64;

/// Parts of the aperture whose phases scatter each by itself.
const PARTS: usize = 12;
/// Number of parts that the level of the clutter counts as, in addition to the measured parts.
const CLUTTER_PARTS: f64 = 3.0;
/// Weight of the place found from the image relative to the phases, whose weights sum to one: half a
/// wavelength against a twentieth.
const PLACE_WEIGHT: f64 = 0.01;

/// A trace that is aligned to an echo.
pub(super) struct Phase {
    /// Derivatives of the trace's path by delay, place east and north, and curvature.
    pub by: Vector4<f64>,
    /// Value at the delay at which their sum is strongest.
    pub value: Complex64,
}

/// Difference of the hyperbola's curvature from that along which the traces were aligned, and the deviation
/// of the difference (m): a Newton step to the greatest power of the traces' sum. Residual phases are assumed
/// correlated within each of several parts of the aperture, as phases of clutter are.
pub(super) fn regress(traces: &[Phase], wavelength_m: f64, clutter: f64) -> Option<[f64; 2]> {
    let total: Complex64 = traces.iter().map(|trace| trace.value).sum();
    let metres = -wavelength_m / TAU;
    // A trace against the sum of the others, which is free of that trace's noise.
    let products: Vec<Complex64> = (traces.iter())
        .map(|trace| trace.value * (total - trace.value).conj())
        .collect();
    let all: f64 = products.iter().map(|product| product.re).sum();
    let mut normal = Matrix4::zeros();
    let mut right = Vector4::zeros();
    for (trace, product) in traces.iter().zip(&products) {
        right += product.im / all * metres * trace.by;
        normal += product.re / all * trace.by * trace.by.transpose();
    }
    // Along a straight track the place across is undetermined.
    for axis in [1, 2] {
        normal[(axis, axis)] += PLACE_WEIGHT;
    }
    let inverse = normal.try_inverse()?;
    let solution = inverse * right;
    // The jackknife over the parts, to first order: the solution without each part.
    let a_part = traces.len().div_ceil(PARTS);
    let mut scatter = Matrix4::zeros();
    for (part, products) in traces.chunks(a_part).zip(products.chunks(a_part)) {
        let mut own = Matrix4::zeros();
        let mut left = Vector4::zeros();
        for (trace, product) in part.iter().zip(products) {
            let left_m = product.im * metres - product.re * trace.by.dot(&solution);
            left += left_m / all * trace.by;
            own += product.re / all * trace.by * trace.by.transpose();
        }
        let without = (normal - own).try_inverse()? * left;
        scatter += without * without.transpose();
    }
    let parts = traces.len().div_ceil(a_part) as f64;
    let left = scatter[(3, 3)] * (parts - 1.0) / parts;
    // Few parts may agree by chance: the effect of clutter of this share of the power on independent phases
    // counts as some further parts. Between strong points this overestimates the scatter, as sidelobes count
    // as clutter.
    let by_clutter = inverse[(3, 3)] * metres * metres * 0.5 * clutter;
    let variance = (parts * left + CLUTTER_PARTS * by_clutter) / (parts + CLUTTER_PARTS);
    // Few parts, minus the four unknowns, estimate their own scatter poorly (Student).
    let freedom = (parts + CLUTTER_PARTS - 4.0).max(3.0);
    let variance = variance * freedom / (freedom - 2.0);
    variance.is_finite().then(|| [solution[3], variance.sqrt()])
}
