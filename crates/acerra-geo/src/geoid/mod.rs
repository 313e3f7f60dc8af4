//! Heights of the geoid above the WGS84 ellipsoid, from grids such as EGM96 and EGM2008.
//!
//! A height above the sea level of the geoid is the height above the ellipsoid less the geoid's:
//!
//! ```no_run
//! use acerra_geo::geoid::GeoidGrid;
//!
//! let geoid = GeoidGrid::read("egm96_15.gtx")?;
//! let ellipsoidal_m = 104.85;
//! if let Some(geoid_m) = geoid.height_m(35.1347, 136.9776) {
//!     println!("{:.2} m above the geoid", ellipsoidal_m - geoid_m);
//! }
//! # Ok::<(), acerra_geo::geoid::GeoidError>(())
//! ```

mod binary;
mod error;
mod geotiff;
mod grid;
mod pgm;
mod text;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use binary::DAC_BYTES;
pub use error::GeoidError;
pub use grid::GeoidGrid;

/// Most bytes of a grid file: EGM2008 at one minute in 32 bits is 0.93 GB.
const MAX_BYTES: u64 = 1 << 30;

impl GeoidGrid {
    /// Reads a grid file in one of the formats of [`from_reader`](Self::from_reader).
    ///
    /// # Errors
    /// [`GeoidError::File`], which names the file.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, GeoidError> {
        let path = path.as_ref();
        let open = || Self::from_reader(File::open(path)?);
        open().map_err(|source| GeoidError::File {
            path: path.to_owned(),
            source: Box::new(source),
        })
    }

    /// Reads a grid in one of five formats, distinguished by content:
    ///
    /// - NGA's `WW15MGH.DAC` (EGM96, 0.25°): 721 rows from north to south of 1440 columns from
    ///   Greenwich eastwards, signed 16 bits, big-endian, centimetres;
    /// - NGA's `WW15MGH.GRD`: text, the edges and steps in degrees, then metres from north to
    ///   south;
    /// - NOAA VDatum `.gtx` (`egm96_15.gtx`): big-endian header of south, west, steps (degrees,
    ///   64 bits), rows and columns (32 bits), then 32-bit metres from south to north;
    /// - GeographicLib `.pgm` (`egm96-15.pgm`, `egm2008-5.pgm` …): 16-bit grey map from north to
    ///   south with `# Offset` and `# Scale` in its header;
    /// - GeoTIFF in longitude and latitude (PROJ's `us_nga_egm96_15.tif`): metres.
    ///
    /// # Errors
    /// [`GeoidError`].
    pub fn from_reader(reader: impl Read) -> Result<Self, GeoidError> {
        let mut bytes = Vec::new();
        reader.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(GeoidError::Limit { limit: MAX_BYTES });
        }
        let starts = |with: &[u8]| bytes.starts_with(with);
        if starts(b"P5") {
            pgm::read(&bytes)
        } else if starts(b"II*\0") || starts(b"MM\0*") || starts(b"II+\0") || starts(b"MM\0+") {
            geotiff::read(&bytes)
        } else if bytes.len() == DAC_BYTES {
            binary::dac(&bytes)
        } else if is_text(&bytes) {
            text::grd(&bytes)
        } else {
            binary::gtx(&bytes)
        }
    }
}

/// Whether a file that begins with `head` and has `file_bytes` bytes is a geoid grid in one of the formats of
/// [`GeoidGrid::from_reader`] other than GeoTIFF, whose heights may be anything's.
///
/// ```
/// use acerra_geo::geoid::is_grid;
/// assert!(is_grid(b"P5\n# Offset -108\n", 300));
/// assert!(is_grid(b"  -90.0 90.0 0.0 360.0 15.0 15.0\n 13.6 13.6\n", 300));
/// assert!(!is_grid(b"time_s,x_m,y_m,z_m\n", 300));
/// ```
#[must_use]
pub fn is_grid(head: &[u8], file_bytes: u64) -> bool {
    head.starts_with(b"P5")
        || file_bytes == DAC_BYTES as u64
        || text::begins(head)
        || binary::is_gtx(head, file_bytes)
}

