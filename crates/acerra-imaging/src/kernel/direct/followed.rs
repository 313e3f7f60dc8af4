//! Rays below uneven ground, followed from a pulse at which they were traced to another.
//!
//! The surface is taken for a parabola about the crossing of a ray, and the crossing is found by two steps of Newton's
//! method. The second step's gain counts, so that the length deviates by the fourth order of the first step; spreading and
//! transmission are those of the plane tangent at the crossing.

use super::corners::{Corners, Crossings, MOST_CORNERS, TracedRays, UnevenGround};
use super::job::Job;
use crate::kernel::aligned::Aligned;
use crate::kernel::lanes::Lanes;
use crate::refraction::relief::FollowedRay;
use crate::vector::range_m;

/// Relative deviation of a weight that was followed over a segment, at most, in allowed errors: rays are followed over half
/// a segment, where they deviate by half as much at most.
const WEIGHTS_APART: f64 = 8.0;

/// Arrays of what [`FollowedRay`] holds, relative to the crossing of the first ray, `[field, corner]`.
pub(super) struct Traced {
    /// The first crossing, m.
    from_m: [f64; 3],
    numbers: Box<[Aligned<MOST_CORNERS>; FIELDS]>,
}

/// Crossing, slopes, curvatures, inverse of the second derivatives, point from the crossing, and slopes of the optical
/// length below ground along both tangents.
const FIELDS: usize = 16;

/// Rays at one end of a segment.
pub(super) struct End {
    pub rays: TracedRays,
    pub traced: [Traced; 2],
    pub rest: Box<Aligned<MOST_CORNERS>>,
}

/// Half ways of a pulse to points, m: beyond `base_m`, and the changes a pixel along the row and across; and weights.
pub(super) struct Followed {
    pub base_m: f64,
    pub beyond_m: Aligned<MOST_CORNERS>,
    pub change_m: [Aligned<MOST_CORNERS>; 2],
    pub weight: Aligned<MOST_CORNERS>,
    /// Crossings of the rays of transmitter and receiver, beyond that of the first ray, x and y (m).
    pub crossing_m: [[Aligned<MOST_CORNERS>; 2]; 2],
}

/// What all rays of a tile have in common.
#[derive(Clone, Copy)]
pub(super) struct Common {
    /// Changes of place from a pixel to the next along the row and across, m.
    pub pixels_m: [[f32; 3]; 2],
    pub index: f32,
    pub has_spreading: bool,
}

impl Followed {
    pub const NONE: Self = Self {
        base_m: 0.0,
        beyond_m: Aligned([0.0; MOST_CORNERS]),
        change_m: [const { Aligned([0.0; MOST_CORNERS]) }; 2],
        weight: Aligned([0.0; MOST_CORNERS]),
        crossing_m: [const { [const { Aligned([0.0; MOST_CORNERS]) }; 2] }; 2],
    };

    /// The crossings of the rays of `end` that were followed, those at the places `at`.
    pub fn crossings(&self, end: &End, at: impl Iterator<Item = usize> + Clone) -> Crossings {
        [0, 1].map(|antenna| {
            let (from_m, beyond_m) = (end.traced[antenna].from_m, &self.crossing_m[antenna]);
            let crossing =
                |at: usize| [0, 1].map(|axis| from_m[axis] + f64::from(beyond_m[axis].0[at]));
            at.clone().map(crossing).collect()
        })
    }
}

impl End {
    /// The rays to corners in arrays with rows of `stride`.
    pub fn of_corners(rays: TracedRays, corners: &Corners, stride: usize) -> Self {
        let laid_out: Vec<usize> = laid_out(corners, stride)
            .map(|(_, [i, j])| j * corners.columns + i)
            .collect();
        Self::new(rays, &laid_out, |k| corners.point_m(k))
    }

    /// Rays, those numbered in `laid_out` one after another.
    pub fn new(rays: TracedRays, laid_out: &[usize], point_m: impl Fn(usize) -> [f64; 3]) -> Self {
        let of_antenna = |antenna: usize| Traced::new(&rays.rays[antenna], laid_out, &point_m);
        let mut rest = Box::new(Aligned([0.0; MOST_CORNERS]));
        for (rest, k) in rest.0.iter_mut().zip(laid_out) {
            *rest = rays.rest[*k] as f32;
        }
        Self {
            traced: [0, 1].map(of_antenna),
            rest,
            rays,
        }
    }
}

