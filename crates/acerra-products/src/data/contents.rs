//! Data of a run for programs that read arrays, from memory or from its directory.

use std::borrow::Cow;

use num_complex::Complex32;

use super::table::Table;

/// Contents of a run.
pub(super) struct RunContents<'a> {
    /// Name of the campaign.
    pub name: String,
    /// Names and values of the provenance.
    pub items: Vec<(String, String)>,
    pub image: ImageContents<'a>,
    /// The places of all traces: `trajectory.csv`.
    pub trajectory: Table,
    pub targets: Vec<TargetPlace>,
    /// Spectra and radargrams; a run's directory does not hold them.
    pub pulses: Option<PulseContents<'a>>,
}

/// The image and its axes: `image.npz`.
#[derive(Clone, Debug)]
pub struct ImageContents<'a> {
    /// Row-major, row 0 at the smallest y.
    pub values: Cow<'a, [Complex32]>,
    /// East, of each column (m).
    pub x_m: Vec<f64>,
    /// North, of each row (m).
    pub y_m: Vec<f64>,
    /// Height of all pixels, or of each.
    pub z_m: Vec<f64>,
}

impl ImageContents<'_> {
    /// Distance of pixels along an axis (m).
    #[must_use]
    pub fn pixel_m(&self) -> f64 {
        match (self.x_m.as_slice(), self.y_m.as_slice()) {
            ([first, .., last], _) => (last - first) / (self.x_m.len() - 1) as f64,
            (_, [first, .., last]) => (last - first) / (self.y_m.len() - 1) as f64,
            _ => 1.0,
        }
    }
}

/// A target.
#[derive(Clone, Copy, Debug)]
pub(super) struct TargetPlace {
    pub place_m: [f64; 3],
    pub level_db: f64,
    /// Latitude, longitude (degrees) and ellipsoidal height (m), where known.
    pub place_deg_m: Option<[f64; 3]>,
}

/// The pulses that entered the image.
pub(super) struct PulseContents<'a> {
    /// Places of the phase centre: east, north, up (m).
    pub position_m: &'a [[f64; 3]],
    /// Row of each in the trajectory.
    pub trace: Vec<i32>,
    /// Number of the track of each, from 1.
    pub track: Vec<i32>,
    pub frequency_hz: &'a [f64],
    /// `[pulses, frequencies]`.
    pub spectrum: Vec<Complex32>,
    /// The cleaned radargram of each track that has one.
    pub radargrams: Vec<RadargramContents<'a>>,
}

/// The cleaned traces of a track.
pub(super) struct RadargramContents<'a> {
    /// Number of the track, from 1.
    pub track: usize,
    pub radargram: &'a acerra_radar::Radargram,
    /// Unit of the samples.
    pub unit: &'static str,
}
