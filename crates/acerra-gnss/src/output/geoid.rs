//! Geoid heights from grids.

use std::io::{self, Read};

/// Bytes of NGA's EGM96 grid of a quarter of a degree.
const DAC_BYTES: usize = 721 * 1440 * 2;
/// Most bytes of a grid file: EGM2008 at one minute in 32 bits is 0.93 GB.
const MAX_BYTES: u64 = 1 << 30;
/// Heights of the geoid above the ellipsoid lie within these bounds (m).
const HEIGHTS_M: std::ops::RangeInclusive<f64> = -150.0..=150.0;

/// Why a geoid grid cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GeoidError {
    /// The file cannot be read.
    #[error("cannot read: {0}")]
    Io(#[from] io::Error),
    /// The content is none of the known formats.
    #[error(
        "expected a geoid grid: NGA WW15MGH.DAC ({DAC_BYTES} bytes), NOAA .gtx, or GeographicLib \
         .pgm; found {bytes} bytes of something else"
    )]
    Unknown {
        /// Size of the file.
        bytes: usize,
    },
    /// The header contradicts the file.
    #[error("{format} geoid grid: expected {expected}, found {found}")]
    Format {
        /// The format.
        format: &'static str,
        /// What should be there.
        expected: String,
        /// What is there.
        found: String,
    },
    /// Larger than any known grid.
    #[error("the file exceeds the limit of {limit} bytes")]
    Limit {
        /// The limit.
        limit: u64,
    },
}

/// Heights of a geoid above the WGS84 ellipsoid on a regular grid.
#[derive(Clone, PartialEq)]
pub struct GeoidGrid {
    /// Latitude of the first row and step to the next (degrees, towards the north).
    south_deg: f64,
    latitude_step_deg: f64,
    /// Longitude of the first column and step to the next (degrees, towards the east).
    west_deg: f64,
    longitude_step_deg: f64,
    columns: usize,
    /// Whether the columns go around the Earth.
    around: bool,
    /// Rows from south to north (m).
    heights_m: Vec<f32>,
}

impl std::fmt::Debug for GeoidGrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GeoidGrid")
            .field("rows", &self.rows())
            .field("columns", &self.columns)
            .finish_non_exhaustive()
    }
}

/// The edges and steps of a grid (degrees).
struct Layout {
    south: f64,
    west: f64,
    steps: [f64; 2],
    rows: usize,
    columns: usize,
}

