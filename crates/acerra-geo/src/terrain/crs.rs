//! Coordinates that terrain comes in.

use super::TerrainError;
use crate::epsg::EpsgCrs;
use crate::geodesy::Geodetic;
use crate::utm::utm_from_geodetic;

/// Meaning of the first two coordinates of a raster.
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
    /// Another system of the EPSG registry whose datum is related to WGS84, by its code.
    Epsg(u16),
    /// Metres east and north of the origin of the positions' local frame, heights in that frame.
    Local,
}

const KNOWN: &str = "\"local\" or EPSG: and a number, such as EPSG:4326 or EPSG:32633";

impl Crs {
    /// From its EPSG code.
    ///
    /// # Errors
    /// A system that is not supported.
    ///
    /// ```
    /// use acerra_geo::terrain::Crs;
    /// assert_eq!(Crs::from_epsg(32733)?, Crs::Utm { zone: 33, south: true });
    /// assert_eq!(Crs::from_epsg(6708)?, Crs::Epsg(6708)); // RDN2008 / UTM zone 33N
    /// assert!(Crs::from_epsg(1).is_err());
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
            _ => Ok(Self::Epsg(EpsgCrs::from_epsg(code)?.epsg())),
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

    /// Whether the coordinates are longitude and latitude.
    pub(super) fn is_geographic(self) -> bool {
        match self {
            Self::Geographic => true,
            Self::Epsg(code) => {
                EpsgCrs::from_epsg(code.into()).is_ok_and(|crs| crs.is_geographic())
            }
            Self::Utm { .. } | Self::Local => false,
        }
    }
}

/// Transformation from places on the Earth to the coordinates of a system.
pub(super) enum Projection {
    Geographic,
    Utm { zone: u8, south: bool },
    Epsg(EpsgCrs),
}

impl Projection {
    /// Of a system; none for [`Crs::Local`].
    pub fn of(crs: Crs) -> Result<Option<Self>, TerrainError> {
        Ok(Some(match crs {
            Crs::Geographic => Self::Geographic,
            Crs::Utm { zone, south } => Self::Utm { zone, south },
            Crs::Epsg(code) => Self::Epsg(EpsgCrs::from_epsg(code.into())?),
            Crs::Local => return Ok(None),
        }))
    }

    /// First and second coordinate of a place; a longitude is the one within half a turn of another.
    pub fn coordinates(
        &self,
        place: &Geodetic,
        near_longitude_deg: f64,
    ) -> Result<[f64; 2], TerrainError> {
        let near = |[longitude, latitude]: [f64; 2]| {
            let turns = ((near_longitude_deg - longitude) / 360.0).round();
            [longitude + 360.0 * turns, latitude]
        };
        Ok(match self {
            Self::Geographic => near([place.longitude_deg(), place.latitude_deg()]),
            Self::Utm { zone, south } => utm_from_geodetic(place, *zone, *south),
            Self::Epsg(crs) if crs.is_geographic() => near(crs.map_from_geodetic(place)?),
            Self::Epsg(crs) => crs.map_from_geodetic(place)?,
        })
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
            Self::Epsg(code) => write!(f, "EPSG:{code}"),
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
        for wrong in ["", "4326", "EPSG:", "EPSG:32600", "EPSG:99999999999"] {
            let message = Crs::parse(wrong).unwrap_err().to_string();
            assert!(message.contains("EPSG:"), "{message}");
        }
    }
}
