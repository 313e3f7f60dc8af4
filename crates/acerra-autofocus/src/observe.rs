//! Linear observations of the path and the points from phases and delays of echoes.

use std::ops::Range;

use nalgebra::{DMatrix, Vector3};

use crate::globals::{Effect, Global};
use crate::ground::Ground;
use crate::histories::Histories;
use crate::information::{Observations, PulseInformation};
use crate::model::Model;
use crate::parts::Parts;
use crate::ranging::Ranging;
use crate::smoother::Smoothed;

/// Least ratio of an echo's power to its variance for which phase and delay are used.
const LEAST_SIGNAL: f64 = 3.0;
/// Observables of an echo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Phase of the echo as a range, up to a constant of the point.
    Phase,
    /// Delay of the echo as a range.
    Delay,
}

/// Settings of the observations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observing<'a> {
    /// Whether phases are observed in addition to delays.
    pub phases: bool,
    /// Points whose echoes constrain the path; the echoes of other points only determine the points' own places.
    pub guides: &'a [bool],
    /// The globals.
    pub globals: &'a [Global],
    /// Deviation of a change of a point's place and of the range equivalent to the point's phase, m.
    pub place_sigma_m: f64,
}

/// One observation: a range, linear in the error of its pulse's position.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub pulse: usize,
    pub point: usize,
    /// The part of the flight that the pulse belongs to.
    part: usize,
    pub kind: Kind,
    value_m: f64,
    by_error: Vector3<f64>,
    by_place: [f64; 2],
    /// Variance by the noise, m².
    pub variance_m2: f64,
    /// Share of the inverse variance that counts.
    pub weight: f64,
}

/// All observations about a model.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    pub rows: Vec<Row>,
    pub pulses: usize,
    pub points: usize,
    /// Number of phases of each point: one a part of the flight, or zero where delays alone are observed.
    phases: usize,
    /// Prior variances of the globals.
    global_variance: Vec<f64>,
    /// Factors of the globals in each row, row after row.
    by_global: Vec<f64>,
    pixel_m: Vec<[f64; 2]>,
    place_sigma_m: f64,
    /// Factor of each point's variances: `[phase, delay]`.
    pub scale: Vec<[f64; 2]>,
}

/// The model about which observations are linearised, and constants of the radar.
pub(crate) struct LinearisationPoint<'a> {
    pub model: &'a Model,
    pub histories: &'a Histories,
    pub parts: &'a Parts,
    pub position_m: &'a [[f64; 3]],
    pub ground: &'a Ground<'a>,
    /// Wavenumber that converts phases into ranges, rad/m.
    pub carrier: f64,
    /// Range resolution, m.
    pub cell_m: f64,
}

