//! Parameters of the stage `clean`.

use crate::choices::{Background, Delay, Gate, ZeroTiming};

/// Parameters of the stage `clean`.
#[derive(Clone, Debug)]
pub struct CleanOptions {
    /// Window of fast time whose running mean is taken off every trace (ns).
    pub dewow_ns: Option<f64>,
    /// Band of frequencies that is kept of every trace (GHz).
    pub band_pass_ghz: Option<[f64; 2]>,
    /// Fast time at which range is zero, when calibrated (ns).
    pub delay_ns: Option<Delay>,
    /// Method by which the fast time at which range is zero is found.
    pub zero_timing: ZeroTiming,
    /// Fast time at which range is zero by the echo that follows the height over the whole flight (s), where
    /// one clearly does: zero-timing by the surface echo stays near this echo.
    pub surface_delay_s: Option<f64>,
    /// Background subtracted from every trace.
    pub background: Background,
    /// The part of each trace that is kept.
    pub gate_ns: Gate,
    /// Evenly spaced frequencies of the spectra (Hz).
    pub frequency_hz: Vec<f64>,
}

impl Default for CleanOptions {
    /// The paper's: zero-timing by the first trace, the mean as background, a gate about 2h/c, 341
    /// frequencies over 3.1 to 4.8 GHz.
    fn default() -> Self {
        Self {
            dewow_ns: None,
            band_pass_ghz: None,
            delay_ns: None,
            zero_timing: ZeroTiming::default(),
            surface_delay_s: None,
            background: Background::default(),
            gate_ns: Gate::default(),
            frequency_hz: frequencies_hz([3.1, 4.8], 341),
        }
    }
}

impl CleanOptions {
    /// For traces that are clean already and whose fast time is 2R/c: spectra alone.
    #[must_use]
    pub fn none() -> Self {
        Self {
            zero_timing: ZeroTiming::None,
            background: Background::None,
            gate_ns: Gate::None,
            ..Self::default()
        }
    }

    /// Whether the fast time at which range is zero is stated, or measured between the antennas, rather than found
    /// from the surface echo.
    #[must_use]
    pub fn is_calibrated(&self) -> bool {
        if self.delay_ns == Some(Delay::Auto) {
            return false;
        }
        match self.zero_timing {
            ZeroTiming::FirstTrace => false,
            ZeroTiming::None | ZeroTiming::Shift { .. } | ZeroTiming::DirectWave => true,
        }
    }
}

/// `count` evenly spaced frequencies over a band, both ends included (Hz).
#[must_use]
pub fn frequencies_hz(band_ghz: [f64; 2], count: usize) -> Vec<f64> {
    let [low, high] = band_ghz.map(|f| f * 1e9);
    #[expect(clippy::cast_precision_loss, reason = "a count of frequencies")]
    let step = if count > 1 {
        (high - low) / (count - 1) as f64
    } else {
        0.0
    };
    #[expect(clippy::cast_precision_loss, reason = "a count of frequencies")]
    (0..count).map(|n| low + n as f64 * step).collect()
}
