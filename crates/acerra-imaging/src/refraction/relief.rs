//! Rays through an uneven surface.

use super::fresnel::transmission_te;
use super::ray::{MAX_LAYERS, Ray};
use crate::checks::{check_finite, check_length, check_positive};
use crate::error::ImagingError;
use crate::vector::{dot, norm};

/// An uneven surface: heights at the nodes of an even lattice, interpolated by Keys' cubic convolution
/// (1981, a = −½), level beyond the edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Relief {
    origin_m: [f64; 2],
    step_m: f64,
    columns: usize,
    height_m: Vec<f64>,
    span_m: [f64; 2],
}

/// Height of a surface, its slopes and its curvatures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facet {
    /// Height, m.
    pub height_m: f64,
    /// Derivatives along x and y.
    pub slope: [f64; 2],
    /// Second derivatives xx, xy, yy, 1/m.
    pub curvature: [f64; 3],
}

/// Places along the horizontal line through antenna and point from which the crossing is searched, and as many these to
/// either side of each.
const STARTS: usize = 25;
const ASIDE: usize = 12;
/// The samples reach this many depths of the point from the point towards the antenna, or to the crossing of
/// a ray at the critical angle of level ground, with a margin for slopes.
const REACH_DEPTHS: f64 = 4.0;
const CRITICAL_ROOM: f64 = 2.0;
/// Share of the reach by which the samples extend beyond the point, and beyond the antenna.
const BEYOND: f64 = 0.25;
/// Number of the earliest local minima among the samples that are refined.
const REFINED: usize = 6;
/// The gain by refining a minimum is assumed to be at most this multiple of the gain predicted for the first
/// step.
const GAIN_ROOM: f64 = 4.0;
/// Share of the distance of two crossings by which the crossing between them may be beside the straight line.
const STEP_SHARE: f64 = 0.25;
/// Steps of a search, and halvings of a step that leads to a later crossing.
const MOST_STEPS: usize = 40;
/// Least gain of a step, as a share of the optical length: a crossing is then found to some 10⁻⁷ of the
/// length, and the length, which is stationary there, to rounding.
const LEAST_GAIN: f64 = 1e-13;
const MOST_HALVINGS: usize = 30;
/// Steps of Newton's method from a crossing nearby.
const MOST_FOLLOWED: usize = 6;

impl Relief {
    /// A surface of the heights `[rows, columns]` (rows along y), `step_m` apart from `origin_m` on.
    ///
    /// # Errors
    /// No heights, a number of heights that `columns` does not divide, a height that is not finite, a step
    /// that is not positive.
    pub fn new(
        origin_m: [f64; 2],
        step_m: f64,
        columns: usize,
        height_m: Vec<f64>,
    ) -> Result<Self, ImagingError> {
        if height_m.is_empty() || columns == 0 {
            return Err(ImagingError::Empty { what: "height_m" });
        }
        let rows = height_m.len().div_ceil(columns);
        check_length("height_m", rows * columns, height_m.len())?;
        check_finite("height_m", height_m.iter().copied())?;
        check_finite("origin_m", origin_m.into_iter())?;
        check_positive("step_m", "above 0 m", step_m)?;
        let extreme = |f: fn(f64, f64) -> f64, start| height_m.iter().copied().fold(start, f);
        let span = [extreme(f64::min, f64::MAX), extreme(f64::max, f64::MIN)];
        // Cubic convolution overshoots the heights by at most a quarter of their span in two dimensions:
        // the magnitudes of its weights sum to 5/4 an axis, (25/16 − 1)/2 < 0.3.
        let beyond = 0.3 * (span[1] - span[0]);
        Ok(Self {
            origin_m,
            step_m,
            columns,
            height_m,
            span_m: [span[0] - beyond, span[1] + beyond],
        })
    }

    /// Distance of the nodes, m.
    pub(crate) fn step_m(&self) -> f64 {
        self.step_m
    }

    /// Bounds of the surface's heights, m.
    #[must_use]
    pub fn span_m(&self) -> [f64; 2] {
        self.span_m
    }

    /// The first of the four nodes about a coordinate along an axis, the fraction of the cell between the middle two, and
    /// whether the coordinate is beyond the edges, where the height is that of the edge. The first node may be one before
    /// the lattice.
    #[inline]
    fn nodes(&self, axis: usize, coordinate_m: f64) -> (usize, f64, bool) {
        let size = [self.columns, self.height_m.len() / self.columns][axis];
        let last = (size - 1) as f64;
        let place = (coordinate_m - self.origin_m[axis]) / self.step_m;
        let held = place.clamp(0.0, last);
        let cell = (held as usize).min(size.saturating_sub(2));
        (cell, held - cell as f64, place != held)
    }

