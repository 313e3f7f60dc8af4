//! Which traces were made in motion.

use anyhow::bail;

/// Faster than this over ground is moving (m/s): beyond what a hovering drone sways, below any
/// survey speed.
const MOVING_M_S: f64 = 0.3;

/// Tells motion from hovering: faster than 0.3 m/s over ground, or than half the highest speed on
/// platforms that never get so fast (rails, arms).
///
/// # Errors
/// A platform that does not move at all.
pub fn moving(speed_m_s: &[f64]) -> anyhow::Result<Vec<bool>> {
    let fastest = speed_m_s.iter().copied().fold(0.0, f64::max);
    if fastest < 1e-3 {
        bail!(
            "[radar] select = \"moving\": the platform never moves over ground (fastest \
             {fastest:.4} m/s)"
        );
    }
    let threshold = MOVING_M_S.min(0.5 * fastest);
    Ok(speed_m_s.iter().map(|v| *v > threshold).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hovering_and_slow_rails_are_told_apart() {
        assert_eq!(
            moving(&[0.02, 0.1, 1.5, 0.31, 0.0]).unwrap(),
            [false, false, true, true, false]
        );
        assert_eq!(
            moving(&[0.0, 0.05, 0.04, 0.01]).unwrap(),
            [false, true, true, false]
        );
        assert!(
            moving(&[0.0, 0.0])
                .unwrap_err()
                .to_string()
                .contains("never moves")
        );
        assert!(moving(&[]).is_err());
    }
}
