//! Snell's law through level layers.

use super::fresnel::transmission_te;
use super::ray::MAX_LAYERS;

/// Media along a ray, from the antenna down: vertical extents and refractive indices.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stack {
    /// Height of the antenna above the surface, m, above 0.
    pub height_m: f64,
    /// Vertical extent of the ray in each layer of ground, m.
    pub depth_m: [f64; MAX_LAYERS],
    /// Refractive index of each layer, at least 1.
    pub index: [f64; MAX_LAYERS],
    /// Number of layers crossed, at least 1.
    pub layers: usize,
}

/// A ray through a stack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StackRay {
    /// Optical length, m.
    pub optical_m: f64,
    /// Sine and cosine of the angle from the vertical in air.
    pub sine: f64,
    pub cosine: f64,
    /// Refractive index of the last layer times the cosine of the angle from the vertical there.
    pub last_cosine_index: f64,
    /// Length in each layer, m.
    pub soil_m: [f64; MAX_LAYERS],
    /// Amplitude at the end for 1/m at a distance of 1 m in air: transmission and spreading, 1/m.
    pub amplitude: f64,
}

/// Change of the slope, relative to 1 + slope, at which the search ends: the optical length is stationary, so
/// that its relative error is the square of this change.
const CONVERGED: f64 = 1e-9;
/// Steps after which the search ends in any case.
const MOST_STEPS: usize = 60;

impl Stack {
    fn media(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        (self.depth_m.iter().zip(&self.index))
            .take(self.layers)
            .map(|(d, n)| (*d, *n))
    }

    /// Horizontal distance that a ray of the slope u = tan θ in air covers, m, and its derivative.
    ///
    /// L(u) = h u + Σ d p/√(n² − p²), p = u/√(1 + u²) = n sin θ being equal in all media. Each term rises and
    /// is concave for n ≥ 1.
    fn distance_m(&self, slope: f64) -> [f64; 2] {
        let cosine = 1.0 / (1.0 + slope * slope).sqrt();
        let p = slope * cosine;
        self.media().fold(
            [self.height_m * slope, self.height_m],
            |[sum, change], (d, n)| {
                let q2 = n * n - p * p;
                let q = q2.sqrt();
                let ratio = cosine / q;
                [sum + d * p / q, change + d * n * n * ratio * ratio * ratio]
            },
        )
    }

    /// Slope tan θ in air of the ray that covers `distance_m`.
    ///
    /// Newton's method on a function that rises and is concave, from a start at or below the root, stays
    /// below it and converges. The function's tangent at 0 and its asymptote bound the function from above,
    /// and so the root from below.
    pub fn slope(&self, distance_m: f64) -> f64 {
        let steep = self.media().map(|(d, n)| d / n).sum::<f64>() + self.height_m;
        let flat: f64 = self.media().map(|(d, n)| d / (n * n - 1.0).sqrt()).sum();
        let mut slope = (distance_m / steep).max((distance_m - flat) / self.height_m);
        for _ in 0..MOST_STEPS {
            let [found, change] = self.distance_m(slope);
            let step = (distance_m - found) / change;
            slope += step;
            if step.abs() <= CONVERGED * (1.0 + slope) {
                break;
            }
        }
        slope
    }

    /// The ray that covers `distance_m` horizontally.
    pub fn ray(&self, distance_m: f64) -> StackRay {
        self.ray_of_slope(self.slope(distance_m), distance_m)
    }

