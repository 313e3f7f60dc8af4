//! Rays to a level plane below level ground, as functions of the straight distance.
//!
//! For one pulse and one depth the optical length depends on the horizontal distance alone, and so on the straight
//! distance R that kernels compute: range tables hold, at R, the pulse's profile at the optical length P(R) times the
//! weight of the ray. P and the logarithm of the amplitude are analytic in R, on the scale of the antenna's height.

use crate::grid::image::ImageGrid;
use crate::pulses::Pulses;
use crate::refraction::{Ground, MAX_LAYERS};
use crate::vector::norm;
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::ops::Range;

/// Distance of the knots between which rays are interpolated, in heights of the antenna: cubic interpolation then
/// leaves some 10⁻⁸ of the height.
const KNOTS_PER_HEIGHT: f64 = 32.0;

/// Least rays that a thread traces at a time.
const RAYS_A_TASK: usize = 256;

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

/// The rays from the antennas of all pulses to a level plane below level ground.
#[derive(Debug, Clone)]
pub(crate) struct LevelLaw {
    ground: Ground,
    light_speed_m_s: f64,
    /// Depth of the plane below the surface, m.
    depth_m: f64,
    /// Heights above the surface of the antenna of every pulse, or of its transmitter and receiver, m.
    height_m: Vec<f64>,
    /// Antennas of a pulse.
    antennas: usize,
    /// Sides of a pixel, m.
    pixel_m: [f64; 2],
}

impl LevelLaw {
    /// Of a grid that is level and below a level surface; `None` of any other.
    pub fn new(pulses: &Pulses, grid: &ImageGrid) -> Option<Self> {
        let ground = pulses.ground()?;
        let z_m = ground.level_m().filter(|_| grid.is_level())?;
        let depth_m = z_m - grid.plane().origin_m[2];
        let antennas = 1 + usize::from(pulses.is_bistatic());
        let height_m = |m: usize| pulses.antennas_m(m).into_iter().take(antennas);
        (depth_m > 0.0).then(|| Self {
            ground: ground.clone(),
            light_speed_m_s: pulses.light_speed_m_s(),
            depth_m,
            height_m: (0..pulses.len())
                .flat_map(|m| height_m(m).map(|antenna_m| antenna_m[2] - z_m))
                .collect(),
            antennas,
            pixel_m: [grid.plane().u_m, grid.plane().v_m].map(norm),
        })
    }

    /// Whether transmitter and receiver have separate rays.
    pub fn is_apart(&self) -> bool {
        self.antennas > 1
    }

    /// Heights above the surface of the antennas of a pulse, m.
    pub fn heights_m(&self, pulse: usize) -> &[f64] {
        &self.height_m[self.antennas * pulse..][..self.antennas]
    }

    /// Sides of a pixel, m.
    pub fn pixel_m(&self) -> [f64; 2] {
        self.pixel_m
    }

    /// That of some pulses.
    pub fn slice(&self, range: Range<usize>) -> Self {
        Self {
            ground: self.ground.clone(),
            height_m: self.height_m[range.start * self.antennas..range.end * self.antennas]
                .to_vec(),
            ..*self
        }
    }

    /// The rays of some pulses, each up to the straight distance that `farthest_m` gives, tabulated, and the index into
    /// these of every antenna of every pulse.
    pub fn tabulated(
        &self,
        which: Range<usize>,
        farthest_m: impl Fn(usize) -> f64,
    ) -> (Vec<Knots>, Vec<usize>) {
        let heights = self.equal_heights(which, farthest_m);
        let knots = heights.tabulated(&self.ground, self.light_speed_m_s, self.depth_m);
        (knots, heights.of_antenna)
    }

    /// Numbers of rays and of tables of [`LevelLaw::tabulated`].
    pub fn rays(&self, which: Range<usize>, farthest_m: impl Fn(usize) -> f64) -> [u128; 2] {
        let heights = self.equal_heights(which, farthest_m);
        [heights.rays(self.depth_m), heights.heights_m.len() as u128]
    }

