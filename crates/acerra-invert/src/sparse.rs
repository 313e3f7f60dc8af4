//! Sparse scenes by FISTA (Beck & Teboulle 2009), complex, over one track or a group of tracks.
//!
//! min ½ Σ_t ‖L_t y_t − d_t‖² + λ Σ_i (Σ_t |y_ti|²)^½: with one track the complex ℓ1 norm, with several a
//! pixel is dark or bright in all tracks while its reflectivity may differ from track to track.

use crate::error::{InvertError, check_length, check_range};
use crate::history::{History, Iteration, Stop};
use crate::operator::LinearOperator;
use crate::vector::{inner, norm, power, scale};
use acerra_imaging::{Complex64, Control, Progress};
use rayon::prelude::*;

/// Requirements on a sparse solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparseOptions {
    /// λ.
    pub lambda: f64,
    /// Most iterations.
    pub max_iterations: usize,
    /// Duality gap over ½‖d‖² below which the solution has converged.
    pub tolerance: f64,
}

/// A scene a track and how they were found.
#[derive(Debug, Clone)]
pub struct SparseSolution {
    /// The scenes, one a track.
    pub scenes: Vec<Vec<Complex64>>,
    /// Pixels that are not zero.
    pub support: usize,
    /// The iterations.
    pub history: History,
}

/// One track: its operator and its data.
#[derive(Clone, Copy)]
pub struct TrackData<'a> {
    /// Operator of the track.
    pub operator: &'a dyn LinearOperator,
    /// Data of the track.
    pub data: &'a [Complex64],
}

/// The greatest λ with a scene that is not zero: max_i (Σ_t |L_t⁺ d_t|²)^½.
///
/// # Errors
/// Errors of the operators, cancellation.
pub fn greatest_lambda(tracks: &[TrackData], control: Control) -> Result<f64, InvertError> {
    let mut images = Vec::new();
    for track in tracks {
        let mut image = vec![Complex64::ZERO; track.operator.pixels()];
        track.operator.adjoint(track.data, &mut image, control)?;
        images.push(image);
    }
    Ok(greatest_group(&images))
}

/// Bytes that a sparse solution takes, excluding the data.
#[must_use]
pub fn sparse_bytes(tracks: &[TrackData]) -> u128 {
    const VALUE: u128 = size_of::<Complex64>() as u128;
    let own = |track: &TrackData| {
        (7 * track.operator.pixels() + 6 * track.operator.samples()) as u128 * VALUE
    };
    let working = tracks.iter().map(|t| t.operator.working_bytes()).max();
    tracks.iter().map(own).sum::<u128>() + working.unwrap_or(0)
}

/// Computes the sparse scenes of one or more tracks over the same pixels.
///
/// # Errors
/// No track, tracks of different pixels, parameters without a meaning, errors of the operators,
/// cancellation.
pub fn solve_sparse(
    tracks: &[TrackData],
    options: &SparseOptions,
    control: Control,
) -> Result<SparseSolution, InvertError> {
    check_range("lambda", "above 0", options.lambda, options.lambda > 0.0)?;
    let Some(first) = tracks.first() else {
        return Err(InvertError::NoSignal { what: "no track" });
    };
    let pixels = first.operator.pixels();
    for track in tracks {
        check_length("pixels of a track", pixels, track.operator.pixels())?;
        check_length("data", track.operator.samples(), track.data.len())?;
    }
    let mut search = Search::start(tracks, options.lambda, control.silent())?;
    let mut iterations: Vec<Iteration> = Vec::new();
    let mut stop = Stop::Iterations;
    for number in 1..=options.max_iterations {
        let gap = search.step(control.silent())?;
        let residual = search.residual_norm() / search.data_norm;
        iterations.push(Iteration {
            number,
            residual,
            change: gap,
        });
        control.report(Progress {
            done: number as u64,
            total: options.max_iterations as u64,
        });
        if gap <= options.tolerance {
            stop = Stop::Converged;
            break;
        }
    }
    let scenes: Vec<Vec<Complex64>> = search.states.into_iter().map(|state| state.y).collect();
    let is_bright = |i: &usize| scenes.iter().any(|scene| scene[*i] != Complex64::ZERO);
    Ok(SparseSolution {
        support: (0..pixels).into_par_iter().filter(is_bright).count(),
        scenes,
        history: History { iterations, stop },
    })
}

/// The iterate of one track.
struct State {
    y: Vec<Complex64>,
    before: Vec<Complex64>,
    /// L y, and L applied to the previous iterate.
    model: Vec<Complex64>,
    model_before: Vec<Complex64>,
    /// The point that the gradient step starts from, then the new iterate.
    point: Vec<Complex64>,
}

