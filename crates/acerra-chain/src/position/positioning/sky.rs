//! The sky of the rover's log.

use acerra_gnss::SatelliteInSky;

use super::error::PositioningError;
use super::input::PositioningInput;
use super::reader::Reader;

/// Direction and signal strength of every satellite of the rover's log, at epochs at least `interval_s` apart, seen
/// from `place_ecef_m` (m); see [`acerra_gnss::sky`].
///
/// # Errors
/// A file that cannot be read, or rover files without observations, named.
pub fn sky(
    input: &PositioningInput,
    place_ecef_m: [f64; 3],
    interval_s: f64,
) -> Result<Vec<SatelliteInSky>, PositioningError> {
    let mut reader = Reader::new(input);
    let rover_files = input.rover_files();
    let mut rover = reader.receiver(&rover_files, "observations")?;
    // The base's raw log may hold the ephemerides.
    for path in input.base_files().iter().chain(&input.navigation) {
        reader.read(path)?;
    }
    reader.complete(&rover_files, &mut rover)?;
    let navigation = &reader.navigation;
    Ok(acerra_gnss::sky(
        &rover,
        navigation,
        place_ecef_m,
        interval_s,
    ))
}
