//! Planning a flight: from an area and a required resolution to flight lines.
//!
//! 1. [`PlanFile`] states the requirements (area, resolution) and the equipment (radar, drone).
//! 2. `swath` finds, for each height, the strip next to a line that is resolved finely enough (Eq. (9)), lies
//!    in the antenna's beam and has the required signal-to-noise ratio (radar equation, `link`).
//! 3. `lines` covers the area with the fewest lines; the height with the shortest flight wins.
//! 4. `curve` bends the lines until the ghost on the other side is below the required level, by the exact
//!    point spread function.
//! 5. `flights` adds time and batteries, `maps` the expected quality over the area.
//! 6. `route` is the path of each flight, over level ground or a terrain (`ground`); `qgroundcontrol`,
//!    `mavlink`, `wpml` and `ugcs` write it as missions, `geojson` and `kml` as maps.
//!
//! Impossible plans are refused with the reason: [`PlanError::Impossible`].

mod aliasing;
mod curve;
mod error;
mod file;
mod flights;
mod geojson;
mod ground;
mod kml;
mod lines;
mod link;
mod maps;
mod mavlink;
mod polygon;
mod qgroundcontrol;
mod route;
mod summary;
mod swath;
mod ugcs;
mod wpml;

pub use curve::Curve;
pub use error::PlanError;
pub use file::{Area, DjiModel, Drone, PlanFile, Radar, Want};
pub use flights::Flight;
pub use geojson::to_geojson;
pub use ground::Ground;
pub use kml::to_kml;
pub use lines::{Line, Lines};
pub use link::{image_snr_db, pulse_snr_db};
pub use maps::{ExpectedMaps, expected_maps};
pub use mavlink::to_waypoints;
pub use qgroundcontrol::to_qgroundcontrol;
pub use route::{Route, Stop};
pub use summary::{FlightPlan, Summary};
pub use swath::Swath;
pub use ugcs::to_ugcs;
pub use wpml::to_wpml;

/// Speed of light (m/s).
pub(crate) const LIGHT_SPEED_M_S: f64 = 299_792_458.0;
