//! GeoTIFF rasters (OGC 19-008): TIFF by the `tiff` crate, place and coordinates by the tags here.

use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::raster::{Header, Placement, Window};
use super::{Crs, TerrainError};

/// Largest strip or tile that is decoded, bytes.
const MAX_CHUNK_BYTES: usize = 256 << 20;

/// A GeoTIFF whose header has been read.
pub(super) struct Reader<R: Read + Seek> {
    decoder: Decoder<R>,
    nodata: Option<f64>,
    size: [usize; 2],
}

impl<R: Read + Seek> Reader<R> {
    pub fn open(mut reader: R) -> Result<(Header, Self), TerrainError> {
        check_texts(&mut reader)?;
        let mut limits = Limits::default();
        limits.decoding_buffer_size = MAX_CHUNK_BYTES;
        limits.intermediate_buffer_size = MAX_CHUNK_BYTES;
        let broken = |at: &str| {
            let at = at.to_owned();
            move |source| TerrainError::Tiff { at, source }
        };
        let mut decoder = Decoder::new(reader)
            .map_err(broken("TIFF header"))?
            .with_limits(limits);
        let (columns, rows) = decoder.dimensions().map_err(broken("image size"))?;
        if columns == 0 || rows == 0 {
            return Err(TerrainError::Empty);
        }
        let colour = decoder.colortype().map_err(broken("sample format"))?;
        if !matches!(colour, ColorType::Gray(_)) {
            return Err(TerrainError::Tag {
                at: "SamplesPerPixel",
                expected: "one height a pixel",
                found: format!("{colour:?}"),
            });
        }
        let keys = GeoKeys::read(&mut decoder)?;
        let placement = placement(&mut decoder, keys.pixel_is_point())?;
        let nodata = match decoder
            .find_tag(Tag::GdalNodata)
            .map_err(broken("GDAL_NODATA"))?
        {
            None => None,
            Some(value) => {
                let text = value.into_string().map_err(broken("GDAL_NODATA"))?;
                let text = text.trim_end_matches('\0').trim();
                Some(text.parse().map_err(|_| TerrainError::Tag {
                    at: "GDAL_NODATA",
                    expected: "a number",
                    found: format!("{text:?}"),
                })?)
            }
        };
        let size = [columns as usize, rows as usize];
        let header = Header {
            columns: size[0],
            rows: size[1],
            placement,
            crs: keys.crs()?,
            vertical: keys.vertical()?,
        };
        Ok((
            header,
            Self {
                decoder,
                nodata,
                size,
            },
        ))
    }

    /// Reads the strips or tiles that hold these cells.
    pub fn window(
        &mut self,
        columns: Range<usize>,
        rows: Range<usize>,
        limit: usize,
    ) -> Result<Window, TerrainError> {
        let mut window = Window::empty(columns.clone(), rows.clone(), limit)?;
        let (width, height) = self.decoder.chunk_dimensions();
        let (width, height) = (width as usize, height as usize);
        if width == 0 || height == 0 {
            return Err(TerrainError::Tag {
                at: "TileWidth, TileLength, RowsPerStrip",
                expected: "above 0",
                found: format!("{width} × {height}"),
            });
        }
        let across = self.size[0].div_ceil(width);
        for tile_row in rows.start / height..rows.end.div_ceil(height) {
            for tile_column in columns.start / width..columns.end.div_ceil(width) {
                let chunk = tile_row * across + tile_column;
                self.chunk(
                    u32::try_from(chunk).unwrap_or(u32::MAX),
                    [tile_column * width, tile_row * height],
                    &mut window,
                )?;
            }
        }
        Ok(window)
    }

