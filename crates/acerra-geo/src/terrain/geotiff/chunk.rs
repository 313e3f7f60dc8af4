//! Strips and tiles of an image, each decoded as a separate TIFF.
//!
//! The `tiff` crate reads neither Zstandard nor masks, and reads tiles wider than the image row by row. A
//! strip or tile copied after a separate directory has the width of its rows, the photometric interpretation
//! of plain numbers, and content that `ruzstd` has unpacked.

use std::io::{Cursor, Read, Seek, SeekFrom};
use std::ops::Range;

use tiff::Directory;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::{ByteOrder, Tag};

use super::super::TerrainError;

/// Most bytes of a strip or tile, unpacked.
const MAX_BYTES: u64 = 128 << 20;

/// Most bytes that the strips or tiles under one window may unpack to, all together.
const MAX_TOTAL_BYTES: u128 = 1 << 30;

/// Zstandard's number among compressions.
const ZSTD: u16 = 50_000;

/// Storage of the strips or tiles of one image.
pub(super) struct Chunks {
    order: ByteOrder,
    /// Columns and rows of the image.
    pub size: [usize; 2],
    /// Columns and rows of a whole strip or tile.
    chunk: [usize; 2],
    tiled: bool,
    bits: u16,
    compression: u16,
    predictor: u16,
    format: u16,
    offsets: Vec<u64>,
    counts: Vec<u64>,
}