struct Search<'a> {
    tracks: &'a [TrackData<'a>],
    states: Vec<State>,
    lambda: f64,
    lipschitz: f64,
    momentum: f64,
    data_norm: f64,
}

/// Iterations of the power method that bound ‖L‖².
const POWER_ITERATIONS: usize = 8;

impl<'a> Search<'a> {
    fn start(
        tracks: &'a [TrackData<'a>],
        lambda: f64,
        control: Control,
    ) -> Result<Self, InvertError> {
        let data_power: f64 = tracks.iter().map(|track| power(track.data)).sum();
        if !(data_power > 0.0 && data_power.is_finite()) {
            return Err(InvertError::NoSignal { what: "the data" });
        }
        let mut lipschitz: f64 = 0.0;
        for track in tracks {
            lipschitz = lipschitz.max(greatest_eigenvalue(track, control)?);
        }
        let state = |track: &TrackData| {
            let (n, m) = (track.operator.pixels(), track.operator.samples());
            State {
                y: vec![Complex64::ZERO; n],
                before: vec![Complex64::ZERO; n],
                model: vec![Complex64::ZERO; m],
                model_before: vec![Complex64::ZERO; m],
                point: vec![Complex64::ZERO; n],
            }
        };
        Ok(Self {
            tracks,
            states: tracks.iter().map(state).collect(),
            lambda,
            lipschitz,
            momentum: 1.0,
            data_norm: data_power.sqrt(),
        })
    }

    /// ‖d − L y‖ over all tracks.
    fn residual_norm(&self) -> f64 {
        let of = |(state, track): (&State, &TrackData)| distance_power(&state.model, track.data);
        self.states
            .iter()
            .zip(self.tracks)
            .map(of)
            .sum::<f64>()
            .sqrt()
    }

    /// One accelerated step; the duality gap at the point that it starts from, over ½‖d‖².
    fn step(&mut self, control: Control) -> Result<f64, InvertError> {
        let next = 0.5 * (1.0 + (1.0 + 4.0 * self.momentum * self.momentum).sqrt());
        let ahead = (self.momentum - 1.0) / next;
        let mut residuals = Vec::new();
        let mut gradients = Vec::new();
        for (state, track) in self.states.iter_mut().zip(self.tracks) {
            state.extrapolate(ahead);
            let at = state.model_ahead(ahead);
            let residual: Vec<Complex64> = at.iter().zip(track.data).map(|(a, d)| a - d).collect();
            let mut gradient = vec![Complex64::ZERO; track.operator.pixels()];
            track.operator.adjoint(&residual, &mut gradient, control)?;
            residuals.push(residual);
            gradients.push(gradient);
        }
        let gap = self.gap(&residuals, &gradients);
        let started_at: f64 = residuals.iter().map(|r| 0.5 * power(r)).sum();
        loop {
            let mut trial: Vec<Vec<Complex64>> = self
                .states
                .iter()
                .zip(&gradients)
                .map(|(state, gradient)| moved(&state.point, gradient, -self.lipschitz.recip()))
                .collect();
            shrink_groups(&mut trial, self.lambda / self.lipschitz);
            let mut models = Vec::new();
            let mut misfit = 0.0;
            let mut bound = started_at;
            for (k, track) in self.tracks.iter().enumerate() {
                let mut model = vec![Complex64::ZERO; track.operator.samples()];
                track.operator.forward(&trial[k], &mut model, control)?;
                misfit += 0.5 * distance_power(&model, track.data);
                let by = moved(&trial[k], &self.states[k].point, -1.0);
                bound += inner(&gradients[k], &by).re + 0.5 * self.lipschitz * power(&by);
                models.push(model);
            }
            // The bound ‖L‖² was too small where the quadratic model does not hold.
            if misfit > bound + 1e-9 * self.data_norm * self.data_norm {
                self.lipschitz *= 1.5;
                continue;
            }
            self.accept(trial, models, next);
            return Ok(gap);
        }
    }

    /// Takes the new iterates; the momentum starts again where it leads uphill (O'Donoghue & Candès
    /// 2015).
    fn accept(&mut self, trial: Vec<Vec<Complex64>>, models: Vec<Vec<Complex64>>, next: f64) {
        let mut uphill = 0.0;
        for ((state, new), model) in self.states.iter_mut().zip(trial).zip(models) {
            let step = moved(&state.point, &new, -1.0);
            let travelled = moved(&new, &state.y, -1.0);
            uphill += inner(&step, &travelled).re;
            state.before = std::mem::replace(&mut state.y, new);
            state.model_before = std::mem::replace(&mut state.model, model);
        }
        self.momentum = if uphill > 0.0 { 1.0 } else { next };
    }

    /// Primal objective less that of the dual point θ = r·min(1, λ/max‖L⁺r‖), over ½‖d‖².
    fn gap(&self, residuals: &[Vec<Complex64>], gradients: &[Vec<Complex64>]) -> f64 {
        let misfit: f64 = residuals.iter().map(|r| 0.5 * power(r)).sum();
        let points: Vec<&[Complex64]> = self.states.iter().map(|s| s.point.as_slice()).collect();
        let primal = misfit + self.lambda * group_norm(&points);
        let factor = (self.lambda / greatest_group(gradients).max(f64::MIN_POSITIVE)).min(1.0);
        // θ = −factor·(L z − d): the dual objective is ½‖d‖² − ½‖d − θ‖².
        let apart: f64 = residuals
            .iter()
            .zip(self.tracks)
            .map(|(r, track)| {
                let pairs = r.iter().zip(track.data);
                pairs.map(|(r, d)| (d + r * factor).norm_sqr()).sum::<f64>()
            })
            .sum();
        let whole = 0.5 * self.data_norm * self.data_norm;
        (primal - (whole - 0.5 * apart)).max(0.0) / whole
    }
}

