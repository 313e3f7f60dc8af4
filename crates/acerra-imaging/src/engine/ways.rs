//! Ways of echoes to the points of a row, interpolated between exact rays.
//!
//! Along a row the half path and the weight of an echo are smooth, except where the earliest ray changes its
//! crossing. The row is bisected until cubics through lengths and slopes at both ends (Hermite) agree with
//! the exact length and slope in the middle; slopes need no further rays, by Fermat's principle. Where cubics never
//! agree, every point has an exact ray.

use super::weights::WeightedPulses;

/// Points of a row that share an interpolation.
pub(crate) const BLOCK: usize = 32;

/// Allowed deviation of interpolated ways.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WayTolerance {
    /// Of half the optical length in the middle of a span, m.
    half_m: f64,
    /// Deviation of the weight in the middle from the mean of both ends, relative.
    weight: f64,
    /// Difference of the weights at both ends, relative.
    weight_change: f64,
}

impl WayTolerance {
    /// Every path is along exact rays.
    pub const EXACT: Self = Self {
        half_m: 0.0,
        weight: 0.0,
        weight_change: 0.0,
    };

    /// Tolerance such that a contribution whose shortest wave has the length `wave_m` deviates by the share
    /// `accuracy`.
    ///
    /// The deviation of a cubic grows with the fourth power of its span: the deviation of the halves, which
    /// are used, is a sixteenth of the tested one, or an eighth where curvatures jump; half of that margin is
    /// kept. Where the fourth derivative changes its sign, the length in the middle agrees and its slope
    /// deviates, over the span by thirteen times as much as the halves do. A parabola through three weights
    /// follows a smooth function to the power 3/2 of its deviation from the chord, and to a twentieth of the
    /// cube of its change: at the shoulder of a maximum a weight meets its chord.
    pub fn new(accuracy: f64, wave_m: f64) -> Self {
        Self {
            half_m: 4.0 * accuracy * wave_m / (4.0 * std::f64::consts::PI),
            weight: accuracy.powf(2.0 / 3.0),
            weight_change: 2.0 * accuracy.cbrt(),
        }
    }

    /// Whether a parabola through the weights at both ends of a span and in its middle follows the weights between, within
    /// `times` the tolerance.
    pub fn has_smooth_weight(&self, [from, middle, to]: [f64; 3], times: f64) -> bool {
        let largest = times * from.abs().max(to.abs());
        let chord = 0.5 * (from + to);
        (chord - middle).abs() <= self.weight * largest
            && (from - to).abs() <= self.weight_change * largest
    }

    /// Allowed deviation of half the optical length in the middle of a span, m.
    pub fn half_m(&self) -> f64 {
        self.half_m
    }
}

/// Half ways (m) and weights from a pulse to a block of points.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Ways {
    pub half_m: [f64; BLOCK],
    pub weight: [f64; BLOCK],
}

/// An exact path: half its length, its weight, and the change of the half length from a point to the next.
#[derive(Debug, Clone, Copy)]
struct Knot {
    at: usize,
    half_m: f64,
    weight: f64,
    slope_m: f64,
}

impl Ways {
    /// To `points_m`, at most [`BLOCK`], evenly along a line.
    pub fn along(
        echoes: &WeightedPulses,
        pulse: usize,
        points_m: &[[f64; 3]],
        tolerance: WayTolerance,
    ) -> Self {
        let mut ways = Self::default();
        let last = points_m.len().min(BLOCK) - 1;
        let steps = last.max(1) as f64;
        let step_m = std::array::from_fn(|k| (points_m[last][k] - points_m[0][k]) / steps);
        let knot = |at: usize| {
            let [half_m, weight, slope_m] = echoes.half_way(pulse, points_m[at], step_m);
            Knot {
                at,
                half_m,
                weight,
                slope_m,
            }
        };
        let first = knot(0);
        ways.set(&first);
        if last > 0 {
            let end = knot(last);
            ways.set(&end);
            ways.between(&knot, [&first, &end], tolerance);
        }
        ways
    }

