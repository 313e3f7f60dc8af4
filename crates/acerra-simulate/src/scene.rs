//! The scene file: flight, ground and instruments.

use std::path::Path;

use acerra_settings::{SyntaxError, ValueError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::time::{Calendar, GpsTime};

use super::flight::{Flight, FlightModel, GivenFlight, GivenFlightError};
use super::gnss::GnssModel;
use super::radar::{Clutter, CornerReflector, Ground, PointTarget, RadarModel, RadarScene};

/// A scene file. Positions are east, north, up about `origin_deg_m`, the surface at z = 0.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Seed of everything random: the same seed gives the same bytes.
    #[serde(default)]
    pub seed: u64,
    /// Latitude and longitude (degrees) and ellipsoidal height (m) of the origin.
    #[serde(default = "default_origin_deg_m")]
    pub origin_deg_m: [f64; 3],
    /// The flight: one straight track, flown by hand.
    #[serde(default)]
    pub flight: Option<FlightModel>,
    /// The flight as a file has it, instead of `[flight]`.
    #[serde(default)]
    pub trajectory: Option<GivenFlight>,
    /// The radar.
    #[serde(default)]
    pub radar: RadarModel,
    /// Which part of the flight the radar log holds.
    #[serde(default)]
    pub record: Record,
    /// Statement of the written campaign file on the offset between the clocks.
    #[serde(default)]
    pub time_offset: OffsetTold,
    /// Points.
    #[serde(default)]
    pub point: Vec<PointTarget>,
    /// Corner reflectors.
    #[serde(default)]
    pub corner: Vec<CornerReflector>,
    /// The surface; absent for targets in free space.
    #[serde(default)]
    pub ground: Option<Ground>,
    /// Extended objects.
    #[serde(default)]
    pub clutter: Vec<Clutter>,
    /// The GNSS receivers; without them the true trajectory is written.
    #[serde(default)]
    pub gnss: Option<GnssModel>,
    /// Position of the base's antenna: east, north, up (m).
    #[serde(default = "default_base_m")]
    pub base_m: [f64; 3],
    /// GPS time at the start of the flight: year, month, day, hour, minute, second.
    #[serde(default = "default_start_gpst")]
    pub start_gpst: [u32; 6],
    /// The image that the campaign file asks for; by default the square of the paper, from the
    /// start of the track.
    #[serde(default)]
    pub image: SceneImage,
}

/// `[image]` of a scene file: image of the written campaign file.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SceneImage {
    /// First and last pixel centre to the east (m).
    pub x_m: [f64; 2],
    /// First and last pixel centre to the north (m).
    pub y_m: [f64; 2],
    /// Side of a pixel (m).
    pub pixel_m: f64,
}

impl Default for SceneImage {
    fn default() -> Self {
        Self {
            x_m: [0.0, 18.0],
            y_m: [-9.0, 9.0],
            pixel_m: 0.01,
        }
    }
}

/// Which part of a flight the radar log holds.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Record {
    /// From one end of the track to the other.
    #[default]
    Track,
    /// From before take-off to after landing.
    Flight,
}

/// Statement of a campaign file on the offset between the clocks.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum OffsetTold {
    /// The offset, as a controller keeps it that records both.
    #[default]
    Exact,
    /// `"auto"`: it is to be found from the data.
    Auto,
}

/// Why a scene is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// Not TOML, an unknown key, or a value of the wrong form.
    #[error(transparent)]
    Syntax(#[from] SyntaxError),
    /// A flight from a file that cannot be flown.
    #[error(transparent)]
    GivenFlight(#[from] GivenFlightError),
    /// No flight, or two.
    #[error("expected either [flight] or [trajectory]")]
    Flights,
    /// An image that is no image.
    #[error("[image] {0}")]
    Image(String),
    /// A value outside its possible range.
    #[error(transparent)]
    Value(#[from] ValueError),
    /// Receivers that cannot be.
    #[error("[gnss] {0}")]
    Gnss(String),
    /// No day of GPS time.
    #[error("start_gpst: expected year, month, day, hour, minute, second after 1980, found {0:?}")]
    Start([u32; 6]),
    /// No place on Earth.
    #[error(
        "origin_deg_m: expected [latitude, longitude, height], degrees and metres, found {0:?}"
    )]
    Origin([f64; 3]),
}