impl GeoidGrid {
    /// Reads a grid in one of three formats, told apart by content:
    ///
    /// - NGA's `WW15MGH.DAC` (EGM96, 0.25°): 721 rows from north to south of 1440 columns from
    ///   Greenwich eastwards, signed 16 bits, big-endian, centimetres;
    /// - NOAA VDatum `.gtx` (`egm96_15.gtx`): big-endian header of south, west, steps (degrees,
    ///   64 bits), rows and columns (32 bits), then 32-bit metres from south to north;
    /// - GeographicLib `.pgm` (`egm96-15.pgm`, `egm2008-5.pgm` …): 16-bit grey map from north to
    ///   south with `# Offset` and `# Scale` in its header.
    ///
    /// # Errors
    /// [`GeoidError`].
    pub fn read(reader: impl Read) -> Result<Self, GeoidError> {
        let mut bytes = Vec::new();
        reader.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(GeoidError::Limit { limit: MAX_BYTES });
        }
        if bytes.starts_with(b"P5") {
            return pgm(&bytes);
        }
        if bytes.len() == DAC_BYTES {
            return dac(&bytes);
        }
        gtx(&bytes)
    }

    fn new(layout: &Layout, heights_m: Vec<f32>, format: &'static str) -> Result<Self, GeoidError> {
        let wrong = |expected: &str, found: String| GeoidError::Format {
            format,
            expected: expected.to_owned(),
            found,
        };
        let [latitude_step_deg, longitude_step_deg] = layout.steps;
        let north = layout.south + latitude_step_deg * (layout.rows - 1) as f64;
        let sane = layout.rows >= 2
            && layout.columns >= 2
            && latitude_step_deg > 0.0
            && longitude_step_deg > 0.0
            && layout.south >= -90.001
            && north <= 90.001
            && layout.west.abs() <= 360.0
            && longitude_step_deg * (layout.columns - 1) as f64 <= 360.001;
        if !sane {
            let found = format!(
                "{} × {} from {}° {}° by {latitude_step_deg}° {longitude_step_deg}°",
                layout.rows, layout.columns, layout.south, layout.west
            );
            return Err(wrong("rows and columns on the Earth", found));
        }
        if let Some(bad) = heights_m
            .iter()
            .find(|h| !HEIGHTS_M.contains(&f64::from(**h)))
        {
            return Err(wrong("heights within ±150 m", format!("{bad} m")));
        }
        let width_deg = longitude_step_deg * layout.columns as f64;
        Ok(Self {
            south_deg: layout.south,
            latitude_step_deg,
            west_deg: layout.west,
            longitude_step_deg,
            columns: layout.columns,
            around: width_deg > 359.999,
            heights_m,
        })
    }

    fn rows(&self) -> usize {
        self.heights_m.len() / self.columns
    }

    /// Height of the geoid above the ellipsoid (m), bilinear between the grid's points; `None`
    /// outside the grid.
    #[must_use]
    pub fn height_m(&self, latitude_deg: f64, longitude_deg: f64) -> Option<f64> {
        let y = (latitude_deg - self.south_deg) / self.latitude_step_deg;
        let x = (longitude_deg - self.west_deg).rem_euclid(360.0) / self.longitude_step_deg;
        let last_row = (self.rows() - 1) as f64;
        // Roundoff at the very edges.
        let y = if y > -1e-9 && y < last_row + 1e-9 {
            y.clamp(0.0, last_row)
        } else {
            return None;
        };
        let (row, column) = (y.floor() as usize, x.floor() as usize);
        let next_row = (row + 1).min(self.rows() - 1);
        let next_column = if column + 1 < self.columns {
            column + 1
        } else if self.around {
            0
        } else if column + 1 == self.columns && x.fract() < 1e-9 {
            column
        } else {
            return None;
        };
        let at = |row: usize, column: usize| {
            let index = row * self.columns + column % self.columns;
            self.heights_m.get(index).copied().map(f64::from)
        };
        let (dy, dx) = (y - row as f64, x - column as f64);
        let south = at(row, column)? * (1.0 - dx) + at(row, next_column)? * dx;
        let north = at(next_row, column)? * (1.0 - dx) + at(next_row, next_column)? * dx;
        Some(south * (1.0 - dy) + north * dy)
    }
}

/// Rows turned around, so that they go from south to north.
fn northwards(heights_m: &[f32], columns: usize) -> Vec<f32> {
    heights_m.chunks(columns).rev().flatten().copied().collect()
}

fn dac(bytes: &[u8]) -> Result<GeoidGrid, GeoidError> {
    let heights: Vec<f32> = bytes
        .chunks_exact(2)
        .map(|b| f32::from(i16::from_be_bytes([b[0], b[1]])) * 0.01)
        .collect();
    let layout = Layout {
        south: -90.0,
        west: 0.0,
        steps: [0.25, 0.25],
        rows: 721,
        columns: 1440,
    };
    GeoidGrid::new(&layout, northwards(&heights, 1440), "EGM96 .DAC")
}

