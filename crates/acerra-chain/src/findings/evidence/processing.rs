//! What processing choices do to the echoes: spacing of the frequencies, length of the background.

use super::finding::{Finding, Verdict};

/// Speed of light in vacuum (m/s).
const LIGHT_SPEED_M_S: f64 = 299_792_458.0;

/// Spacing of the frequencies, and the ranges that the data hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyGrid {
    /// Distance of neighbouring frequencies (Hz).
    pub step_hz: f64,
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
    /// Longest span of ranges that the data of one trace hold (m).
    pub range_span_m: f64,
}

/// Judges the spacing of the frequencies: an echo repeats in range every c/(2Δf), so that a span of
/// ranges longer than that folds onto itself.
#[must_use]
pub fn frequency_step(grid: &FrequencyGrid) -> Finding {
    let unambiguous_m = 0.5 * grid.light_speed_m_s / grid.step_hz;
    let verdict = if grid.range_span_m <= unambiguous_m {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("frequency_step", unambiguous_m, "m", verdict)
        .expecting(grid.range_span_m)
        .because(format!(
            "at frequencies {:.3} MHz apart echoes repeat every {unambiguous_m:.2} m of range, the \
             data hold {:.2} m ([image] frequencies, band_ghz; [preprocess] gate_ns)",
            1e-6 * grid.step_hz,
            grid.range_span_m
        ))
}

/// A background that is the mean of a window of traces about each trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BackgroundWindow {
    /// Path flown over the window (m).
    pub path_m: f64,
    /// Wavelength (m).
    pub wavelength_m: f64,
    /// Range of the scene (m).
    pub range_m: f64,
}

/// Judges the length of a background window by the first Fresnel zone, √(λR/2).
///
/// Within the zone the echo of a target at closest approach keeps its phase, so that the mean over
/// the window is the echo itself and takes it away.
#[must_use]
pub fn background_window(window: &BackgroundWindow) -> Finding {
    let zone_m = (0.5 * window.wavelength_m * window.range_m).sqrt();
    let verdict = if window.path_m >= 2.0 * zone_m {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("background_window", window.path_m, "m", verdict)
        .expecting(2.0 * zone_m)
        .because(format!(
            "the background's window covers {:.2} m of path, the first Fresnel zone is {zone_m:.2} \
             m: targets are taken for background ([preprocess] background)",
            window.path_m
        ))
}

/// Waves in air are slower than in vacuum by up to so much
/// (refractivity below 450·10⁻⁶, ITU-R P.453), and settings round that.
const AIR_SHARE: f64 = 1e-3;

/// Judges the propagation speed: radar of drones works in air.
#[must_use]
pub fn light_speed(light_speed_m_s: f64) -> Finding {
    let off = (light_speed_m_s / LIGHT_SPEED_M_S - 1.0).abs();
    let verdict = if off <= AIR_SHARE {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("light_speed", light_speed_m_s, "m/s", verdict)
        .expecting(LIGHT_SPEED_M_S)
        .because(format!(
            "ranges are scaled by {:.1} % against propagation in air ([image] light_speed_m_s)",
            100.0 * (light_speed_m_s / LIGHT_SPEED_M_S - 1.0)
        ))
}

/// Amplitude that a background may take from a target (dB).
const MOST_TAKEN_DB: f64 = 3.0;
/// Below this the echo is gone, whatever is left (dB).
const GONE_DB: f64 = 60.0;

/// Judges a background by the share of its amplitude that it leaves a point target.
#[must_use]
pub fn background_loss(kept: f64) -> Finding {
    let loss_db = (-20.0 * kept.max(0.0).log10()).clamp(0.0, GONE_DB);
    let verdict = if loss_db <= MOST_TAKEN_DB {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("background_loss", loss_db, "dB", verdict)
        .expecting(0.0)
        .because(format!(
            "removing the background takes {loss_db:.1} dB from the strongest echoes: targets are taken for \
             background, weakened and split ([preprocess] background)"
        ))
}

/// Judges what does not change from trace to trace in the spectra that are imaged, as a share of their
/// power: more than half, and the background has not been removed.
#[must_use]
pub fn still_echoes(share: f64) -> Finding {
    let verdict = if share <= 0.5 {
        Verdict::Agrees
    } else {
        Verdict::Doubtful
    };
    Finding::judged("still_echoes", share, "share of the power", verdict)
        .expecting(0.0)
        .because(format!(
            "{:.0} % of the power imaged does not change from trace to trace: coupling or an even surface, \
             which no background removal has taken, lies over the targets ([preprocess] background, \
             gate_ns)",
            100.0 * share
        ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_span_that_folds_is_doubtful() {
        let judge = |count: f64| {
            frequency_step(&FrequencyGrid {
                step_hz: 1.7e9 / (count - 1.0),
                light_speed_m_s: 299_792_458.0,
                range_span_m: 4.5,
            })
        };
        assert_eq!(judge(341.0).verdict, Verdict::Agrees);
        assert!((judge(341.0).value.unwrap() - 29.98).abs() < 0.01);
        assert_eq!(judge(8.0).verdict, Verdict::Doubtful);
    }

    #[test]
    fn a_speed_of_light_of_another_medium_is_doubtful() {
        assert_eq!(light_speed(299_702_547.0).verdict, Verdict::Agrees);
        assert_eq!(light_speed(3e8).verdict, Verdict::Agrees);
        assert_eq!(light_speed(2.9e8).verdict, Verdict::Doubtful);
    }

    #[test]
    fn a_background_that_takes_half_of_an_echo_is_doubtful() {
        assert_eq!(background_loss(0.9).verdict, Verdict::Agrees);
        let half = background_loss(0.5);
        assert_eq!(half.verdict, Verdict::Doubtful);
        assert!((half.value.unwrap() - 6.02).abs() < 0.01);
        // A window may turn an echo's sign.
        assert_eq!(background_loss(-0.1).value, Some(GONE_DB));
    }

    #[test]
    fn echoes_that_mostly_stand_still_are_doubtful() {
        assert_eq!(still_echoes(0.3).verdict, Verdict::Agrees);
        assert_eq!(still_echoes(0.7).verdict, Verdict::Doubtful);
    }

    #[test]
    fn a_window_within_the_fresnel_zone_is_doubtful() {
        // √(0.076 m · 10 m / 2) = 0.62 m.
        let judge = |path_m| {
            let seen = BackgroundWindow {
                path_m,
                wavelength_m: 0.076,
                range_m: 10.0,
            };
            background_window(&seen).verdict
        };
        assert_eq!(judge(0.3), Verdict::Doubtful);
        assert_eq!(judge(5.0), Verdict::Agrees);
    }
}