impl Chunks {
    /// From the tags of a directory.
    ///
    /// # Errors
    /// Tags that are broken, contradict each other, or need an unsupported feature.
    pub fn read<R: Read + Seek>(
        decoder: &mut Decoder<R>,
        directory: &Directory,
    ) -> Result<Self, TerrainError> {
        let order = decoder.byte_order();
        let mut tags = decoder.read_directory_tags(directory);
        let broken = |at: &str| {
            let at = at.to_owned();
            move |source| TerrainError::Tiff { at, source }
        };
        let mut number = |tag: Tag, at: &str, default: Option<u32>| match default {
            Some(default) => tags
                .find_tag_unsigned(tag)
                .map(|found| found.unwrap_or(default))
                .map_err(broken(at)),
            None => tags.get_tag_unsigned(tag).map_err(broken(at)),
        };
        let size = [
            number(Tag::ImageWidth, "ImageWidth", None)?,
            number(Tag::ImageLength, "ImageLength", None)?,
        ];
        let tiled = directory.contains(Tag::TileWidth);
        let chunk = if tiled {
            [
                number(Tag::TileWidth, "TileWidth", None)?,
                number(Tag::TileLength, "TileLength", None)?,
            ]
        } else {
            let rows = number(Tag::RowsPerStrip, "RowsPerStrip", Some(u32::MAX))?;
            [size[0], rows.min(size[1])]
        };
        let short = |value: u32, at: &'static str| {
            u16::try_from(value).map_err(|_| TerrainError::Tag {
                at,
                expected: "a short number",
                found: value.to_string(),
            })
        };
        let samples = number(Tag::SamplesPerPixel, "SamplesPerPixel", Some(1))?;
        if samples != 1 {
            return Err(TerrainError::Tag {
                at: "SamplesPerPixel",
                expected: "one height a pixel",
                found: samples.to_string(),
            });
        }
        let [bits, compression, predictor, format] = [
            (Tag::BitsPerSample, "BitsPerSample", 1),
            (Tag::Compression, "Compression", 1),
            (Tag::Predictor, "Predictor", 1),
            (Tag::SampleFormat, "SampleFormat", 1),
        ]
        .map(|(tag, at, default)| short(number(tag, at, Some(default))?, at));
        let (offsets, counts) = if tiled {
            (Tag::TileOffsets, Tag::TileByteCounts)
        } else {
            (Tag::StripOffsets, Tag::StripByteCounts)
        };
        let mut numbers = |tag: Tag, at: &str| {
            let found = tags.get_tag(tag).and_then(|v| v.into_u64_vec());
            found.map_err(broken(at))
        };
        let chunks = Self {
            order,
            size: size.map(|s| s as usize),
            chunk: chunk.map(|s| s as usize),
            tiled,
            bits: bits?,
            compression: compression?,
            predictor: predictor?,
            format: format?,
            offsets: numbers(offsets, "offsets of strips or tiles")?,
            counts: numbers(counts, "lengths of strips or tiles")?,
        };
        chunks.check()?;
        Ok(chunks)
    }

    fn check(&self) -> Result<(), TerrainError> {
        if self.size.contains(&0) {
            return Err(TerrainError::Empty);
        }
        if self.chunk.contains(&0) {
            return Err(TerrainError::Tag {
                at: "TileWidth, TileLength, RowsPerStrip",
                expected: "above 0",
                found: format!("{} × {}", self.chunk[0], self.chunk[1]),
            });
        }
        match self.compression {
            1 | 5 | 8 | 32_946 | 32_773 | ZSTD => Ok(()),
            other => Err(TerrainError::Tag {
                at: "Compression",
                expected: "none, LZW, Deflate, PackBits or Zstandard (convert: gdal_translate -co \
                           COMPRESS=DEFLATE)",
                found: match other {
                    34_887 => "LERC".to_owned(),
                    34_925 => "LZMA".to_owned(),
                    6 | 7 => "JPEG".to_owned(),
                    50_001 => "WebP".to_owned(),
                    other => format!("number {other}"),
                },
            }),
        }
    }

    /// Calls `take` with each stored number under columns and rows of the image, and its index in their
    /// window.
    ///
    /// # Errors
    /// Strips or tiles that are too large, break off or cannot be unpacked.
    pub fn each_cell<R: Read + Seek>(
        &self,
        reader: &mut R,
        (columns, rows): &(Range<usize>, Range<usize>),
        mut take: impl FnMut(usize, f64),
    ) -> Result<(), TerrainError> {
        let [width, height] = self.chunk;
        let down = rows.start / height..rows.end.div_ceil(height);
        let across = columns.start / width..columns.end.div_ceil(width);
        let total = self.unpacked_bytes() * down.len() as u128 * across.len() as u128;
        if total > MAX_TOTAL_BYTES {
            return Err(TerrainError::Limit {
                what: "bytes of strips or tiles under the image",
                found: total,
                limit: MAX_TOTAL_BYTES,
            });
        }
        for (j, i) in down.flat_map(|j| across.clone().map(move |i| (j, i))) {
            let number = j * self.across() + i;
            let Some(values) = self.decode(reader, number)? else {
                continue;
            };
            let first = [i * width, j * height];
            let end = [
                (first[0] + width).min(columns.end),
                (first[1] + height).min(rows.end),
            ];
            for row in first[1].max(rows.start)..end[1] {
                for column in first[0].max(columns.start)..end[0] {
                    let at = [column - first[0], row - first[1]];
                    let value =
                        stored(&values, self.bits, at, width).ok_or_else(|| TerrainError::Tag {
                            at: "SampleFormat, BitsPerSample",
                            expected: "floats of 32 or 64 bits, or whole numbers of up to 32",
                            found: format!("format {} of {} bits", self.format, self.bits),
                        })?;
                    let cell = (row - rows.start) * columns.len() + column - columns.start;
                    take(cell, value);
                }
            }
        }
        Ok(())
    }

    /// Bytes of a whole strip or tile.
    fn unpacked_bytes(&self) -> u128 {
        let row = (self.chunk[0] as u128 * u128::from(self.bits)).div_ceil(8);
        row * self.chunk[1] as u128
    }

    /// Number of strips or tiles in a row of the image.
    fn across(&self) -> usize {
        self.size[0].div_ceil(self.chunk[0])
    }

    /// Rows of a strip or tile that are stored: strips end with the image, tiles do not.
    fn stored_rows(&self, number: usize) -> usize {
        if self.tiled {
            return self.chunk[1];
        }
        let first = number / self.across() * self.chunk[1];
        self.chunk[1].min(self.size[1].saturating_sub(first))
    }

    /// Numbers of a strip or tile, row by row with the width of [`Self::chunk`]; none where the file leaves it out, as
    /// sparse files do.
    ///
    /// # Errors
    /// One that is too large, is cut off or cannot be unpacked.
    fn decode<R: Read + Seek>(
        &self,
        reader: &mut R,
        number: usize,
    ) -> Result<Option<DecodingResult>, TerrainError> {
        let at = || format!("strip or tile {number}");
        let (Some(&offset), Some(&count)) = (self.offsets.get(number), self.counts.get(number))
        else {
            return Err(TerrainError::Tag {
                at: "strips or tiles",
                expected: "an offset and a length for each",
                found: format!("none for number {number}"),
            });
        };
        if offset == 0 && count == 0 {
            return Ok(None);
        }
        let rows = self.stored_rows(number);
        let row_bytes = (self.chunk[0] as u64 * u64::from(self.bits)).div_ceil(8);
        let bytes = row_bytes.saturating_mul(rows as u64);
        if bytes > MAX_BYTES || count > MAX_BYTES {
            return Err(TerrainError::Limit {
                what: "bytes of a strip or tile (cut it smaller: gdal_translate -co TILED=YES)",
                found: u128::from(bytes.max(count)),
                limit: u128::from(MAX_BYTES),
            });
        }
        reader.seek(SeekFrom::Start(offset))?;
        let mut packed = Vec::new();
        reader.by_ref().take(count).read_to_end(&mut packed)?;
        if (packed.len() as u64) < count {
            return Err(TerrainError::Tag {
                at: "strip or tile",
                expected: "as many bytes as its length says",
                found: format!("{} of {count} in number {number}", packed.len()),
            });
        }
        let mut compression = self.compression;
        if compression == ZSTD {
            packed = unzstd(&packed, bytes).map_err(|found| TerrainError::Tag {
                at: "strip or tile",
                expected: "Zstandard of as many bytes as its rows take",
                found: format!("{found} in number {number}"),
            })?;
            compression = 1;
        }
        let file = self.alone(&packed, rows, compression);
        let mut limits = Limits::default();
        limits.decoding_buffer_size = MAX_BYTES as usize;
        limits.intermediate_buffer_size = MAX_BYTES as usize;
        let decode = || {
            Decoder::new(Cursor::new(file))?
                .with_limits(limits)
                .read_chunk(0)
        };
        decode()
            .map(Some)
            .map_err(|source| TerrainError::Tiff { at: at(), source })
    }

    /// A TIFF with this content alone.
    fn alone(&self, content: &[u8], rows: usize, compression: u16) -> Vec<u8> {
        const ENTRIES: u16 = 11;
        let big = self.order == ByteOrder::BigEndian;
        let short = |out: &mut Vec<u8>, v: u16| {
            out.extend(if big {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            });
        };
        let long = |out: &mut Vec<u8>, v: u32| {
            out.extend(if big {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            });
        };
        let mut out = Vec::with_capacity(content.len() + 256);
        out.extend(if big { b"MM" } else { b"II" });
        short(&mut out, 42);
        long(&mut out, 8);
        short(&mut out, ENTRIES);
        let start = 8 + 2 + 12 * u32::from(ENTRIES) + 4;
        let (width, rows) = (self.chunk[0] as u32, rows as u32);
        for (tag, value) in [
            (256, width),
            (257, rows),
            (258, u32::from(self.bits)),
            (259, u32::from(compression)),
            (262, 1),
            (273, start),
            (277, 1),
            (278, rows),
            (279, content.len() as u32),
            (317, u32::from(self.predictor)),
            (339, u32::from(self.format)),
        ] {
            short(&mut out, tag);
            short(&mut out, 4);
            long(&mut out, 1);
            long(&mut out, value);
        }
        long(&mut out, 0);
        out.extend(content);
        out
    }
}