    fn equal_heights(
        &self,
        which: Range<usize>,
        farthest_m: impl Fn(usize) -> f64,
    ) -> EqualHeights {
        let heights = which.flat_map(|m| {
            let farthest_m = farthest_m(m);
            (self.heights_m(m).iter()).map(move |height_m| [*height_m, farthest_m])
        });
        EqualHeights::of(heights)
    }

    /// Bounds (m) of half the optical length of every pulse's ways, from those of the straight distances of its antennas.
    pub fn half_ways_m(&self, distances_m: &[Vec<[f64; 2]>]) -> Vec<[f64; 2]> {
        let share = 1.0 / self.antennas as f64;
        let of_pulse = |m: usize| {
            let mut half_m = [0.0; 2];
            for (height_m, distances_m) in self.heights_m(m).iter().zip(distances_m) {
                let stack = self.ground.stack(*height_m, self.depth_m);
                let down_m = height_m + self.depth_m;
                for (half_m, distance_m) in half_m.iter_mut().zip(distances_m[m]) {
                    let across_m2 = (distance_m - down_m) * (distance_m + down_m);
                    *half_m += share * stack.ray(across_m2.max(0.0).sqrt()).optical_m;
                }
            }
            half_m
        };
        (0..self.height_m.len() / self.antennas)
            .into_par_iter()
            .map(of_pulse)
            .collect()
    }
}

/// Antennas by their height above the surface: those of equal height share their rays.
#[derive(Debug)]
pub(crate) struct EqualHeights {
    /// Every height, and the greatest straight distance from its antennas to the plane, m.
    heights_m: Vec<[f64; 2]>,
    /// Index into the heights of every antenna.
    pub of_antenna: Vec<usize>,
}

impl EqualHeights {
    /// Of antennas at these heights above the surface, with their greatest straight distances to the plane, m.
    pub fn of(antennas_m: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let mut heights_m: Vec<[f64; 2]> = Vec::new();
        let mut known: HashMap<u64, usize> = HashMap::new();
        let mut index = |[height_m, farthest_m]: [f64; 2]| {
            let k = *known.entry(height_m.to_bits()).or_insert(heights_m.len());
            match heights_m.get_mut(k) {
                Some([_, farthest]) => *farthest = farthest.max(farthest_m),
                None => heights_m.push([height_m, farthest_m]),
            }
            k
        };
        let of_antenna = antennas_m.into_iter().map(&mut index).collect();
        Self {
            heights_m,
            of_antenna,
        }
    }

    /// Number of rays that all heights together have in their tables.
    pub fn rays(&self, depth_m: f64) -> u128 {
        let of_height = |[height_m, farthest_m]: &[f64; 2]| {
            Knots::count([*height_m, depth_m], *farthest_m) as u128
        };
        self.heights_m.iter().map(of_height).sum()
    }

    /// Largest number of rays that a height has in its table.
    pub fn longest(&self, depth_m: f64) -> usize {
        (self.heights_m.iter())
            .map(|[height_m, farthest_m]| Knots::count([*height_m, depth_m], *farthest_m))
            .fold(0, usize::max)
    }

    /// The rays of every height to a plane `depth_m` below the surface.
    pub fn tabulated(&self, ground: &Ground, light_speed_m_s: f64, depth_m: f64) -> Vec<Knots> {
        let knots = |[height_m, farthest_m]: &[f64; 2]| {
            Knots::new(ground, light_speed_m_s, [*height_m, depth_m], *farthest_m)
        };
        self.heights_m.par_iter().map(knots).collect()
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
    fn new(
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
                .into_par_iter()
                .with_min_len(RAYS_A_TASK)
                .map(knot)
                .collect(),
        }
    }

    /// Number of rays up to `farthest_m`, three of them beyond.
    fn count([height_m, depth_m]: [f64; 2], farthest_m: f64) -> usize {
        let beyond_m = (farthest_m - height_m - depth_m).max(0.0);
        (beyond_m * KNOTS_PER_HEIGHT / height_m).ceil() as usize + 4
    }

    /// Least distance, m, and knots in a metre.
    pub fn scale(&self) -> [f64; 2] {
        [self.nearest_m, self.per_m]
    }

    /// Height of the antenna above the surface, m.
    pub fn height_m(&self) -> f64 {
        KNOTS_PER_HEIGHT / self.per_m
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