impl Rows {
    /// Phases and delays about a model.
    pub fn about(reference: &LinearisationPoint, observing: Observing) -> Self {
        let globals = observing.globals;
        let points = reference.model.points_m(reference.ground);
        let ranging = Ranging::new(
            globals,
            &reference.model.globals,
            reference.position_m.len(),
        );
        let tangents: Vec<_> = reference
            .model
            .places
            .iter()
            .map(|p| reference.ground.tangents_m(*p))
            .collect();
        let amplitudes = observing.phases.then(|| reference.histories.coherent());
        let mut rows = Vec::new();
        let mut by_global = Vec::new();
        for (m, pulse) in reference.histories.pulses.iter().enumerate() {
            let from = Vector3::from(reference.position_m[m]);
            for (k, echo) in pulse.echoes.iter().enumerate() {
                let variance = reference.histories.noise * echo.amplitude_variance;
                let power = echo.amplitude.norm_sqr();
                if power <= LEAST_SIGNAL * variance {
                    continue;
                }
                let apart = points[k] - from;
                let sight = apart.normalize();
                let guiding = f64::from(u8::from(observing.guides[k]));
                let by_error = -sight * (ranging.slowness * guiding);
                let own = globals.iter().zip(&reference.model.globals);
                let factors: Vec<f64> = own
                    .map(|(global, value)| {
                        let of = (global, *value);
                        guiding * ranging.derivative(of, m, (&sight, apart.norm()))
                    })
                    .collect();
                // The point's own phase absorbs a delay common to all pulses of a part.
                let takes_up = |own: &Range<usize>| {
                    let part = reference.parts.about(m);
                    own.start <= part.start && part.end <= own.end
                };
                let each = factors.iter().zip(globals);
                let of_phase: Vec<f64> = each
                    .map(|(f, g)| match &g.effect {
                        Effect::Delay(own) if takes_up(own) => 0.0,
                        Effect::RiseOverSurface(own) if takes_up(own) => *f + guiding,
                        Effect::Phase(own) if own.contains(&m) => -guiding / reference.carrier,
                        _ => *f,
                    })
                    .collect();
                let by_error_m = by_error.dot(&reference.model.error_m[m]);
                let reached_m = |factors: &[f64]| {
                    let each = factors.iter().zip(&reference.model.globals);
                    by_error_m + each.map(|(f, v)| f * v).sum::<f64>()
                };
                let mut row = Row {
                    pulse: m,
                    point: k,
                    part: reference.parts.of(m),
                    kind: Kind::Delay,
                    value_m: echo
                        .delay_m
                        .clamp(-0.5 * reference.cell_m, 0.5 * reference.cell_m)
                        + reached_m(&factors),
                    by_error,
                    by_place: [0, 1].map(|a| ranging.slowness * sight.dot(&tangents[k][a])),
                    variance_m2: reference.histories.noise * echo.delay_variance_m2,
                    weight: 1.0,
                };
                if row.variance_m2.is_finite() {
                    rows.push(row.clone());
                    by_global.extend_from_slice(&factors);
                }
                let Some(coherent) = &amplitudes else {
                    continue;
                };
                let own = coherent.amplitude[m][k];
                let modulus = own.norm();
                if modulus * modulus > LEAST_SIGNAL * variance {
                    let turn = (echo.amplitude * own.conj()).arg();
                    row.kind = Kind::Phase;
                    row.value_m = -turn / reference.carrier + reached_m(&of_phase);
                    row.variance_m2 = 0.5 * variance / (modulus * reference.carrier).powi(2);
                    rows.push(row);
                    by_global.extend_from_slice(&of_phase);
                }
            }
        }
        let lengths = |t: &[Vector3<f64>; 2]| [0, 1].map(|a| t[a].norm().max(1e-9));
        Self {
            rows,
            pulses: reference.histories.pulses.len(),
            points: points.len(),
            phases: match observing.phases {
                true => reference.parts.len(),
                false => 0,
            },
            global_variance: globals.iter().map(|g| g.sigma * g.sigma).collect(),
            by_global,
            place_sigma_m: observing.place_sigma_m,
            pixel_m: tangents.iter().map(lengths).collect(),
            scale: vec![[1.0; 2]; points.len()],
        }
    }

    /// Number of parameters of each point: two of place, and the phases.
    fn per_point(&self) -> usize {
        2 + self.phases
    }

    fn parameters(&self) -> usize {
        self.points * self.per_point() + self.global_variance.len()
    }

    /// Factors of a row's parameters: the parameters of the row's point, then the globals.
    fn coefficients(&self, index: usize) -> impl Iterator<Item = (usize, f64)> {
        let row = &self.rows[index];
        let first = row.point * self.per_point();
        let of_phase = match row.kind {
            Kind::Phase => Some((first + 2 + row.part, 1.0)),
            Kind::Delay => None,
        };
        let count = self.global_variance.len();
        let shared = self.parameters() - count;
        let of_globals = &self.by_global[index * count..(index + 1) * count];
        [(first, row.by_place[0]), (first + 1, row.by_place[1])]
            .into_iter()
            .chain(of_phase)
            .chain((shared..).zip(of_globals.iter().copied()))
    }