fn gtx(bytes: &[u8]) -> Result<GeoidGrid, GeoidError> {
    const HEADER_BYTES: usize = 40;
    let unknown = || GeoidError::Unknown { bytes: bytes.len() };
    let real = |at: usize| {
        let field: Option<[u8; 8]> = bytes.get(at..at + 8)?.try_into().ok();
        field.map(f64::from_be_bytes).filter(|v| v.is_finite())
    };
    let count = |at: usize| {
        let field: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
        usize::try_from(i32::from_be_bytes(field)).ok()
    };
    let header = || {
        Some((
            real(0)?,
            real(8)?,
            [real(16)?, real(24)?],
            count(32)?,
            count(36)?,
        ))
    };
    let (south, west, steps, rows, columns) = header().ok_or_else(unknown)?;
    let expected = rows
        .checked_mul(columns)
        .and_then(|n| n.checked_mul(4)?.checked_add(HEADER_BYTES));
    if expected != Some(bytes.len()) || rows < 2 || columns < 2 {
        return Err(unknown());
    }
    let heights = bytes[HEADER_BYTES..]
        .chunks_exact(4)
        .map(|b| f32::from_be_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    let layout = Layout {
        south,
        west,
        steps,
        rows,
        columns,
    };
    GeoidGrid::new(&layout, heights, ".gtx")
}

fn pgm(bytes: &[u8]) -> Result<GeoidGrid, GeoidError> {
    let wrong = |expected: &str, found: String| GeoidError::Format {
        format: ".pgm",
        expected: expected.to_owned(),
        found,
    };
    let (mut offset, mut scale) = (None, None);
    let mut numbers = Vec::new();
    let mut at = 2;
    // Width, height and greatest value, among comments; one blank ends the header.
    while numbers.len() < 3 {
        match bytes.get(at) {
            Some(b'#') => {
                let end = bytes[at..].iter().position(|&b| b == b'\n').unwrap_or(0);
                let comment = String::from_utf8_lossy(&bytes[at..at + end]).into_owned();
                let mut words = comment.trim_start_matches('#').split_whitespace();
                let (key, value) = (words.next(), words.next().and_then(|v| v.parse().ok()));
                match key {
                    Some("Offset") => offset = value,
                    Some("Scale") => scale = value,
                    _ => {}
                }
                at += end.max(1);
            }
            Some(b) if b.is_ascii_whitespace() => at += 1,
            Some(b'0'..=b'9') => {
                let digits = bytes[at..]
                    .iter()
                    .take_while(|b| b.is_ascii_digit())
                    .count();
                let text = String::from_utf8_lossy(&bytes[at..at + digits]).into_owned();
                let number = text.parse::<usize>();
                numbers.push(number.map_err(|_| wrong("a width, height or depth", text))?);
                at += digits;
            }
            Some(&other) => return Err(wrong("a number", format!("{:?}", char::from(other)))),
            None => return Err(wrong("width, height and depth", "the end".to_owned())),
        }
    }
    let (columns, rows) = (numbers[0], numbers[1]);
    let (offset, scale): (f64, f64) = offset
        .zip(scale)
        .ok_or_else(|| wrong("# Offset and # Scale", "neither or one".to_owned()))?;
    let pixels = bytes.get(at + 1..).unwrap_or(&[]);
    let needed = rows.checked_mul(columns).and_then(|n| n.checked_mul(2));
    if needed != Some(pixels.len()) || numbers[2] != 65_535 || rows < 3 || columns < 2 {
        let expected = format!("{columns} × {rows} values of 16 bits");
        return Err(wrong(&expected, format!("{} bytes", pixels.len())));
    }
    let heights: Vec<f32> = pixels
        .chunks_exact(2)
        .map(|b| (offset + scale * f64::from(u16::from_be_bytes([b[0], b[1]]))) as f32)
        .collect();
    let layout = Layout {
        south: -90.0,
        west: 0.0,
        steps: [180.0 / (rows - 1) as f64, 360.0 / columns as f64],
        rows,
        columns,
    };
    GeoidGrid::new(&layout, northwards(&heights, columns), ".pgm")
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn every_format_gives_the_same_heights() {
        for (bytes, tolerance) in [
            (gtx_bytes(), 1e-4),
            (pgm_bytes(), 2e-3),
            (dac_bytes(), 6e-3),
        ] {
            let grid = GeoidGrid::read(&bytes[..]).unwrap();
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
        let grid = GeoidGrid::read(&bytes[..]).unwrap();
        assert_eq!(grid.height_m(40.5, 10.5), Some(3.5));
        assert_eq!(grid.height_m(41.0, 12.0), Some(7.0));
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
        ] {
            assert!(GeoidGrid::read(bytes).is_err(), "{} bytes", bytes.len());
        }
        let mut wild = gtx.clone();
        wild[40..44].copy_from_slice(&1e9_f32.to_be_bytes());
        assert!(matches!(
            GeoidGrid::read(&wild[..]),
            Err(GeoidError::Format { .. })
        ));
        let mut nan = gtx.clone();
        nan[40..44].copy_from_slice(&f32::NAN.to_be_bytes());
        assert!(matches!(
            GeoidGrid::read(&nan[..]),
            Err(GeoidError::Format { .. })
        ));
        let mut steps = gtx;
        steps[16..24].copy_from_slice(&0.0_f64.to_be_bytes());
        assert!(matches!(
            GeoidGrid::read(&steps[..]),
            Err(GeoidError::Format { .. })
        ));
    }
}
