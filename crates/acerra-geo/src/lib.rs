//! Frames, geodesy and time-tagged trajectories, with readers for the formats they come in.
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
//! - [`write`](mod@write): trajectories and positions as CSV.
//!
//! SI units and radians throughout; names carry units and frames (`height_m`,
//! `enu_from_ecef`). Vectors are `[f64; 3]`, matrices `[[f64; 3]; 3]` in row-major order.

pub mod geodesy;
pub mod interpolate;
pub mod lever_arm;
mod line_end;
pub mod matrix;
pub mod read;
pub mod terrain;
pub mod time;
pub mod trajectory;
pub mod write;