    fn set(&mut self, knot: &Knot) {
        self.half_m[knot.at] = knot.half_m;
        self.weight[knot.at] = knot.weight;
    }

    /// Interpolates between two exact paths.
    fn between(
        &mut self,
        exact: &impl Fn(usize) -> Knot,
        [from, to]: [&Knot; 2],
        tolerance: WayTolerance,
    ) {
        let points = to.at - from.at;
        if points < 2 {
            return;
        }
        let middle = exact(from.at + points / 2);
        self.set(&middle);
        let is_met = |found: f64, expected: f64, within: f64| (found - expected).abs() <= within;
        let share = (middle.at - from.at) as f64 / points as f64;
        let chord = from.weight + share * (to.weight - from.weight);
        let largest = from.weight.abs().max(to.weight.abs());
        let [cubic_m, slope_m] = cubic(from, to, middle.at);
        let is_smooth = is_met(cubic_m, middle.half_m, tolerance.half_m)
            && is_met(slope_m, middle.slope_m, tolerance.half_m / points as f64)
            && is_met(chord, middle.weight, tolerance.weight * largest)
            && is_met(from.weight, to.weight, tolerance.weight_change * largest);
        if !is_smooth {
            self.between(exact, [from, &middle], tolerance);
            self.between(exact, [&middle, to], tolerance);
            return;
        }
        let [a, b, c] = [from, &middle, to].map(|knot| knot.at as f64);
        for at in from.at + 1..to.at {
            if at == middle.at {
                continue;
            }
            let (left, right) = if at < middle.at {
                (from, &middle)
            } else {
                (&middle, to)
            };
            [self.half_m[at], _] = cubic(left, right, at);
            let x = at as f64;
            self.weight[at] = from.weight * (x - b) * (x - c) / ((a - b) * (a - c))
                + middle.weight * (x - a) * (x - c) / ((b - a) * (b - c))
                + to.weight * (x - a) * (x - b) / ((c - a) * (c - b));
        }
    }
}

