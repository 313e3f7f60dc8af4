//! What processing choices do to the echoes: spacing of the frequencies, length of the background.

use super::finding::{Finding, Verdict};

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
