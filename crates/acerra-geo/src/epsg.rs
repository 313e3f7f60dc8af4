//! Coordinate reference systems by their codes in the EPSG registry.

use proj4rs::Proj;
use proj4rs::adaptors::transform_xyz;

use crate::geodesy::Geodetic;
use crate::utm::{utm_from_geodetic, utm_zone};

/// Reason why coordinates of a system cannot be computed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CrsError {
    /// A code that the table of coordinate reference systems does not hold.
    #[error("EPSG:{code}: expected a coordinate reference system of the EPSG registry, found none")]
    UnknownCrs {
        /// The code.
        code: u32,
    },
    /// A system that is known but cannot be used.
    #[error(
        "EPSG:{code}: {reason}; expected a system whose datum is related to WGS84, such as UTM"
    )]
    UnusableCrs {
        /// The code.
        code: u32,
        /// Reason.
        reason: String,
    },
    /// A place outside of the area in which a system is defined.
    #[error(
        "EPSG:{code}: {latitude_deg:.6}°, {longitude_deg:.6}° has no coordinates there; expected a \
         system that covers the image"
    )]
    OutsideCrs {
        /// The code.
        code: u32,
        /// Latitude of the place (degrees).
        latitude_deg: f64,
        /// Longitude of the place (degrees).
        longitude_deg: f64,
    },
}

/// A coordinate reference system whose relation to WGS84 is known.
#[derive(Debug)]
pub struct EpsgCrs {
    code: u16,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    /// Longitude and latitude on WGS84.
    Geographic,
    /// A UTM zone on WGS84.
    Utm { zone: u8, south: bool },
    /// The projection that `proj4rs` makes from the registry's definition.
    Projected { wgs84: Box<Proj>, crs: Box<Proj> },
}

/// A place on the Earth in WGS84, longitude and latitude, with heights that datum shifts need.
const WGS84: &str = "+proj=longlat +datum=WGS84 +no_defs";

impl EpsgCrs {
    /// The UTM zone of a place, on WGS84.
    ///
    /// ```
    /// use acerra_geo::geodesy::Geodetic;
    /// use acerra_geo::epsg::EpsgCrs;
    /// let cape_town = Geodetic::from_degrees(-33.9, 18.4, 0.0);
    /// assert_eq!(EpsgCrs::utm_about(&cape_town).epsg(), 32734);
    /// ```
    #[must_use]
    pub fn utm_about(place: &Geodetic) -> Self {
        let (zone, south) = utm_zone(place);
        Self {
            code: if south { 32700 } else { 32600 } + u16::from(zone),
            kind: Kind::Utm { zone, south },
        }
    }

    /// The system of an EPSG code.
    ///
    /// Datum shifts are as in the definition (`+towgs84`): metres for old national datums.
    ///
    /// # Errors
    /// A code that is not in the table, a definition that cannot be computed here, a datum whose
    /// relation to WGS84 is not known or known by a grid file only.
    ///
    /// ```
    /// use acerra_geo::epsg::EpsgCrs;
    /// assert_eq!(EpsgCrs::from_epsg(3857)?.epsg(), 3857);
    /// assert!(EpsgCrs::from_epsg(1).is_err());
    /// # Ok::<(), acerra_geo::epsg::CrsError>(())
    /// ```
    pub fn from_epsg(code: u32) -> Result<Self, CrsError> {
        let unknown = || CrsError::UnknownCrs { code };
        let short = u16::try_from(code).map_err(|_| unknown())?;
        let kind = match code {
            4326 | 4979 => Kind::Geographic,
            32601..=32660 => utm(code - 32600, false),
            32701..=32760 => utm(code - 32700, true),
            _ => {
                let definition = crs_definitions::from_code(short).ok_or_else(unknown)?;
                projected(code, definition.proj4)?
            }
        };
        let code = if matches!(kind, Kind::Geographic) {
            4326
        } else {
            short
        };
        Ok(Self { code, kind })
    }

    /// Code.
    #[must_use]
    pub fn epsg(&self) -> u16 {
        self.code
    }

    /// Whether its coordinates are longitude and latitude in degrees, rather than easting and
    /// northing.
    #[must_use]
    pub fn is_geographic(&self) -> bool {
        match &self.kind {
            Kind::Geographic => true,
            Kind::Utm { .. } => false,
            Kind::Projected { crs, .. } => crs.is_latlong(),
        }
    }

    /// Unit of easting and northing (m); none for degrees.
    #[must_use]
    pub fn unit_m(&self) -> Option<f64> {
        match &self.kind {
            Kind::Utm { .. } => Some(1.0),
            Kind::Projected { crs, .. } if !crs.is_latlong() => Some(crs.to_meter()),
            Kind::Geographic | Kind::Projected { .. } => None,
        }
    }