/// Whether a file starts with numbers in text.
fn is_text(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(64)];
    !start.is_empty()
        && start
            .iter()
            .all(|b| b.is_ascii_digit() || b.is_ascii_whitespace() || b"+-.eE".contains(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tiff::tags::Tag;

    /// A plane in latitude, a wave in longitude: bilinear interpolation meets it on the grid.
    fn height(latitude: f64, longitude: f64) -> f64 {
        0.5 * latitude + 20.0 * longitude.to_radians().cos()
    }

    fn gtx_bytes() -> Vec<u8> {
        let (rows, columns) = (13_i32, 24_i32);
        let mut out = Vec::new();
        for value in [-90.0_f64, -180.0, 15.0, 15.0] {
            out.extend(value.to_be_bytes());
        }
        out.extend(rows.to_be_bytes());
        out.extend(columns.to_be_bytes());
        for row in 0..rows {
            for column in 0..columns {
                let (lat, lon) = (
                    f64::from(row) * 15.0 - 90.0,
                    f64::from(column) * 15.0 - 180.0,
                );
                out.extend((height(lat, lon) as f32).to_be_bytes());
            }
        }
        out
    }

    fn pgm_bytes() -> Vec<u8> {
        let mut out = b"P5\n# Geoid\n# Offset -108\n# Scale 0.003\n24\t13\n65535\n".to_vec();
        for row in 0..13 {
            for column in 0..24 {
                let (lat, lon) = (90.0 - f64::from(row) * 15.0, f64::from(column) * 15.0);
                let grey = ((height(lat, lon) + 108.0) / 0.003).round() as u16;
                out.extend(grey.to_be_bytes());
            }
        }
        out
    }

    fn dac_bytes() -> Vec<u8> {
        let mut out = Vec::with_capacity(DAC_BYTES);
        for row in 0..721 {
            for column in 0..1440 {
                let (lat, lon) = (90.0 - f64::from(row) * 0.25, f64::from(column) * 0.25);
                out.extend(((height(lat, lon) * 100.0).round() as i16).to_be_bytes());
            }
        }
        out
    }

    fn grd_bytes() -> Vec<u8> {
        let mut text = String::from(" -90.000000 90.000000 .000000 360.000000 15.0 15.0\n");
        for row in 0..13 {
            for column in 0..25 {
                let (lat, lon) = (90.0 - f64::from(row) * 15.0, f64::from(column) * 15.0);
                text += &format!("{:9.3}", height(lat, lon));
                text += if column % 8 == 7 { "\n" } else { "" };
            }
            text += "\n\n";
        }
        text.into_bytes()
    }

    /// A GeoTIFF of single-precision heights in one strip, cells named by their centres.
    fn geotiff_bytes() -> Vec<u8> {
        let mut out = Vec::new();
        let mut file = tiff::encoder::TiffEncoder::new(std::io::Cursor::new(&mut out)).unwrap();
        let mut image = file
            .new_image::<tiff::encoder::colortype::Gray32Float>(24, 13)
            .unwrap();
        let tags = image.encoder();
        let scale: &[f64] = &[15.0, 15.0, 0.0];
        let tie: &[f64] = &[0.0, 0.0, 0.0, -180.0, 90.0, 0.0];
        let keys: &[u16] = &[1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 2, 2048, 0, 1, 4979];
        tags.write_tag(Tag::ModelPixelScaleTag, scale).unwrap();
        tags.write_tag(Tag::ModelTiepointTag, tie).unwrap();
        tags.write_tag(Tag::GeoKeyDirectoryTag, keys).unwrap();
        let heights: Vec<f32> = (0..13 * 24)
            .map(|k| {
                let (row, column) = (f64::from(k / 24), f64::from(k % 24));
                height(90.0 - row * 15.0, column * 15.0 - 180.0) as f32
            })
            .collect();
        image.write_data(&heights).unwrap();
        out
    }

    #[test]
    fn a_file_that_is_refused_is_named() {
        let error = GeoidGrid::read("/nowhere/egm96_15.gtx").unwrap_err();
        assert!(
            error.to_string().contains("/nowhere/egm96_15.gtx"),
            "{error}"
        );
    }

    #[test]
    fn every_format_gives_the_same_heights() {
        for (bytes, tolerance) in [
            (gtx_bytes(), 1e-4),
            (pgm_bytes(), 2e-3),
            (dac_bytes(), 6e-3),
            (grd_bytes(), 1e-3),
            (geotiff_bytes(), 1e-4),
        ] {
            let grid = GeoidGrid::from_reader(&bytes[..]).unwrap();
            for (lat, lon) in [(45.0, 15.0), (-30.0, -150.0), (90.0, 0.0), (-90.0, 345.0)] {
                let found = grid.height_m(lat, lon).unwrap();
                assert!(
                    (found - height(lat, lon)).abs() < tolerance,
                    "{lat} {lon} {found}"
                );
            }
            // Half way between rows, and over the seam of the longitudes.
            let found = grid.height_m(37.5, -180.0).unwrap();
            assert!((found - height(37.5, 180.0)).abs() < tolerance);
            let (west, east) = (
                grid.height_m(0.0, 359.9).unwrap(),
                grid.height_m(0.0, 0.1).unwrap(),
            );
            assert!((west - east).abs() < tolerance, "{west} {east}");
            assert_eq!(grid.height_m(90.1, 0.0), None);
        }
    }

    #[test]
    fn a_part_of_the_earth_answers_inside_only() {
        let mut bytes = Vec::new();
        for value in [40.0_f64, 10.0, 1.0, 1.0] {
            bytes.extend(value.to_be_bytes());
        }
        bytes.extend(2_i32.to_be_bytes());
        bytes.extend(3_i32.to_be_bytes());
        for value in [1.0_f32, 2.0, 3.0, 5.0, 6.0, 7.0] {
            bytes.extend(value.to_be_bytes());
        }
        let grid = GeoidGrid::from_reader(&bytes[..]).unwrap();
        assert_eq!(grid.height_m(40.5, 10.5), Some(3.5));
        assert_eq!(grid.height_m(41.0, 12.0), Some(7.0));
        assert_eq!(grid.height_m(40.5, f64::NAN), None);
        for (lat, lon) in [(39.9, 11.0), (41.1, 11.0), (40.5, 9.9), (40.5, 12.1)] {
            assert_eq!(grid.height_m(lat, lon), None, "{lat} {lon}");
        }
    }

    #[test]
    fn other_content_is_refused() {
        let gtx = gtx_bytes();
        for bytes in [
            &gtx[..gtx.len() - 1],
            &gtx[..39],
            b"",
            b"P5",
            b"P5\n# Scale x\n3 3 65535\n",
            b"-90 90 0 360 15 15\n1.0 2.0\n",
            b"-90 90 0 360 0 15\n",
            b"-90 90 0 360 15\n",
            b"II*\0\x08\0\0\0",
        ] {
            assert!(
                GeoidGrid::from_reader(bytes).is_err(),
                "{} bytes",
                bytes.len()
            );
        }
        let mut dense = gtx.clone();
        dense[24..32].copy_from_slice(&f64::MIN_POSITIVE.to_be_bytes());
        assert!(GeoidGrid::from_reader(&dense[..]).is_err());
        let mut wild = gtx.clone();
        wild[40..44].copy_from_slice(&1e9_f32.to_be_bytes());
        assert!(matches!(
            GeoidGrid::from_reader(&wild[..]),
            Err(GeoidError::Format { .. })
        ));
        let mut nan = gtx.clone();
        nan[40..44].copy_from_slice(&f32::NAN.to_be_bytes());
        assert!(matches!(
            GeoidGrid::from_reader(&nan[..]),
            Err(GeoidError::Format { .. })
        ));
        let mut steps = gtx;
        steps[16..24].copy_from_slice(&0.0_f64.to_be_bytes());
        assert!(matches!(
            GeoidGrid::from_reader(&steps[..]),
            Err(GeoidError::Format { .. })
        ));
    }
}
