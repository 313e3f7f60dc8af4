//! Probability that a target is on its side of the track, and not at the place of its ghost.
//!
//! Of a target and its mirror image the stronger counts as the target. Along a perfectly straight track both
//! are equal; bends and wander of the track distinguish them. Errors of the positions defocus the target, and
//! may leave the ghost as strong. The probability of this is found from errors drawn from the deviations and
//! the correlation that the positions state.

use std::f64::consts::TAU;

use acerra_autofocus::PositionPrior;
use acerra_imaging::metrics::{Ghost, Target};
use nalgebra::{DMatrix, Matrix3};
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::autofocus::AutofocusOptions;
use crate::echoes::history::{Measured, distance_m};
use crate::journal::finding::{Finding, Verdict};
use crate::prepare::Prepared;

/// Targets that are looked at: the strongest, down to this level (dB).
const STRONGEST: usize = 10;
const LEAST_LEVEL_DB: f64 = -20.0;

/// Draws of errors.
const DRAWS: usize = 200;

/// Pulses and frequencies that represent all.
const MOST_PULSES: usize = 256;
const FREQUENCIES: usize = 8;

/// Pulses whose echo is weaker than this share of the strongest do not see the target.
const LEAST_ECHO: f64 = 0.05;

/// Where about a place its maximum is looked for, in resolutions along and across the track.
const ALONG: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];
const ACROSS: [f64; 3] = [-0.5, 0.0, 0.5];

/// Resolutions of a target whose image does not determine them (m).
const USUAL_RESOLUTION_M: [f64; 2] = [0.05, 0.4];

/// Standard deviation of a ghost's level about the predicted level for positions without errors: antennas and
/// reflectors that the point spread function does not include, a decibel.
const MODEL_SIGMA: f64 = 0.115;

/// Judges the sides of the strongest targets; none where no target has a ghost.
pub(super) fn weigh(prepared: &Prepared, targets: &[Target]) -> Option<Finding> {
    target_side(&sides(prepared, targets))
}

/// Data on each of the strongest targets that has a ghost.
fn sides(prepared: &Prepared, targets: &[Target]) -> Vec<SideSeen> {
    let prior = prepared
        .position_prior(&AutofocusOptions::default())
        .ok()
        .map(|(prior, _)| prior);
    let looked_at = targets
        .iter()
        .filter(|target| target.level_db >= LEAST_LEVEL_DB)
        .take(STRONGEST);
    let with_ghosts: Vec<(&Target, &Ghost)> = looked_at
        .filter_map(|target| Some((target, target.ghost.as_ref()?)))
        .collect();
    with_ghosts
        .par_iter()
        .filter_map(|(target, ghost)| {
            let aperture = Aperture::of(prepared, prior.as_ref(), target)?;
            Some(SideSeen {
                place_m: [target.x_m, target.y_m],
                risk: aperture.risk(target, ghost, ghost_height_m(prepared, target, ghost)),
            })
        })
        .collect()
}

/// Height of the image where a ghost is (m).
fn ghost_height_m(prepared: &Prepared, target: &Target, ghost: &Ghost) -> f64 {
    match &prepared.scene.pixels.surface {
        Some(_) => prepared.scene.ground.below_m(ghost.x_m, ghost.y_m),
        None => target.z_m,
    }
}

/// The pulses that see a target, and the errors of their positions.
struct Aperture {
    position_m: Vec<[f64; 3]>,
    /// Amplitude with which each pulse counts.
    weight: Vec<f64>,
    /// Phase of a metre of range, both ways, at some frequencies of the band (rad/m).
    phase_rad_m: Vec<f64>,
    errors: Option<Errors>,
}

/// Errors of the positions of an aperture: square roots of their covariance and of their correlation.
struct Errors {
    root_m: Vec<Matrix3<f64>>,
    correlation_root: DMatrix<f64>,
}

impl Aperture {
    fn of(prepared: &Prepared, prior: Option<&PositionPrior>, target: &Target) -> Option<Self> {
        let spectrum = &prepared.spectrum;
        let (position_m, path_m) = (&prepared.aligned.position_m, &prepared.aligned.path_m);
        let light_speed_m_s = prepared.scene.light_speed_m_s;
        let measured = Measured::part(position_m, spectrum, 0..position_m.len(), light_speed_m_s)?;
        let power: Vec<f64> = measured
            .history([target.x_m, target.y_m, target.z_m])
            .iter()
            .map(Complex64::norm_sqr)
            .collect();
        // The weakest quarter gives the clutter.
        let mut sorted = power.clone();
        sorted.sort_by(f64::total_cmp);
        let clutter = *sorted.get(sorted.len() / 4)?;
        let echo: Vec<f64> = power
            .iter()
            .map(|p| (p - clutter).max(0.0).sqrt())
            .collect();
        let least = LEAST_ECHO * echo.iter().copied().fold(0.0, f64::max);
        let seeing: Vec<usize> = (0..echo.len()).filter(|m| echo[*m] > least).collect();
        let step = seeing.len().div_ceil(MOST_PULSES).max(1);
        let pulses: Vec<usize> = seeing.into_iter().step_by(step).collect();
        let has_paths = path_m.len() == echo.len() && path_m.iter().any(|path| *path > 0.0);
        let weight = |m: &usize| echo[*m] * if has_paths { path_m[*m] } else { 1.0 };
        let (low, high) = (
            *spectrum.frequency_hz.first()?,
            *spectrum.frequency_hz.last()?,
        );
        let phase_rad_m = |n: usize| {
            let share = (n as f64 + 0.5) / FREQUENCIES as f64;
            2.0 * TAU * (low + share * (high - low)) / light_speed_m_s
        };
        (pulses.len() > 1).then(|| Self {
            position_m: pulses.iter().map(|m| position_m[*m]).collect(),
            weight: pulses.iter().map(weight).collect(),
            phase_rad_m: (0..FREQUENCIES).map(phase_rad_m).collect(),
            errors: prior.and_then(|prior| Errors::of(prior, &pulses)),
        })
    }

