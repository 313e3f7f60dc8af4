//! A whole GeoTIFF in longitude and latitude, as a grid from south to north.

use std::io::{Read, Seek};

use super::{TerrainError, geotiff};

/// Most cells that are held: EGM2008 at one minute has 233 million.
const MAX_CELLS: usize = 1 << 28;

/// Marks of PROJ's grids of a geoid's heights above the ellipsoid.
const GEOID_TYPE: &str = "VERTICAL_OFFSET_GEOGRAPHIC_TO_VERTICAL";

/// Heights of a raster whose rows and columns follow latitude and longitude.
pub(crate) struct GeographicRaster {
    /// Latitude of the first row (degrees).
    pub south_deg: f64,
    /// Longitude of the first column (degrees).
    pub west_deg: f64,
    /// Steps of latitude and longitude (degrees).
    pub steps_deg: [f64; 2],
    pub columns: usize,
    /// Rows from south to north (m); NaN without data.
    pub heights_m: Vec<f32>,
}

impl GeographicRaster {
    pub fn read(reader: impl Read + Seek) -> Result<Self, TerrainError> {
        let (header, mut tiff) = geotiff::Reader::open(reader)?;
        if header.crs.is_some_and(|crs| !crs.is_geographic()) {
            return Err(TerrainError::Tag {
                at: "GeoKeyDirectory",
                expected: "longitude and latitude",
                found: header.crs.map_or_else(String::new, |crs| crs.to_string()),
            });
        }
        if let Some(found) = tiff.grid_type.as_deref().filter(|t| *t != GEOID_TYPE) {
            return Err(TerrainError::Tag {
                at: "TYPE of GDAL_METADATA",
                expected: GEOID_TYPE,
                found: format!("{found:?}"),
            });
        }
        let (rows, columns) = (header.rows, header.columns);
        // The inverse of the transformation gives cells per degree.
        let [[across, turned], [turned_too, down]] = header.placement.inverse;
        if turned != 0.0 || turned_too != 0.0 || across <= 0.0 || down >= 0.0 {
            return Err(TerrainError::Tag {
                at: "the raster's transformation",
                expected: "columns eastwards and rows southwards",
                found: format!("{:?} cells per degree", header.placement.inverse),
            });
        }
        let [west_deg, north_deg] = header.placement.origin;
        let latitude_step_deg = -1.0 / down;
        let window = tiff.window(0..columns, 0..rows, MAX_CELLS)?;
        let northwards = window.height_m.chunks(columns).rev().flatten();
        Ok(Self {
            south_deg: north_deg - latitude_step_deg * (rows - 1) as f64,
            west_deg,
            steps_deg: [latitude_step_deg, 1.0 / across],
            columns,
            heights_m: northwards.copied().collect(),
        })
    }
}