impl Scene {
    /// Reads a scene from the text of its file.
    ///
    /// # Errors
    /// Unknown keys, values of the wrong form, scenes that cannot be.
    ///
    /// ```
    /// use acerra_simulate::scene::Scene;
    /// let scene = Scene::parse(
    ///     "[flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [31.4, 0]\nheight_m = 4\n\
    ///      track_duration_s = 17.5\n[[corner]]\nposition_m = [4, 0, 0]\n",
    /// )?;
    /// assert_eq!(scene.corner.len(), 1);
    /// # Ok::<(), acerra_simulate::scene::SceneError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let scene: Self = acerra_settings::parse(text)?;
        scene.check()?;
        Ok(scene)
    }

    /// Flies the scene's flight.
    ///
    /// # Errors
    /// A flight that cannot be flown.
    pub fn fly(&self) -> Result<Flight, SceneError> {
        match (&self.flight, &self.trajectory) {
            (Some(model), None) => Ok(Flight::fly(model, self.seed)?),
            (None, Some(given)) => {
                let [latitude, longitude, height_m] = self.origin_deg_m;
                Ok(given.fly(Geodetic::from_degrees(latitude, longitude, height_m))?)
            }
            _ => Err(SceneError::Flights),
        }
    }

    /// This scene with its files' relative paths resolved in `folder`.
    #[must_use]
    pub fn resolved_in(mut self, folder: &Path) -> Self {
        if let Some(given) = &mut self.trajectory {
            given.file = folder.join(&given.file);
        }
        if let Some(navigation) = self.gnss.as_mut().and_then(|g| g.navigation.as_mut()) {
            *navigation = folder.join(&*navigation);
        }
        self
    }

    /// What the radar sees.
    #[must_use]
    pub fn radar_scene(&self) -> RadarScene {
        RadarScene {
            point: self.point.clone(),
            corner: self.corner.clone(),
            ground: self.ground.clone(),
            clutter: self.clutter.clone(),
        }
    }

    fn check(&self) -> Result<(), SceneError> {
        match (&self.flight, &self.trajectory) {
            (Some(flight), None) => flight.check()?,
            (None, Some(_)) => {}
            _ => return Err(SceneError::Flights),
        }
        self.radar.check()?;
        self.radar_scene().check()?;
        let [latitude, longitude, height] = self.origin_deg_m;
        if !(latitude.abs() <= 90.0 && longitude.abs() <= 360.0 && height.abs() < 1e5) {
            return Err(SceneError::Origin(self.origin_deg_m));
        }
        if let Some(gnss) = &self.gnss {
            gnss.check()
                .map_err(|error| SceneError::Gnss(error.to_string()))?;
        }
        let SceneImage { x_m, y_m, pixel_m } = self.image;
        acerra_imaging::PlaneGrid::from_ranges(x_m, y_m, 0.0, pixel_m)
            .map_err(|error| SceneError::Image(error.to_string()))?;
        if !self.base_m.iter().all(|v| v.abs() < 1e5) {
            return Err(SceneError::Gnss(
                "base_m: expected a place within 100 km".to_owned(),
            ));
        }
        self.start()?;
        Ok(())
    }

    /// GPS time at the start of the flight.
    ///
    /// # Errors
    /// A day that is none.
    pub fn start(&self) -> Result<GpsTime, SceneError> {
        let wrong = SceneError::Start(self.start_gpst);
        let [year, month, day, hour, minute, second] = self.start_gpst;
        let small = |v: u32| u8::try_from(v).map_err(|_| wrong.clone());
        let year = i32::try_from(year).map_err(|_| wrong.clone())?;
        let calendar = Calendar::new(
            year,
            small(month)?,
            small(day)?,
            small(hour)?,
            small(minute)?,
            f64::from(second),
        )
        .map_err(|_| wrong.clone())?;
        if !(1981..2099).contains(&year) {
            return Err(wrong);
        }
        Ok(GpsTime::from_calendar(&calendar))
    }

    /// The frame of the scene's positions.
    #[must_use]
    pub fn frame(&self) -> EnuFrame {
        let [latitude, longitude, height_m] = self.origin_deg_m;
        EnuFrame::new(Geodetic::from_degrees(latitude, longitude, height_m))
    }
}

fn default_base_m() -> [f64; 3] {
    [-12.0, -8.0, 1.5]
}

fn default_start_gpst() -> [u32; 6] {
    [2019, 10, 15, 9, 30, 0]
}

/// The paper's test site, a small town near Naples.
fn default_origin_deg_m() -> [f64; 3] {
    [40.9596, 14.3696, 75.0]
}