    /// Decodes a strip or tile whose first cell is `first` into the window.
    fn chunk(
        &mut self,
        chunk: u32,
        first: [usize; 2],
        window: &mut Window,
    ) -> Result<(), TerrainError> {
        let broken = |source: TiffError| TerrainError::Tiff {
            at: format!("strip or tile {chunk}"),
            source,
        };
        let (width, height) = self.decoder.chunk_data_dimensions(chunk);
        let (width, height) = (width as usize, height as usize);
        let values = self.decoder.read_chunk(chunk).map_err(broken)?;
        let mut fill = |length: usize, value: &dyn Fn(usize) -> f64| {
            if length < width * height {
                return Err(TerrainError::Tag {
                    at: "strip or tile",
                    expected: "a value for each of its pixels",
                    found: format!("{length} for {width} × {height}, in number {chunk}"),
                });
            }
            let rows = first[1].max(window.first_row)
                ..(first[1] + height).min(window.first_row + window.rows);
            let columns = first[0].max(window.first_column)
                ..(first[0] + width).min(window.first_column + window.columns);
            for row in rows {
                for column in columns.clone() {
                    let v = value((row - first[1]) * width + column - first[0]);
                    // Printed in double precision, held in single: compared as the latter.
                    let missing = self.nodata.is_some_and(|n| n as f32 == v as f32);
                    if v.is_finite() && !missing {
                        let at = (row - window.first_row) * window.columns + column
                            - window.first_column;
                        window.height_m[at] = v as f32;
                    }
                }
            }
            Ok(())
        };
        match &values {
            DecodingResult::F32(v) => fill(v.len(), &|k| f64::from(v[k])),
            DecodingResult::F64(v) => fill(v.len(), &|k| v[k]),
            DecodingResult::I16(v) => fill(v.len(), &|k| f64::from(v[k])),
            DecodingResult::U16(v) => fill(v.len(), &|k| f64::from(v[k])),
            DecodingResult::I32(v) => fill(v.len(), &|k| f64::from(v[k])),
            DecodingResult::U32(v) => fill(v.len(), &|k| f64::from(v[k])),
            DecodingResult::U8(v) => fill(v.len(), &|k| f64::from(v[k])),
            DecodingResult::I8(v) => fill(v.len(), &|k| f64::from(v[k])),
            _ => Err(TerrainError::Tag {
                at: "SampleFormat",
                expected: "heights as 32- or 64-bit floats, or whole numbers up to 32 bits",
                found: "another format".to_owned(),
            }),
        }
    }
}

/// Longest text that a tag may hold, bytes.
const MAX_TEXT_BYTES: u64 = 1 << 20;

/// Refuses a directory that claims a text longer than any sensible one: the `tiff` crate refuses it
/// too, but prints as it does. What cannot be read here is left for it to name.
fn check_texts(reader: &mut (impl Read + Seek)) -> Result<(), TerrainError> {
    let found = longest_text(reader);
    reader.seek(SeekFrom::Start(0))?;
    match found {
        Ok(bytes) if bytes > MAX_TEXT_BYTES => Err(TerrainError::Limit {
            what: "bytes of a text in a tag",
            found: u128::from(bytes),
            limit: u128::from(MAX_TEXT_BYTES),
        }),
        _ => Ok(()),
    }
}

/// Longest text claimed by the first directory.
fn longest_text(reader: &mut (impl Read + Seek)) -> std::io::Result<u64> {
    let mut head = [0; 4];
    reader.read_exact(&mut head)?;
    let little = head[0] == b'I';
    // BigTIFF says so by 43 in place of 42, and counts in eight bytes.
    let big = head[if little { 2 } else { 3 }] == 43;
    let (offset, entries_bytes, count_bytes) = if big {
        number(reader, 4, little)?;
        (number(reader, 8, little)?, 8, 8)
    } else {
        (number(reader, 4, little)?, 2, 4)
    };
    reader.seek(SeekFrom::Start(offset))?;
    let entries = number(reader, entries_bytes, little)?;
    let mut longest = 0;
    for _ in 0..entries.min(1 << 16) {
        number(reader, 2, little)?;
        let kind = number(reader, 2, little)?;
        let count = number(reader, count_bytes, little)?;
        number(reader, count_bytes, little)?;
        if kind == 2 {
            longest = longest.max(count);
        }
    }
    Ok(longest)
}

/// A whole number of so many bytes.
fn number(reader: &mut impl Read, bytes: usize, little: bool) -> std::io::Result<u64> {
    let mut value = [0; 8];
    reader.read_exact(&mut value[..bytes])?;
    if !little {
        value[..bytes].reverse();
    }
    Ok(u64::from_le_bytes(value))
}