    fn variance(&self, row: &Row) -> f64 {
        let kind = usize::from(row.kind == Kind::Delay);
        row.variance_m2 * self.scale[row.point][kind] / row.weight
    }

    /// The normal equations of all rows.
    pub fn observations(&self) -> Observations {
        let parameters = self.parameters();
        let mut pulses = vec![PulseInformation::none(parameters); self.pulses];
        let mut cross = DMatrix::zeros(1 + parameters, 1 + parameters);
        let mut terms = Vec::new();
        for (index, row) in self.rows.iter().enumerate() {
            let inverse = 1.0 / self.variance(row);
            let pulse = &mut pulses[row.pulse];
            pulse.information += row.by_error * row.by_error.transpose() * inverse;
            terms.clear();
            terms.push((0, row.value_m));
            terms.extend(self.coefficients(index).map(|(j, v)| (1 + j, v)));
            for (a, (i, v)) in terms.iter().enumerate() {
                if *v == 0.0 {
                    continue;
                }
                for axis in 0..3 {
                    pulse.right[(axis, *i)] += row.by_error[axis] * v * inverse;
                }
                for (b, (j, w)) in terms.iter().enumerate() {
                    if a <= b && *w != 0.0 {
                        let product = v * w * inverse;
                        cross[(*i, *j)] += product;
                        if a != b {
                            cross[(*j, *i)] += product;
                        }
                    }
                }
            }
        }
        Observations {
            pulses,
            cross,
            variance: self.prior_variances(),
            shared: self.global_variance.len(),
        }
    }

    fn prior_variances(&self) -> Vec<f64> {
        let mut variance = Vec::with_capacity(self.parameters());
        for pixel_m in &self.pixel_m {
            variance.extend(pixel_m.map(|side| (self.place_sigma_m / side).powi(2)));
            variance.extend(vec![self.place_sigma_m.powi(2); self.phases]);
        }
        variance.extend_from_slice(&self.global_variance);
        variance
    }

    /// Residual of a row for a solution, m.
    pub fn residual_m(&self, index: usize, found: &Smoothed) -> f64 {
        let row = &self.rows[index];
        let by_parameters: f64 = self
            .coefficients(index)
            .map(|(j, v)| v * found.parameter[j])
            .sum();
        row.value_m - row.by_error.dot(&found.error_m[row.pulse]) - by_parameters
    }

    /// The model after the step of a solution.
    pub fn apply(&self, model: &Model, found: &Smoothed) -> Model {
        let per_point = self.per_point();
        let mut next = model.clone();
        for (k, place) in next.places.iter_mut().enumerate() {
            for (a, v) in place.iter_mut().enumerate() {
                *v += found.parameter[k * per_point + a];
            }
        }
        next.error_m.clone_from(&found.error_m);
        next.force.clone_from(&found.force);
        let shared = self.parameters() - next.globals.len();
        for (j, value) in next.globals.iter_mut().enumerate() {
            *value = found.parameter[shared + j];
        }
        next
    }

    /// Weighted rms of a point's residual ranges by phase, m; `None` where the point has too few
    /// observations.
    pub fn phase_rms_m(&self, found: &Smoothed, point: usize) -> Option<f64> {
        let rows = self.rows.iter().enumerate();
        let own = rows.filter(|(_, r)| r.point == point && r.kind == Kind::Phase);
        let (sum, count) = own.fold((0.0, 0_usize), |(sum, count), (index, _)| {
            (sum + self.residual_m(index, found).powi(2), count + 1)
        });
        (count > 8).then(|| (sum / count as f64).sqrt())
    }

    /// Posterior deviations of a point's place along columns and rows, m.
    pub fn place_sigma_m(&self, covariance: &DMatrix<f64>, point: usize) -> [f64; 2] {
        let first = point * self.per_point();
        [0, 1].map(|a| {
            let variance = covariance[(first + a, first + a)];
            variance.max(0.0).sqrt() * self.pixel_m[point][a]
        })
    }
}
