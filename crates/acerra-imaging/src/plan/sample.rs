//! Random lines of sight from pulses to pixels, by which costs and errors are judged.

use crate::grid::terrain::Terrain;
use crate::grid::tilted::TiltedGrid;
use crate::pulses::Pulses;
use crate::sampling::Random;
use crate::vector::{dot, norm};

/// A pulse seen from a pixel.
pub(super) struct Sight {
    pub range_m: f64,
    /// Changes of the range along the row and across: over a plane the sines of the angles from the line of sight's
    /// normal plane.
    pub sine: [f64; 2],
}

/// Random pairs of pulse and pixel.
pub(super) struct Sample(Vec<Sight>);

impl Sample {
    /// Draws pairs of a pulse and a sample of a grid.
    pub fn draw(pulses: &Pulses, grid: &TiltedGrid, terrain: Terrain) -> Self {
        let mut random = Random(0x9e37_79b9);
        Self(
            (0..256)
                .map(|_| {
                    let p = pulses.position_m()[random.below(pulses.len())];
                    let (i, j) = (random.below(grid.columns), random.below(grid.rows));
                    let (i, j) = (i as f64, j as f64);
                    let point = terrain.near_m(grid, i, j);
                    let d = std::array::from_fn(|a| point[a] - p[a]);
                    let range_m = norm(d).max(1e-12);
                    Sight {
                        range_m,
                        sine: terrain
                            .axes(grid, i, j)
                            .map(|axis| (dot(d, axis) / range_m).abs()),
                    }
                })
                .collect(),
        )
    }

    /// Root mean square of the sines along an axis.
    pub fn rms_sine(&self, axis: usize) -> f64 {
        let sum: f64 = self.0.iter().map(|s| s.sine[axis].powi(2)).sum();
        (sum / self.0.len() as f64).sqrt()
    }

    /// Relative RMS error of the bistatic spreading S²/(R_t R_r), with ranges R_t and R_r of mean S, at
    /// `away_m` from the place where the spreading is computed.
    ///
    /// With the antennas' half distance b and u along it from their middle, the spreading is 1/(1 − b²u²/S⁴), whose
    /// gradient is at most about 2 b²/S³.
    pub fn spreading_error(&self, half_apart_m: f64, away_m: f64) -> f64 {
        let error = |s: &Sight| 2.0 * half_apart_m.powi(2) * away_m / s.range_m.powi(3);
        let sum: f64 = self.0.iter().map(|s| error(s).powi(2)).sum();
        (sum / self.0.len() as f64).sqrt()
    }

    /// Share of the lines of sight that meet a condition.
    pub fn share(&self, f: impl Fn(&Sight) -> bool) -> f64 {
        self.0.iter().filter(|s| f(s)).count() as f64 / self.0.len() as f64
    }
}