    /// Probability that the target is at the place of its ghost.
    ///
    /// The level of a ghost relative to its target, in nepers, is normal about the mean of the draws, and
    /// about the negative mean if target and ghost are exchanged.
    fn risk(&self, target: &Target, ghost: &Ghost, ghost_height_m: f64) -> f64 {
        let at_m = [target.x_m, target.y_m, target.z_m];
        let ghost_m = [ghost.x_m, ghost.y_m, ghost_height_m];
        let resolution_m = [
            target.along.rayleigh_m.unwrap_or(USUAL_RESOLUTION_M[0]),
            target.across.rayleigh_m.unwrap_or(USUAL_RESOLUTION_M[1]),
        ];
        let ratios = self.ghost_ratios(at_m, ghost_m, resolution_m);
        let count = ratios.len() as f64;
        let exchanged = ratios.iter().filter(|ratio| **ratio >= 0.0).count() as f64 / count;
        let expected = ratios.iter().sum::<f64>() / count;
        let variance = ratios.iter().map(|r| (r - expected).powi(2)).sum::<f64>() / count;
        if expected >= 0.0 || !expected.is_finite() {
            return 0.5;
        }
        let odds = 2.0 * ghost.level.ln() * expected / (variance + MODEL_SIGMA * MODEL_SIGMA);
        exchanged.max(1.0 / (1.0 + odds.exp()))
    }

    /// Levels of the maximum about the ghost's place over that about the target's (nepers), one for each
    /// draw of errors.
    fn ghost_ratios(&self, at_m: [f64; 3], ghost_m: [f64; 3], resolution_m: [f64; 2]) -> Vec<f64> {
        let about_target = self.phasors_about(at_m, at_m, resolution_m);
        let about_ghost = self.phasors_about(ghost_m, at_m, resolution_m);
        let strongest = |places: &[Vec<Complex64>], echoes: &[Complex64]| {
            let level = |phasors: &Vec<Complex64>| {
                let terms = phasors.iter().zip(echoes);
                terms.map(|(p, e)| p * e).sum::<Complex64>().norm()
            };
            places.iter().map(level).fold(0.0, f64::max)
        };
        let ratio = |range_error_m: &Vec<f64>| {
            let echoes = self.echoes(range_error_m);
            (strongest(&about_ghost, &echoes) / strongest(&about_target, &echoes)).ln()
        };
        self.range_errors_m(at_m).iter().map(ratio).collect()
    }

    /// Draws of the errors of the pulses' ranges to a point (m); zero alone where the positions state no
    /// errors.
    fn range_errors_m(&self, point_m: [f64; 3]) -> Vec<Vec<f64>> {
        let Some(errors) = &self.errors else {
            return vec![vec![0.0; self.position_m.len()]];
        };
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let towards = self.position_m.iter().zip(&errors.root_m);
        let gain: Vec<[f64; 3]> = towards
            .map(|(p, root)| {
                let range_m = distance_m(*p, point_m).max(f64::MIN_POSITIVE);
                let unit =
                    nalgebra::Vector3::from(std::array::from_fn(|i| (p[i] - point_m[i]) / range_m));
                (root.transpose() * unit).into()
            })
            .collect();
        (0..DRAWS)
            .map(|_| {
                let white = DMatrix::from_fn(gain.len(), 3, |_, _| normal(&mut random));
                let lasting = &errors.correlation_root * white;
                let along =
                    |(m, gain): (usize, &[f64; 3])| (0..3).map(|i| gain[i] * lasting[(m, i)]).sum();
                gain.iter().enumerate().map(along).collect()
            })
            .collect()
    }

    /// Phase of each pulse and frequency in the image at places about `centre_m`, relative to the phase at
    /// `origin_m`.
    fn phasors_about(
        &self,
        centre_m: [f64; 3],
        origin_m: [f64; 3],
        resolution_m: [f64; 2],
    ) -> Vec<Vec<Complex64>> {
        let tangent = self.tangent();
        let places = ALONG
            .iter()
            .flat_map(|along| ACROSS.map(|across| (along, across)));
        places
            .map(|(along, across)| {
                let (a, c) = (along * resolution_m[0], across * resolution_m[1]);
                let place_m = [
                    centre_m[0] + a * tangent[0] - c * tangent[1],
                    centre_m[1] + a * tangent[1] + c * tangent[0],
                    centre_m[2],
                ];
                let pulses = self.position_m.iter().zip(&self.weight);
                pulses
                    .flat_map(|(p, weight)| {
                        let longer_m = distance_m(*p, place_m) - distance_m(*p, origin_m);
                        let turn = move |k: &f64| Complex64::from_polar(*weight, k * longer_m);
                        self.phase_rad_m.iter().map(turn)
                    })
                    .collect()
            })
            .collect()
    }

