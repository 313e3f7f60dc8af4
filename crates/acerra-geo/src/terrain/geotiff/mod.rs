//! GeoTIFF rasters (OGC 19-008): TIFF by the `tiff` crate, place, coordinates and values by the tags here.

mod chunk;
mod keys;
mod placement;
mod texts;
mod values;

use std::io::{Read, Seek};
use std::ops::Range;

use tiff::decoder::{Decoder, Limits};
use tiff::tags::Tag;

use super::TerrainError;
use super::raster::{Header, Window};
use chunk::Chunks;
use keys::GeoKeys;
use values::Values;

/// Largest number of directories searched for a mask: an image, its overviews, and a mask of each.
const MAX_DIRECTORIES: usize = 64;

/// Bit of NewSubfileType that marks a mask.
const IS_MASK: u32 = 4;

/// A GeoTIFF whose header has been read.
pub(super) struct Reader<R: Read + Seek> {
    decoder: Decoder<R>,
    chunks: Chunks,
    /// Where the image holds data.
    mask: Option<Chunks>,
    nodata: Option<f64>,
    values: Values,
    /// Purpose of the grid by GDAL's metadata.
    pub grid_type: Option<String>,
}

impl<R: Read + Seek> Reader<R> {
    pub fn open(mut reader: R) -> Result<(Header, Self), TerrainError> {
        texts::check_texts(&mut reader)?;
        let broken = |at: &str| {
            let at = at.to_owned();
            move |source| TerrainError::Tiff { at, source }
        };
        let mut decoder = Decoder::new(reader)
            .map_err(broken("TIFF header"))?
            .with_limits(Limits::default());
        let (chunks, mask) = images(&mut decoder)?;
        let keys = GeoKeys::read(&mut decoder)?;
        let placement = placement::placement(&mut decoder, keys.pixel_is_point())?;
        let mut text = |tag: Tag, at: &str| {
            let found = decoder.find_tag(tag).map_err(broken(at))?;
            found
                .map(|v| v.into_string().map_err(broken(at)))
                .transpose()
        };
        let nodata = match text(Tag::GdalNodata, "GDAL_NODATA")? {
            None => None,
            Some(text) => {
                let text = text.trim_end_matches('\0').trim();
                Some(text.parse().map_err(|_| TerrainError::Tag {
                    at: "GDAL_NODATA",
                    expected: "a number",
                    found: format!("{text:?}"),
                })?)
            }
        };
        let metadata = text(Tag::Unknown(42_112), "GDAL_METADATA")?;
        let header = Header {
            columns: chunks.size[0],
            rows: chunks.size[1],
            placement,
            crs: keys.crs()?,
            vertical: keys.vertical()?,
        };
        let reader = Self {
            decoder,
            chunks,
            mask,
            nodata,
            values: Values::read(metadata.as_deref(), keys.vertical_unit_m()?)?,
            grid_type: values::grid_type(metadata.as_deref())?,
        };
        Ok((header, reader))
    }

    /// Reads the strips or tiles that hold these cells.
    pub fn window(
        &mut self,
        columns: Range<usize>,
        rows: Range<usize>,
        limit: usize,
    ) -> Result<Window, TerrainError> {
        let mut window = Window::empty(columns.clone(), rows.clone(), limit)?;
        let (nodata, values) = (self.nodata, self.values);
        let range = (columns, rows);
        self.chunks
            .each_cell(self.decoder.inner(), &range, |cell, stored| {
                // Printed in double precision, held in single: compared as the latter.
                let missing = nodata.is_some_and(|n| n as f32 == stored as f32);
                if stored.is_finite() && !missing {
                    window.height_m[cell] = values.height_m(stored) as f32;
                }
            })?;
        if let Some(mask) = &self.mask {
            mask.each_cell(self.decoder.inner(), &range, |cell, stored| {
                if stored == 0.0 {
                    window.height_m[cell] = f32::NAN;
                }
            })?;
        }
        Ok(window)
    }
}

/// The first image, and the mask of its size where one follows.
fn images<R: Read + Seek>(
    decoder: &mut Decoder<R>,
) -> Result<(Chunks, Option<Chunks>), TerrainError> {
    let broken = |source| TerrainError::Tiff {
        at: "image directories".to_owned(),
        source,
    };
    let first = decoder.ifd_pointer().ok_or(TerrainError::Empty)?;
    let directory = decoder.read_directory(first).map_err(broken)?;
    let image = Chunks::read(decoder, &directory)?;
    let mut next = directory.next();
    for _ in 1..MAX_DIRECTORIES {
        let Some(pointer) = next else {
            break;
        };
        let directory = decoder.read_directory(pointer).map_err(broken)?;
        let mut tags = decoder.read_directory_tags(&directory);
        let kind: u32 = tags
            .find_tag_unsigned(Tag::NewSubfileType)
            .map_err(broken)?
            .unwrap_or(0);
        let size = [Tag::ImageWidth, Tag::ImageLength].map(|t| tags.get_tag_u32(t).ok());
        let same = [0, 1].map(|a| size[a].is_some_and(|s| s as usize == image.size[a]));
        if kind & IS_MASK != 0 && same == [true; 2] {
            return Ok((image, Some(Chunks::read(decoder, &directory)?)));
        }
        next = directory.next();
    }
    Ok((image, None))
}