/// The place in arrays with rows of `stride` corners, and the corner there: the last ones of a row or column are repeated.
pub(super) fn laid_out(
    corners: &Corners,
    stride: usize,
) -> impl Iterator<Item = (usize, [usize; 2])> {
    let (columns, rows) = (corners.columns, corners.rows);
    (0..MOST_CORNERS).map(move |at| {
        let corner = [(at % stride).min(columns - 1), (at / stride).min(rows - 1)];
        (at, corner)
    })
}

impl Traced {
    fn new(rays: &[FollowedRay], laid_out: &[usize], point_m: impl Fn(usize) -> [f64; 3]) -> Self {
        let from_m = rays.first().map_or([0.0; 3], |ray| ray.crossing_m);
        let mut numbers = Box::new([const { Aligned([0f32; MOST_CORNERS]) }; FIELDS]);
        if rays.is_empty() {
            return Self { from_m, numbers };
        }
        for (at, k) in laid_out.iter().copied().enumerate().take(MOST_CORNERS) {
            let (ray, point_m) = (&rays[k], point_m(k));
            let [x, y, z] = [0, 1, 2].map(|axis| ray.crossing_m[axis] - from_m[axis]);
            let [p, q, r] = [0, 1, 2].map(|axis| point_m[axis] - ray.crossing_m[axis]);
            let ([sx, sy], [gx, gy, gz]) = (ray.slope, ray.gradient);
            let [xx, xy, yy] = ray.curvature;
            let [hxx, hxy, hyy] = ray.inverse;
            let (along, across) = (gx + sx * gz, gy + sy * gz);
            let of_ray = [
                x, y, z, sx, sy, xx, xy, yy, hxx, hxy, hyy, p, q, r, along, across,
            ];
            for (numbers, number) in numbers.iter_mut().zip(of_ray) {
                numbers.0[at] = number as f32;
            }
        }
        Self { from_m, numbers }
    }
}

/// Whether way and weight at a place of the arrays deviate little from those of the traced rays `k` of the same pulse.
pub(super) fn is_met(
    ground: &dyn UnevenGround,
    followed: &Followed,
    at: usize,
    (traced, k): (&TracedRays, usize),
) -> bool {
    let found_m = followed.base_m + f64::from(followed.beyond_m.0[at]);
    let weight = f64::from(followed.weight.0[at]);
    let allowed = WEIGHTS_APART * ground.weight_tolerance() * traced.weight[k];
    (found_m - traced.half_m[k]).abs() <= ground.tolerance_m()
        && (weight - traced.weight[k]).abs() <= allowed
}

/// As [`follow`], compiled for the level of `s`.
#[inline(never)]
pub(super) fn follow_to<S: Lanes>(
    s: S,
    ends: [&End; 2],
    to: (&Job, usize, Common),
    out: &mut Followed,
) {
    s.vectorize(
        #[inline(always)]
        |s| follow(s, ends, to, out),
    );
}

/// Follows the rays of the nearer end of a segment to a pulse.
#[inline(always)]
pub(super) fn follow<S: Lanes>(
    s: S,
    [before, after]: [&End; 2],
    (job, pulse, common): (&Job, usize, Common),
    out: &mut Followed,
) {
    let [first, last] = [before, after].map(|end| end.rays.pulse);
    let is_late = pulse.abs_diff(first) > pulse.abs_diff(last);
    let end = if is_late { after } else { before };
    let share = pulse.abs_diff(first) as f32 / first.abs_diff(last).max(1) as f32;
    let antennas = job.antennas_m.len();
    out.base_m = 0.0;
    for at in (0..MOST_CORNERS).step_by(S::N) {
        // SAFETY: arrays hold MOST_CORNERS numbers, a multiple of N.
        unsafe {
            let a = s.load(before.rest.0.as_ptr().add(at));
            let b = s.load(after.rest.0.as_ptr().add(at));
            let rest = s.mul_add(s.splat(share), s.sub(b, a), a);
            s.store(out.weight.0.as_mut_ptr().add(at), rest);
        }
    }
    for (k, (antenna_m, traced)) in job.antennas_m.iter().zip(&end.traced).enumerate() {
        let antenna_m = [0, 1, 2].map(|axis: usize| antenna_m[axis][pulse]);
        let from_m = range_m(antenna_m, traced.from_m);
        out.base_m += from_m / antennas as f64;
        let apart = [0, 1, 2].map(|axis: usize| (traced.from_m[axis] - antenna_m[axis]) as f32);
        let of_antenna = Antenna {
            apart,
            from_m: from_m as f32,
            common,
            is_one: antennas == 1,
            is_first: k == 0,
        };
        for at in (0..MOST_CORNERS).step_by(S::N) {
            of_antenna.follow(s, &traced.numbers, at, out);
        }
    }
}