/// The cubic through two half ways with their slopes, and its slope from a point to the next.
fn cubic(from: &Knot, to: &Knot, at: usize) -> [f64; 2] {
    let span = (to.at - from.at) as f64;
    let t = (at - from.at) as f64 / span;
    let s = 1.0 - t;
    [
        from.half_m * s * s * (1.0 + 2.0 * t)
            + to.half_m * t * t * (1.0 + 2.0 * s)
            + span * t * s * (s * from.slope_m - t * to.slope_m),
        6.0 * t * s * (to.half_m - from.half_m) / span
            + s * (s - 2.0 * t) * from.slope_m
            + t * (t - 2.0 * s) * to.slope_m,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::weights::Weights;
    use crate::pulses::{PulseArrays, Pulses, Spreading};
    use crate::refraction::{Ground, Layer, Relief, Soil, Surface};
    use crate::sampling::Random;
    use num_complex::Complex64;

    /// Half ways and weights of antennas apart and low above level ground stay within the tolerance, also where they
    /// bend and turn within a few points.
    #[test]
    fn ways_of_low_antennas_keep_the_tolerance() {
        let soil = Soil {
            relative_permittivity: 7.0,
            conductivity_s_m: 0.0,
        };
        let surface = Surface::Level { z_m: 0.0 };
        let ground = Ground::new(surface, &[Layer::below_all(soil)], 1.5e9).unwrap();
        let mut random = Random(129);
        let mut within =
            |low: f64, high: f64| low * (high / low).powf(random.below(1_000_000) as f64 / 1e6);
        let (accuracy, wave_m) = (5e-4, 0.1);
        let tolerance = WayTolerance::new(accuracy, wave_m);
        let allowed_m = accuracy * wave_m / (4.0 * std::f64::consts::PI);
        let mut worst = [0.0f64; 2];
        for _ in 0..4000 {
            let (height_m, apart_m, aside_m) =
                (within(0.005, 0.3), within(0.01, 0.3), within(0.001, 0.3));
            let (depth_m, pixel_m) = (within(0.01, 0.3), within(0.002, 0.03));
            let middle_m = pixel_m * (within(1.0, 33.0) - 1.0);
            let antenna_m = |side: f64| [[middle_m + side * apart_m, aside_m, height_m]];
            let [sent_m, position_m, received_m] = [-0.5, 0.0, 0.5].map(antenna_m);
            let pulses = Pulses::new(PulseArrays {
                position_m: &position_m,
                frequency_hz: &[1e9, 2e9],
                spectrum: &[Complex64::ONE; 2],
                weight: &[1.0],
                light_speed_m_s: 3e8,
            })
            .unwrap()
            .with_antennas(&sent_m, &received_m)
            .unwrap()
            .with_ground(&ground)
            .unwrap();
            let weights = Weights::spreading_alone(Spreading::InverseSquare);
            let echoes = WeightedPulses::new(pulses, weights);
            let points_m: Vec<[f64; 3]> = (0..BLOCK)
                .map(|k| [pixel_m * k as f64, 0.0, -depth_m])
                .collect();
            let found = Ways::along(&echoes, 0, &points_m, tolerance);
            let exact = Ways::along(&echoes, 0, &points_m, WayTolerance::EXACT);
            for k in 0..BLOCK {
                let off_m = (found.half_m[k] - exact.half_m[k]).abs();
                let off = (found.weight[k] / exact.weight[k] - 1.0).abs();
                worst = [
                    worst[0].max(off_m / allowed_m),
                    worst[1].max(off / tolerance.weight),
                ];
            }
        }
        assert!(worst[0] < 1.0 && worst[1] < 1.0, "{worst:?}");
    }

    /// Interpolated paths over a relief deviate from exact rays by the tolerance at most, and need fewer
    /// rays.
    #[test]
    fn ways_follow_exact_rays_within_the_tolerance() {
        let height_m = |k: usize| 0.02 * (0.15 * (k % 160) as f64).sin();
        let relief = Relief::new(
            [-0.8, -0.2],
            0.02,
            160,
            (0..160 * 20).map(height_m).collect(),
        );
        let soil = Soil {
            relative_permittivity: 5.0,
            conductivity_s_m: 0.0,
        };
        let surface = Surface::Relief(relief.unwrap());
        let ground = Ground::new(surface, &[Layer::below_all(soil)], 1.5e9).unwrap();
        let position_m = [[0.3, 0.0, 0.9]];
        let pulses = Pulses::new(PulseArrays {
            position_m: &position_m,
            frequency_hz: &[1e9, 2e9],
            spectrum: &[Complex64::ONE; 2],
            weight: &[1.0],
            light_speed_m_s: 3e8,
        })
        .unwrap()
        .with_ground(&ground)
        .unwrap();
        let weights = Weights::spreading_alone(Spreading::InverseSquare);
        let echoes = WeightedPulses::new(pulses, weights);
        let points_m: Vec<[f64; 3]> = (0..BLOCK)
            .map(|k| [0.1 + 0.005 * k as f64, 0.0, -0.2])
            .collect();
        let tolerance = WayTolerance::new(1e-3, 0.15);
        let found = Ways::along(&echoes, 0, &points_m, tolerance);
        let exact = Ways::along(&echoes, 0, &points_m, WayTolerance::EXACT);
        let off = |a: &[f64; BLOCK], b: &[f64; BLOCK]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a / b - 1.0).abs())
                .fold(0.0, f64::max)
        };
        let (length, weight) = (
            off(&found.half_m, &exact.half_m),
            off(&found.weight, &exact.weight),
        );
        // 10⁻³ of a radian at 2 GHz are 1.2·10⁻⁵ m of some 1.3 m.
        assert!(length > 1e-12 && length < 1e-5, "{length}");
        assert!(weight < 1e-3, "{weight}");
    }
}
