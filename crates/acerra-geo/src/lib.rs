//! Frames, geodesy and time-tagged trajectories, with readers for the formats they come in.
//!
//! ```text
//! file ──read_trajectory──► Trajectory ──apply_lever_arm──► Trajectory ──Interpolator──► Interpolated
//!                           (Fix, Frame, TimeOrigin)                     │               (position, flag)
//! raster ──TerrainFile──► LocalTerrain ── height of the ground there ────┘
//! ```
//!
//! - [`time`]: GPS time as whole seconds and fraction, calendars, leap seconds, BeiDou and
//!   GLONASS time.
//! - [`geodesy`]: the WGS84 ellipsoid, Earth-centred and geodetic coordinates, local
//!   east-north-up frames.
//! - [`trajectory`]: the one type every reader produces and every later stage takes.
//! - [`read`]: RTKLIB `.pos`, CSV, NMEA and OptiTrack exports, recognised from content.
//! - [`interpolate`]: positions at any time, gaps and unfixed stretches flagged; path and speed.
//! - [`lever_arm`]: from the positioned point to the radar's phase centre.
//! - [`terrain`]: heights of the ground from GeoTIFF and text grids.
//! - [`epsg`]: coordinate reference systems by EPSG code.
//! - [`geoid`]: heights of the geoid from the grids of EGM96 and EGM2008.
//! - [`utm`]: the UTM zones and their projection.
//! - [`write`](mod@write): trajectories and positions as CSV.
//!
//! SI units and radians throughout; names carry units and frames (`height_m`,
//! `enu_from_ecef`). Vectors are `[f64; 3]`, matrices `[[f64; 3]; 3]` in row-major order.
//!
//! From a file to the place of the radar at any time:
//!
//! ```
//! use acerra_geo::interpolate::{Flag, InterpolationOptions, Interpolator};
//! use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
//! use acerra_geo::read::{ReadOptions, read_trajectory};
//!
//! let table = "time_s,x_m,y_m,z_m\n0,0,0,4\n1,1.5,0,4\n2,3,0,4\n3,4.5,0,4\n";
//! let (track, report) = read_trajectory(table.as_bytes(), &ReadOptions::default())?;
//! assert!(report.warnings.is_empty());
//!
//! // The antennas of the radar sit 20 cm below the positioned point.
//! let (radar, _) = apply_lever_arm(&track, [0.0, 0.0, -0.2], &HeadingOptions::default())?;
//! let at = Interpolator::new(&radar, &InterpolationOptions::default());
//! let place = at.at(1.5);
//! assert_eq!(place.flag, Flag::Ok);
//! assert!((place.position_m[0] - 2.25).abs() < 1e-9);
//! assert!((place.position_m[2] - 3.8).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod epsg;
pub mod geodesy;
pub mod geoid;
pub mod interpolate;
pub mod lever_arm;
mod line_end;
pub mod matrix;
pub mod read;
pub mod terrain;
pub mod time;
pub mod trajectory;
pub mod utm;
pub mod write;
