//! Half ways and weights at the corners of squares of pixels below uneven ground, and at pixels of squares without a polynomial.
//!
//! Rays to the corners are traced at the first pulse of a segment and at the first one of the next segment. At the pulses
//! between, the crossing of each ray follows from that at the nearer end by two steps of Newton's method, the surface
//! about the crossing being a parabola.
//!
//! Rays that are followed from one end to the other are compared with those traced there. In squares whose rays deviate, or
//! whose corners no polynomial joins, rays to every pixel are followed ([`TileCorners::sum_pixels`]), and pixels whose rays
//! deviate have rays traced for every pulse.

use super::corners::{Corners, MOST_CORNERS, TracedRays, UnevenGround, Within};
use super::followed::{Common, End, Followed, follow, follow_to, is_met, laid_out};
use super::job::{CHUNK, GROUP, Job, SIDE};
use crate::kernel::aligned::Aligned;
use crate::kernel::lanes::Lanes;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;

/// Corners along a row or across, at least, so that polynomials between them can be tested.
const LEAST_CORNERS: usize = 3;

/// Pixels from the middle of a square to its edge.
pub(super) const EDGE: f32 = 0.5 * SIDE as f32;

/// Share of a window of two registers over which the linear part of a way may extend.
const WINDOW_SHARE: f64 = 0.8;

/// One over a weight, where it is left out of the sum.
pub(super) const NO_WEIGHT: f32 = 1e15;

/// The rays of a pulse to all pixels of some squares, where all are kept.
fn kept_rays(
    kept: &BTreeMap<[usize; 2], TracedRays>,
    squares: &[[usize; 2]],
    pulse: usize,
) -> Option<TracedRays> {
    let mut rays = TracedRays {
        pulse,
        ..TracedRays::default()
    };
    for square in squares {
        rays.append(kept.get(square).filter(|kept| kept.pulse == pulse)?);
    }
    Some(rays)
}

/// Coefficients of i² and j² of one over the weight over squares.
pub(super) type Bends = Box<[Aligned<MOST_CORNERS>; 2]>;

/// The corners of a tile's squares, and the rays of a segment of pulses to them.
pub(super) struct TileCorners<'a> {
    ground: &'a dyn UnevenGround,
    weight_tolerance: f32,
    /// Corners from a row of the arrays to the next.
    stride: usize,
    corners: Corners,
    /// The tile's first pixel, m.
    first_m: [f64; 3],
    /// Changes of place from a pixel to the next along the row and across, m.
    pixels_m: [[f32; 3]; 2],
    /// Groups along the row and strips.
    squares: [usize; 2],
    segment: Range<usize>,
    ends: Option<[End; 2]>,
    bends: [Bends; 2],
    /// Rays to all pixels of squares, at the last pulse to which they were traced.
    kept: RefCell<BTreeMap<[usize; 2], TracedRays>>,
    /// 1 for squares that have polynomials, 0 for others, laid out as corners.
    has_polynomial: Aligned<MOST_CORNERS>,
    followed: Box<[Followed; CHUNK]>,
    first: usize,
}

impl<'a> TileCorners<'a> {
    /// A tile of no pulses.
    pub fn new(ground: &'a dyn UnevenGround, lanes: usize) -> Self {
        Self {
            ground,
            weight_tolerance: ground.weight_tolerance() as f32,
            stride: lanes + 1,
            corners: Corners {
                origin_m: [0.0; 3],
                steps_m: [[0.0; 3]; 2],
                columns: 0,
                rows: 0,
            },
            first_m: [0.0; 3],
            pixels_m: [[0.0; 3]; 2],
            squares: [0; 2],
            segment: 0..0,
            ends: None,
            bends: [(); 2].map(|()| no_bends()),
            kept: RefCell::default(),
            has_polynomial: Aligned([0.0; MOST_CORNERS]),
            followed: Box::new([const { Followed::NONE }; CHUNK]),
            first: 0,
        }
    }

