//! Rays below uneven ground to the corners of squares of pixels, and tests of polynomials between the corners.
//!
//! The crossing of a ray is followed from that of an earlier pulse, or from a corner nearby, by Newton's method. Of each
//! pulse one corner is searched for the earliest ray of all, in turn, and so are corners about which ways are not
//! smooth: where the ray of a corner nearby belongs to an earlier minimum, it is taken.

use super::ways::WayTolerance;
use super::weights::WeightedPulses;
use crate::kernel::direct::corners::{Corners, Crossings, TracedRays, UnevenGround, Within};
use crate::kernel::direct::job::SIDE;
use crate::pulses::Spreading;
use crate::refraction::relief::{FollowedRay, Relief, Search};
use crate::refraction::{Ground, Ray, Surface};
use crate::sampling::Random;
use crate::vector::range_m;

/// Corners from one that is searched to the next, at the first pulse.
const SEARCHED: usize = 4;
/// Most pulses of a segment.
const MOST_PULSES: usize = 64;
/// Motion of an antenna over a segment, at most, as a share of the antenna's height above the ground.
const MOTION_SHARE: f64 = 0.5;
/// Motion of a crossing over a segment, at most, as a share of the distance of the surface's heights.
const CROSSING_SHARE: f64 = 0.5;
/// Share of the tolerance to which the length of a ray is found.
const FOUND_SHARE: f64 = 0.01;
/// Distance of a crossing from where the ray to a corner lets it be expected, as a share of the corners' distance, from
/// which on the crossing about that place is tried too.
const OTHER_SHARE: f64 = 0.5;
/// Allowed deviations of the cubic and of the weight in the middle of two squares, as multiples of the tolerances of
/// [`WayTolerance`]: polynomials are used over one square, where the root mean square of their deviations is smaller.
const OVER_SQUARES: f64 = 4.0;
const WEIGHT_OVER_SQUARES: f64 = 2.0;
/// Times that rays nearby are tried.
const REPAIRS: usize = 4;

/// An uneven surface above the pixels, and the pulses that see these.
pub(crate) struct UnevenRays<'a> {
    echoes: &'a WeightedPulses<'a>,
    ground: &'a Ground,
    relief: &'a Relief,
    tolerance: WayTolerance,
    weight_tolerance: f64,
}

impl<'a> UnevenRays<'a> {
    /// Rays of which ways deviate by a share `accuracy` of the phase of a wave of `wave_m`; `None` unless pulses see
    /// through an uneven surface.
    pub fn new(echoes: &'a WeightedPulses<'a>, accuracy: f64, wave_m: f64) -> Option<Self> {
        let ground = echoes.pulses.ground()?;
        let Surface::Relief(relief) = ground.surface() else {
            return None;
        };
        Some(Self {
            echoes,
            ground,
            relief,
            tolerance: WayTolerance::new(accuracy, wave_m),
            weight_tolerance: accuracy,
        })
    }

    fn antennas(&self) -> usize {
        1 + usize::from(self.echoes.pulses.is_bistatic())
    }

