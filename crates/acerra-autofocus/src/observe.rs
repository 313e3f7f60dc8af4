//! Linear observations of the path and the points from phases and delays of echoes.

use nalgebra::{DMatrix, Vector3};

use crate::ground::Ground;
use crate::histories::Histories;
use crate::information::{Observations, PulseInformation};
use crate::model::Model;
use crate::smoother::Smoothed;

/// Power of an echo over its variance from which its phase and delay are taken.
const LEAST_SIGNAL: f64 = 3.0;
/// Prior deviation of a change of place: about what a point may be off where it was found (m).
const PLACE_SIGMA_M: f64 = 0.5;
/// What is observed of an echo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Its phase, as a range, up to a constant of the point.
    Phase,
    /// Its delay, as a range.
    Delay,
}

/// How observations are made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observing<'a> {
    /// Whether phases are observed beside delays.
    pub phases: bool,
    /// Points whose echoes tell of the path; the others only find their own places.
    pub guides: &'a [bool],
    /// Prior deviation of the delay that all share, m.
    pub delay_sigma_m: f64,
}

/// One observation: a range, linear in the error of its pulse's position.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub pulse: usize,
    pub point: usize,
    pub kind: Kind,
    value_m: f64,
    by_error: Vector3<f64>,
    by_place: [f64; 2],
    /// Variance by the noise, m², and the share of its inverse that counts.
    pub variance_m2: f64,
    pub weight: f64,
}

/// All observations about a model.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    pub rows: Vec<Row>,
    pub pulses: usize,
    pub points: usize,
    phases: bool,
    delay_sigma_m: f64,
    pixel_m: Vec<[f64; 2]>,
    /// Factor of each point's variances: `[phase, delay]`.
    pub scale: Vec<[f64; 2]>,
}

/// What rows are made about.
pub(crate) struct Standpoint<'a> {
    pub model: &'a Model,
    pub histories: &'a Histories,
    pub position_m: &'a [[f64; 3]],
    pub ground: &'a Ground<'a>,
    /// Wavenumber that turns phases into ranges, rad/m, and the range resolution, m.
    pub carrier: f64,
    pub cell_m: f64,
}

impl Rows {
    /// Phases and delays about a model.
    pub fn about(stand: &Standpoint, observing: Observing) -> Self {
        let points = stand.model.points_m(stand.ground);
        let tangents: Vec<_> = stand
            .model
            .places
            .iter()
            .map(|p| stand.ground.tangents_m(*p))
            .collect();
        let amplitudes = observing.phases.then(|| stand.histories.coherent());
        let mut rows = Vec::new();
        for (m, pulse) in stand.histories.pulses.iter().enumerate() {
            let from = Vector3::from(stand.position_m[m]);
            for (k, echo) in pulse.echoes.iter().enumerate() {
                let variance = stand.histories.noise * echo.amplitude_variance;
                let power = echo.amplitude.norm_sqr();
                if power <= LEAST_SIGNAL * variance {
                    continue;
                }
                let sight = (points[k] - from).normalize();
                let by_error = if observing.guides[k] {
                    -sight
                } else {
                    Vector3::zeros()
                };
                let reached_m = by_error.dot(&stand.model.error_m[m]);
                let mut row = Row {
                    pulse: m,
                    point: k,
                    kind: Kind::Delay,
                    value_m: echo.delay_m.clamp(-0.5 * stand.cell_m, 0.5 * stand.cell_m)
                        + reached_m
                        + stand.model.delay_m,
                    by_error,
                    by_place: [0, 1].map(|a| sight.dot(&tangents[k][a])),
                    variance_m2: stand.histories.noise * echo.delay_variance_m2,
                    weight: 1.0,
                };
                if row.variance_m2.is_finite() {
                    rows.push(row.clone());
                }
                let Some(coherent) = &amplitudes else {
                    continue;
                };
                let modulus = coherent.modulus[m][k];
                if modulus * modulus > LEAST_SIGNAL * variance {
                    let turn = (echo.amplitude * coherent.phase[k].conj()).arg();
                    row.kind = Kind::Phase;
                    row.value_m = -turn / stand.carrier + reached_m;
                    row.variance_m2 = 0.5 * variance / (modulus * stand.carrier).powi(2);
                    rows.push(row);
                }
            }
        }
        let lengths = |t: &[Vector3<f64>; 2]| [0, 1].map(|a| t[a].norm().max(1e-9));
        Self {
            rows,
            pulses: stand.histories.pulses.len(),
            points: points.len(),
            phases: observing.phases,
            delay_sigma_m: observing.delay_sigma_m,
            pixel_m: tangents.iter().map(lengths).collect(),
            scale: vec![[1.0; 2]; points.len()],
        }
    }

    /// Parameters: two of place and, where phases are observed, one of phase for each point; then
    /// the delay, where it is unknown.
    fn per_point(&self) -> usize {
        2 + usize::from(self.phases)
    }

    fn parameters(&self) -> usize {
        self.points * self.per_point() + usize::from(self.delay_sigma_m > 0.0)
    }

    /// Coefficients of a row: indices of parameters with factors.
    fn coefficients(&self, row: &Row) -> [(usize, f64); 4] {
        let first = row.point * self.per_point();
        let last = self.parameters() - 1;
        let of_phase = f64::from(u8::from(row.kind == Kind::Phase));
        let of_delay = f64::from(u8::from(
            row.kind == Kind::Delay && self.delay_sigma_m > 0.0,
        ));
        [
            (first, row.by_place[0]),
            (first + 1, row.by_place[1]),
            (
                first + self.per_point() - 1,
                if self.phases { of_phase } else { 0.0 },
            ),
            (last, of_delay),
        ]
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
        for row in &self.rows {
            let inverse = 1.0 / self.variance(row);
            let pulse = &mut pulses[row.pulse];
            pulse.information += row.by_error * row.by_error.transpose() * inverse;
            let mut terms = [(0, row.value_m); 5];
            for (term, (j, v)) in terms[1..].iter_mut().zip(self.coefficients(row)) {
                *term = (1 + j, v);
            }
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
        }
    }

    fn prior_variances(&self) -> Vec<f64> {
        let mut variance = Vec::with_capacity(self.parameters());
        for pixel_m in &self.pixel_m {
            variance.extend(pixel_m.map(|side| (PLACE_SIGMA_M / side).powi(2)));
            if self.phases {
                variance.push(PLACE_SIGMA_M.powi(2));
            }
        }
        if self.delay_sigma_m > 0.0 {
            variance.push(self.delay_sigma_m.powi(2));
        }
        variance
    }

    /// What a solution leaves of a row, m.
    pub fn residual_m(&self, row: &Row, found: &Smoothed) -> f64 {
        let by_parameters: f64 = self
            .coefficients(row)
            .iter()
            .map(|(j, v)| {
                if *v == 0.0 {
                    0.0
                } else {
                    v * found.parameter[*j]
                }
            })
            .sum();
        row.value_m - row.by_error.dot(&found.error_m[row.pulse]) - by_parameters
    }

    /// The model that a solution leads to.
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
        if self.delay_sigma_m > 0.0 {
            next.delay_m = found.parameter[self.parameters() - 1];
        }
        next
    }

    /// Weighted rms of a point's residual ranges by phase, m; none where it has too few.
    pub fn phase_rms_m(&self, found: &Smoothed, point: usize) -> Option<f64> {
        let own = self
            .rows
            .iter()
            .filter(|r| r.point == point && r.kind == Kind::Phase);
        let (sum, count) = own.fold((0.0, 0_usize), |(sum, count), row| {
            (sum + self.residual_m(row, found).powi(2), count + 1)
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
