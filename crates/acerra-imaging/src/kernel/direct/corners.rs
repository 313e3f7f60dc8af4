//! Corners of squares of pixels below uneven ground, and rays to these.

use crate::refraction::relief::FollowedRay;
use std::ops::Range;

/// Most corners of a tile, a multiple of the lanes of all levels: strips of a tile times groups of a block are 128.
pub(super) const MOST_CORNERS: usize = 160;

/// Corners of squares: those `[column, row]` of the lattice are at `origin_m` + column·`steps_m[0]` + row·`steps_m[1]`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Corners {
    pub origin_m: [f64; 3],
    pub steps_m: [[f64; 3]; 2],
    pub columns: usize,
    pub rows: usize,
}

impl Corners {
    /// Number of corners.
    pub fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// About their middle, m.
    pub fn middle_m(&self) -> [f64; 3] {
        self.point_m(self.rows / 2 * self.columns + self.columns / 2)
    }

    /// Corner `k`, row by row, m.
    pub fn point_m(&self, k: usize) -> [f64; 3] {
        let (i, j) = ((k % self.columns) as f64, (k / self.columns) as f64);
        let [u, v] = self.steps_m;
        std::array::from_fn(|axis| self.origin_m[axis] + i * u[axis] + j * v[axis])
    }
}

/// Rays of a pulse to some points.
#[derive(Debug, Clone, Default)]
pub(crate) struct TracedRays {
    pub pulse: usize,
    /// From the transmitter and from the receiver; the latter has none where it is the former.
    pub rays: [Vec<FollowedRay>; 2],
    /// Half the optical length of the way, m, and its changes from a corner to the next along the row and across, for corners.
    pub half_m: Vec<f64>,
    pub change_m: Vec<[f64; 2]>,
    /// Weight of an echo, without that of the pulse, and what of it is neither transmission nor spreading.
    pub weight: Vec<f64>,
    pub rest: Vec<f64>,
    /// Whether polynomials between corners join the ways and weights about a corner.
    pub is_smooth: Vec<bool>,
}

impl TracedRays {
    /// Those to some of the points.
    pub fn slice(&self, points: Range<usize>) -> Self {
        let of = |rays: &Vec<FollowedRay>| match rays.is_empty() {
            true => Vec::new(),
            false => rays[points.clone()].to_vec(),
        };
        Self {
            pulse: self.pulse,
            rays: [of(&self.rays[0]), of(&self.rays[1])],
            half_m: self.half_m[points.clone()].to_vec(),
            change_m: Vec::new(),
            weight: self.weight[points.clone()].to_vec(),
            rest: self.rest[points.clone()].to_vec(),
            is_smooth: self.is_smooth[points].to_vec(),
        }
    }

    /// Adds rays of the same pulse to other points.
    pub fn append(&mut self, other: &Self) {
        for (rays, others) in self.rays.iter_mut().zip(&other.rays) {
            rays.extend_from_slice(others);
        }
        self.half_m.extend_from_slice(&other.half_m);
        self.weight.extend_from_slice(&other.weight);
        self.rest.extend_from_slice(&other.rest);
        self.is_smooth.extend_from_slice(&other.is_smooth);
    }
}

/// Ground whose surface is uneven.
pub(crate) trait UnevenGround: Sync {
    /// Refractive index below the surface.
    fn index(&self) -> f64;
    /// Allowed deviation of half an optical length from one that was followed from the other end of a segment, m.
    fn tolerance_m(&self) -> f64;
    /// Whether echoes are weighted by transmission and spreading.
    fn has_spreading(&self) -> bool;
    /// Allowed relative error of a weight.
    fn weight_tolerance(&self) -> f64;
    /// The last pulse up to `last` to which rays to points about `point_m` can be followed from pulse `first`, or the next.
    fn segment_end(&self, first: usize, last: usize, point_m: [f64; 3]) -> usize;
    /// Rays of a pulse to all corners.
    fn trace(&self, corners: &Corners, pulse: usize, near: Option<&Crossings>) -> TracedRays;
    /// Rays of a pulse to points, each within the square of some corners whose rays are `around`. A point counts as smooth
    /// where its rays are minima of the optical length.
    fn trace_within(
        &self,
        points: &[Within],
        around: (&Corners, &TracedRays),
        near: Option<&Crossings>,
    ) -> TracedRays;
    /// Half the optical length of the way of a pulse to a point, m, and its weight without that of the pulse: between the
    /// ends of a segment, at which the point has the rays `k`, `share` of the way from the first to the second.
    fn between(
        &self,
        to: (usize, [f64; 3]),
        ends: ([&TracedRays; 2], usize),
        share: f64,
    ) -> [f64; 2];
}

/// About where the rays of transmitter and receiver to some points cross the surface, x and y (m).
pub(crate) type Crossings = [Vec<[f64; 2]>; 2];

/// A point within a square.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Within {
    pub point_m: [f64; 3],
    /// The corners of the square, the nearest first.
    pub corners: [usize; 4],
}