    fn search(&self, antenna_m: [f64; 3], point_m: [f64; 3]) -> Search<'a> {
        self.relief.search(self.index(), antenna_m, point_m)
    }

    fn found_m(&self) -> f64 {
        FOUND_SHARE * self.tolerance.half_m()
    }

    /// Share of the motion of a point by which the crossing of a ray moves, about: that of level ground straight below an
    /// antenna.
    fn share(&self, antenna_m: [f64; 3], point_m: [f64; 3]) -> f64 {
        let [height_m, depth_m] = [
            -self.ground.depth_m(antenna_m),
            self.ground.depth_m(point_m),
        ];
        let air_m = self.index() * height_m.max(0.0);
        air_m / (air_m + depth_m.max(1e-6))
    }

    /// The ray to a corner about the crossing of the ray to another.
    fn beside(
        &self,
        (antenna_m, points_m): ([f64; 3], [[f64; 3]; 2]),
        (crossing_m, share): ([f64; 3], f64),
    ) -> FollowedRay {
        let start = start(points_m, crossing_m, share);
        self.search(antenna_m, points_m[1])
            .follow(start, self.found_m())
    }

    /// Adds half the optical length of a way, and its weight, along the rays `k`.
    fn add_way(&self, rays: &mut TracedRays, k: usize, point_m: [f64; 3]) {
        let antennas_m = self.echoes.pulses.antennas_m(rays.pulse);
        let whole = |antenna: usize| -> Ray {
            let search = self.search(antennas_m[antenna], point_m);
            search.ray_of(&rays.rays[antenna][k])
        };
        let first = whole(0);
        let second = if self.antennas() > 1 { whole(1) } else { first };
        let [half_m, weight] = self.echoes.along_rays(rays.pulse, &[first, second]);
        let spread = match self.has_spreading() {
            true => first.amplitude * second.amplitude,
            false => 1.0,
        };
        rays.half_m.push(half_m);
        rays.weight.push(weight);
        rays.rest.push(weight / spread);
    }

    /// The earliest ray of all.
    fn earliest(&self, antenna_m: [f64; 3], point_m: [f64; 3]) -> FollowedRay {
        let search = self.search(antenna_m, point_m);
        search.follow(search.earliest(), self.found_m())
    }

    /// Rays of an antenna to all corners at the first pulse: searched for at some, and found from the nearest of these.
    fn first(&self, corners: &Corners, antenna_m: [f64; 3]) -> Vec<FollowedRay> {
        let node = |at: usize, count: usize| {
            let nearest = (at + SEARCHED / 2) / SEARCHED * SEARCHED;
            nearest.min((count - 1) / SEARCHED * SEARCHED)
        };
        let columns = corners.columns;
        let share = self.share(antenna_m, corners.middle_m());
        let mut rays = vec![FollowedRay::default(); corners.count()];
        for pass in [true, false] {
            for k in 0..corners.count() {
                let (i, j) = (k % columns, k / columns);
                let from = node(j, corners.rows) * columns + node(i, columns);
                let point_m = corners.point_m(k);
                if pass && from == k {
                    rays[k] = self.earliest(antenna_m, point_m);
                } else if !pass && from != k {
                    let points_m = [corners.point_m(from), point_m];
                    let from = (rays[from].crossing_m, share);
                    rays[k] = self.beside((antenna_m, points_m), from);
                }
            }
        }
        rays
    }

    /// Rays of an antenna to all corners, found about the crossings `near`.
    fn next(
        &self,
        corners: &Corners,
        antenna_m: [f64; 3],
        (near, searched): (&[[f64; 2]], usize),
    ) -> Vec<FollowedRay> {
        let found_m = self.found_m();
        let of_corner = |(k, start): (usize, &[f64; 2])| {
            let search = self.search(antenna_m, corners.point_m(k));
            let found = search.follow(*start, found_m);
            if k != searched {
                return found;
            }
            let earliest = search.follow(search.earliest(), found_m);
            match earliest.optical_m < found.optical_m - found_m {
                true => earliest,
                false => found,
            }
        };
        near.iter().enumerate().map(of_corner).collect()
    }

    /// Ways and weights along the rays of a pulse to corners.
    fn measure(&self, corners: &Corners, rays: &mut TracedRays) {
        let [u, v] = corners.steps_m;
        let along = |ray: &FollowedRay, step_m: [f64; 3]| -> f64 {
            (0..3).map(|axis| ray.gradient[axis] * step_m[axis]).sum()
        };
        let count = corners.count();
        rays.half_m = Vec::with_capacity(count);
        rays.change_m = Vec::with_capacity(count);
        rays.weight = Vec::with_capacity(count);
        rays.rest = Vec::with_capacity(count);
        for k in 0..count {
            let point_m = corners.point_m(k);
            let of = |antenna: usize| &rays.rays[antenna.min(self.antennas() - 1)][k];
            let [sent, received] = [of(0), of(1)];
            let change_m =
                [u, v].map(|step_m| 0.5 * (along(sent, step_m) + along(received, step_m)));
            self.add_way(rays, k, point_m);
            rays.change_m.push(change_m);
        }
        rays.is_smooth = (0..count)
            .map(|k| self.is_smooth(corners, rays, k))
            .collect();
    }

    /// Whether a cubic from the corner before to the one after meets the way of a corner and its slope, along the row and
    /// across, and a parabola its weight.
    fn is_smooth(&self, corners: &Corners, rays: &TracedRays, k: usize) -> bool {
        let tolerance_m = OVER_SQUARES * self.tolerance.half_m();
        let (columns, rows) = (corners.columns, corners.rows);
        let of = |antenna: usize| &rays.rays[antenna][k];
        if !(0..self.antennas()).all(|antenna| of(antenna).is_minimum)
            || self.ground.depth_m(corners.point_m(k)) <= 0.0
        {
            return false;
        }
        let lines = [(k % columns, columns, 1), (k / columns, rows, columns)];
        lines
            .into_iter()
            .enumerate()
            .all(|(axis, (at, count, step))| {
                if at == 0 || at + 1 == count {
                    return true;
                }
                let [before, after] = [k - step, k + step];
                let ends_m = [rays.half_m[before], rays.half_m[after]];
                let slopes_m = [rays.change_m[before][axis], rays.change_m[after][axis]];
                // Over two steps, to the middle.
                let cubic_m = 0.5 * (ends_m[0] + ends_m[1]) + 0.25 * (slopes_m[0] - slopes_m[1]);
                let slope_m = 0.75 * (ends_m[1] - ends_m[0]) - 0.25 * (slopes_m[0] + slopes_m[1]);
                let over_points = 1.0 / (2 * SIDE) as f64;
                let slope_off_m = (slope_m - rays.change_m[k][axis]) / SIDE as f64;
                (cubic_m - rays.half_m[k]).abs() <= tolerance_m
                    && slope_off_m.abs() <= tolerance_m * over_points
                    && (self.tolerance).has_smooth_weight(
                        [before, k, after].map(|k| rays.weight[k]),
                        WEIGHT_OVER_SQUARES,
                    )
            })
    }

    /// Takes rays about the crossings of neighbours where these are earlier, at corners that are not smooth; whether any is.
    fn repair(&self, corners: &Corners, rays: &mut TracedRays) -> bool {
        let antennas_m = self.echoes.pulses.antennas_m(rays.pulse);
        let (columns, rows) = (corners.columns, corners.rows);
        let mut is_changed = false;
        for (antenna, antenna_m) in antennas_m.into_iter().enumerate().take(self.antennas()) {
            let share = self.share(antenna_m, corners.middle_m());
            for k in (0..corners.count()).filter(|k| !rays.is_smooth[*k]) {
                let (i, j) = (k % columns, k / columns);
                let neighbours = [
                    (i > 0).then(|| k - 1),
                    (i + 1 < columns).then(|| k + 1),
                    (j > 0).then(|| k - columns),
                    (j + 1 < rows).then(|| k + columns),
                ];
                for l in neighbours.into_iter().flatten() {
                    // Both ways: either may have the earlier minimum.
                    for [from, to] in [[l, k], [k, l]] {
                        let points_m = [from, to].map(|k| corners.point_m(k));
                        let crossing_m = rays.rays[antenna][from].crossing_m;
                        let found = self.beside((antenna_m, points_m), (crossing_m, share));
                        let kept = &mut rays.rays[antenna][to];
                        if found.optical_m < kept.optical_m - self.found_m() {
                            *kept = found;
                            is_changed = true;
                        }
                    }
                }
            }
        }
        is_changed
    }
}