/// Where cell centres stand, from the transformation or tie point and scale.
fn placement<R: Read + Seek>(
    decoder: &mut Decoder<R>,
    pixel_is_point: bool,
) -> Result<Placement, TerrainError> {
    // Tie points count from the corner of the first pixel, or from its centre.
    let centre = if pixel_is_point { 0.0 } else { 0.5 };
    if let Some(m) = doubles(decoder, Tag::ModelTransformationTag, "ModelTransformation")? {
        let &[a, b, _, d, e, f, _, h, ..] = m.as_slice() else {
            return Err(too_short("ModelTransformation", "16 numbers", m.len()));
        };
        let origin = [d + centre * (a + b), h + centre * (e + f)];
        return Placement::new(origin, [a, e], [b, f]);
    }
    let Some(scale) = doubles(decoder, Tag::ModelPixelScaleTag, "ModelPixelScale")? else {
        return Err(TerrainError::Tag {
            at: "ModelPixelScale, ModelTransformation",
            expected: "one of them, to say where the raster stands",
            found: "neither (a TIFF without a place)".to_owned(),
        });
    };
    let tie = doubles(decoder, Tag::ModelTiepointTag, "ModelTiepoint")?.unwrap_or_default();
    let (&[sx, sy, ..], &[i, j, _, x, y, ..]) = (scale.as_slice(), tie.as_slice()) else {
        return Err(too_short(
            "ModelPixelScale, ModelTiepoint",
            "3 and 6 numbers",
            scale.len() + tie.len(),
        ));
    };
    Placement::new(
        [x + (centre - i) * sx, y - (centre - j) * sy],
        [sx, 0.0],
        [0.0, -sy],
    )
}

fn too_short(at: &'static str, expected: &'static str, found: usize) -> TerrainError {
    TerrainError::Tag {
        at,
        expected,
        found: format!("{found} numbers"),
    }
}

fn doubles<R: Read + Seek>(
    decoder: &mut Decoder<R>,
    tag: Tag,
    at: &'static str,
) -> Result<Option<Vec<f64>>, TerrainError> {
    let broken = |source| TerrainError::Tiff {
        at: at.to_owned(),
        source,
    };
    decoder
        .find_tag(tag)
        .map_err(broken)?
        .map(|v| v.into_f64_vec().map_err(broken))
        .transpose()
}

/// The GeoKey directory: key, and its value where that is a short number.
struct GeoKeys(Vec<[u16; 4]>);

/// GeoKey "user-defined".
const USER_DEFINED: u16 = 32767;

impl GeoKeys {
    fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Self, TerrainError> {
        let broken = |source| TerrainError::Tiff {
            at: "GeoKeyDirectory".to_owned(),
            source,
        };
        let Some(value) = decoder.find_tag(Tag::GeoKeyDirectoryTag).map_err(broken)? else {
            return Ok(Self(Vec::new()));
        };
        let numbers = value.into_u16_vec().map_err(broken)?;
        let keys = numbers
            .chunks_exact(4)
            .skip(1)
            .map(|k| [k[0], k[1], k[2], k[3]]);
        Ok(Self(keys.collect()))
    }

    /// The short number of a key.
    fn short(&self, key: u16) -> Option<u16> {
        let found = self.0.iter().find(|k| k[0] == key && k[1] == 0);
        found.map(|k| k[3])
    }

    fn pixel_is_point(&self) -> bool {
        self.short(1025) == Some(2)
    }

    fn crs(&self) -> Result<Option<Crs>, TerrainError> {
        let unit = |key, metre, at, expected| match self.short(key) {
            Some(code) if code != metre => Err(TerrainError::Tag {
                at,
                expected,
                found: format!("unit code {code}"),
            }),
            _ => Ok(()),
        };
        let known = |code: Option<u16>| match code {
            None | Some(USER_DEFINED | 0) => Ok(None),
            Some(code) => Crs::from_epsg(u32::from(code)).map(Some),
        };
        match self.short(1024) {
            Some(1) => {
                unit(3076, 9001, "ProjLinearUnits", "metres (9001)")?;
                known(self.short(3072))
            }
            Some(2) => {
                unit(2054, 9102, "GeogAngularUnits", "degrees (9102)")?;
                known(self.short(2048))
            }
            Some(found @ 3) => Err(TerrainError::Tag {
                at: "GTModelType",
                expected: "projected (1) or geographic (2) coordinates",
                found: format!("{found}"),
            }),
            _ => Ok(None),
        }
    }

    /// What heights are above, in words; metres are asked for.
    fn vertical(&self) -> Result<Option<String>, TerrainError> {
        if let Some(code) = self.short(4099)
            && code != 9001
            && code != USER_DEFINED
        {
            return Err(TerrainError::Tag {
                at: "VerticalUnits",
                expected: "metres (9001)",
                found: format!("unit code {code}"),
            });
        }
        Ok(self.short(4096).map(|code| match code {
            5030 | 4979 | 4326 => "the ellipsoid".to_owned(),
            5773 => "the geoid EGM96".to_owned(),
            3855 => "the geoid EGM2008".to_owned(),
            other => format!("a surface of EPSG code {other}"),
        }))
    }
}
