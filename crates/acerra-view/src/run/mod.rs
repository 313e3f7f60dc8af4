//! A run as its directory holds it: image, record, targets and track.

mod display;
mod image;
mod inputs;
mod record;
mod track;
mod volume;

use std::path::{Path, PathBuf};

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use serde_json::Value;

use crate::error::ViewError;
use crate::raster::Pyramid;
pub use display::Display;
pub use image::{RunImage, Terrain};
pub use inputs::Input;
pub use record::Record;
pub use track::{Seen, TrackTable, range_and_incidence};
pub use volume::{Plane, Volume};

/// A run that is shown.
#[derive(Debug)]
pub struct Run {
    /// Name.
    pub name: String,
    /// Directory.
    pub directory: PathBuf,
    /// Image.
    pub image: RunImage,
    /// The image's levels.
    pub pyramid: Pyramid,
    /// Volume, where it made one.
    pub volume: Option<Volume>,
    /// Display of the image in the run's own picture.
    pub display: Display,
    /// `run.json`.
    pub record: Record,
    /// `targets.json`.
    pub targets: Value,
    /// `trajectory.csv`.
    pub track: TrackTable,
    /// The frame of all coordinates, where it is on the Earth.
    pub frame: Option<EnuFrame>,
}

impl Run {
    /// Reads the products in a directory.
    ///
    /// # Errors
    /// A product that is absent or broken, with its name and the place.
    pub fn open(directory: &Path) -> Result<Self, ViewError> {
        let record = Record::read(&directory.join("run.json"))?;
        let targets = record::json(&directory.join("targets.json"))?;
        let track = TrackTable {
            line_starts: record.line_starts(),
            ..TrackTable::read(&directory.join("trajectory.csv"))?
        };
        let image = RunImage::read(&directory.join("image.npz"))?;
        let volume = Volume::open(&directory.join("volume.npz"), &image.grid)?;
        let display = Display::of(&image, &track, &record);
        let frame = record
            .origin_deg_m
            .map(|[latitude_deg, longitude_deg, height_m]| {
                EnuFrame::new(Geodetic::from_degrees(
                    latitude_deg,
                    longitude_deg,
                    height_m,
                ))
            });
        Ok(Self {
            name: name_of(directory),
            directory: directory.to_owned(),
            pyramid: Pyramid::of(&image),
            image,
            volume,
            display,
            record,
            targets,
            track,
            frame,
        })
    }

    /// Latitude, longitude (degrees) and ellipsoidal height (m) of a place, where the frame's place on
    /// the Earth is known.
    #[must_use]
    pub fn place_deg_m(&self, place_m: [f64; 3]) -> Option<[f64; 3]> {
        let place = self.frame?.geodetic_from_enu(place_m);
        Some([place.latitude_deg(), place.longitude_deg(), place.height_m])
    }
}

/// A directory's name, with that of its parent where several runs share it.
fn name_of(directory: &Path) -> String {
    let whole = directory
        .canonicalize()
        .unwrap_or_else(|_| directory.to_owned());
    let part = |path: &Path| path.file_name().map(|n| n.to_string_lossy().into_owned());
    let own = part(&whole).unwrap_or_else(|| whole.display().to_string());
    match whole.parent().and_then(part) {
        Some(above) if own == "products" => above,
        _ => own,
    }
}
