//! Transmission of plane waves through an interface (Born and Wolf, Principles of Optics, 1.5.2).

/// Amplitude transmitted from a medium of index `n1` into one of `n2`, electric field perpendicular to the
/// plane of incidence (TE): 2 n₁cos θ₁ / (n₁cos θ₁ + n₂cos θ₂).
///
/// `q1` and `q2` are n cos θ on either side.
#[must_use]
pub fn transmission_te(q1: f64, q2: f64) -> f64 {
    2.0 * q1 / (q1 + q2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energy_is_conserved_with_the_reflection() {
        for n2 in [1.0f64, 1.7, 3.0] {
            for degrees in [0.0f64, 20.0, 50.0, 80.0] {
                let p = degrees.to_radians().sin();
                let (q1, q2) = ((1.0 - p * p).sqrt(), (n2 * n2 - p * p).sqrt());
                let t = transmission_te(q1, q2);
                // Continuity: 1 + r = t; power flows n cos θ.
                assert!((q1 * (1.0 - (t - 1.0).powi(2)) - q2 * t * t).abs() < 1e-12);
            }
        }
        assert!((transmission_te(1.0, 2.0) - 2.0 / 3.0).abs() < 1e-15);
    }
}