    /// Heights of the 4 × 4 nodes whose second node in both directions is `[column, row]`, m.
    #[inline]
    fn patch(&self, [column, row]: [usize; 2]) -> [[f64; 4]; 4] {
        let (columns, rows) = (self.columns, self.height_m.len() / self.columns);
        let is_inside = column >= 1 && row >= 1 && column + 2 < columns && row + 2 < rows;
        let mut patch = [[0.0; 4]; 4];
        if is_inside {
            let first = (row - 1) * columns + column - 1;
            for (k, nodes) in patch.iter_mut().enumerate() {
                nodes.copy_from_slice(&self.height_m[first + k * columns..][..4]);
            }
        } else {
            let held =
                |node: usize, k: usize, size: usize| (node + k).saturating_sub(1).min(size - 1);
            for (k, nodes) in patch.iter_mut().enumerate() {
                let first = held(row, k, rows) * columns;
                for (j, node) in nodes.iter_mut().enumerate() {
                    *node = self.height_m[first + held(column, j, columns)];
                }
            }
        }
        patch
    }

    /// The surface at `[x, y]`.
    #[must_use]
    pub fn at(&self, place_m: [f64; 2]) -> Facet {
        let per_m = 1.0 / self.step_m;
        let (column, across, is_beyond_x) = self.nodes(0, place_m[0]);
        let (row, along, is_beyond_y) = self.nodes(1, place_m[1]);
        let [x, mut x1, mut x2] = keys(across, per_m);
        let [y, mut y1, mut y2] = keys(along, per_m);
        if is_beyond_x {
            (x1, x2) = ([0.0; 4], [0.0; 4]);
        }
        if is_beyond_y {
            (y1, y2) = ([0.0; 4], [0.0; 4]);
        }
        // Height of every row, and derivatives of the height along x.
        let patch = self.patch([column, row]);
        let (mut rows, mut rows1, mut rows2) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for (k, nodes) in patch.iter().enumerate() {
            rows[k] = product(&x, nodes);
            rows1[k] = product(&x1, nodes);
            rows2[k] = product(&x2, nodes);
        }
        Facet {
            height_m: product(&y, &rows),
            slope: [product(&y, &rows1), product(&y1, &rows)],
            curvature: [
                product(&y, &rows2),
                product(&y1, &rows1),
                product(&y2, &rows),
            ],
        }
    }

    /// Height at `[x, y]`, m, as by [`Relief::at`].
    #[must_use]
    pub fn height_m(&self, place_m: [f64; 2]) -> f64 {
        let (column, across, _) = self.nodes(0, place_m[0]);
        let (row, along, _) = self.nodes(1, place_m[1]);
        let (across, along) = (weights(across), weights(along));
        let patch = self.patch([column, row]);
        let mut rows = [0.0; 4];
        for (row, nodes) in rows.iter_mut().zip(&patch) {
            *row = product(&across, nodes);
        }
        product(&along, &rows)
    }

    /// The earliest ray from an antenna above the surface to a point below it, in soil of refractive index `n`.
    /// Spreading and transmission are computed for the tangent plane.
    #[must_use]
    pub fn ray(&self, n: f64, antenna_m: [f64; 3], point_m: [f64; 3]) -> Ray {
        let search = self.search(n, antenna_m, point_m);
        search.ray(search.earliest())
    }

    pub(crate) fn search(&self, n: f64, antenna_m: [f64; 3], point_m: [f64; 3]) -> Search<'_> {
        Search {
            relief: self,
            n,
            antenna_m,
            point_m,
        }
    }
}

