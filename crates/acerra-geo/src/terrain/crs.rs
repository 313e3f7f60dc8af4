//! Coordinates that terrain comes in.

use super::TerrainError;
use crate::geodesy::Geodetic;
use crate::utm::utm_from_geodetic;

/// What the first two coordinates of a raster are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Crs {
    /// Longitude and latitude in degrees on WGS84 (or ETRS89, from which it differs by the drift of
    /// Europe, under a metre).
    Geographic,
    /// Easting and northing in metres: UTM on WGS84 or ETRS89.
    Utm {
        /// Zone, 1 to 60.
        zone: u8,
        /// Whether south of the equator.
        south: bool,
    },
    /// Metres east and north of the origin of the positions' own frame, heights in it.
    Local,
}

const KNOWN: &str = "\"local\", EPSG:4326 (also 4979, 4258) or a UTM zone on WGS84 or ETRS89 \
                     (EPSG:32601–32660, 32701–32760, 25828–25838)";

impl Crs {
    /// From its EPSG code.
    ///
    /// # Errors
    /// One that is not known here.
    ///
    /// ```
    /// use acerra_geo::terrain::Crs;
    /// assert_eq!(Crs::from_epsg(32733)?, Crs::Utm { zone: 33, south: true });
    /// assert!(Crs::from_epsg(3857).is_err());
    /// # Ok::<(), acerra_geo::terrain::TerrainError>(())
    /// ```
    pub fn from_epsg(code: u32) -> Result<Self, TerrainError> {
        let zone = |south, base| Self::Utm {
            zone: (code - base) as u8,
            south,
        };
        match code {
            4326 | 4979 | 4258 => Ok(Self::Geographic),
            32601..=32660 => Ok(zone(false, 32600)),
            32701..=32760 => Ok(zone(true, 32700)),
            25828..=25838 => Ok(zone(false, 25800)),
            _ => Err(TerrainError::Crs {
                expected: KNOWN,
                found: format!("EPSG:{code}"),
            }),
        }
    }

    /// From `local` or `EPSG:…`.
    ///
    /// # Errors
    /// Anything else.
    pub fn parse(text: &str) -> Result<Self, TerrainError> {
        if text.eq_ignore_ascii_case("local") {
            return Ok(Self::Local);
        }
        let upper = text.to_ascii_uppercase();
        match upper.strip_prefix("EPSG:").and_then(|c| c.parse().ok()) {
            Some(code) => Self::from_epsg(code),
            None => Err(TerrainError::Crs {
                expected: KNOWN,
                found: format!("{text:?}"),
            }),
        }
    }

    /// First and second coordinate of a place; none in [`Crs::Local`].
    pub(super) fn coordinates(self, place: &Geodetic) -> Option<[f64; 2]> {
        match self {
            Self::Geographic => Some([place.longitude_deg(), place.latitude_deg()]),
            Self::Utm { zone, south } => Some(utm_from_geodetic(place, zone, south)),
            Self::Local => None,
        }
    }
}

impl std::fmt::Display for Crs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Geographic => f.write_str("longitude and latitude"),
            Self::Utm { zone, south } => {
                write!(
                    f,
                    "UTM zone {zone} {}",
                    if *south { "south" } else { "north" }
                )
            }
            Self::Local => f.write_str("local east and north"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_words_are_known_or_refused() {
        assert_eq!(Crs::parse("local").unwrap(), Crs::Local);
        assert_eq!(Crs::parse("epsg:4326").unwrap(), Crs::Geographic);
        assert_eq!(
            Crs::parse("EPSG:25832").unwrap(),
            Crs::Utm {
                zone: 32,
                south: false
            }
        );
        for wrong in [
            "",
            "4326",
            "EPSG:",
            "EPSG:32600",
            "EPSG:32661",
            "EPSG:99999999999",
        ] {
            let message = Crs::parse(wrong).unwrap_err().to_string();
            assert!(message.contains("EPSG:4326"), "{message}");
        }
    }
}