    /// Turns to other squares, `[along, across]`, whose first pixel is at `first_m`; pixels are `u_m` and `v_m` apart.
    pub fn turn_to(&mut self, first_m: [f64; 3], [u_m, v_m]: [[f64; 3]; 2], squares: [usize; 2]) {
        let [columns, rows] = squares.map(|count| (count + 1).max(LEAST_CORNERS));
        self.corners = Corners {
            origin_m: std::array::from_fn(|axis| first_m[axis] - 0.5 * (u_m[axis] + v_m[axis])),
            steps_m: [u_m, v_m].map(|of| of.map(|x| SIDE as f64 * x)),
            columns,
            rows,
        };
        self.first_m = first_m;
        self.pixels_m = [u_m, v_m].map(|of| of.map(|x| x as f32));
        self.squares = squares;
        self.segment = 0..0;
        self.ends = None;
        self.kept.get_mut().clear();
    }

    /// Follows the rays of pulses from `first` on, [`CHUNK`] at most, and tells their number, and whether a segment begins.
    #[inline(never)]
    pub fn advance<S: Lanes>(&mut self, s: S, job: &Job, first: usize) -> (usize, bool) {
        s.vectorize(
            #[inline(always)]
            |s| self.advance_here(s, job, first),
        )
    }

    #[inline(always)]
    fn advance_here<S: Lanes>(&mut self, s: S, job: &Job, first: usize) -> (usize, bool) {
        let begins = !self.segment.contains(&first);
        if begins {
            self.begin(s, job, first);
        }
        let count = (self.segment.end - first).min(CHUNK);
        self.first = first;
        if let Some([before, after]) = &self.ends {
            for m in 0..count {
                let pulse = first + m;
                let ends = [before, after];
                follow(s, ends, (job, pulse, self.common()), &mut self.followed[m]);
            }
        }
        (count, begins)
    }

    /// Traces the rays of the segment that begins at pulse `first`.
    #[inline(never)]
    fn begin<S: Lanes>(&mut self, s: S, job: &Job, first: usize) {
        let last = job.pulses.end - 1;
        let (ground, corners) = (self.ground, self.corners);
        let to = ground.segment_end(first, last, corners.middle_m());
        let before = match self.ends.take() {
            Some([_, after]) if after.rays.pulse == first => after,
            _ => End::of_corners(ground.trace(&corners, first, None), &corners, self.stride),
        };
        let common = self.common();
        follow_to(s, [&before; 2], (job, to, common), &mut self.followed[0]);
        let places = (0..corners.count()).map(|k| self.place(k));
        let near = self.followed[0].crossings(&before, places);
        let rays = ground.trace(&corners, to, Some(&near));
        let after = End::of_corners(rays, &corners, self.stride);
        self.bends = [&before, &after].map(|end| bends(&end.rays.weight, &corners, self.stride));
        self.segment = first..if to == last { last + 1 } else { to };
        let mut is_sound: Vec<bool> = (before.rays.is_smooth.iter())
            .zip(&after.rays.is_smooth)
            .map(|(a, b)| *a && *b)
            .collect();
        self.compare(&after.rays, &mut is_sound);
        follow_to(s, [&after; 2], (job, first, common), &mut self.followed[0]);
        self.compare(&before.rays, &mut is_sound);
        let most_bins = (2 * S::N) as f64 * WINDOW_SHARE;
        for end in [&before, &after] {
            for (is_sound, change_m) in is_sound.iter_mut().zip(&end.rays.change_m) {
                *is_sound &= (change_m[0].abs() + change_m[1].abs()) / job.table.bin_m < most_bins;
            }
        }
        self.has_polynomial.0.fill(0.0);
        let [along, across] = self.squares;
        for (j, i) in (0..across).flat_map(|j| (0..along).map(move |i| (j, i))) {
            let at = |i: usize, j: usize| is_sound[j * corners.columns + i];
            if at(i, j) && at(i + 1, j) && at(i, j + 1) && at(i + 1, j + 1) {
                self.has_polynomial.0[j * self.stride + i] = 1.0;
            }
        }
        self.ends = Some([before, after]);
    }

    /// The place of corner `k` in arrays.
    fn place(&self, k: usize) -> usize {
        k / self.corners.columns * self.stride + k % self.corners.columns
    }

    /// What all rays have in common.
    fn common(&self) -> Common {
        Common {
            pixels_m: self.pixels_m,
            index: self.ground.index() as f32,
            has_spreading: self.ground.has_spreading(),
        }
    }

