//! Kind of image, and how traces and tracks are summed.

use schemars::JsonSchema;
use serde::de::Deserializer;
use serde::{Deserialize, Serialize};
use toml::Value;

use super::parse::{FARTHEST_M, pair_within, within, word_or};

/// `[image] z_m`: the height of the image.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
#[serde(untagged)]
pub enum Heights {
    /// A horizontal plane at this height (m).
    Plane(f64),
    /// A volume between two heights (m).
    Range([f64; 2]),
}

impl<'de> Deserialize<'de> for Heights {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let heights = |value: &Value| match within(value, FARTHEST_M) {
            Some(height_m) => Some(Self::Plane(height_m)),
            None => pair_within(value, FARTHEST_M)
                .filter(|[from, to]| from <= to)
                .map(Self::Range),
        };
        let expected = "a height within 1e7 m, or [from, to] with from <= to";
        word_or(deserializer, &[], heights, expected)
    }
}

/// `[image] weight`: the weight of each trace in the sum of Eq. (3).
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Weight {
    /// By path where the platform is at rest for a tenth of the time or more, otherwise equal for every trace.
    #[default]
    Auto,
    /// One for every trace: the paper's sum.
    Trace,
    /// The path that the trace covers, in metres, so that hovering does not dominate.
    Path,
}

/// `[image] values`: meaning of the pixels.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Values {
    /// The sum of Eq. (3), which grows as 1/R⁴ towards the flight.
    #[default]
    Sum,
    /// The sum divided by that of a point of unit reflectivity: equal reflectors near and far are equally
    /// bright, and noise is brighter far away.
    Reflectivity,
}

/// `[image] antenna_axis`: where the antenna looks, from which its pattern counts.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AntennaAxis {
    /// Down in the axes of the platform, by the recorded attitude; straight down where none is recorded.
    #[default]
    Attitude,
    /// Straight down whatever the attitude: on a gimbal that keeps it level.
    Vertical,
    /// Down in the axes of a gimbal, by its attitude in the log of the autopilot: an antenna that looks down where
    /// the gimbal's angles are zero.
    Gimbal,
    /// Forward in the axes of a gimbal, by the same: an antenna in the place of a camera, which looks down where the
    /// gimbal's pitch is −90°.
    GimbalForward,
}

impl AntennaAxis {
    /// Whether the antenna looks where a gimbal points.
    #[must_use]
    pub const fn is_gimbal(self) -> bool {
        matches!(self, Self::Gimbal | Self::GimbalForward)
    }

    /// Its name in the campaign.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Attitude => "attitude",
            Self::Vertical => "vertical",
            Self::Gimbal => "gimbal",
            Self::GimbalForward => "gimbal-forward",
        }
    }
}

/// `[image] look_window`: the taper of each look.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LookTaper {
    /// None.
    #[default]
    None,
    /// Hann, over the look's path.
    Hann,
}

/// `[tracks] sum`: how several tracks are summed.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sum {
    /// Amplitudes: one image with the aperture of all.
    #[default]
    Coherent,
    /// Powers of each track's own image.
    Incoherent,
}

/// `[tracks] calibration`: where delay and phase of each track come from.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CalibrationSource {
    /// The campaign file alone.
    #[default]
    Given,
    /// A target that all tracks see, in addition to the values of the campaign file.
    Target,
}
