//! Parameters that raw samples do not contain.

use serde::Deserialize;

use crate::error::{FormatError, Place};

/// How a DCA1000 lays out complex samples (Texas Instruments, SWRA581).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layout {
    /// Four lanes (xWR12xx, xWR14xx): receivers side by side, all real parts of a sample before its imaginary ones.
    Interleaved,
    /// Two lanes (xWR16xx, xWR18xx, xWR68xx): receiver after receiver, two real parts before two imaginary ones.
    Paired,
}

/// The table `[fmcw]` of a settings file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FmcwSettings {
    /// The raw samples, relative to the settings.
    pub file: String,
    /// Frequency at the first sample, Hz.
    pub start_frequency_hz: f64,
    /// Slope, Hz/s.
    pub slope_hz_per_s: f64,
    /// Samples a second.
    pub sample_rate_hz: f64,
    /// Samples of a chirp.
    pub samples: usize,
    /// Receivers that were on, 1 to 4.
    pub receivers: usize,
    /// Whether samples are complex.
    #[serde(default = "yes")]
    pub complex: bool,
    /// How complex samples are laid out.
    #[serde(default = "paired")]
    pub layout: Layout,
    /// Seconds from chirp to chirp.
    pub chirp_interval_s: f64,
    /// Chirps in a frame, and seconds from frame to frame; without them chirps go on evenly.
    pub chirps_per_frame: Option<usize>,
    /// Seconds from frame to frame.
    pub frame_interval_s: Option<f64>,
    /// Whether phases of echoes lag in the beat.
    #[serde(default)]
    pub conjugate: bool,
}

const fn yes() -> bool {
    true
}

const fn paired() -> Layout {
    Layout::Paired
}

#[derive(Deserialize)]
struct Document {
    fmcw: FmcwSettings,
}

/// Whether a text has a table `[fmcw]`.
#[must_use]
pub fn is_fmcw_settings(head: &[u8]) -> bool {
    String::from_utf8_lossy(head)
        .lines()
        .any(|line| line.trim() == "[fmcw]")
}

impl FmcwSettings {
    /// Reads settings.
    ///
    /// # Errors
    /// Broken TOML, a key that is missing or unknown, a value without meaning.
    pub fn parse(text: &str) -> Result<Self, FormatError> {
        let document: Document = toml::from_str(text)
            .map_err(|e| FormatError::content(Place::field("[fmcw]"), "settings", e.message()))?;
        let s = document.fmcw;
        let positive = [
            ("start_frequency_hz", s.start_frequency_hz),
            ("slope_hz_per_s", s.slope_hz_per_s.abs()),
            ("sample_rate_hz", s.sample_rate_hz),
            ("chirp_interval_s", s.chirp_interval_s),
            ("frame_interval_s", s.frame_interval_s.unwrap_or(1.0)),
        ];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(FormatError::content(
                    Place::field(format!("[fmcw] {name}")),
                    "a positive number",
                    value,
                ));
            }
        }
        if !(1..=4).contains(&s.receivers) {
            return Err(FormatError::content(
                Place::field("[fmcw] receivers"),
                "1 to 4",
                s.receivers,
            ));
        }
        let even = if s.complex && s.layout == Layout::Paired {
            2
        } else {
            1
        };
        if s.samples < 2 || !s.samples.is_multiple_of(even) {
            return Err(FormatError::content(
                Place::field("[fmcw] samples"),
                format!("at least 2, a multiple of {even}"),
                s.samples,
            ));
        }
        if s.chirps_per_frame == Some(0)
            || s.chirps_per_frame.is_some() != s.frame_interval_s.is_some()
        {
            return Err(FormatError::content(
                Place::field("[fmcw]"),
                "chirps_per_frame, at least 1, and frame_interval_s together",
                "one of them",
            ));
        }
        Ok(s)
    }
}