    /// Compares traced rays with those just followed to their pulse.
    fn compare(&self, traced: &TracedRays, is_sound: &mut [bool]) {
        let (followed, allowed_m) = (&self.followed[0], self.ground.tolerance_m());
        for (k, is_sound) in is_sound.iter_mut().enumerate() {
            let at = self.place(k);
            let change_off_m = |axis: usize| {
                let found_m = f64::from(followed.change_m[axis].0[at]);
                let traced_m = traced.change_m[k][axis] / SIDE as f64;
                f64::from(EDGE) * (found_m - traced_m).abs()
            };
            *is_sound &= is_met(self.ground, followed, at, (traced, k))
                && change_off_m(0) <= allowed_m
                && change_off_m(1) <= allowed_m;
        }
    }

    /// Squares `[along, across]` of the segment with or without polynomials.
    pub fn squares(&self, with_polynomials: bool) -> Vec<[usize; 2]> {
        let [along, across] = self.squares;
        (0..across)
            .flat_map(|j| (0..along).map(move |i| [i, j]))
            .filter(|[i, j]| (self.has_polynomial.0[j * self.stride + i] > 0.0) == with_polynomials)
            .collect()
    }

    /// Number of squares of a strip that have polynomials.
    pub fn polynomials(&self, strip: usize) -> usize {
        let of_strip = &self.has_polynomial.0[strip * self.stride..][..self.squares[0]];
        of_strip.iter().filter(|has| **has > 0.0).count()
    }

    /// The pulses of the segment.
    pub fn segment(&self) -> Range<usize> {
        self.segment.clone()
    }

    /// Gives half the ways (m) and weights of some pulses of the segment to all pixels of squares, pulse by pulse: the
    /// square's place in the list, and its pixels row by row.
    pub fn sum_pixels<S: Lanes>(
        &self,
        s: S,
        job: &Job,
        (squares, pulses): (&[[usize; 2]], Range<usize>),
        mut give: impl FnMut(usize, usize, &[f64; GROUP], &[f32; GROUP]),
    ) {
        let Some([before, after]) = &self.ends else {
            return;
        };
        let (ground, corners) = (self.ground, self.corners);
        let mut kept = self.kept.borrow_mut();
        let common = self.common();
        let mut followed = Box::new(Followed::NONE);
        let [first, last] = [before, after].map(|end| end.rays.pulse);
        for (batch, squares) in squares.chunks(MOST_CORNERS / GROUP).enumerate() {
            let points: Vec<Within> = (squares.iter())
                .flat_map(|square| (0..GROUP).map(|p| self.within(*square, p)))
                .collect();
            let all: Vec<usize> = (0..MOST_CORNERS)
                .map(|at| at.min(points.len() - 1))
                .collect();
            let end_of = |rays: TracedRays| End::new(rays, &all, |k| points[k].point_m);
            let of_start = kept_rays(&kept, squares, first);
            let start =
                end_of(of_start.unwrap_or_else(|| {
                    ground.trace_within(&points, (&corners, &before.rays), None)
                }));
            follow_to(s, [&start; 2], (job, last, common), &mut followed);
            let near = followed.crossings(&start, 0..points.len());
            let end = end_of(ground.trace_within(&points, (&corners, &after.rays), Some(&near)));
            for (k, square) in squares.iter().enumerate() {
                let rays = end.rays.slice(k * GROUP..(k + 1) * GROUP);
                kept.insert(*square, rays);
            }
            let mut is_sound: Vec<bool> = (start.rays.is_smooth.iter())
                .zip(&end.rays.is_smooth)
                .map(|(a, b)| *a && *b)
                .collect();
            for (k, is_sound) in is_sound.iter_mut().enumerate() {
                *is_sound &= is_met(ground, &followed, k, (&end.rays, k));
            }
            follow_to(s, [&end; 2], (job, first, common), &mut followed);
            for (k, is_sound) in is_sound.iter_mut().enumerate() {
                *is_sound &= is_met(ground, &followed, k, (&start.rays, k));
            }
            for pulse in pulses.clone() {
                let share = (pulse - first) as f64 / (last - first).max(1) as f64;
                follow_to(s, [&start, &end], (job, pulse, common), &mut followed);
                for square in 0..squares.len() {
                    let (mut half_m, mut weight) = ([0.0; GROUP], [0.0; GROUP]);
                    for p in 0..GROUP {
                        let k = square * GROUP + p;
                        half_m[p] = followed.base_m + f64::from(followed.beyond_m.0[k]);
                        weight[p] = followed.weight.0[k];
                        if !is_sound[k] {
                            let to = (pulse, points[k].point_m);
                            let ends = ([&start.rays, &end.rays], k);
                            let [traced_m, traced] = ground.between(to, ends, share);
                            (half_m[p], weight[p]) = (traced_m, traced as f32);
                        }
                    }
                    give(
                        batch * (MOST_CORNERS / GROUP) + square,
                        pulse,
                        &half_m,
                        &weight,
                    );
                }
            }
        }
    }

