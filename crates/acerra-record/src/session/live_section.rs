//! `[live]` of a session file: the image that forms while the recording goes on.

use acerra_settings::{Rule, ValueError, check};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[live]`: the image of `acerra live`. Absent keys take the value of `[campaign]`, where it states one.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LiveSection {
    /// First and last pixel centre to the east (m); by default those of `[campaign.image]`, or 10 m to
    /// either side of the first position.
    pub x_m: Option<[f64; 2]>,
    /// First and last pixel centre to the north (m), likewise.
    pub y_m: Option<[f64; 2]>,
    /// Distance of pixel centres (m); by default 0.02, or less or more as `max_pixels` allows.
    pub pixel_m: Option<f64>,
    /// Most pixels of the image.
    pub max_pixels: u32,
    /// Height of the image plane above the origin (m). The origin is that of `[campaign.trajectory]`, or the
    /// first position.
    pub z_m: Option<f64>,
    /// Relative error allowed against Eq. (3) in double precision.
    pub accuracy: f64,
    /// Traces over which the background is averaged: the running mean counts each trace so many times less
    /// than the sum of those before it.
    pub background_traces: u32,
    /// Traces that are collected before the first is imaged: they start the background, and determine where
    /// range is zero unless that is stated.
    pub first_traces: u32,
    /// Interval of each trace that is kept, about 2h/c (ns); by default as in `[campaign.preprocess]`.
    pub gate_ns: Option<[f64; 2]>,
    /// Height above the image plane from which pulses are imaged (m); by default three quarters of `[flight]
    /// height_m`, or 0.5 without it.
    pub least_height_m: Option<f64>,
}

impl Default for LiveSection {
    fn default() -> Self {
        Self {
            x_m: None,
            y_m: None,
            pixel_m: None,
            max_pixels: 1_000_000,
            z_m: None,
            accuracy: 1e-2,
            background_traces: 300,
            first_traces: 24,
            gate_ns: None,
            least_height_m: None,
        }
    }
}

impl LiveSection {
    pub(super) fn check(&self) -> Result<(), ValueError> {
        let ordered = |key, range: Option<[f64; 2]>| {
            let [from, to] = range.unwrap_or([0.0, 1.0]);
            let is_sound = from < to && from.abs() < 1e6 && to.abs() < 1e6;
            Rule::new(
                key,
                is_sound,
                "a start before its end",
                format!("[{from}, {to}]"),
            )
        };
        let range = Rule::range;
        check(
            "live",
            &[
                ordered("x_m", self.x_m),
                ordered("y_m", self.y_m),
                ordered("gate_ns", self.gate_ns),
                range(
                    "pixel_m",
                    self.pixel_m.unwrap_or(0.02),
                    1e-3..=10.0,
                    "0.001 to 10",
                ),
                range(
                    "max_pixels",
                    self.max_pixels.into(),
                    1.0..=16e6,
                    "1 to 16000000",
                ),
                range(
                    "z_m",
                    self.z_m.unwrap_or(0.0),
                    -1e4..=1e4,
                    "-10000 to 10000",
                ),
                range("accuracy", self.accuracy, 1e-4..=0.1, "0.0001 to 0.1"),
                range(
                    "background_traces",
                    self.background_traces.into(),
                    2.0..=100_000.0,
                    "2 to 100000",
                ),
                range(
                    "first_traces",
                    self.first_traces.into(),
                    2.0..=1000.0,
                    "2 to 1000",
                ),
                range(
                    "least_height_m",
                    self.least_height_m.unwrap_or(0.5),
                    0.05..=1000.0,
                    "0.05 to 1000",
                ),
            ],
        )
    }
}