impl Search<'_> {
    /// The crossing of the earliest ray.
    ///
    /// The minimum about the crossing of level ground is refined by Newton's method on the surface. Places about the
    /// vertical plane through antenna and point are sampled where a crossing of any height could be earlier, and the
    /// earliest local minima among the samples are refined as well. The earliest arrival is used.
    pub fn earliest(&self) -> [f64; 2] {
        let Self {
            relief,
            n,
            antenna_m,
            point_m,
        } = *self;
        let towards_m = [0, 1].map(|axis| antenna_m[axis] - point_m[axis]);
        let distance_m = towards_m[0].hypot(towards_m[1]);
        let towards = match distance_m {
            0.0 => [1.0, 0.0],
            _ => towards_m.map(|v| v / distance_m),
        };
        let surface_m = relief.height_m([point_m[0], point_m[1]]);
        let depth_m = (surface_m - point_m[2]).max(0.0);
        let height_m = (antenna_m[2] - surface_m).max(1e-12);
        // The straight line's crossing, moved towards the point as refraction does near the vertical.
        let start_m = distance_m * depth_m / (n * (height_m + depth_m));
        let start = [0, 1].map(|axis| point_m[axis] + start_m * towards[axis]);
        let mut best = self.refine(start);
        let critical = CRITICAL_ROOM / (n * n - 1.0).max(1e-6).sqrt();
        let reach_m = distance_m.min(depth_m * REACH_DEPTHS.max(critical));
        let margin_m = BEYOND * reach_m.max(depth_m);
        let step_m = (reach_m + 2.0 * margin_m) / (STARTS - 1) as f64;
        let offset_m = |k: usize| k as f64 * step_m - margin_m;
        let at = |k: usize, j: usize| {
            let aside_m = (j as f64 - ASIDE as f64) * step_m;
            let along_m = offset_m(k);
            [
                point_m[0] + along_m * towards[0] - aside_m * towards[1],
                point_m[1] + along_m * towards[1] + aside_m * towards[0],
            ]
        };
        // Lengths over the plane's samples, with a margin all around.
        let mut length_m = [[f64::INFINITY; 2 * ASIDE + 3]; STARTS + 2];
        for (k, lengths_m) in length_m[1..=STARTS].iter_mut().enumerate() {
            for aside in 0..=ASIDE {
                let aside_m = aside as f64 * step_m;
                let least_m = self.least_m(distance_m, [offset_m(k), aside_m], 0.5 * step_m);
                if least_m >= best.1 {
                    break;
                }
                for j in [ASIDE - aside, ASIDE + aside] {
                    lengths_m[j + 1] = self.optical_m(at(k, j));
                }
            }
        }
        let mut minima = [(f64::INFINITY, [0.0; 2]); REFINED];
        for (k, rows) in length_m.windows(3).enumerate() {
            for j in 0..=2 * ASIDE {
                let here_m = rows[1][j + 1];
                // Corners are left out: valleys may be oblique.
                let about_m = [rows[0][j + 1], rows[1][j], rows[1][j + 2], rows[2][j + 1]];
                let is_minimum = || about_m.iter().all(|length_m| here_m <= *length_m);
                if here_m < minima[REFINED - 1].0 && is_minimum() {
                    let place = minima.partition_point(|(length_m, _)| *length_m <= here_m);
                    minima[place..].rotate_right(1);
                    minima[place] = (here_m, at(k, j));
                }
            }
        }
        for (length_m, place) in minima
            .into_iter()
            .filter(|(length_m, _)| length_m.is_finite())
        {
            let newton = self.newton_step(place);
            if !newton.is_convex || length_m - GAIN_ROOM * newton.gain_m < best.1 {
                let found = self.refine(place);
                best = if found.1 < best.1 { found } else { best };
            }
        }
        best.0
    }
}

