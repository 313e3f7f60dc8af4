//! Traces that enter the image, and the background subtracted from each.

use schemars::JsonSchema;
use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize};
use toml::Value;

use super::parse::{LONGEST_NS, pair_within, single, word_or};

/// `[radar] select`: the traces that enter background and image.
#[derive(Clone, Copy, Debug, Default, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Select {
    /// The traces during which the platform moves, where it is at rest for a tenth of the time or more; every trace
    /// otherwise.
    #[default]
    Auto,
    /// Every trace that has a position.
    All,
    /// The traces during which the platform moves.
    Moving,
    /// Trace numbers counted from 0, both ends included.
    #[serde(untagged)]
    Range([usize; 2]),
}

impl<'de> Deserialize<'de> for Select {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const EXPECTED: &str = "expected \"auto\", \"all\", \"moving\" or [first, last]";
        match Value::deserialize(deserializer)? {
            Value::String(word) if word == "auto" => Ok(Self::Auto),
            Value::String(word) if word == "all" => Ok(Self::All),
            Value::String(word) if word == "moving" => Ok(Self::Moving),
            Value::Array(ends) => match ends.as_slice() {
                [Value::Integer(first), Value::Integer(last)] if 0 <= *first && first <= last => {
                    let index = |i: i64| usize::try_from(i).map_err(Error::custom);
                    Ok(Self::Range([index(*first)?, index(*last)?]))
                }
                _ => Err(Error::custom(format!(
                    "{EXPECTED}, whole numbers with 0 <= first <= last; found {}",
                    Value::Array(ends)
                ))),
            },
            other => Err(Error::custom(format!("{EXPECTED}; found {other}"))),
        }
    }
}

/// `[preprocess] background`: background subtracted from every trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Background {
    /// The mean of the selected traces (the paper's).
    #[default]
    Mean,
    /// Their median, sample by sample.
    Median,
    /// The mean, and the echo of the surface wherever the height puts it: both at once, with `[ground]` the default.
    Surface,
    /// Nothing.
    None,
    /// The mean of a window of this number of traces about each trace.
    #[serde(untagged)]
    Window {
        /// Length of the window, in traces.
        window: usize,
    },
    /// The strongest principal components.
    #[serde(untagged)]
    Components {
        /// How many are removed.
        components: usize,
    },
}

impl<'de> Deserialize<'de> for Background {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let counted = |value: &Value| {
            let count = |key| {
                let count = usize::try_from(single(value, key)?.as_integer()?).ok()?;
                (count > 0).then_some(count)
            };
            count("window")
                .map(|window| Self::Window { window })
                .or_else(|| count("components").map(|components| Self::Components { components }))
        };
        word_or(
            deserializer,
            &[
                ("mean", Self::Mean),
                ("median", Self::Median),
                ("surface", Self::Surface),
                ("none", Self::None),
            ],
            counted,
            "\"mean\", \"median\", \"surface\", \"none\", { window = TRACES } or { components = COUNT } with a \
             count above 0",
        )
    }
}

/// `[preprocess] gate_ns`: the part of each trace that is kept, about 2h/c.
#[derive(Clone, Copy, Debug, Default, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Gate {
    /// From 6 ns before 2h/c to 24 ns after it, where the image lies at such ranges; the whole trace
    /// where it looks to the side, or below ground.
    #[default]
    Auto,
    /// The whole trace.
    None,
    /// From this number of nanoseconds after 2h/c (negative: before) to the second.
    #[serde(untagged)]
    About([f64; 2]),
}

impl Gate {
    /// The gate of [`Gate::Auto`] where the image lies below the flight: nanoseconds about 2h/c.
    pub const BELOW_NS: [f64; 2] = [-6.0, 24.0];

    /// The nanoseconds about 2h/c that are kept, with [`Gate::Auto`] as for a view below the flight; none
    /// where all are kept.
    #[must_use]
    pub fn about_ns(self) -> Option<[f64; 2]> {
        match self {
            Self::Auto => Some(Self::BELOW_NS),
            Self::About(ns) => Some(ns),
            Self::None => None,
        }
    }
}

impl<'de> Deserialize<'de> for Gate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        word_or(
            deserializer,
            &[("none", Self::None), ("auto", Self::Auto)],
            |value| {
                pair_within(value, LONGEST_NS)
                    .filter(|[from, to]| from < to)
                    .map(Self::About)
            },
            "[from, to] with from < to, within a million ns, \"auto\" or \"none\"",
        )
    }
}
