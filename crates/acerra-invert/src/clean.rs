//! CLEAN with the true, place-dependent point spread (Högbom 1974; in major and minor cycles, Schwab
//! 1984).
//!
//! A minor cycle subtracts components at the local maxima of the residual image by their exact overlaps ⟨Lᵢ,
//! Lⱼ⟩, one term a pulse; a major cycle subtracts their exact echoes from the data and images the residual.
//! No gridded or shift-invariant beam is used.

use crate::error::{InvertError, check_length, check_range};
use crate::flight::Flight;
use crate::history::{History, Iteration, Stop};
use crate::operator::LinearOperator;
use crate::vector::{greatest, norm};
use acerra_imaging::{Complex64, Control, ImageGrid, Progress};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Requirements on CLEAN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CleanOptions {
    /// Share of a maximum that is taken off at a time.
    pub gain: f64,
    /// Correlation |⟨Lᵢ, r⟩|/‖Lᵢ‖ at which it stops.
    pub threshold: f64,
    /// Most major cycles.
    pub max_cycles: usize,
    /// Most components.
    pub max_components: usize,
}

/// A point that was taken off the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component {
    /// Index of its pixel.
    pub pixel: usize,
    /// Position of the component, m.
    pub point_m: [f64; 3],
    /// Its reflectivity.
    pub reflectivity: Complex64,
}

/// Components, and the residual.
#[derive(Debug, Clone)]
pub struct CleanSolution {
    /// The components, by pixel.
    pub components: Vec<Component>,
    /// The image of the residual data, as the reflectivity that a point would need: ⟨Lᵢ, r⟩/‖Lᵢ‖².
    pub residual: Vec<Complex64>,
    /// The major cycles; their `change` is the greatest remaining correlation over that of the data.
    pub history: History,
}

/// Depth of a minor cycle: maxima above this share of the greatest are used, and cleaned down to it.
const MINOR_DEPTH: f64 = 0.5;
/// Most maxima of a minor cycle.
const MINOR_MAXIMA: usize = 160;
/// Most steps of a minor cycle.
const MINOR_STEPS: usize = 4000;
/// Major cycles without progress that end the search.
const STALLED_CYCLES: usize = 3;

/// What CLEAN works on.
pub struct CleanInput<'a> {
    /// The flight.
    pub flight: &'a Flight,
    /// Its operator with even columns: y with σ = D y.
    pub operator: &'a dyn LinearOperator,
    /// D.
    pub weight: &'a [f32],
    /// The pixels.
    pub grid: ImageGrid<'a>,
    /// Weighted data.
    pub data: &'a [Complex64],
}

/// Subtracts points from the data until no maximum exceeds the threshold.
///
/// # Errors
/// Parameters without a meaning, arrays of other lengths, errors of the operator, cancellation.
pub fn clean(
    input: &CleanInput<'_>,
    options: &CleanOptions,
    control: Control,
) -> Result<CleanSolution, InvertError> {
    let (operator, grid) = (input.operator, &input.grid);
    check_length("pixels", operator.pixels(), grid.len())?;
    check_length("weight", operator.pixels(), input.weight.len())?;
    check_length("data", operator.samples(), input.data.len())?;
    let gain = options.gain;
    check_range(
        "gain",
        "above 0 and at most 1",
        gain,
        gain > 0.0 && gain <= 1.0,
    )?;
    let threshold = options.threshold;
    check_range("threshold", "above 0", threshold, threshold > 0.0)?;
    let silent = control.silent();
    let data_norm = norm(input.data);
    let mut residual = input.data.to_vec();
    let mut image = vec![Complex64::ZERO; operator.pixels()];
    operator.adjoint(&residual, &mut image, silent)?;
    let first = greatest(&image).1;
    if !(first > 0.0 && first.is_finite()) {
        return Err(InvertError::NoSignal { what: "the image" });
    }
    let mut found: BTreeMap<usize, Complex64> = BTreeMap::new();
    let mut iterations = Vec::new();
    let (mut best, mut stalled) = (first, 0);
    let mut stop = Stop::Iterations;
    for number in 1..=options.max_cycles {
        let peak = greatest(&image).1;
        if peak <= threshold {
            stop = Stop::Noise;
            break;
        }
        if found.len() >= options.max_components {
            break;
        }
        let room = options.max_components - found.len();
        let taken = minor_cycle(input, &image, options, room);
        for (pixel, amplitude) in taken {
            let point_m = grid.point_m(pixel % grid.columns(), pixel / grid.columns());
            let reflectivity = amplitude * f64::from(input.weight[pixel]);
            input.flight.add_echo(point_m, -reflectivity, &mut residual);
            *found.entry(pixel).or_default() += reflectivity;
        }
        operator.adjoint(&residual, &mut image, silent)?;
        let left = greatest(&image).1;
        iterations.push(Iteration {
            number,
            residual: norm(&residual) / data_norm,
            change: left / first,
        });
        control.report(Progress {
            done: number as u64,
            total: options.max_cycles as u64,
        });
        stalled = if left < 0.98 * best { 0 } else { stalled + 1 };
        best = best.min(left);
        if stalled >= STALLED_CYCLES {
            stop = Stop::Stalled;
            break;
        }
    }
    image
        .par_iter_mut()
        .zip(input.weight)
        .for_each(|(v, w)| *v *= f64::from(*w));
    let component = |(pixel, reflectivity): (usize, Complex64)| Component {
        pixel,
        point_m: grid.point_m(pixel % grid.columns(), pixel / grid.columns()),
        reflectivity,
    };
    Ok(CleanSolution {
        components: found.into_iter().map(component).collect(),
        residual: image,
        history: History { iterations, stop },
    })
}