    /// Easting and northing in the system's unit, or longitude and latitude in degrees.
    ///
    /// # Errors
    /// A place where the system has no coordinates.
    pub fn map_from_geodetic(&self, place: &Geodetic) -> Result<[f64; 2], CrsError> {
        match &self.kind {
            Kind::Geographic => Ok([place.longitude_deg(), place.latitude_deg()]),
            Kind::Utm { zone, south } => Ok(utm_from_geodetic(place, *zone, *south)),
            Kind::Projected { wgs84, crs } => {
                let (longitude, latitude) = (place.longitude_rad, place.latitude_rad);
                let found = transform_xyz(wgs84, crs, longitude, latitude, place.height_m);
                let outside = || CrsError::OutsideCrs {
                    code: self.code.into(),
                    latitude_deg: place.latitude_deg(),
                    longitude_deg: place.longitude_deg(),
                };
                let (x, y, _) = found.map_err(|_| outside())?;
                let [x, y] = if crs.is_latlong() {
                    [x.to_degrees(), y.to_degrees()]
                } else {
                    [x, y]
                };
                if x.is_finite() && y.is_finite() {
                    Ok([x, y])
                } else {
                    Err(outside())
                }
            }
        }
    }
}

fn utm(zone: u32, south: bool) -> Kind {
    Kind::Utm {
        zone: zone as u8,
        south,
    }
}

fn projected(code: u32, definition: &str) -> Result<Kind, CrsError> {
    let unusable = |reason: String| CrsError::UnusableCrs { code, reason };
    datum_is_related(definition).map_err(unusable)?;
    let crs = Proj::from_proj_string(definition)
        .map_err(|error| unusable(format!("{definition:?} cannot be computed: {error}")))?;
    if crs.is_geocent() || !crs.has_forward() && !crs.is_latlong() {
        return Err(unusable("it has no plane coordinates".to_owned()));
    }
    if !crs.is_normalized_axis() {
        return Err(unusable("its axes do not point east and north".to_owned()));
    }
    let wgs84 = Proj::from_proj_string(WGS84).map_err(|e| unusable(e.to_string()))?;
    Ok(Kind::Projected {
        wgs84: Box::new(wgs84),
        crs: Box::new(crs),
    })
}

/// Whether a definition relates its datum to WGS84: without that relation, coordinates would silently be off
/// by up to hundreds of metres.
fn datum_is_related(definition: &str) -> Result<(), String> {
    let value = |key: &str| {
        definition
            .split_whitespace()
            .find_map(|word| word.strip_prefix('+')?.strip_prefix(key)?.strip_prefix('='))
    };
    match value("nadgrids") {
        None | Some("@null") => {}
        Some(grid) => return Err(format!("its datum needs the grid file {grid}")),
    }
    let is_global = value("ellps").is_some_and(|ellipsoid| ["WGS84", "GRS80"].contains(&ellipsoid));
    let is_sphere_of_wgs84 = value("nadgrids") == Some("@null");
    let is_shifted = value("towgs84").is_some();
    let is_datum = value("datum").is_some_and(|datum| ["WGS84", "NAD83"].contains(&datum));
    if is_global || is_sphere_of_wgs84 || is_shifted || is_datum {
        return Ok(());
    }
    Err("its datum's relation to WGS84 is not in the table".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coordinates by PROJ 9.5 (`pyproj`, `always_xy`), at places where the systems are used. Shifts by seven
    /// parameters are as in the definitions.
    #[test]
    fn coordinates_are_those_of_proj() {
        for (code, lat, lon, expected) in PROJ {
            let crs = EpsgCrs::from_epsg(code).unwrap();
            let found = crs
                .map_from_geodetic(&Geodetic::from_degrees(lat, lon, 0.0))
                .unwrap();
            let scale = if crs.is_geographic() { 111_000.0 } else { 1.0 };
            for (f, e) in found.iter().zip(expected) {
                assert!((f - e).abs() * scale < 1e-3, "EPSG:{code}: {found:?}");
            }
        }
    }

    const PROJ: [(u32, f64, f64, [f64; 2]); 10] = [
        (3857, 41.0, 14.2, [1_580_736.769_3, 5_012_341.663_8]),
        (25833, 41.0, 14.2, [432_718.466_2, 4_539_065.232_5]),
        (2154, 46.5, 3.0, [700_000.0, 6_600_000.0]),
        (3035, 48.0, 11.0, [4_395_662.556_9, 2_765_662.609_3]),
        (3395, 10.0, 20.0, [2_226_389.815_9, 1_111_475.102_9]),
        (3031, -75.0, 30.0, [819_391.619_2, 1_419_227.915_8]),
        (3006, 60.0, 15.0, [500_000.0, 6_651_411.190_2]),
        (2193, -41.0, 174.0, [1_684_102.134_4, 5_460_761.410_7]),
        (2263, 40.7, -74.0, [984_250.0, 194_305.338_9]),
        (2056, 46.95, 7.45, [2_600_865.384_6, 1_199_879.680_8]),
    ];

    #[test]
    fn a_datum_that_is_not_related_to_wgs84_is_refused() {
        // Without a shift; by a grid; not in the registry.
        for code in [1, 70_000] {
            let error = EpsgCrs::from_epsg(code).unwrap_err();
            assert!(matches!(error, CrsError::UnknownCrs { .. }), "{error}");
        }
        assert!(datum_is_related("+proj=utm +zone=33 +ellps=intl +units=m").is_err());
        assert!(datum_is_related("+proj=longlat +ellps=clrk66 +nadgrids=conus").is_err());
        assert!(datum_is_related("+proj=utm +zone=33 +ellps=intl +towgs84=-87,-98,-121").is_ok());
    }
}
