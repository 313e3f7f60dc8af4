//! The ground below the flight.

use schemars::JsonSchema;
use serde::de::Deserializer;
use serde::{Deserialize, Serialize};

use super::parse::{within, word_or};

/// `[ground] surface`: where the surface of the ground lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GroundSurface {
    /// Level, at `surface_z_m`.
    #[default]
    Level,
    /// The surface of `[image] terrain`, with one soil below; `[image] z_m` gives the heights of the image.
    Terrain,
    /// As the first echo of the ground places it below the tracks, with one soil below. Where `[radar] delay_ns` is not
    /// stated, its median is at `surface_z_m`.
    Radar,
}

/// `[ground] relative_permittivity`: permittivity of the soil.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Permittivity {
    /// Found from the data.
    Auto,
    /// Given.
    #[serde(untagged)]
    Relative(f64),
}

impl Permittivity {
    /// The permittivity given; none where it is to be found.
    #[must_use]
    pub fn given(self) -> Option<f64> {
        match self {
            Self::Auto => None,
            Self::Relative(given) => Some(given),
        }
    }
}

impl<'de> Deserialize<'de> for Permittivity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        word_or(
            deserializer,
            &[("auto", Self::Auto)],
            |value| within(value, f64::INFINITY).map(Self::Relative),
            "the relative permittivity of the soil as a number, or \"auto\"",
        )
    }
}
