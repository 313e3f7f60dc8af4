//! Frames, geodesy and time-tagged trajectories, with readers for the formats they come in.
//!
//! - [`time`]: GPS time as whole seconds and fraction, calendars, leap seconds, BeiDou and
//!   GLONASS time.
//! - [`geodesy`]: the WGS84 ellipsoid, Earth-centred and geodetic coordinates, local
//!   east-north-up frames.
//! - [`trajectory`]: the one type every reader produces and every later stage takes.
//!
//! SI units and radians throughout; names carry units and frames (`height_m`,
//! `enu_from_ecef`). Vectors are `[f64; 3]`, matrices `[[f64; 3]; 3]` in row-major order.

pub mod geodesy;
pub mod matrix;
pub mod read;
pub mod time;
pub mod trajectory;
