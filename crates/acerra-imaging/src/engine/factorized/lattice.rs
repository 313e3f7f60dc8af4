//! Interpolation weights and carrier phases between the coarse grids and the fine one.

use super::coarse::Coarse;
use super::interpolation::{Interpolator, before};
use super::spec::Stage;
use crate::engine::polynomials::even_polynomial;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::merge::{MOST_TAPS, Stencil};
use crate::kernel::phase::PhaseRow;
use crate::pulses::Pulses;
use crate::vector::norm;
use std::f64::consts::PI;

/// Interpolation weights and phases, the same for all sub-apertures.
#[derive(Debug)]
pub(crate) struct Lattice {
    pub stage: Stage,
    cycles_per_m: f64,
    /// Weights of every pixel of a cell, along the row and across.
    pub weights: [Vec<[f32; MOST_TAPS]>; 2],
    /// Interpolation weights along the row and across, in the form that merging reads.
    pub stencils: [Stencil; 2],
    cosine: [f32; 6],
    sine: [f32; 6],
}

impl Lattice {
    /// The lattice for images on `grid`, with the phase of the carrier `carrier_hz` removed.
    pub fn new(pulses: &Pulses, grid: &TiltedGrid, stage: Stage, carrier_hz: f64) -> Self {
        let steps = [norm(grid.u_m), norm(grid.v_m)];
        let weights: [Vec<[f32; MOST_TAPS]>; 2] = [0, 1].map(|axis: usize| {
            let Coarse { cells, taps } = stage.coarse;
            let cell = cells[axis];
            let nu = stage.bandwidth_per_m[axis] * steps[axis] * cell.interval();
            let interpolator = Interpolator::new(taps, nu);
            (0..cell.pixels)
                .map(|p| match cell.fraction(p) {
                    0.0 => std::array::from_fn(|k| if k == before(taps) { 1.0 } else { 0.0 }),
                    f => interpolator
                        .weights(before(taps) as f64 + f)
                        .map(|w| w as f32),
                })
                .collect()
        });
        let stencils = [0, 1].map(|axis: usize| {
            let cell = stage.coarse.cells[axis];
            Stencil::new(&weights[axis], |pixel| cell.sample_before(pixel))
        });
        let (cosine, sine) = phase_polynomials();
        Self {
            stage,
            cycles_per_m: 2.0 * carrier_hz / pulses.light_speed_m_s(),
            weights,
            stencils,
            cosine,
            sine,
        }
    }

    /// Row `j` of a grid, ready for the carrier's phase at the range to `centre_m`.
    pub fn phase_row(&self, grid: &TiltedGrid, j: usize, centre_m: [f64; 3]) -> PhaseRow {
        let start = grid.point_m(0.0, j as f64);
        let pixel_m = norm(grid.u_m).max(1e-12);
        PhaseRow {
            from_centre_m: std::array::from_fn(|a| start[a] - centre_m[a]),
            unit: grid.u_m.map(|u| u / pixel_m),
            pixel_m,
            cycles_per_m: self.cycles_per_m,
            cosine: self.cosine,
            sine: self.sine,
        }
    }
}

/// Polynomials in x² of cos 2πx and sin(2πx)/x for |x| ≤ ½, by interpolation at Chebyshev nodes.
fn phase_polynomials() -> ([f32; 6], [f32; 6]) {
    let cosine = even_polynomial(|x| (2.0 * PI * x).cos(), 6);
    let sine = even_polynomial(|x| (2.0 * PI * x).sin() / x, 6);
    (cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phase_polynomials_are_close() {
        let (cosine, sine) = phase_polynomials();
        for k in -50..=50 {
            let x = k as f32 / 100.0;
            let at = |c: [f32; 6]| c.iter().rev().fold(0.0, |sum, c| sum * x * x + c);
            let angle = 2.0 * std::f32::consts::PI * x;
            assert!((at(cosine) - angle.cos()).abs() < 3e-6);
            assert!((at(sine) * x - angle.sin()).abs() < 3e-6);
        }
    }
}