#[inline]
fn product(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

/// Keys' weights of four nodes at a fraction of a cell.
#[inline]
fn weights(t: f64) -> [f64; 4] {
    let s = t * t;
    let cube = s * t;
    [
        -0.5 * cube + s - 0.5 * t,
        1.5 * cube - 2.5 * s + 1.0,
        -1.5 * cube + 2.0 * s + 0.5 * t,
        0.5 * cube - 0.5 * s,
    ]
}

/// Keys' weights of four nodes at a fraction of a cell, and their first and second derivatives.
#[inline]
fn keys(t: f64, per_m: f64) -> [[f64; 4]; 3] {
    let (s, square) = (t * t, per_m * per_m);
    let first = [
        (-1.5 * s + 2.0 * t - 0.5) * per_m,
        (4.5 * s - 5.0 * t) * per_m,
        (-4.5 * s + 4.0 * t + 0.5) * per_m,
        (1.5 * s - t) * per_m,
    ];
    let second = [
        (-3.0 * t + 2.0) * square,
        (9.0 * t - 5.0) * square,
        (-9.0 * t + 4.0) * square,
        (3.0 * t - 1.0) * square,
    ];
    [weights(t), first, second]
}

/// A step of Newton's method.
#[derive(Debug, Clone, Copy)]
struct Newton {
    step_m: [f64; 2],
    /// Gain predicted for the step, m.
    gain_m: f64,
    is_convex: bool,
}

/// The optical length about a place of the surface.
#[derive(Debug, Clone, Copy)]
struct About {
    facet: Facet,
    /// Length from the antenna to the place, and from the place to the point, m.
    lengths_m: [f64; 2],
    /// From the place to the point, m.
    on_m: [f64; 3],
    /// First derivatives by the place along x and y, and second ones xx, xy and yy (1/m).
    gradient: [f64; 2],
    second: [f64; 3],
}

impl About {
    fn step(&self) -> Newton {
        let ([a, b], gradient, [xx, xy, yy]) = (self.lengths_m, self.gradient, self.second);
        let determinant = xx * yy - xy * xy;
        let is_convex = xx > 0.0 && determinant > 1e-12 * xx * yy;
        let step_m = if is_convex {
            [
                -(yy * gradient[0] - xy * gradient[1]) / determinant,
                -(xx * gradient[1] - xy * gradient[0]) / determinant,
            ]
        } else {
            gradient.map(|g| -g * a.min(b))
        };
        Newton {
            step_m,
            gain_m: -0.5 * (gradient[0] * step_m[0] + gradient[1] * step_m[1]),
            is_convex,
        }
    }
}

/// A ray through the surface, and the surface and the optical length about its crossing.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FollowedRay {
    pub crossing_m: [f64; 3],
    pub slope: [f64; 2],
    /// Second derivatives xx, xy and yy of the height, 1/m.
    pub curvature: [f64; 3],
    /// Inverse of the second derivatives of the optical length by the place of the crossing: xx, xy and yy, m.
    pub inverse: [f64; 3],
    /// Whether the optical length is least at the crossing, so that the inverse is one.
    pub is_minimum: bool,
    pub optical_m: f64,
    /// Of the optical length with respect to the point.
    pub gradient: [f64; 3],
}

/// The search for a crossing point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Search<'a> {
    relief: &'a Relief,
    n: f64,
    antenna_m: [f64; 3],
    point_m: [f64; 3],
}