/// An antenna, from which rays are followed.
struct Antenna {
    /// From the antenna to the first crossing, m, and the distance.
    apart: [f32; 3],
    from_m: f32,
    common: Common,
    /// Whether it both sends and receives, and whether it is the first.
    is_one: bool,
    is_first: bool,
}

impl Antenna {
    #[inline(always)]
    fn follow<S: Lanes>(
        &self,
        s: S,
        numbers: &[Aligned<MOST_CORNERS>; FIELDS],
        at: usize,
        out: &mut Followed,
    ) {
        assert!(at + S::N <= MOST_CORNERS);
        // SAFETY: checked above.
        let number = |k: usize| unsafe { s.load(numbers[k].0.as_ptr().add(at)) };
        let (zero, half) = (s.splat(0.0), s.splat(0.5));
        let (one, index) = (s.splat(1.0), s.splat(self.common.index));
        let tiny = s.splat(1e-30);
        let [ax, ay, az] = self.apart;
        let apart = [s.splat(ax), s.splat(ay), s.splat(az)];
        let from_m = s.splat(self.from_m);
        let from_square = s.mul(from_m, from_m);
        let place = [number(0), number(1), number(2)];
        let slope = [number(3), number(4)];
        let [xx, xy, yy] = [number(5), number(6), number(7)];
        let inverse_second = [number(8), number(9), number(10)];
        // First step, from the crossing at the end of the segment.
        let square = s.max(s.add(from_square, beyond(s, apart, place)), tiny);
        let inverse = s.inverse_sqrt(square);
        let down = sum(s, apart, place);
        let gradient = [
            s.sub(s.mul(along(s, down, 0, slope), inverse), number(14)),
            s.sub(s.mul(along(s, down, 1, slope), inverse), number(15)),
        ];
        let [x, y] = step_of(s, inverse_second, gradient);
        let turn_x = s.mul_add(xx, x, s.mul(xy, y));
        let turn_y = s.mul_add(xy, x, s.mul(yy, y));
        let z = s.mul_add(
            x,
            s.mul_add(half, turn_x, slope[0]),
            s.mul(y, s.mul_add(half, turn_y, slope[1])),
        );
        let step = [x, y, z];
        let slope = [s.add(slope[0], turn_x), s.add(slope[1], turn_y)];
        let place = sum(s, place, step);
        let on = difference(s, [number(11), number(12), number(13)], step);
        // Second step, of which the length takes the gain.
        let beyond_square = beyond(s, apart, place);
        let square = s.max(s.add(from_square, beyond_square), tiny);
        let inverse = s.inverse_sqrt(square);
        let down = sum(s, apart, place);
        let on_square = s.max(dot(s, on, on), tiny);
        let on_inverse = s.mul(index, s.inverse_sqrt(on_square));
        let gradient = [
            s.sub(
                s.mul(along(s, down, 0, slope), inverse),
                s.mul(along(s, on, 0, slope), on_inverse),
            ),
            s.sub(
                s.mul(along(s, down, 1, slope), inverse),
                s.mul(along(s, on, 1, slope), on_inverse),
            ),
        ];
        let [x, y] = step_of(s, inverse_second, gradient);
        let twice_lost = s.mul_add(gradient[0], x, s.mul(gradient[1], y));
        let in_air = s.mul(
            beyond_square,
            s.reciprocal(s.mul_add(square, inverse, from_m)),
        );
        let length = s.mul_add(on_square, on_inverse, in_air);
        let length = s.mul_add(half, twice_lost, length);
        if self.common.has_spreading {
            // Spreading and transmission through the tangent plane at the crossing.
            let upright = s.mul_add(slope[0], slope[0], s.mul_add(slope[1], slope[1], one));
            let upright = s.inverse_sqrt(upright);
            let per_index = s.splat(1.0 / self.common.index);
            let least = s.splat(1e-6);
            let upright_air = s.mul(upright, inverse);
            let upright_soil = s.mul(upright, s.mul(on_inverse, per_index));
            let air = s.max(s.mul(falling(s, down, slope), upright_air), least);
            let soil = s.max(s.mul(falling(s, on, slope), upright_soil), least);
            let air_m = s.mul(square, inverse);
            let soil_m = s.mul(s.mul(on_square, on_inverse), s.mul(per_index, per_index));
            let (over_air, over_soil) = (s.reciprocal(air), s.reciprocal(soil));
            let along_m = s.mul_add(
                s.mul(soil_m, over_soil),
                over_soil,
                s.mul(s.mul(air_m, over_air), over_air),
            );
            let tube = s.mul(s.add(air_m, soil_m), along_m);
            let cosines = s.mul_add(index, soil, air);
            // 2/((cos + n cos)√tube) is the amplitude of one way.
            let inverse_square = s.mul(s.mul(s.splat(0.25), tube), s.mul(cosines, cosines));
            let inverse_square = s.max(inverse_square, tiny);
            let amplitude = match self.is_one {
                true => s.reciprocal(inverse_square),
                false => s.inverse_sqrt(inverse_square),
            };
            // SAFETY: checked above.
            unsafe {
                let target = out.weight.0.as_mut_ptr().add(at);
                s.store(target, s.mul(amplitude, s.load(target)));
            }
        }
        let [crossing_x, crossing_y] = &mut out.crossing_m[usize::from(!self.is_first)];
        // SAFETY: checked above.
        unsafe {
            s.store(crossing_x.0.as_mut_ptr().add(at), s.add(place[0], x));
            s.store(crossing_y.0.as_mut_ptr().add(at), s.add(place[1], y));
        }
        let z = s.mul_add(slope[0], x, s.mul(slope[1], y));
        let on = difference(s, on, [x, y, z]);
        let on_inverse = s.mul(index, s.inverse_sqrt(s.max(dot(s, on, on), tiny)));
        let share = if self.is_one { one } else { half };
        let [u, v] = self.common.pixels_m;
        let change_u = s.mul(
            dot(s, on, [s.splat(u[0]), s.splat(u[1]), s.splat(u[2])]),
            on_inverse,
        );
        let change_v = s.mul(
            dot(s, on, [s.splat(v[0]), s.splat(v[1]), s.splat(v[2])]),
            on_inverse,
        );
        let [of_u, of_v] = &mut out.change_m;
        // SAFETY: checked above.
        unsafe {
            for (target, value) in [
                (&mut out.beyond_m, length),
                (of_u, change_u),
                (of_v, change_v),
            ] {
                let target = target.0.as_mut_ptr().add(at);
                let before = if self.is_first { zero } else { s.load(target) };
                s.store(target, s.mul_add(share, value, before));
            }
        }
    }
}