/// Cleans the highest maxima of a residual image against one another; amplitudes of unit-norm columns by
/// pixel.
fn minor_cycle(
    input: &CleanInput<'_>,
    image: &[Complex64],
    options: &CleanOptions,
    room: usize,
) -> Vec<(usize, Complex64)> {
    let grid = &input.grid;
    let level = (MINOR_DEPTH * greatest(image).1).max(options.threshold);
    let maxima = local_maxima(image, grid, level, MINOR_MAXIMA.min(room.max(1)));
    let points: Vec<[f64; 3]> = maxima
        .iter()
        .map(|k| grid.point_m(k % grid.columns(), k / grid.columns()))
        .collect();
    let weight: Vec<f64> = maxima.iter().map(|k| f64::from(input.weight[*k])).collect();
    let overlaps: Vec<Vec<Complex64>> = points
        .par_iter()
        .zip(&weight)
        .map(|(a, wa)| {
            let with = points.iter().zip(&weight);
            with.map(|(b, wb)| input.flight.overlap(*a, *b) * (wa * wb))
                .collect()
        })
        .collect();
    let mut left: Vec<Complex64> = maxima.iter().map(|k| image[*k]).collect();
    let mut taken = vec![Complex64::ZERO; maxima.len()];
    for _ in 0..MINOR_STEPS {
        let (k, most) = greatest(&left);
        if most <= level {
            break;
        }
        let amplitude = left[k] * options.gain;
        taken[k] += amplitude;
        for (value, overlap) in left.iter_mut().zip(&overlaps) {
            *value -= overlap[k] * amplitude;
        }
    }
    let pairs = maxima.into_iter().zip(taken);
    pairs.filter(|(_, a)| *a != Complex64::ZERO).collect()
}

/// The pixels that exceed `level` and their eight neighbours, at most `most`, highest first.
fn local_maxima(image: &[Complex64], grid: &ImageGrid, level: f64, most: usize) -> Vec<usize> {
    let (nx, ny) = (grid.columns(), grid.rows());
    let power = |i: usize, j: usize| image[j * nx + i].norm_sqr();
    let is_maximum = |k: usize| {
        let (i, j) = (k % nx, k / nx);
        let here = image[k].norm_sqr();
        if here < level * level {
            return false;
        }
        let columns = i.saturating_sub(1)..(i + 2).min(nx);
        (j.saturating_sub(1)..(j + 2).min(ny)).all(|row| {
            columns.clone().all(|column| {
                // Of equal neighbours the first is the maximum.
                let other = power(column, row);
                other < here || (other <= here && row * nx + column >= k)
            })
        })
    };
    let mut maxima: Vec<usize> = (0..image.len())
        .into_par_iter()
        .filter(|k| is_maximum(*k))
        .collect();
    maxima.sort_by(|a, b| image[*b].norm_sqr().total_cmp(&image[*a].norm_sqr()));
    maxima.truncate(most);
    maxima
}
