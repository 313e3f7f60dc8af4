//! Parts of an array that lies uncompressed in its archive, read where they lie.

use std::io::{BufReader, Read, Seek, SeekFrom};

use zip::read::ZipFileSeek;

use crate::error::NpzError;
use crate::npy::{NpyError, NpyHeader};

/// Bytes read at once: values nearer to one another than this cost one read.
const BLOCK_BYTES: usize = 1 << 13;

/// An array whose parts are read without the rest. The archive's checksum covers the whole array and
/// is not verified.
pub struct StoredArray<'a, R> {
    array: &'static str,
    header: NpyHeader,
    reader: BufReader<ZipFileSeek<'a, R>>,
    /// Bytes of the header, before the first value.
    start: u64,
    /// The place of the reader, in bytes from the start of the header.
    at: u64,
}

impl<'a, R: Read + Seek> StoredArray<'a, R> {
    pub(crate) fn new(array: &'static str, file: ZipFileSeek<'a, R>) -> Result<Self, NpzError> {
        let mut reader = BufReader::with_capacity(BLOCK_BYTES, file);
        let (header, start) =
            begin(&mut reader).map_err(|source| NpzError::Array { array, source })?;
        Ok(Self {
            array,
            header,
            reader,
            start,
            at: start,
        })
    }

    /// Content of the array's header.
    #[must_use]
    pub fn header(&self) -> &NpyHeader {
        &self.header
    }

    /// Hands `(re, im)` of `count` values from `first` on, in the file's order, to `sink`.
    ///
    /// # Errors
    /// Values beyond the array's end, or a file that cannot be read.
    pub fn values(
        &mut self,
        first: u64,
        count: u64,
        mut sink: impl FnMut(f64, f64),
    ) -> Result<(), NpzError> {
        let (start, at) = (self.start, &mut self.at);
        let (header, reader) = (&self.header, &mut self.reader);
        let mut read = || -> Result<(), NpyError> {
            header.check_part(first, count)?;
            let mut item = [0_u8; 16];
            let item = &mut item[..header.item_bytes()];
            let wanted = start + first * item.len() as u64;
            // Values of one file are less than 2^63 bytes apart.
            reader.seek_relative(wanted.wrapping_sub(*at).cast_signed())?;
            *at = wanted;
            for _ in 0..count {
                reader.read_exact(item)?;
                *at += item.len() as u64;
                let (re, im) = header.decode(item);
                sink(re, im);
            }
            Ok(())
        };
        let array = self.array;
        read().map_err(|source| NpzError::Array { array, source })
    }
}

/// Reads a header, checks it against the bytes behind it, and stays at the first value.
fn begin(reader: &mut (impl Read + Seek)) -> Result<(NpyHeader, u64), NpyError> {
    let header = NpyHeader::read(reader)?;
    let start = reader.stream_position()?;
    let bytes = reader.seek(SeekFrom::End(0))?.saturating_sub(start);
    header.check_bytes(bytes)?;
    reader.seek(SeekFrom::Start(start))?;
    Ok((header, start))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use num_complex::Complex32;

    use crate::{NpzReader, NpzWriter};

    const SHAPE: [u64; 3] = [5, 40, 70];

    fn archive(deflated: bool) -> Cursor<Vec<u8>> {
        let file = Cursor::new(Vec::new());
        let mut npz = match deflated {
            true => NpzWriter::deflated(file),
            false => NpzWriter::stored(file),
        };
        npz.array("z_m", &[2], [0.0_f64, 1.0]).unwrap();
        let values = (0..5 * 40 * 70_u16).map(|k| Complex32::new(f32::from(k), -1.0));
        npz.array("volume", &SHAPE, values).unwrap();
        npz.finish().unwrap()
    }

    #[test]
    fn parts_are_those_of_the_whole() {
        let mut npz = NpzReader::new(archive(false)).unwrap();
        let mut array = npz.stored("volume").unwrap();
        assert_eq!(array.header().shape, SHAPE);
        // Forwards, backwards, within a block and far from it.
        for (first, count) in [(0, 3), (13_990, 10), (7, 1), (9, 2), (6_000, 4_000), (0, 0)] {
            let mut found = Vec::new();
            array
                .values(first, count, |re, im| found.push((re, im)))
                .unwrap();
            let expected: Vec<_> = (first..first + count).map(|k| (k as f64, -1.0)).collect();
            assert_eq!(found, expected, "{count} from {first}");
        }
    }

    #[test]
    fn parts_beyond_the_end_and_arrays_that_are_compressed_are_refused() {
        let mut npz = NpzReader::new(archive(false)).unwrap();
        let mut array = npz.stored("volume").unwrap();
        for (first, count) in [(13_999, 2), (14_001, 0), (u64::MAX, 1), (1, u64::MAX)] {
            let message = array
                .values(first, count, |_, _| ())
                .unwrap_err()
                .to_string();
            assert!(
                message.contains("volume") && message.contains("14000"),
                "{message}"
            );
        }
        assert!(npz.stored("absent").is_err());
        let mut npz = NpzReader::new(archive(true)).unwrap();
        let message = npz.stored("volume").err().unwrap().to_string();
        assert!(
            message.contains("`volume`: expected an uncompressed array"),
            "{message}"
        );
    }

    #[test]
    fn headers_that_claim_other_sizes_are_refused() {
        let mut bytes = archive(false).into_inner();
        let at = bytes.windows(11).position(|w| w == b"(5, 40, 70)").unwrap();
        bytes[at + 1] = b'6';
        let mut npz = NpzReader::new(Cursor::new(bytes)).unwrap();
        let message = npz.stored("volume").err().unwrap().to_string();
        assert!(
            message.contains("claims 16800 values, only 14000"),
            "{message}"
        );
    }
}
