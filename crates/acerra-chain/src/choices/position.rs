//! Where the heights of the flight come from, and positions without a fix.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[trajectory] height`: where the heights of the flight come from.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HeightSource {
    /// The positions.
    #[default]
    Positions,
    /// The surface echo of the radar, over level ground.
    Radar,
}

/// `[trajectory] height_datum`: vertical datum of the heights of a table.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HeightDatum {
    /// The ellipsoid.
    Ellipsoid,
    /// The sea; `[image] geoid` raises them to the ellipsoid.
    Sea,
    /// The place of take-off, whose height above the ellipsoid is not known.
    TakeOff,
}

impl From<HeightDatum> for acerra_geo::read::HeightDatum {
    fn from(datum: HeightDatum) -> Self {
        match datum {
            HeightDatum::Ellipsoid => Self::Ellipsoid,
            HeightDatum::Sea => Self::Sea,
            HeightDatum::TakeOff => Self::TakeOff,
        }
    }
}

/// `[trajectory] unfixed`: treatment of traces whose position has no fixed solution.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Unfixed {
    /// They enter the image, and a warning counts them.
    #[default]
    Keep,
    /// They are left out, and a warning counts them.
    Drop,
}
