//! Normally distributed numbers.

use rand_chacha::rand_core::RngCore;

/// Standard normal numbers by the transform of Box and Muller.
pub(super) struct Normal<R> {
    random: R,
    spare: Option<f64>,
}

impl<R: RngCore> Normal<R> {
    pub fn new(random: R) -> Self {
        Self {
            random,
            spare: None,
        }
    }

    pub fn draw(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        const UNIT: f64 = 1.0 / (1u64 << 53) as f64;
        // (0, 1]: the logarithm stays finite.
        let u = ((self.random.next_u64() >> 11) + 1) as f64 * UNIT;
        let turn = (self.random.next_u64() >> 11) as f64 * UNIT;
        let radius = (-2.0 * u.ln()).sqrt();
        let (sin, cos) = (2.0 * std::f64::consts::PI * turn).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }
}
