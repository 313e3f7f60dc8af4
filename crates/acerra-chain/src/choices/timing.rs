//! Times: the delay, the offset between the clocks, the fast time at which range is zero.

use schemars::JsonSchema;
use serde::de::Deserializer;
use serde::{Deserialize, Serialize};
use toml::Value;

use super::parse::{LONGEST_NS, LONGEST_S, single, within, word_or};

/// `[radar] delay_ns`: the fast time at which range is zero.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Delay {
    /// Found from the data.
    Auto,
    /// Given, in nanoseconds.
    #[serde(untagged)]
    Nanoseconds(f64),
}

impl Delay {
    /// The delay given, in nanoseconds; none where it is to be found.
    #[must_use]
    pub fn given_ns(self) -> Option<f64> {
        match self {
            Self::Auto => None,
            Self::Nanoseconds(delay_ns) => Some(delay_ns),
        }
    }
}

impl<'de> Deserialize<'de> for Delay {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        word_or(
            deserializer,
            &[("auto", Self::Auto)],
            |value| within(value, LONGEST_NS).map(Self::Nanoseconds),
            "nanoseconds, within a million, or \"auto\"",
        )
    }
}

/// `[trajectory] time_offset_s`: trajectory time minus radar time.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TimeOffset {
    /// Found from the data.
    Auto,
    /// Taken from the clock recorded with the radar log.
    Logged,
    /// Given, in seconds.
    #[serde(untagged)]
    Seconds(f64),
}

impl Default for TimeOffset {
    fn default() -> Self {
        Self::Seconds(0.0)
    }
}

impl<'de> Deserialize<'de> for TimeOffset {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        word_or(
            deserializer,
            &[("auto", Self::Auto), ("logged", Self::Logged)],
            |value| within(value, LONGEST_S).map(Self::Seconds),
            "seconds, within 1e10, \"auto\" or \"logged\"",
        )
    }
}

/// `[preprocess] zero_timing`: how the fast time at which range is zero is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ZeroTiming {
    /// The paper's: the surface echo of the first trace is put at 2h/c.
    #[default]
    FirstTrace,
    /// The direct wave between transmitter and receiver, the first arrival of the mean trace, is put at the time of
    /// light from one to the other: for antennas whose places apart are known.
    DirectWave,
    /// Fast time is left as it is (less `[radar] delay_ns`).
    None,
    /// Fast time is shifted by this number of nanoseconds.
    #[serde(untagged)]
    Shift {
        /// Added to fast time, in nanoseconds.
        shift_ns: f64,
    },
}

impl<'de> Deserialize<'de> for ZeroTiming {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let shift = |value: &Value| {
            let shift_ns = within(single(value, "shift_ns")?, LONGEST_NS)?;
            Some(Self::Shift { shift_ns })
        };
        word_or(
            deserializer,
            &[
                ("first-trace", Self::FirstTrace),
                ("direct-wave", Self::DirectWave),
                ("none", Self::None),
            ],
            shift,
            "\"first-trace\", \"direct-wave\", \"none\" or { shift_ns = NUMBER }",
        )
    }
}
