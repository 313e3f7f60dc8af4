//! Geometry of a target: first-order effect of range errors on its peak.

use std::f64::consts::PI;

use super::model::ErrorModel;
use crate::error::ImagingError;
use crate::metrics::track::LocalTrack;
use crate::psf::analysis::track_at;
use crate::psf::cell::Cell;
use crate::psf::spread::PointSpread;

/// Nodes and weights of the six-point Gauss–Legendre rule on [−1, 1]: the band, taken as evenly
/// filled, is integrated rather than summed.
const BAND_NODES: [[f64; 2]; 6] = [
    [-0.932_469_514_203_152, 0.171_324_492_379_170],
    [-0.661_209_386_466_265, 0.360_761_573_048_139],
    [-0.238_619_186_083_197, 0.467_913_934_572_691],
    [0.238_619_186_083_197, 0.467_913_934_572_691],
    [0.661_209_386_466_265, 0.360_761_573_048_139],
    [0.932_469_514_203_152, 0.171_324_492_379_170],
];

/// More pulses than this are thinned for the theory's double sums; the power of their speckle is corrected by
/// [`View::speckle_scale`].
const MOST_PULSES: usize = 700;

/// The pulses that enter the theory, with their lines of sight to the target.
pub(super) struct View {
    /// Indices of the pulses.
    pub pulse: Vec<usize>,
    /// Share of each pulse in the peak; they add up to 1.
    pub share: Vec<f64>,
    /// Unit vectors from antenna to target.
    pub sight: Vec<[f64; 3]>,
    /// Change of range per metre along and across the track, one pair a pulse.
    pub gradient: Vec<[f64; 2]>,
    /// Two-way wavenumbers 4πf/c of the quadrature, rad/m, and their weights (sum 1).
    pub wavenumber: Vec<[f64; 2]>,
    pub track: LocalTrack,
    pub cell: Cell,
    /// Whether the across-track place of the peak is determined to first order: false for a target under the
    /// track, where the range does not change across the track.
    pub across_known: bool,
    /// Σ share² of all pulses over Σ share² of the pulses kept.
    pub speckle_scale: f64,
}

impl View {
    pub fn of(
        spread: &PointSpread,
        target_m: [f64; 3],
        model: &ErrorModel,
    ) -> Result<Self, ImagingError> {
        let position_m = spread.position_m();
        crate::checks::check_length("the error model", position_m.len(), model.len())?;
        let (low, high) = spread.band_hz();
        if high <= low {
            let (what, expected) = ("bandwidth_hz", "above 0 Hz");
            return Err(ImagingError::OutOfRange {
                what,
                expected,
                found: high - low,
            });
        }
        let track = track_at(spread, target_m)?;
        let cell = Cell::expected(spread, &track, target_m);

        let weight = |m: usize| {
            let range2: f64 = (0..3)
                .map(|i| (position_m[m][i] - target_m[i]).powi(2))
                .sum();
            spread.weight()[m] / (range2 * range2)
        };
        // Pulses without weight have no share in a peak.
        let all: Vec<usize> = (0..position_m.len()).filter(|m| weight(*m) > 0.0).collect();
        let pulse: Vec<usize> = all
            .iter()
            .copied()
            .step_by(all.len().div_ceil(MOST_PULSES).max(1))
            .collect();
        let total: f64 = pulse.iter().map(|m| weight(*m)).sum();
        if !(total.is_finite() && total > 0.0) {
            return Err(ImagingError::Empty {
                what: "the response to the target",
            });
        }
        let share: Vec<f64> = pulse.iter().map(|m| weight(*m) / total).collect();
        let all_total: f64 = all.iter().map(|m| weight(*m)).sum();
        let whole: f64 = all.iter().map(|m| (weight(*m) / all_total).powi(2)).sum();
        let kept: f64 = share.iter().map(|w| w * w).sum();

        let sight: Vec<[f64; 3]> = pulse
            .iter()
            .map(|m| {
                let d = [0, 1, 2].map(|i| target_m[i] - position_m[*m][i]);
                let range = d.iter().map(|v| v * v).sum::<f64>().sqrt();
                d.map(|v| v / range)
            })
            .collect();
        let (ahead, left) = (track.tangent, track.left());
        let gradient = sight
            .iter()
            .map(|u| {
                [
                    u[0] * ahead[0] + u[1] * ahead[1],
                    u[0] * left[0] + u[1] * left[1],
                ]
            })
            .collect();
        let wavenumber = BAND_NODES
            .iter()
            .map(|[node, weight]| {
                let f = 0.5 * (low + high) + 0.5 * (high - low) * node;
                [4.0 * PI * f / spread.light_speed_m_s(), 0.5 * weight]
            })
            .collect();
        Ok(Self {
            pulse,
            share,
            sight,
            gradient,
            wavenumber,
            across_known: track.offset_m.abs() > cell.across_m,
            track,
            cell,
            speckle_scale: whole / kept,
        })
    }