impl State {
    /// `point` = y + ahead·(y − before).
    fn extrapolate(&mut self, ahead: f64) {
        self.point
            .par_iter_mut()
            .zip(&self.y)
            .zip(&self.before)
            .for_each(|((point, y), before)| *point = y + (y - before) * ahead);
    }

    /// L of that point.
    fn model_ahead(&self, ahead: f64) -> Vec<Complex64> {
        let pairs = self.model.iter().zip(&self.model_before);
        pairs
            .map(|(now, before)| now + (now - before) * ahead)
            .collect()
    }
}

/// a + factor·b.
fn moved(a: &[Complex64], b: &[Complex64], factor: f64) -> Vec<Complex64> {
    let pairs = a.par_iter().zip(b);
    pairs.map(|(a, b)| a + b * factor).collect()
}

fn distance_power(a: &[Complex64], b: &[Complex64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm_sqr()).sum()
}

fn group_power(scenes: &[impl AsRef<[Complex64]>], i: usize) -> f64 {
    scenes
        .iter()
        .map(|scene| scene.as_ref()[i].norm_sqr())
        .sum()
}

fn greatest_group(scenes: &[Vec<Complex64>]) -> f64 {
    let pixels = scenes.first().map_or(0, Vec::len);
    let most = (0..pixels)
        .into_par_iter()
        .map(|i| group_power(scenes, i))
        .reduce(|| 0.0, f64::max);
    most.sqrt()
}

fn group_norm(scenes: &[&[Complex64]]) -> f64 {
    let pixels = scenes.first().map_or(0, |s| s.len());
    (0..pixels).map(|i| group_power(scenes, i).sqrt()).sum()
}

/// Soft threshold of the group of every pixel.
fn shrink_groups(scenes: &mut [Vec<Complex64>], by: f64) {
    if let [one] = scenes {
        one.par_iter_mut()
            .for_each(|v| *v *= kept_share(v.norm(), by));
        return;
    }
    let pixels = scenes.first().map_or(0, Vec::len);
    let kept: Vec<f64> = (0..pixels)
        .into_par_iter()
        .map(|i| kept_share(group_power(scenes, i).sqrt(), by))
        .collect();
    for scene in scenes {
        scene
            .par_iter_mut()
            .zip(&kept)
            .for_each(|(v, kept)| *v *= *kept);
    }
}

fn kept_share(modulus: f64, by: f64) -> f64 {
    if modulus > by {
        1.0 - by / modulus
    } else {
        0.0
    }
}

/// ‖L‖², approached from below by the power method on the data, with a margin.
fn greatest_eigenvalue(track: &TrackData, control: Control) -> Result<f64, InvertError> {
    let mut scene = vec![Complex64::ZERO; track.operator.pixels()];
    let mut data = track.data.to_vec();
    let mut value: f64 = 0.0;
    for _ in 0..POWER_ITERATIONS {
        track.operator.adjoint(&data, &mut scene, control)?;
        let length = norm(&scene);
        if !(length > 0.0 && length.is_finite()) {
            return Err(InvertError::NoSignal { what: "the image" });
        }
        scale(&mut scene, length.recip());
        track.operator.forward(&scene, &mut data, control)?;
        value = power(&data);
    }
    Ok(1.1 * value)
}
