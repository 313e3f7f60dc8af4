//! Residuals of an echo's delays as a mixture of the surface and of strays.
//!
//! A residual belongs to the surface, with a normal error of standard deviation s about the delay, or to a stray, with
//! a constant density. The delay is the one at which most residuals agree; s and the share of strays are estimated
//! from the data.

/// Smallest standard deviation of a residual, s (1.5 mm).
const LEAST_S: f64 = 0.01e-9;
/// Largest standard deviation of a residual, s (10 cm of range): ground is smoother.
const MOST_S: f64 = 0.7e-9;
/// Iterations of the expectation maximisation at most, and the relative change at which it has converged.
const MOST_ITERATIONS: usize = 20;
const CONVERGED: f64 = 1e-3;
/// Width of a cell of the histogram of residuals by which the delay is found, s.
const CELL_S: f64 = 0.1e-9;
/// Standard deviations beyond which a residual is a stray: the surface's density is below 10⁻¹⁰ of its maximum, and
/// less than 10⁻⁵ of the density of strays at the smallest error.
const REACH: f64 = 7.0;
/// Number of residuals that are evaluated together.
const LANES: usize = 8;

/// Error of the residuals and share of strays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mixture {
    pub sigma_s: f64,
    pub stray_share: f64,
}

impl Mixture {
    /// Density of the surface at its delay, 1/s.
    fn height(self) -> f64 {
        (1.0 - self.stray_share) / (self.sigma_s * std::f64::consts::TAU.sqrt())
    }
}

/// Density of strays, and the delays at which the surface may be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Agreement {
    /// Density of a stray over fast time, 1/s.
    pub chance: f64,
    /// Smallest and largest delay, s.
    pub delay_s: [f64; 2],
}

/// Memory of an evaluation.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    counts: Vec<u32>,
    residual_s: Vec<f64>,
    /// Residuals near the delay, in standard deviations from the first estimate of the delay.
    near: Vec<[f32; LANES]>,
}

impl Agreement {
    /// Log-likelihood of residuals (s) at the delay at which most residuals agree, and this delay, s. Unknown
    /// residuals (NaN: no position) are strays.
    pub fn log_likelihood(
        &self,
        residuals: impl Iterator<Item = f64>,
        mixture: Mixture,
        scratch: &mut Scratch,
    ) -> (f64, f64) {
        let sigma_s = mixture.sigma_s;
        scratch.residual_s.clear();
        scratch.residual_s.extend(residuals);
        let cell_s = CELL_S.max(sigma_s);
        let first_s = self.commonest_s(cell_s, scratch);
        // Each of two estimates of the delay moves it by less than a cell.
        scratch.gather(first_s, sigma_s, REACH + 2.0 * cell_s / sigma_s);
        let stray = mixture.stray_share * self.chance;
        // Both in standard deviations and relative to the density of strays.
        let height = (mixture.height() / stray) as f32;
        let mut delay = 0.0;
        let [low, high] = self.delay_s.map(|d| (d - first_s) / sigma_s);
        for _ in 0..2 {
            let (sum, weight) = weighted_sums(&scratch.near, height, delay as f32);
            if weight > 0.0 {
                delay = (sum / weight).clamp(low, high);
            }
        }
        let over: f64 = scratch
            .near
            .iter()
            .map(|few| log_of_ratios(few, height, delay as f32))
            .sum();
        let total = over + scratch.residual_s.len() as f64 * stray.ln();
        (total, first_s + delay * sigma_s)
    }

    /// [`Self::log_likelihood`] of given residuals.
    pub fn at_commonest(&self, residuals: &[f64], mixture: Mixture) -> (f64, f64) {
        self.log_likelihood(residuals.iter().copied(), mixture, &mut Scratch::default())
    }

    /// The mixture with error and share of strays re-estimated (expectation maximisation).
    pub fn fitted(&self, residuals: &[f64], mut mixture: Mixture) -> Mixture {
        let mut scratch = Scratch::default();
        for _ in 0..MOST_ITERATIONS {
            let (_, delay_s) =
                self.log_likelihood(residuals.iter().copied(), mixture, &mut scratch);
            let (mut power, mut weight) = (0.0, 0.0);
            for r in residuals.iter().filter(|r| r.is_finite()) {
                let w = self.surface_weight(r - delay_s, mixture);
                power += w * (r - delay_s).powi(2);
                weight += w;
            }
            if weight < 3.0 {
                return mixture;
            }
            let before = mixture;
            mixture.sigma_s = (power / weight).sqrt().clamp(LEAST_S, MOST_S);
            mixture.stray_share = (1.0 - weight / residuals.len() as f64).clamp(0.01, 0.95);
            let is_near = |now: f64, before: f64| (now - before).abs() <= CONVERGED * before;
            if is_near(mixture.sigma_s, before.sigma_s)
                && is_near(mixture.stray_share, before.stray_share)
            {
                break;
            }
        }
        mixture
    }

    /// Probability that a residual (s, from the delay) belongs to the surface.
    pub fn surface_weight(&self, residual_s: f64, mixture: Mixture) -> f64 {
        let x = residual_s / mixture.sigma_s;
        let surface = mixture.height() * (-0.5 * x * x).exp();
        surface / (surface + mixture.stray_share * self.chance)
    }