    /// Echoes of a point with errors of range, relative to the echoes without errors.
    fn echoes(&self, range_error_m: &[f64]) -> Vec<Complex64> {
        let of_pulse = |error_m: &f64| {
            let error_m = *error_m;
            let turn = move |k: &f64| Complex64::from_polar(1.0, -k * error_m);
            self.phase_rad_m.iter().map(turn)
        };
        range_error_m.iter().flat_map(of_pulse).collect()
    }

    /// Direction from the first to the last pulse, level; along x where that has no length.
    fn tangent(&self) -> [f64; 2] {
        let (first, last) = (
            self.position_m[0],
            self.position_m[self.position_m.len() - 1],
        );
        let way_m = [last[0] - first[0], last[1] - first[1]];
        let length_m = way_m[0].hypot(way_m[1]);
        if length_m > 0.0 {
            way_m.map(|w| w / length_m)
        } else {
            [1.0, 0.0]
        }
    }
}

impl Errors {
    fn of(prior: &PositionPrior, pulses: &[usize]) -> Option<Self> {
        let root = |m: &usize| {
            let covariance = Matrix3::from_fn(|i, j| prior.covariance_m2[*m][i][j]);
            let deviations = covariance.diagonal().map(|v| v.max(0.0).sqrt());
            covariance
                .cholesky()
                .map_or(Matrix3::from_diagonal(&deviations), |root| root.l())
        };
        let count = pulses.len();
        // A thousandth of the variance is each pulse's own: equal times must not make the matrix singular.
        let correlation = DMatrix::from_fn(count, count, |i, j| {
            let apart = prior.abscissa[pulses[i]] - prior.abscissa[pulses[j]];
            0.999 * prior.correlation.at(apart) + if i == j { 1e-3 } else { 0.0 }
        });
        Some(Self {
            root_m: pulses.iter().map(root).collect(),
            correlation_root: correlation.cholesky()?.unpack(),
        })
    }
}

/// A number of a normal distribution of unit variance, by the transform of Box and Muller.
fn normal(random: &mut impl Rng) -> f64 {
    let (u, v) = (1.0 - random.random::<f64>(), random.random::<f64>());
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}

/// Probabilities that targets are on their side of the track.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SideSeen {
    /// Place of the target (x, y), m.
    pub place_m: [f64; 2],
    /// Probability that the target is at the place of its ghost.
    pub risk: f64,
}

impl SideSeen {
    /// Risk from which a target's side is doubtful.
    pub const DOUBTFUL_RISK: f64 = 0.01;
}

/// Judges the sides of the strongest targets; none where no target has a ghost.
fn target_side(seen: &[SideSeen]) -> Option<Finding> {
    let worst = seen.iter().max_by(|a, b| a.risk.total_cmp(&b.risk))?;
    let is_doubtful = |target: &&SideSeen| target.risk > SideSeen::DOUBTFUL_RISK;
    let doubtful = seen.iter().filter(is_doubtful).count();
    let (verdict, what) = if doubtful == 0 {
        let what = "bends and wander of the track distinguish it from its ghost".to_owned();
        (Verdict::Agrees, what)
    } else {
        let what = format!(
            "the track is too straight, for positions with the deviations stated, to determine the side of \
             {doubtful} of the {} strongest targets with a ghost: each may as well be at the place of its \
             ghost. A bent track, a second track parallel to this one or a surveyed point determines the \
             side",
            seen.len()
        );
        (Verdict::Doubtful, what)
    };
    let [x_m, y_m] = worst.place_m;
    let risk = match worst.risk {
        risk if risk < SideSeen::DOUBTFUL_RISK => "less than 0.01".to_owned(),
        risk => format!("{risk:.2}"),
    };
    let finding = Finding::judged("target_side", worst.risk, "probability", verdict)
        .expecting(0.0)
        .because(format!(
            "the target at ({x_m:.2}, {y_m:.2}) m is on the other side of the track with a probability of \
             {risk}: {what}"
        ));
    Some(finding)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_is_doubtful_where_any_target_s_is() {
        let seen = |risk: f64| SideSeen {
            place_m: [4.0, -5.97],
            risk,
        };
        assert_eq!(target_side(&[]), None);
        let sure = target_side(&[seen(1e-6), seen(1e-3)]).map(|f| (f.verdict, f.value));
        assert_eq!(sure, Some((Verdict::Agrees, Some(1e-3))));
        let unsure = target_side(&[seen(1e-6), seen(0.07)]).map(|f| (f.verdict, f.value));
        assert_eq!(unsure, Some((Verdict::Doubtful, Some(0.07))));
    }
}
