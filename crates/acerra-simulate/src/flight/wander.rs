//! Smooth random motion: departures from an intended path by wind and the pilot.

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// A stationary, twice smoothed random process of zero mean: white noise through a critically
/// damped oscillator, x″ + 2ωx′ + ω²x = w.
#[derive(Debug)]
pub struct Wander {
    rate_rad_s: f64,
    noise_per_step: f64,
    step_s: f64,
    value: f64,
    speed: f64,
}

impl Wander {
    /// A process of standard deviation `sigma` with correlation time `time_s`, started from its stationary
    /// distribution, in steps of `step_s`.
    #[must_use]
    pub fn new(sigma: f64, time_s: f64, step_s: f64, rng: &mut ChaCha8Rng) -> Self {
        let rate_rad_s = 1.0 / time_s;
        // Var x = S/(4ω³) and Var x′ = S/(4ω) for noise of density S.
        let noise_per_step = 2.0 * sigma * rate_rad_s.powf(1.5) * step_s.sqrt();
        Self {
            rate_rad_s,
            noise_per_step,
            step_s,
            value: sigma * normal(rng),
            speed: sigma * rate_rad_s * normal(rng),
        }
    }

    /// The value after one more step.
    pub fn step(&mut self, rng: &mut ChaCha8Rng) -> f64 {
        let pull = -self.rate_rad_s * (2.0 * self.speed + self.rate_rad_s * self.value);
        self.speed += pull * self.step_s + self.noise_per_step * normal(rng);
        self.value += self.speed * self.step_s;
        self.value
    }
}

/// A standard normal deviate (Box and Muller).
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius: f64 = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
    radius * (std::f64::consts::TAU * rng.random::<f64>()).cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn spread_and_memory_are_as_asked() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (sigma, time_s, step_s) = (0.3, 2.0, 0.01);
        let mut wander = Wander::new(sigma, time_s, step_s, &mut rng);
        let x: Vec<f64> = (0..400_000).map(|_| wander.step(&mut rng)).collect();
        #[expect(clippy::cast_precision_loss, reason = "a count")]
        let mean_of = |lag: usize| {
            let pairs = x.iter().zip(&x[lag..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (x.len() - lag) as f64
        };
        let variance = mean_of(0);
        assert!(
            (variance.sqrt() / sigma - 1.0).abs() < 0.1,
            "{}",
            variance.sqrt()
        );
        // Autocorrelation (1 + ωt) e^{−ωt}: 0.736 after one time constant.
        let correlation = mean_of(200) / variance;
        assert!(
            (correlation - 2.0 * (-1.0_f64).exp()).abs() < 0.08,
            "{correlation}"
        );
    }
}
