//! Rays to a level plane below level ground, as functions of the straight distance.
//!
//! For one pulse and one depth the optical length depends on the horizontal distance alone, and so on the straight
//! distance R that kernels compute: range tables hold, at R, the pulse's profile at the optical length P(R) times the
//! weight of the ray. P and the logarithm of the amplitude are analytic in R, on the scale of the antenna's height.

use crate::grid::image::ImageGrid;
use crate::pulses::Pulses;
use crate::refraction::{Ground, MAX_LAYERS};
use std::f64::consts::PI;
use std::ops::Range;

/// Distance of the knots between which rays are interpolated, in heights of the antenna: cubic interpolation then
/// leaves some 10⁻⁸ of the height.
const KNOTS_PER_HEIGHT: f64 = 32.0;

/// Two-way amplitude factor of absorption at the frequency of the rays, over half a path of these lengths.
pub(crate) fn transmitted(
    ground: &Ground,
    soil_m: &[f64; MAX_LAYERS],
    light_speed_m_s: f64,
) -> f64 {
    let f = ground.ray_frequency_hz();
    (4.0 * PI * f / light_speed_m_s * ground.dispersion_m(f, soil_m).im).exp()
}

/// A ray of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LawPoint {
    /// Optical length, m.
    pub optical_m: f64,
    /// One-way amplitude by transmission and spreading, 1/m.
    pub amplitude: f64,
    /// Amplitude left by absorption both ways.
    pub transmitted: f64,
    /// Cosine of the angle from the vertical at the antenna.
    pub cosine: f64,
}

impl LawPoint {
    fn of([optical_m, amplitude, transmitted, cosine]: [f64; 4]) -> Self {
        Self {
            optical_m,
            amplitude,
            transmitted,
            cosine,
        }
    }
}

/// The rays from all pulses to a level plane below level ground.
#[derive(Debug, Clone)]
pub(crate) struct LevelLaw {
    ground: Ground,
    light_speed_m_s: f64,
    /// Depth of the plane below the surface, m.
    depth_m: f64,
    /// Heights of the antennas above the surface, m.
    height_m: Vec<f64>,
}

impl LevelLaw {
    /// Of a grid that is level and below a level surface; `None` of any other.
    pub fn new(pulses: &Pulses, grid: &ImageGrid) -> Option<Self> {
        let ground = pulses.ground()?;
        let z_m = ground.level_m().filter(|_| grid.is_level())?;
        let depth_m = z_m - grid.plane().origin_m[2];
        (depth_m > 0.0).then(|| Self {
            ground: ground.clone(),
            light_speed_m_s: pulses.light_speed_m_s(),
            depth_m,
            height_m: pulses.position_m().iter().map(|p| p[2] - z_m).collect(),
        })
    }

    /// That of some pulses.
    pub fn slice(&self, range: Range<usize>) -> Self {
        Self {
            ground: self.ground.clone(),
            height_m: self.height_m[range].to_vec(),
            ..*self
        }
    }

    /// The law of a pulse up to the distance `farthest_m`, tabulated.
    pub fn tabulated(&self, pulse: usize, farthest_m: f64) -> Knots {
        let vertical_m = [self.height_m[pulse], self.depth_m];
        Knots::new(&self.ground, self.light_speed_m_s, vertical_m, farthest_m)
    }
}

/// Rays at even distances, interpolated by cubics through four of them.
#[derive(Debug, Clone)]
pub(crate) struct Knots {
    nearest_m: f64,
    per_m: f64,
    knots: Vec<[f64; 4]>,
}

impl Knots {
    /// Rays up to the straight distance `farthest_m` from an antenna `height_m` above a level surface to a plane
    /// `depth_m` below it.
    pub fn new(
        ground: &Ground,
        light_speed_m_s: f64,
        [height_m, depth_m]: [f64; 2],
        farthest_m: f64,
    ) -> Self {
        let nearest_m = height_m + depth_m;
        let step_m = height_m / KNOTS_PER_HEIGHT;
        let stack = ground.stack(height_m, depth_m);
        let knot = |k: usize| {
            let range_m = nearest_m + k as f64 * step_m;
            let across_m2 = (range_m - nearest_m) * (range_m + nearest_m);
            let ray = stack.ray(across_m2.sqrt());
            [
                ray.optical_m,
                ray.amplitude,
                transmitted(ground, &ray.soil_m, light_speed_m_s),
                ray.cosine,
            ]
        };
        Self {
            nearest_m,
            per_m: 1.0 / step_m,
            knots: (0..Self::count([height_m, depth_m], farthest_m))
                .map(knot)
                .collect(),
        }
    }

    /// Number of rays up to `farthest_m`, three of them beyond.
    pub fn count([height_m, depth_m]: [f64; 2], farthest_m: f64) -> usize {
        let beyond_m = (farthest_m - height_m - depth_m).max(0.0);
        (beyond_m * KNOTS_PER_HEIGHT / height_m).ceil() as usize + 4
    }

    /// Least distance, m, and knots in a metre.
    pub fn scale(&self) -> [f64; 2] {
        [self.nearest_m, self.per_m]
    }

    /// The rays that are tabulated.
    pub fn points(&self) -> impl Iterator<Item = LawPoint> + '_ {
        self.knots.iter().map(|knot| LawPoint::of(*knot))
    }

    /// The ray at a distance; below the height of the antenna above the plane, where no pixel lies, the cubic goes on.
    pub fn at(&self, range_m: f64) -> LawPoint {
        let place = (range_m - self.nearest_m) * self.per_m;
        let last = self.knots.len() - 4;
        let first = ((place - 1.0).max(0.0) as usize).min(last);
        let t = place - first as f64;
        let (a, b, c, d) = (t, t - 1.0, t - 2.0, t - 3.0);
        let weights = [
            b * c * d / -6.0,
            a * c * d / 2.0,
            a * b * d / -2.0,
            a * b * c / 6.0,
        ];
        let mut sum = [0.0; 4];
        for (weight, knot) in weights.iter().zip(&self.knots[first..first + 4]) {
            for (sum, value) in sum.iter_mut().zip(knot) {
                *sum += weight * value;
            }
        }
        LawPoint::of(sum)
    }
}