/// Zstandard's content, exactly `length` bytes.
fn unzstd(packed: &[u8], bytes: u64) -> Result<Vec<u8>, String> {
    let decoder = ruzstd::decoding::StreamingDecoder::new(packed).map_err(|e| format!("{e}"))?;
    let mut out = Vec::new();
    decoder
        .take(bytes + 1)
        .read_to_end(&mut out)
        .map_err(|e| format!("{e}"))?;
    if out.len() as u64 == bytes {
        Ok(out)
    } else {
        Err(format!("{} of {bytes} bytes", out.len()))
    }
}

/// A number of a decoded strip or tile, by its row, column and the columns of a row.
fn stored(
    values: &DecodingResult,
    bits: u16,
    [column, row]: [usize; 2],
    columns: usize,
) -> Option<f64> {
    let at = row * columns + column;
    match values {
        // Less than a byte each: rows begin with a byte, its highest bits first.
        DecodingResult::U8(v) if [1, 2, 4].contains(&bits) => {
            let a_byte = usize::from(8 / bits);
            let byte = *v.get(row * columns.div_ceil(a_byte) + column / a_byte)?;
            let shift = 8 - usize::from(bits) * (column % a_byte + 1);
            Some(f64::from((byte >> shift) & ((1u8 << bits) - 1)))
        }
        DecodingResult::F32(v) => v.get(at).map(|v| f64::from(*v)),
        DecodingResult::F64(v) => v.get(at).copied(),
        DecodingResult::I16(v) => v.get(at).map(|v| f64::from(*v)),
        DecodingResult::U16(v) => v.get(at).map(|v| f64::from(*v)),
        DecodingResult::I32(v) => v.get(at).map(|v| f64::from(*v)),
        DecodingResult::U32(v) => v.get(at).map(|v| f64::from(*v)),
        DecodingResult::U8(v) if bits == 8 => v.get(at).map(|v| f64::from(*v)),
        DecodingResult::I8(v) => v.get(at).map(|v| f64::from(*v)),
        _ => None,
    }
}