/// About where the ray to the second of two points crosses the surface, after that to the first: a crossing moves by a share
/// of the motion of the point.
fn start([from_m, to_m]: [[f64; 3]; 2], crossing_m: [f64; 3], share: f64) -> [f64; 2] {
    [0, 1].map(|axis| crossing_m[axis] + share * (to_m[axis] - from_m[axis]))
}

impl UnevenGround for UnevenRays<'_> {
    fn index(&self) -> f64 {
        self.ground.largest_index()
    }

    fn tolerance_m(&self) -> f64 {
        self.tolerance.half_m()
    }

    fn has_spreading(&self) -> bool {
        self.echoes.weights.spreading == Spreading::InverseSquare
    }

    fn weight_tolerance(&self) -> f64 {
        self.weight_tolerance
    }

    fn segment_end(&self, first: usize, last: usize, point_m: [f64; 3]) -> usize {
        let pulses = &self.echoes.pulses;
        let start_m = pulses.antennas_m(first);
        let is_near = |pulse: &usize| {
            (pulses.antennas_m(*pulse).iter().zip(start_m)).all(|(antenna_m, start_m)| {
                let height_m = -self.ground.depth_m(start_m);
                let share = 1.0 - self.share(start_m, point_m);
                let of_crossing_m = CROSSING_SHARE * self.relief.step_m() / share.max(1e-6);
                range_m(*antenna_m, start_m) <= of_crossing_m.min(MOTION_SHARE * height_m)
            })
        };
        (first + 1..=last.min(first + MOST_PULSES))
            .take_while(is_near)
            .last()
            .unwrap_or((first + 1).min(last))
    }

    fn trace(&self, corners: &Corners, pulse: usize, near: Option<&Crossings>) -> TracedRays {
        let antennas_m = self.echoes.pulses.antennas_m(pulse);
        let mut rays = TracedRays {
            pulse,
            ..TracedRays::default()
        };
        for antenna in 0..self.antennas() {
            rays.rays[antenna] = match near {
                None => self.first(corners, antennas_m[antenna]),
                Some(near) => {
                    // Drawn at random, so that segments of equal length visit all corners.
                    let searched = Random(pulse as u64).below(corners.count());
                    self.next(corners, antennas_m[antenna], (&near[antenna], searched))
                }
            };
        }
        self.measure(corners, &mut rays);
        for _ in 0..REPAIRS {
            if !self.repair(corners, &mut rays) {
                break;
            }
            self.measure(corners, &mut rays);
        }
        rays
    }

    fn trace_within(
        &self,
        points: &[Within],
        (corners, around): (&Corners, &TracedRays),
        near: Option<&Crossings>,
    ) -> TracedRays {
        let pulse = around.pulse;
        let antennas_m = self.echoes.pulses.antennas_m(pulse);
        let mut rays = TracedRays {
            pulse,
            ..TracedRays::default()
        };
        for (antenna, antenna_m) in antennas_m.into_iter().enumerate().take(self.antennas()) {
            let of_corners = &around.rays[antenna];
            let share = self.share(antenna_m, corners.middle_m());
            let apart_m = range_m(corners.point_m(0), corners.point_m(1));
            let other_m2 = (OTHER_SHARE * apart_m).powi(2);
            let of_point = |(k, within): (usize, &Within)| {
                let point_m = within.point_m;
                let beside = |corner: usize| {
                    let points_m = [corners.point_m(corner), point_m];
                    start(points_m, of_corners[corner].crossing_m, share)
                };
                let first = match near {
                    None => beside(within.corners[0]),
                    Some(near) => near[antenna][k],
                };
                let search = self.search(antenna_m, point_m);
                let mut found = search.follow(first, self.found_m());
                for corner in within.corners {
                    let start = beside(corner);
                    let [x, y, _] = found.crossing_m;
                    if (start[0] - x).powi(2) + (start[1] - y).powi(2) > other_m2 {
                        let other = search.follow(start, self.found_m());
                        if other.optical_m < found.optical_m {
                            found = other;
                        }
                    }
                }
                found
            };
            rays.rays[antenna] = points.iter().enumerate().map(of_point).collect();
        }
        for (k, within) in points.iter().enumerate() {
            self.add_way(&mut rays, k, within.point_m);
            let is_minimum = (0..self.antennas()).all(|a| rays.rays[a][k].is_minimum);
            rays.is_smooth
                .push(is_minimum && self.ground.depth_m(within.point_m) > 0.0);
        }
        rays
    }

    fn between(
        &self,
        (pulse, point_m): (usize, [f64; 3]),
        (ends, k): ([&TracedRays; 2], usize),
        share: f64,
    ) -> [f64; 2] {
        let antennas_m = self.echoes.pulses.antennas_m(pulse);
        let is_below = self.ground.depth_m(point_m) > 0.0;
        let ray = |antenna: usize| {
            if !is_below {
                return self.ground.ray(antennas_m[antenna], point_m);
            }
            let search = self.search(antennas_m[antenna], point_m);
            let ends = ends.map(|end| {
                let [x, y, _] = end.rays[antenna][k].crossing_m;
                [x, y]
            });
            search.ray(search.between(ends, share, self.tolerance.half_m()))
        };
        let first = ray(0);
        let second = if self.antennas() > 1 { ray(1) } else { first };
        self.echoes.along_rays(pulse, &[first, second])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::weights::Weights;
    use crate::pulses::{PulseArrays, Pulses};
    use crate::refraction::{Layer, Soil};
    use num_complex::Complex64;
    use std::f64::consts::TAU;

    /// Rays to corners and to points within squares, found from those of an earlier pulse, are the earliest ones of all;
    /// so are rays between pulses.
    #[test]
    fn rays_that_follow_from_others_are_the_earliest() {
        let height_m = |k: usize| {
            let (x, y) = (0.05 * (k % 121) as f64, 0.05 * (k / 121) as f64);
            0.04 * (TAU * x / 1.2).sin() * (TAU * y / 1.5 + 1.0).cos()
        };
        let heights_m = (0..121 * 121).map(height_m).collect();
        let surface = Surface::Relief(Relief::new([-3.0; 2], 0.05, 121, heights_m).unwrap());
        let soil = Soil {
            relative_permittivity: 6.0,
            conductivity_s_m: 0.01,
        };
        let ground = Ground::new(surface, &[Layer::below_all(soil)], 1.5e9).unwrap();
        let places_m = |by_m: f64| -> Vec<[f64; 3]> {
            let place_m = |m: usize| [0.02 * m as f64 + by_m, 0.01 * (m as f64).sin(), 1.0];
            (0..12).map(place_m).collect()
        };
        let (position_m, sent_m, received_m) = (places_m(0.0), places_m(-0.1), places_m(0.1));
        let pulses = Pulses::new(PulseArrays {
            position_m: &position_m,
            frequency_hz: &[1e9, 2e9],
            spectrum: &[Complex64::ONE; 24],
            weight: &[0.5; 12],
            light_speed_m_s: 3e8,
        })
        .unwrap()
        .with_antennas(&sent_m, &received_m)
        .unwrap()
        .with_ground(&ground)
        .unwrap();
        let weights = Weights::spreading_alone(Spreading::InverseSquare);
        let echoes = WeightedPulses::new(pulses, weights);
        let rays = UnevenRays::new(&echoes, 5e-4, 0.2).unwrap();
        let corners = Corners {
            origin_m: [-0.3, -0.4, -0.3],
            steps_m: [[0.04, 0.0, 0.0], [0.0, 0.04, 0.0]],
            columns: 17,
            rows: 9,
        };
        let within_m = FOUND_SHARE * rays.tolerance_m();
        let is_exact = |pulse: usize, point_m: [f64; 3], [half_m, weight]: [f64; 2]| {
            let [exact_m, exact, _] = echoes.half_way(pulse, point_m, [0.0; 3]);
            let off_m = (half_m - exact_m).abs();
            assert!(off_m <= within_m, "{off_m} at {pulse}, {point_m:?}");
            assert!(
                (0.5 * weight / exact - 1.0).abs() < 1e-3,
                "{weight} {exact}"
            );
        };
        let to = rays.segment_end(0, 11, corners.middle_m());
        assert!((3..12).contains(&to), "{to}");
        let first = rays.trace(&corners, 0, None);
        let crossings = [0, 1].map(|antenna: usize| {
            let of_ray = |ray: &FollowedRay| [ray.crossing_m[0], ray.crossing_m[1]];
            first.rays[antenna].iter().map(of_ray).collect()
        });
        let last = rays.trace(&corners, to, Some(&crossings));
        let mut smooth = 0;
        for traced in [&first, &last] {
            for k in 0..corners.count() {
                let way = [traced.half_m[k], traced.weight[k]];
                is_exact(traced.pulse, corners.point_m(k), way);
                smooth += usize::from(traced.is_smooth[k]);
            }
        }
        assert!(smooth > corners.count(), "{smooth}");
        let points: Vec<Within> = (0..8 * 16)
            .map(|k| {
                let (i, j) = (k % 16, k / 16);
                let corner = j * 17 + i;
                let [x, y, z] = corners.point_m(corner);
                Within {
                    point_m: [x + 0.013, y + 0.007, z],
                    corners: [corner, corner + 1, corner + 17, corner + 18],
                }
            })
            .collect();
        let ends = [&first, &last].map(|of| rays.trace_within(&points, (&corners, of), None));
        for (k, point) in points.iter().enumerate() {
            for end in &ends {
                is_exact(end.pulse, point.point_m, [end.half_m[k], end.weight[k]]);
            }
            for pulse in 0..=to {
                let share = pulse as f64 / to as f64;
                let at = (pulse, point.point_m);
                let [half_m, weight] = rays.between(at, ([&ends[0], &ends[1]], k), share);
                let [exact_m, exact, _] = echoes.half_way(pulse, point.point_m, [0.0; 3]);
                assert!((half_m - exact_m).abs() < rays.tolerance_m());
                assert!((0.5 * weight / exact - 1.0).abs() < 1e-2);
            }
        }
    }
}
