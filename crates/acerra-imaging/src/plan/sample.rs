//! Random lines of sight from pulses to pixels, by which costs and errors are judged.

use crate::grid::tilted::TiltedGrid;
use crate::pulses::Pulses;
use crate::sampling::Random;
use crate::vector::{dot, norm};

/// A pulse seen from a pixel.
pub(super) struct Sight {
    pub range_m: f64,
    /// Sines of the angles to row and column from the line of sight's normal plane.
    pub sine: [f64; 2],
}

/// Random pairs of pulse and pixel.
pub(super) struct Sample(Vec<Sight>);

impl Sample {
    /// For pulses and pixels of a grid.
    pub fn draw(pulses: &Pulses, grid: &TiltedGrid) -> Self {
        let mut random = Random(0x9e37_79b9);
        let axes = [grid.u_m, grid.v_m].map(|v| v.map(|x| x / norm(v).max(1e-12)));
        Self(
            (0..256)
                .map(|_| {
                    let p = pulses.position_m()[random.below(pulses.len())];
                    let (i, j) = (random.below(grid.columns), random.below(grid.rows));
                    let point = grid.point_m(i as f64, j as f64);
                    let d = std::array::from_fn(|a| point[a] - p[a]);
                    let range_m = norm(d).max(1e-12);
                    Sight {
                        range_m,
                        sine: axes.map(|axis| (dot(d, axis) / range_m).abs()),
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

    /// Share of the lines of sight that meet a condition.
    pub fn share(&self, f: impl Fn(&Sight) -> bool) -> f64 {
        self.0.iter().filter(|s| f(s)).count() as f64 / self.0.len() as f64
    }
}
