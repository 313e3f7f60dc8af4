//! The coarse grids of a factorized image and the way between them and the fine one.

use super::interpolation::{BEFORE, TAPS, interpolation_weights};
use super::spec::{FactorizedSpec, cut};
use crate::Pulses;
use crate::rows::{TiltedGrid, norm};
use crate::simd::MAX_LANES;
use crate::simd::turn::TurnRow;
use std::f64::consts::PI;

/// Interpolation weights and phases, the same for all sub-apertures.
#[derive(Debug)]
pub(crate) struct Lattice {
    pub spec: FactorizedSpec,
    turns_a_metre: f64,
    /// Weights of every phase of an interval, along the row and across.
    pub weights: [Vec<[f32; TAPS]>; 2],
    cosine: [f32; 6],
    sine: [f32; 6],
}

impl Lattice {
    /// For images on `grid`, with the carrier `carrier_hz` taken out.
    pub fn new(pulses: &Pulses, grid: &TiltedGrid, spec: FactorizedSpec, carrier_hz: f64) -> Self {
        let steps = [norm(grid.u_m), norm(grid.v_m)];
        let weights = [0, 1].map(|axis| {
            let d = spec.coarse[axis];
            let nu = spec.bandwidth_a_metre[axis] * steps[axis] * d as f64;
            (0..d)
                .map(|p| {
                    let x = BEFORE as f64 + p as f64 / d as f64;
                    interpolation_weights(x, nu).0.map(|w| w as f32)
                })
                .collect()
        });
        let (cosine, sine) = turn_polynomials();
        Self {
            spec,
            turns_a_metre: 2.0 * carrier_hz / pulses.light_speed_m_s(),
            weights,
            cosine,
            sine,
        }
    }

    /// Row `j` of a grid as the phase of the range to `centre_m` needs it.
    pub fn turn(&self, grid: &TiltedGrid, j: usize, centre_m: [f64; 3]) -> TurnRow {
        let start = grid.point_m(0.0, j as f64);
        let pixel_m = norm(grid.u_m).max(1e-12);
        TurnRow {
            from_centre_m: std::array::from_fn(|a| start[a] - centre_m[a]),
            unit: grid.u_m.map(|u| u / pixel_m),
            pixel_m,
            turns_a_metre: self.turns_a_metre,
            cosine: self.cosine,
            sine: self.sine,
        }
    }
}

/// The coarse grid that covers `grid`.
pub(crate) fn coarse_grid(grid: &TiltedGrid, coarse: [usize; 2]) -> TiltedGrid {
    let before = |d: usize| -((BEFORE * d) as f64);
    let intervals = grid.columns.div_ceil(coarse[0]).next_multiple_of(MAX_LANES);
    TiltedGrid {
        origin_m: grid.point_m(before(coarse[0]), before(coarse[1])),
        u_m: grid.u_m.map(|x| x * coarse[0] as f64),
        v_m: grid.v_m.map(|x| x * coarse[1] as f64),
        columns: intervals + TAPS,
        rows: grid.rows.div_ceil(coarse[1]) + TAPS,
    }
}

/// Bytes of the coarse images of a run.
pub(crate) fn coarse_bytes(spec: &FactorizedSpec, grid: &TiltedGrid, pulses: &Pulses) -> u128 {
    let coarse = coarse_grid(grid, spec.coarse);
    let pixels = coarse.columns.next_multiple_of(MAX_LANES) as u128 * coarse.rows as u128;
    // One more, complex, is in the making.
    pixels * 8 * (cut(pulses, spec.pulses).len() as u128 + 1)
}

/// Polynomials in x² of cos 2πx and sin(2πx)/x for |x| ≤ ½, by interpolation at Chebyshev nodes.
fn turn_polynomials() -> ([f32; 6], [f32; 6]) {
    let cosine = crate::direct::even_polynomial(|x| (2.0 * PI * x).cos(), 6);
    let sine = crate::direct::even_polynomial(|x| (2.0 * PI * x).sin() / x, 6);
    (cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_close() {
        let (cosine, sine) = turn_polynomials();
        for k in -50..=50 {
            let x = k as f32 / 100.0;
            let at = |c: [f32; 6]| c.iter().rev().fold(0.0, |sum, c| sum * x * x + c);
            let angle = 2.0 * std::f32::consts::PI * x;
            assert!((at(cosine) - angle.cos()).abs() < 3e-6);
            assert!((at(sine) * x - angle.sin()).abs() < 3e-6);
        }
    }
}