    /// Covariance of the range errors of the kept pulses, m², row-major.
    pub fn covariance_m2(&self, model: &ErrorModel) -> Vec<f64> {
        let n = self.pulse.len();
        let pair = |a: usize, b: usize| {
            model.covariance_m2(self.pulse[a], self.pulse[b], self.sight[a], self.sight[b])
        };
        (0..n * n).map(|k| pair(k / n, k % n)).collect()
    }

    /// The linear map from range errors to the shift of the peak (along, across), `[2, pulses]`.
    ///
    /// The peak moves to the place where the phases k(g·Δ − ε) of all pulses and frequencies agree best:
    /// least squares of their variance, which is k̄² Var(g·Δ − ε) + Var(k) E[(g·Δ − ε)²] over pulses.
    pub fn shift_map(&self) -> [Vec<f64>; 2] {
        let moment = |p: i32| -> f64 { self.wavenumber.iter().map(|[k, v]| v * k.powi(p)).sum() };
        let (mean2, variance) = (moment(1).powi(2), moment(2) - moment(1).powi(2));
        let mean: [f64; 2] = [0, 1].map(|i| {
            self.share
                .iter()
                .zip(&self.gradient)
                .map(|(w, g)| w * g[i])
                .sum()
        });
        let row = |i: usize| -> Vec<f64> {
            self.share
                .iter()
                .zip(&self.gradient)
                .map(|(w, g)| w * (mean2 * (g[i] - mean[i]) + variance * g[i]))
                .collect()
        };
        let rows = [row(0), row(1)];
        let normal = |i: usize, j: usize| -> f64 {
            rows[i]
                .iter()
                .zip(&self.gradient)
                .map(|(b, g)| b * g[j])
                .sum()
        };
        let inverse = self.invert([[normal(0, 0), normal(0, 1)], [normal(1, 0), normal(1, 1)]]);
        inverse.unwrap_or_default().map(|[p, q]| {
            rows[0]
                .iter()
                .zip(&rows[1])
                .map(|(x, y)| p * x + q * y)
                .collect()
        })
    }

    /// The inverse of a 2 × 2 matrix over (along, across); of the first element alone where the across-track
    /// place is not determined. `None` where neither place is determined.
    pub fn invert(&self, m: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
        let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        if self.across_known && determinant > 1e-12 * (m[0][0] * m[1][1]).abs() {
            let d = determinant;
            Some([[m[1][1] / d, -m[0][1] / d], [-m[1][0] / d, m[0][0] / d]])
        } else {
            (m[0][0] > 0.0).then(|| [[1.0 / m[0][0], 0.0], [0.0, 0.0]])
        }
    }

    /// Covariance of the errors that remain after the shift of the peak: (I − GH) C (I − GH)ᵀ.
    pub fn residual_m2(&self, c: &[f64], h: &[Vec<f64>; 2]) -> Vec<f64> {
        let n = self.pulse.len();
        // D = (I − GH) C, then D (I − GH)ᵀ. C is symmetric: HC by rows of C.
        let hc: Vec<[f64; 2]> = c
            .chunks(n)
            .map(|row| [dot(row, &h[0]), dot(row, &h[1])])
            .collect();
        let mut d = c.to_vec();
        for (row, g) in d.chunks_mut(n).zip(&self.gradient) {
            for (v, hc) in row.iter_mut().zip(&hc) {
                *v -= g[0] * hc[0] + g[1] * hc[1];
            }
            let dh = [dot(row, &h[0]), dot(row, &h[1])];
            for (v, g) in row.iter_mut().zip(&self.gradient) {
                *v -= dh[0] * g[0] + dh[1] * g[1];
            }
        }
        d
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