    /// The ray of the slope tan θ in air, which covers `distance_m` horizontally.
    pub fn ray_of_slope(&self, slope: f64, distance_m: f64) -> StackRay {
        let cosine = 1.0 / (1.0 + slope * slope).sqrt();
        let p = slope * cosine;
        // p L + Σ z √(n² − p²) is stationary in p at the ray.
        let mut optical_m = p * distance_m + self.height_m * cosine;
        let mut soil_m = [0.0; MAX_LAYERS];
        // L/p, and dL/dp.
        let mut across_m = self.height_m / cosine;
        let mut along_m = self.height_m / cosine.powi(3);
        let (mut transmitted, mut last) = (1.0, (1.0, cosine));
        for ((d, n), length) in self.media().zip(&mut soil_m) {
            let q = (n * n - p * p).sqrt();
            optical_m += d * q;
            *length = d * n / q;
            across_m += d / q;
            along_m += d * n * n / (q * q * q);
            transmitted *= transmission_te(last.1, q);
            last = (n, q);
        }
        // A tube of rays about dΩ = sin θ dθ dφ has the cross-section L dφ · dL cos θ_last. In crossing an
        // interface it narrows by the ratio of the cosines.
        let last_cosine = last.1 / last.0;
        let tube_m2 = across_m * along_m * cosine * last_cosine;
        StackRay {
            optical_m,
            sine: p,
            cosine,
            last_cosine_index: last.1,
            soil_m,
            amplitude: transmitted * (last_cosine / (cosine * tube_m2)).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::Random;

    fn stack(height_m: f64, media: &[(f64, f64)]) -> Stack {
        let mut stack = Stack {
            height_m,
            depth_m: [0.0; MAX_LAYERS],
            index: [1.0; MAX_LAYERS],
            layers: media.len(),
        };
        for (k, (d, n)) in media.iter().enumerate() {
            (stack.depth_m[k], stack.index[k]) = (*d, *n);
        }
        stack
    }

    fn uniform(random: &mut Random, low: f64, high: f64) -> f64 {
        low + (high - low) * random.below(1_000_000) as f64 / 1e6
    }

    /// Least optical length over the crossing point by golden sections.
    fn by_search(h: f64, d: f64, n: f64, distance: f64) -> f64 {
        let f = |x: f64| x.hypot(h) + n * (distance - x).hypot(d);
        let (mut a, mut b) = (0.0, distance);
        for _ in 0..200 {
            let w = 0.381_966_011_250_105 * (b - a);
            if f(a + w) < f(b - w) { b -= w } else { a += w }
        }
        f(0.5 * (a + b))
    }

    #[test]
    fn no_other_crossing_is_earlier() {
        let mut random = Random(11);
        for _ in 0..2000 {
            let h = 10f64.powf(uniform(&mut random, -2.0, 3.0));
            let d = 10f64.powf(uniform(&mut random, -4.0, 0.5));
            let n = uniform(&mut random, 1.0, 6.0);
            let distance = h * 10f64.powf(uniform(&mut random, -3.0, 1.5));
            let found = stack(h, &[(d, n)]).ray(distance).optical_m;
            let expected = by_search(h, d, n, distance);
            assert!(
                (found - expected).abs() < 1e-13 * expected.max(1.0),
                "{h} {d} {n} {distance}: {found} {expected}"
            );
        }
    }

    /// A layer divided into two of the same soil is equivalent to the undivided layer.
    #[test]
    fn layers_add_up() {
        let mut random = Random(5);
        for _ in 0..500 {
            let (h, d) = (
                uniform(&mut random, 0.3, 25.0),
                uniform(&mut random, 0.01, 2.0),
            );
            let (n, m) = (
                uniform(&mut random, 1.0, 5.0),
                uniform(&mut random, 1.0, 5.0),
            );
            let distance = uniform(&mut random, 0.0, 30.0);
            let whole = stack(h, &[(d, n), (0.4, m)]).ray(distance);
            let parts = stack(h, &[(0.3 * d, n), (0.7 * d, n), (0.1, m), (0.3, m)]).ray(distance);
            assert!((whole.optical_m - parts.optical_m).abs() < 1e-12);
            assert!((whole.amplitude / parts.amplitude - 1.0).abs() < 1e-10);
            assert!((whole.soil_m[0] - parts.soil_m[0] - parts.soil_m[1]).abs() < 1e-9);
            // Snell's law: the optical length changes with the distance by n sin θ.
            let step = 1e-5;
            let beyond = stack(h, &[(d, n), (0.4, m)]).ray(distance + step);
            let slope = (beyond.optical_m - whole.optical_m) / step;
            assert!((slope - 0.5 * (whole.sine + beyond.sine)).abs() < 1e-6);
        }
    }

    #[test]
    fn without_contrast_the_ray_is_straight() {
        let ray = stack(3.0, &[(1.0, 1.0)]).ray(2.0);
        let range = 4f64.hypot(2.0);
        assert!((ray.optical_m - range).abs() < 1e-13);
        assert!((ray.amplitude * range - 1.0).abs() < 1e-12);
        assert!((ray.cosine - 4.0 / range).abs() < 1e-12);
    }

    /// Sources and receivers may be exchanged: Green's function from below equals that from above, whose
    /// amplitude is here computed from the tube of rays that leaves the buried point.
    #[test]
    fn amplitudes_are_reciprocal() {
        let (h, d, n, distance) = (1.3, 0.4, 2.5, 1.1);
        let ray = stack(h, &[(d, n)]).ray(distance);
        let p = ray.sine;
        let soil_rad = |p: f64| (p / n).asin();
        let reached = |t: f64| d * t.tan() + h * (n * t.sin()).asin().tan();
        let (t, step) = (soil_rad(p), 1e-6);
        let change = (reached(t + step) - reached(t - step)) / (2.0 * step);
        let tube_m2 = distance / t.sin() * change * ray.cosine;
        let up = transmission_te(n * t.cos(), ray.cosine) * (ray.cosine / t.cos() / tube_m2).sqrt();
        assert!(
            (up / ray.amplitude - 1.0).abs() < 1e-7,
            "{up} {}",
            ray.amplitude
        );
    }
}
