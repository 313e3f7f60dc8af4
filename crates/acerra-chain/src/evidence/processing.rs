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

/// Amplitude that a background may take from a target: 3 dB.
const LEAST_KEPT: f64 = 0.7;

/// Judges a background of principal components: `components` of as many directions as there are
/// `traces` take that share of an echo which follows none of them, on average.
#[must_use]
pub fn background_components(components: usize, traces: usize) -> Finding {
    let kept = 1.0 - components as f64 / traces.max(1) as f64;
    let verdict = match kept {
        k if k >= LEAST_KEPT => Verdict::Agrees,
        k if k > 0.0 => Verdict::Doubtful,
        _ => Verdict::Contradicts,
    };
    Finding::judged("background_components", kept, "share of an echo", verdict)
        .expecting(1.0)
        .because(format!(
            "{components} principal components of {traces} traces leave about {:.0} % of an echo's \
             amplitude ([preprocess] background)",
            100.0 * kept.max(0.0)
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
    fn many_components_take_the_targets_as_well() {
        assert_eq!(background_components(5, 331).verdict, Verdict::Agrees);
        assert_eq!(background_components(200, 331).verdict, Verdict::Doubtful);
        assert_eq!(
            background_components(331, 331).verdict,
            Verdict::Contradicts
        );
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
