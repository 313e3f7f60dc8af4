//! Vertical datum of the heights of a table.

use super::ReadError;

/// Reference of the heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum HeightDatum {
    /// The WGS84 ellipsoid.
    Ellipsoid,
    /// The sea, or the geoid.
    Sea,
    /// The place of take-off, whose height is unknown.
    TakeOff,
}

impl HeightDatum {
    /// From its name in settings: `ellipsoid`, `sea` or `takeoff`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "ellipsoid" => Self::Ellipsoid,
            "sea" => Self::Sea,
            "takeoff" => Self::TakeOff,
            _ => return None,
        })
    }
}

/// Datum by the name of a column of heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Above {
    Stated(HeightDatum),
    /// `height`, `h`: above the ellipsoid unless the caller states otherwise.
    Plain,
    /// `altitude`: loggers differ in its meaning.
    Open,
}

/// The meaning of the name of a column of heights.
pub(super) fn above(name: &str) -> Option<Above> {
    Some(match name {
        "height" | "h" => Above::Plain,
        "alt" | "altitude" | "gps_altitude" | "gps_alt" | "elevation" => Above::Open,
        "ellipsoidal_height"
        | "ellipsoid_height"
        | "height_ellipsoid"
        | "height_ellipsoidal"
        | "ellipsoidal_altitude"
        | "altitude_ellipsoid"
        | "altitude_ellipsoidal"
        | "hae"
        | "altitude_hae"
        | "alt_hae"
        | "height_wgs84"
        | "altitude_wgs84"
        | "h_ell" => Above::Stated(HeightDatum::Ellipsoid),
        "altitude_above_sealevel"
        | "altitude_above_sea_level"
        | "height_above_sea_level"
        | "altitude_msl"
        | "alt_msl"
        | "height_msl"
        | "msl"
        | "amsl"
        | "msl_height"
        | "altitude_amsl"
        | "alt_amsl"
        | "height_above_msl"
        | "orthometric_height" => Above::Stated(HeightDatum::Sea),
        "height_above_takeoff"
        | "height_above_take_off"
        | "altitude_above_takeoff"
        | "altitude_above_take_off"
        | "relative_altitude"
        | "relative_height"
        | "rel_alt"
        | "relative_alt" => Above::Stated(HeightDatum::TakeOff),
        _ => return None,
    })
}

/// The column of heights to use, by index, and its datum.
///
/// # Errors
/// Only columns of unknown datum, or of another datum than the caller's.
pub(super) fn choose(
    line: u64,
    columns: &[(Above, &str)],
    stated: Option<HeightDatum>,
) -> Result<Option<(Above, HeightDatum)>, ReadError> {
    let of = |above: Above| {
        let found = columns.iter().find(|(a, _)| *a == above);
        found.map(|_| above)
    };
    if let Some(datum) = stated {
        let found = [Above::Stated(datum), Above::Plain, Above::Open]
            .into_iter()
            .find_map(of);
        if let (None, Some((_, name))) = (found, columns.first()) {
            return Err(ReadError::Header {
                line,
                problem: format!(
                    "column '{name}' names a datum of its heights that differs from the settings"
                ),
            });
        }
        return Ok(found.map(|above| (above, datum)));
    }
    for datum in [HeightDatum::Ellipsoid, HeightDatum::Sea] {
        if let Some(above) = of(Above::Stated(datum)) {
            return Ok(Some((above, datum)));
        }
    }
    if let Some(above) = of(Above::Plain) {
        return Ok(Some((above, HeightDatum::Ellipsoid)));
    }
    if let Some((_, name)) = columns.iter().find(|(above, _)| *above == Above::Open) {
        return Err(ReadError::HeightsOpen {
            line,
            column: (*name).to_owned(),
        });
    }
    Ok(of(Above::Stated(HeightDatum::TakeOff)).map(|above| (above, HeightDatum::TakeOff)))
}
