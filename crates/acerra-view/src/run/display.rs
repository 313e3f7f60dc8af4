//! Display of the image in the run's own picture: window of levels and gain for range.

use acerra_figure::{DisplayGain, ImageDb, PixelValues};
use acerra_products::display::{RangeGeometry, WINDOW, range_gain};

use super::image::RunImage;
use super::record::Record;
use super::track::TrackTable;
use crate::raster::Precision;

/// Columns and rows of the gain's samples.
pub const GAIN_NODES: usize = 129;

/// The levels of the run's own picture.
#[derive(Clone, Debug)]
pub struct Display {
    /// The level shown as 0 dB, in dB against amplitude 1, the gain included.
    pub zero_db: f64,
    /// The largest level without the gain.
    pub maximum_db: f64,
    /// Half precision for the values of image and volume.
    pub half: Precision,
    /// The lowest level shown, relative to `zero_db`.
    pub floor_db: f64,
    /// The gain that undoes 1/R², `[GAIN_NODES, GAIN_NODES]` over the image's edges, row 0 at the
    /// smallest y; none where it varies little.
    pub gain_db: Option<Vec<f32>>,
}

impl Display {
    /// The levels of an image, as its picture has them.
    #[must_use]
    pub fn of(image: &RunImage, track: &TrackTable, record: &Record) -> Self {
        let grid = &image.grid;
        let values = PixelValues::Complex(&image.values);
        let mut figure =
            ImageDb::new("", values, grid.nx, grid.ny).at(grid.x0_m, grid.y0_m, grid.pixel_m);
        figure.window = WINDOW;
        let maximum_db = figure.levels().reference_db;
        let settings = &record.json["configuration"]["image"];
        let number = |value: &serde_json::Value| value.as_f64().unwrap_or(f64::NAN);
        let band_ghz = &settings["band_ghz"];
        let bandwidth_hz = 1e9 * (number(&band_ghz[1]) - number(&band_ghz[0]));
        let gain = range_gain(RangeGeometry {
            grid,
            z_m: grid.z_m,
            position_m: &track.placed_m(),
            range_cell_m: 0.5 * number(&settings["light_speed_m_s"]) / bandwidth_hz,
        });
        figure.gain = gain;
        let levels = figure.levels();
        Self {
            zero_db: levels.reference_db,
            maximum_db,
            half: Precision::half_for(10_f64.powf(maximum_db / 20.0)),
            floor_db: levels.floor_db,
            gain_db: figure.gain.as_ref().map(samples),
        }
    }
}

/// A gain at even steps from edge to edge.
fn samples(gain: &DisplayGain) -> Vec<f32> {
    let fraction = |k: usize| k as f64 / (GAIN_NODES - 1) as f64;
    #[expect(clippy::cast_possible_truncation, reason = "decibels")]
    (0..GAIN_NODES * GAIN_NODES)
        .map(|k| gain.at(fraction(k % GAIN_NODES), fraction(k / GAIN_NODES)) as f32)
        .collect()
}