#[inline(always)]
fn dot<S: Lanes>(s: S, a: [S::V; 3], b: [S::V; 3]) -> S::V {
    s.mul_add(a[0], b[0], s.mul_add(a[1], b[1], s.mul(a[2], b[2])))
}

#[inline(always)]
fn sum<S: Lanes>(s: S, a: [S::V; 3], b: [S::V; 3]) -> [S::V; 3] {
    [s.add(a[0], b[0]), s.add(a[1], b[1]), s.add(a[2], b[2])]
}

#[inline(always)]
fn difference<S: Lanes>(s: S, a: [S::V; 3], b: [S::V; 3]) -> [S::V; 3] {
    [s.sub(a[0], b[0]), s.sub(a[1], b[1]), s.sub(a[2], b[2])]
}

/// Square of the length of `apart` + `place`, less that of `apart`.
#[inline(always)]
fn beyond<S: Lanes>(s: S, apart: [S::V; 3], place: [S::V; 3]) -> S::V {
    dot(s, place, sum(s, sum(s, apart, apart), place))
}

/// Component of a vector along the tangent of a surface above an axis.
#[inline(always)]
fn along<S: Lanes>(s: S, v: [S::V; 3], axis: usize, slope: [S::V; 2]) -> S::V {
    s.mul_add(slope[axis], v[2], v[axis])
}

/// Component of a vector downwards from a surface, times the length of the surface's normal (−slope, 1).
#[inline(always)]
fn falling<S: Lanes>(s: S, v: [S::V; 3], slope: [S::V; 2]) -> S::V {
    let down = s.sub(s.splat(0.0), v[2]);
    s.mul_add(slope[0], v[0], s.mul_add(slope[1], v[1], down))
}

/// Newton's step, by the inverse of the second derivatives.
#[inline(always)]
fn step_of<S: Lanes>(s: S, [xx, xy, yy]: [S::V; 3], [g, h]: [S::V; 2]) -> [S::V; 2] {
    let x = s.mul_add(xx, g, s.mul(xy, h));
    let y = s.mul_add(xy, g, s.mul(yy, h));
    [s.sub(s.splat(0.0), x), s.sub(s.splat(0.0), y)]
}