impl Search<'_> {
    /// Optical length through a point of the surface, m.
    fn optical_m(&self, place: [f64; 2]) -> f64 {
        let (down, on) = self.legs([place[0], place[1], self.relief.height_m(place)]);
        norm(down) + self.n * norm(on)
    }

    /// Lower bound of the optical length through places about the vertical plane of antenna and point, which are
    /// `distance_m` apart: they are within `half_m` of `offset_m` from the point along the plane, and at least as far from
    /// the plane as `aside_m` less `half_m`, at any height of the surface (m).
    fn least_m(&self, distance_m: f64, [offset_m, aside_m]: [f64; 2], half_m: f64) -> f64 {
        let [lowest_m, highest_m] = self.relief.span_m();
        let beside_m = (aside_m - half_m).max(0.0);
        let far_m = |along_m: f64| {
            let along_m = (along_m.abs() - half_m).max(0.0);
            (along_m * along_m + beside_m * beside_m).sqrt()
        };
        let (below_m, above_m) = (far_m(offset_m), far_m(distance_m - offset_m));
        let lengths_m = |antenna_over_m: f64, point_under_m: f64| {
            let [up_m, down_m] = [antenna_over_m, point_under_m].map(|m| m.max(0.0));
            let a = (above_m * above_m + up_m * up_m).sqrt();
            let b = (below_m * below_m + down_m * down_m).sqrt();
            (a, b, up_m, down_m)
        };
        let (antenna_m, point_m) = (self.antenna_m[2], self.point_m[2]);
        let (a, b, up_m, down_m) = lengths_m(antenna_m - lowest_m, lowest_m - point_m);
        // The bound is convex in the height: if it rises at the lowest height, it is least there.
        if point_m <= lowest_m && self.n * down_m * a >= up_m * b {
            return a + self.n * b;
        }
        let (a, ..) = lengths_m(antenna_m - highest_m, 0.0);
        a + self.n * b
    }

    /// Vectors from the antenna to a crossing point, and from the crossing to the point.
    #[inline]
    fn legs(&self, [x, y, z]: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let ([a, b, c], [p, q, r]) = (self.antenna_m, self.point_m);
        ([x - a, y - b, z - c], [p - x, q - y, r - z])
    }

    /// The local minimum about a place, and the optical length there.
    fn refine(&self, start: [f64; 2]) -> ([f64; 2], f64) {
        let (mut place, mut length) = (start, self.optical_m(start));
        for _ in 0..MOST_STEPS {
            let Newton {
                step_m: step,
                gain_m,
                ..
            } = self.newton_step(place);
            if gain_m < LEAST_GAIN * length {
                break;
            }
            let (mut share, mut moved) = (1.0, false);
            for _ in 0..MOST_HALVINGS {
                let next = [place[0] + share * step[0], place[1] + share * step[1]];
                let found = self.optical_m(next);
                if found < length {
                    (place, length, moved) = (next, found, true);
                    break;
                }
                share *= 0.5;
            }
            if !moved {
                break;
            }
        }
        (place, length)
    }

    /// The optical length about a place of the surface up to second order.
    fn about(&self, place: [f64; 2]) -> About {
        let facet = self.relief.at(place);
        let (down, on) = self.legs([place[0], place[1], facet.height_m]);
        let (a, b) = (norm(down).max(1e-12), norm(on).max(1e-12));
        let tangents = [[1.0, 0.0, facet.slope[0]], [0.0, 1.0, facet.slope[1]]];
        // Derivatives of the length by the crossing point.
        let along = |k: usize| down[k] / a - self.n * on[k] / b;
        let slope = [along(0), along(1), along(2)];
        let gradient = [dot(slope, tangents[0]), dot(slope, tangents[1])];
        let second = |s: [f64; 3], t: [f64; 3], bend: f64| {
            (dot(s, t) - dot(s, down) * dot(t, down) / (a * a)) / a
                + self.n * (dot(s, t) - dot(s, on) * dot(t, on) / (b * b)) / b
                + slope[2] * bend
        };
        let [t, u] = tangents;
        About {
            facet,
            lengths_m: [a, b],
            on_m: on,
            gradient,
            second: [
                second(t, t, facet.curvature[0]),
                second(t, u, facet.curvature[1]),
                second(u, u, facet.curvature[2]),
            ],
        }
    }

    /// Newton's step towards a smaller optical length, steepest descent where the length is not convex.
    fn newton_step(&self, place: [f64; 2]) -> Newton {
        self.about(place).step()
    }

    /// The crossing of the minimum about `start`, from which it must not be far, found so closely that the length deviates
    /// by less than `tolerance_m`.
    fn followed(&self, start: [f64; 2], tolerance_m: f64) -> ([f64; 2], About) {
        let mut place = start;
        for _ in 0..MOST_FOLLOWED {
            let about = self.about(place);
            let newton = about.step();
            if !newton.is_convex {
                break;
            }
            if newton.gain_m < tolerance_m {
                return (place, about);
            }
            place = [place[0] + newton.step_m[0], place[1] + newton.step_m[1]];
        }
        let (place, _) = self.refine(start);
        (place, self.about(place))
    }

    /// The ray through the minimum about `start`, and what it takes to follow it; see [`Search::followed`].
    pub fn follow(&self, start: [f64; 2], tolerance_m: f64) -> FollowedRay {
        let (place, about) = self.followed(start, tolerance_m);
        let [xx, xy, yy] = about.second;
        let determinant = xx * yy - xy * xy;
        let is_minimum = xx > 0.0 && determinant > 1e-12 * xx * yy;
        let inverse = match is_minimum {
            true => [yy / determinant, -xy / determinant, xx / determinant],
            false => [0.0; 3],
        };
        let [a, b] = about.lengths_m;
        FollowedRay {
            crossing_m: [place[0], place[1], about.facet.height_m],
            slope: about.facet.slope,
            curvature: about.facet.curvature,
            inverse,
            is_minimum,
            optical_m: a + self.n * b,
            gradient: about.on_m.map(|v| self.n * v / b),
        }
    }

    /// A crossing between the crossings `ends` of earliest rays nearby, `share` of the way from the first to the second.
    ///
    /// Where both belong to one minimum of the optical length, the crossing between them is a step of Newton's method
    /// away, and the length behind that step deviates by less than the step gains, which must be below `tolerance_m`.
    /// Elsewhere the minima about both ends and about the place between them are refined, and the earliest is used.
    pub fn between(&self, ends: [[f64; 2]; 2], share: f64, tolerance_m: f64) -> [f64; 2] {
        let [from, to] = ends;
        let apart = [to[0] - from[0], to[1] - from[1]];
        let start = [from[0] + share * apart[0], from[1] + share * apart[1]];
        let newton = self.newton_step(start);
        let square = |v: [f64; 2]| v[0] * v[0] + v[1] * v[1];
        let is_near = square(newton.step_m) <= STEP_SHARE * STEP_SHARE * square(apart) + 1e-12;
        if newton.is_convex && newton.gain_m <= tolerance_m && is_near {
            return [start[0] + newton.step_m[0], start[1] + newton.step_m[1]];
        }
        let refined = [start, from, to].map(|place| self.refine(place));
        let earlier = |a: ([f64; 2], f64), b: ([f64; 2], f64)| if b.1 < a.1 { b } else { a };
        refined.into_iter().fold(refined[0], earlier).0
    }

    /// The ray through a place of the surface.
    pub fn ray(&self, place: [f64; 2]) -> Ray {
        let facet = self.relief.at(place);
        self.ray_through([place[0], place[1], facet.height_m], facet.slope)
    }

    /// The whole of a ray that was followed.
    pub fn ray_of(&self, followed: &FollowedRay) -> Ray {
        self.ray_through(followed.crossing_m, followed.slope)
    }

    /// The ray through a crossing, at which the surface has a slope along x and y.
    fn ray_through(&self, crossing_m: [f64; 3], [slope_x, slope_y]: [f64; 2]) -> Ray {
        let (down, on) = self.legs(crossing_m);
        let [a, b] = [norm(down).max(1e-12), norm(on).max(1e-12)];
        let upright = (1.0 + slope_x * slope_x + slope_y * slope_y).sqrt();
        let normal = [-slope_x / upright, -slope_y / upright, 1.0 / upright];
        // Cosine in air, depth below the tangent plane, and n cos θ below by Snell's law.
        let air = (-dot(down, normal) / a).max(1e-9);
        let depth_m = (-dot(on, normal)).max(1e-9);
        let soil = (self.n * self.n - 1.0 + air * air).sqrt();
        // The tube of rays about one through a plane: its widths across and along the plane of incidence.
        let across_m = a + depth_m / soil;
        let along_m = a / (air * air) + depth_m * (self.n / soil).powi(2) / soil;
        let transmitted = transmission_te(air, soil);
        let mut soil_m = [0.0; MAX_LAYERS];
        soil_m[0] = b;
        Ray {
            optical_m: a + self.n * b,
            soil_m,
            departure: down.map(|v| v / a),
            gradient: on.map(|v| self.n * v / b),
            amplitude: transmitted / (air * (across_m * along_m).sqrt()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refraction::{Ground, Layer, Soil, Surface};
    use crate::sampling::Random;

    fn uniform(random: &mut Random, low: f64, high: f64) -> f64 {
        low + (high - low) * random.below(1_000_000) as f64 / 1e6
    }

    fn waves(amplitude_m: f64, length_m: f64) -> Relief {
        let height = |k: usize| {
            let (x, y) = ((k % 121) as f64 * 0.05, (k / 121) as f64 * 0.05);
            let turns = std::f64::consts::TAU / length_m;
            amplitude_m * (turns * x).sin() * (turns * y + 1.0).cos()
        };
        Relief::new([-3.0; 2], 0.05, 121, (0..121 * 121).map(height).collect()).unwrap()
    }

    #[test]
    fn a_tilted_plane_refracts_as_the_level_one_turned_with_it() {
        // z = 0.3 x: heights on the nodes are exact under cubic convolution.
        let height = |k: usize| 0.3 * ((k % 81) as f64 * 0.1 - 4.0);
        let slope = Relief::new([-4.0; 2], 0.1, 81, (0..81 * 81).map(height).collect()).unwrap();
        let scale = 1f64.hypot(0.3);
        let turned = |[x, y, z]: [f64; 3]| {
            [(x - 0.3 * z) / scale, y, (0.3 * x + z) / scale] // level axes to tilted ones
        };
        let soil = Soil {
            relative_permittivity: 5.0,
            conductivity_s_m: 0.0,
        };
        let layers = [Layer::below_all(soil)];
        let level = Ground::new(Surface::Level { z_m: 0.0 }, &layers, 1e9).unwrap();
        let mut random = Random(3);
        for _ in 0..100 {
            let antenna = [0.0, 0.2, uniform(&mut random, 0.3, 2.0)];
            let point = [
                uniform(&mut random, -1.5, 1.5),
                uniform(&mut random, -1.5, 1.5),
                uniform(&mut random, -0.8, -0.02),
            ];
            let expected = level.ray(antenna, point);
            let found = slope.ray(5f64.sqrt(), turned(antenna), turned(point));
            assert!((found.optical_m - expected.optical_m).abs() < 1e-10);
            assert!((found.amplitude / expected.amplitude - 1.0).abs() < 1e-5);
            assert!((found.soil_m[0] - expected.soil_m[0]).abs() < 1e-5);
        }
    }

    /// A dense search over the surface finds no crossing earlier than the ray's.
    #[test]
    fn no_crossing_of_uneven_ground_is_earlier() {
        let reliefs = [0.7, 0.35].map(|length_m| waves(0.03, length_m));
        let mut random = Random(9);
        for k in 0..24 {
            let relief = &reliefs[k % 2];
            let antenna = [0.1, -0.2, uniform(&mut random, 0.4, 3.0)];
            let point = [
                uniform(&mut random, -1.0, 1.0),
                uniform(&mut random, -1.0, 1.0),
                uniform(&mut random, -0.6, -0.05),
            ];
            let search = Search {
                relief,
                n: 2.0,
                antenna_m: antenna,
                point_m: point,
            };
            let mut least = f64::INFINITY;
            for i in 0..=280 {
                for j in 0..=280 {
                    let place = [-1.4 + 0.01 * f64::from(i), -1.4 + 0.01 * f64::from(j)];
                    least = least.min(search.optical_m(place));
                }
            }
            let found = relief.ray(2.0, antenna, point).optical_m;
            assert!(found <= least + 1e-9, "{found} {least}");
            assert!(found > least - 5e-4, "{found} {least}");
        }
    }

    /// A strip is left out by a bound that no crossing within it falls below, wherever the crossing is.
    #[test]
    fn no_crossing_is_earlier_than_the_bound_of_its_strip() {
        let reliefs = [0.0, 0.05].map(|amplitude_m| waves(amplitude_m, 0.7));
        let mut random = Random(21);
        let mut closest = f64::INFINITY;
        for _ in 0..20_000 {
            let relief = &reliefs[random.below(2)];
            let distance_m = uniform(&mut random, 0.0, 2.0);
            let search = Search {
                relief,
                n: uniform(&mut random, 1.0, 5.0),
                antenna_m: [distance_m, 0.0, uniform(&mut random, 0.1, 3.0)],
                point_m: [0.0, 0.0, uniform(&mut random, -1.0, 0.02)],
            };
            let (offset_m, half_m) = (
                uniform(&mut random, -1.0, 2.0),
                uniform(&mut random, 0.0, 0.1),
            );
            let within_m = uniform(&mut random, -half_m, half_m);
            let place = [offset_m + within_m, uniform(&mut random, -0.3, 0.3)];
            let aside_m = place[1].abs() + uniform(&mut random, -0.1, half_m);
            let least_m = search.least_m(distance_m, [offset_m, aside_m], half_m);
            let spare_m = search.optical_m(place) - least_m;
            assert!(spare_m > -1e-12, "{spare_m}");
            closest = closest.min(spare_m);
        }
        assert!(closest < 1e-2, "{closest}");
    }

    #[test]
    fn slopes_and_curvatures_are_derivatives() {
        let relief = waves(0.05, 1.3);
        let at = |x: f64, y: f64| relief.at([x, y]);
        let (x, y, step) = (0.313, -0.477, 1e-5);
        let facet = at(x, y);
        let [a, b] = [at(x + step, y), at(x - step, y)];
        assert!(((a.height_m - b.height_m) / (2.0 * step) - facet.slope[0]).abs() < 1e-7);
        assert!(((a.slope[0] - b.slope[0]) / (2.0 * step) - facet.curvature[0]).abs() < 1e-5);
        assert!(((a.slope[1] - b.slope[1]) / (2.0 * step) - facet.curvature[1]).abs() < 1e-5);
        let [a, b] = [at(x, y + step), at(x, y - step)];
        assert!(((a.slope[1] - b.slope[1]) / (2.0 * step) - facet.curvature[2]).abs() < 1e-5);
    }
}