    /// Pixel `p` of a square.
    fn within(&self, [i, j]: [usize; 2], p: usize) -> Within {
        let [a, b] = [p % SIDE, p / SIDE];
        let [u, v] = self.corners.steps_m;
        let [along, across] = [i * SIDE + a, j * SIDE + b].map(|k| k as f64 / SIDE as f64);
        let columns = self.corners.columns;
        let corner = |x: usize, y: usize| (j + y) * columns + i + x;
        let [x, y] = [a, b].map(|k| usize::from(2 * k >= SIDE));
        Within {
            point_m: std::array::from_fn(|axis| {
                self.first_m[axis] + along * u[axis] + across * v[axis]
            }),
            corners: [
                corner(x, y),
                corner(1 - x, y),
                corner(x, 1 - y),
                corner(1 - x, 1 - y),
            ],
        }
    }

    /// Largest relative error of a weight by its expansion.
    pub fn weight_tolerance(&self) -> f32 {
        self.weight_tolerance
    }

    /// What the half ways of pulse `m` of the chunk are beyond, m.
    #[inline(always)]
    pub fn base_m(&self, m: usize) -> f64 {
        self.followed[m].base_m
    }

    /// Half ways and weights of pulse `m` of the chunk at the corners.
    #[inline(always)]
    pub fn followed(&self, m: usize) -> &Followed {
        &self.followed[m]
    }

    /// First place of a strip in arrays, and places from a row of corners to the next.
    #[inline(always)]
    pub fn row(&self, strip: usize) -> [usize; 2] {
        [strip * self.stride, self.stride]
    }

    /// 1 for squares that have polynomials, 0 for others, laid out as corners.
    #[inline(always)]
    pub fn has_polynomial(&self) -> &Aligned<MOST_CORNERS> {
        &self.has_polynomial
    }

    /// Bends of one over the weight over squares at both ends of the segment, and the share of the way from the first to
    /// the second at pulse `m` of the chunk.
    #[inline(always)]
    pub fn bends(&self, m: usize) -> (&[Bends; 2], f32) {
        let Some([before, after]) = &self.ends else {
            return (&self.bends, 0.0);
        };
        let [first, last] = [before, after].map(|end| end.rays.pulse);
        let share = (self.first + m - first) as f32 / (last - first).max(1) as f32;
        (&self.bends, share)
    }
}

fn no_bends() -> Bends {
    Box::new([const { Aligned([0f32; MOST_CORNERS]) }; 2])
}

/// The bends of one over the weight over squares, from the weights at their corners and around these.
fn bends(weight: &[f64], corners: &Corners, stride: usize) -> Bends {
    let (columns, rows) = (corners.columns, corners.rows);
    let one_over =
        |i: usize, j: usize| 1.0 / weight[j * columns + i].max(1.0 / f64::from(NO_WEIGHT));
    // Second differences, beyond the second corner and the last but one those of these.
    let bend = |i: usize, j: usize| {
        let (p, q) = (i.clamp(1, columns - 2), j.clamp(1, rows - 2));
        [
            one_over(p - 1, j) + one_over(p + 1, j) - 2.0 * one_over(p, j),
            one_over(i, q - 1) + one_over(i, q + 1) - 2.0 * one_over(i, q),
        ]
    };
    let mut bends = no_bends();
    for (at, [i, j]) in laid_out(corners, stride) {
        let (next, below) = ((i + 1).min(columns - 1), (j + 1).min(rows - 1));
        let of = [[i, j], [next, j], [i, below], [next, below]].map(|[i, j]| bend(i, j));
        for (axis, numbers) in bends.iter_mut().enumerate() {
            // A second difference is 16 times the second derivative a pixel, and four are averaged.
            let sum: f64 = of.iter().map(|of| of[axis]).sum();
            numbers.0[at] = (sum / 128.0) as f32;
        }
    }
    bends
}