    /// The delay about which most residuals lie, s.
    fn commonest_s(&self, cell_s: f64, scratch: &mut Scratch) -> f64 {
        let [from_s, to_s] = self.delay_s;
        let cells = ((to_s - from_s) / cell_s).ceil().max(1.0) as usize;
        let counts = &mut scratch.counts;
        counts.clear();
        counts.resize(cells + 2, 0);
        let per_cell = cell_s.recip();
        for r in &scratch.residual_s {
            let x = (r - from_s) * per_cell;
            if x >= 0.0 && x < cells as f64 {
                counts[x as usize + 1] += 1;
            }
        }
        let best = (1..=cells)
            .max_by_key(|&i| counts[i - 1] + 2 * counts[i] + counts[i + 1])
            .unwrap_or(1);
        from_s + (best as f64 - 0.5) * cell_s
    }
}

impl Scratch {
    /// Gathers the residuals within `reach` standard deviations of a delay.
    fn gather(&mut self, delay_s: f64, sigma_s: f64, reach: f64) {
        // A value whose density is zero.
        const FAR: f32 = 1e3;
        self.near.clear();
        let per_sigma = sigma_s.recip();
        let (mut few, mut count) = ([FAR; LANES], 0);
        for r in &self.residual_s {
            let x = (r - delay_s) * per_sigma;
            if x.abs() <= reach {
                few[count] = x as f32;
                count += 1;
                if count == LANES {
                    self.near.push(few);
                    (few, count) = ([FAR; LANES], 0);
                }
            }
        }
        if count > 0 {
            self.near.push(few);
        }
    }
}

/// Sum of the residuals weighted by the probability that each belongs to the surface, and the sum of the weights.
fn weighted_sums(near: &[[f32; LANES]], height: f32, delay: f32) -> (f64, f64) {
    let (mut sums, mut weights) = ([0.0_f32; LANES], [0.0_f32; LANES]);
    for few in near {
        for lane in 0..LANES {
            let ratio = height * bell(few[lane] - delay);
            let weight = ratio / (ratio + 1.0);
            sums[lane] += weight * few[lane];
            weights[lane] += weight;
        }
    }
    let total = |lanes: [f32; LANES]| lanes.into_iter().map(f64::from).sum();
    (total(sums), total(weights))
}

/// Logarithm of the product of the likelihood ratios of residuals to strays.
fn log_of_ratios(few: &[f32; LANES], height: f32, delay: f32) -> f64 {
    let ratios = few.map(|x| height * bell(x - delay) + 1.0);
    ratios.into_iter().map(f64::from).product::<f64>().ln()
}

/// exp(−x²/2) to 2·10⁻⁶ of its value where it exceeds 10⁻¹⁰; without branches, so that it is evaluated in vectors.
fn bell(x: f32) -> f32 {
    /// 1.5·2²³: the sum with a small number has the nearest integer in its last bits.
    const INTEGER: f32 = 12_582_912.0;
    let exponent = (-0.5 * std::f32::consts::LOG2_E * x * x).max(-126.0);
    let shifted = exponent + INTEGER;
    let f = exponent - (shifted - INTEGER);
    // Taylor's series of 2ᶠ, −½ ≤ f ≤ ½.
    let power = 1.0
        + f * (std::f32::consts::LN_2
            + f * (0.240_226_5
                + f * (0.055_504_11
                    + f * (0.009_618_13 + f * (0.001_333_356 + f * 0.000_154_035_3)))));
    f32::from_bits(power.to_bits().wrapping_add(shifted.to_bits() << 23))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bell_is_the_exponential() {
        for k in 0..=6800 {
            let x = 1e-3 * f64::from(k);
            let want = (-0.5 * x * x).exp();
            let off = f64::from(bell(x as f32)) / want - 1.0;
            assert!(off.abs() < 1e-5, "{x}: {off}");
        }
        assert!(bell(1e3) < 1e-37);
    }

    /// Residuals of the surface about 7 ns with an error of 0.2 ns, every fifth a stray.
    fn residuals_s() -> Vec<f64> {
        let mut state = 3_u64;
        let mut uniform = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        (0..1003)
            .map(|k| match k % 5 {
                0 if k % 50 == 0 => f64::NAN,
                0 => 20e-9 * (f64::from(k) / 1003.0),
                _ => 7e-9 + 0.2e-9 * normal(),
            })
            .collect()
    }

    #[test]
    fn the_likelihood_is_that_of_every_density_by_itself() {
        let (residuals_s, agreement) = (
            residuals_s(),
            Agreement {
                chance: 0.5 / 21e-9,
                delay_s: [-1e-9, 20e-9],
            },
        );
        let mixture = agreement.fitted(
            &residuals_s,
            Mixture {
                sigma_s: 0.5e-9,
                stray_share: 0.5,
            },
        );
        assert!((mixture.sigma_s / 0.2e-9 - 1.0).abs() < 0.06, "{mixture:?}");
        assert!((mixture.stray_share - 0.2).abs() < 0.03, "{mixture:?}");
        let (total, delay_s) = agreement.at_commonest(&residuals_s, mixture);
        assert!((delay_s - 7e-9).abs() < 0.02e-9, "{delay_s}");
        let stray = mixture.stray_share * agreement.chance;
        let density = |r: &f64| {
            let x = (r - delay_s) / mixture.sigma_s;
            stray
                + mixture.height()
                    * if r.is_nan() {
                        0.0
                    } else {
                        (-0.5 * x * x).exp()
                    }
        };
        let want: f64 = residuals_s.iter().map(|r| density(r).ln()).sum();
        assert!((total - want).abs() < 1e-2, "{total} {want}");
    }
}
