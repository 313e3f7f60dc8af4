//! Reading archives of arrays: a ZIP file with one NPY file for each.

use std::borrow::Cow;
use std::io::{Read, Seek, SeekFrom};

use zip::result::ZipError;
use zip::{CompressionMethod, ZipArchive};

use crate::error::NpzError;
use crate::npy::{NpyError, NpyHeader};
use crate::stored::StoredArray;

/// Reads arrays from an archive, by name and without the `.npy`.
pub struct NpzReader<R> {
    zip: ZipArchive<R>,
    bytes: u64,
}

impl<R: Read + Seek> NpzReader<R> {
    /// Reads the archive's directory.
    ///
    /// # Errors
    /// [`NpzError::Archive`] if there is none.
    pub fn new(mut reader: R) -> Result<Self, NpzError> {
        let bytes = reader.seek(SeekFrom::End(0)).map_err(NpzError::Archive)?;
        let zip = ZipArchive::new(reader).map_err(|e| NpzError::Archive(e.into()))?;
        Ok(Self { zip, bytes })
    }

    /// Names of the members as stored in the archive, sorted.
    #[must_use]
    pub fn members(&self) -> Vec<String> {
        let readable = |name: Result<Cow<'_, str>, _>| {
            name.map_or_else(|_: ZipError| "(unreadable)".to_owned(), Cow::into_owned)
        };
        let mut names: Vec<String> = self.zip.file_names().map(readable).collect();
        names.sort();
        names
    }

    /// The array's shape; empty for a single value.
    ///
    /// # Errors
    /// If there is no such array or its header is broken.
    pub fn shape(&mut self, array: &'static str) -> Result<Vec<u64>, NpzError> {
        self.open(array, |header, _| Ok(header.shape.clone()))
    }

    /// Shape and values `(re, im)` of an array, in the file's order.
    ///
    /// # Errors
    /// If there is no such array, it is broken, or it holds more than `limit` values or than
    /// [`with`](Self::with) admits.
    #[allow(clippy::type_complexity)]
    pub fn values(
        &mut self,
        array: &'static str,
        limit: usize,
    ) -> Result<(Vec<u64>, Vec<(f64, f64)>), NpzError> {
        self.with(array, |header, mut reader| {
            let mut values = Vec::with_capacity(header.value_count(limit)?);
            header.read_values(&mut reader, limit, |re, im| values.push((re, im)))?;
            Ok((header.shape.clone(), values))
        })
    }

    /// An uncompressed array, of which parts can be read.
    ///
    /// # Errors
    /// If there is no such array, it is compressed, or its header contradicts its length.
    pub fn stored(&mut self, array: &'static str) -> Result<StoredArray<'_, R>, NpzError> {
        let name = format!("{array}.npy");
        let compression = self.zip.by_name(&name).map(|file| file.compression());
        if compression.map_err(|e| NpzError::Archive(e.into()))? != CompressionMethod::Stored {
            return Err(NpzError::Compressed { array });
        }
        let file = self.zip.by_name_seek(&name);
        StoredArray::new(array, file.map_err(|e| NpzError::Archive(e.into()))?)
    }

    /// Opens an array, reads its header and hands both to `body`, which may hold all values in memory.
    ///
    /// # Errors
    /// If there is no such array, its header is broken or claims far more values than the archive's length
    /// justifies, or `body` fails.
    pub fn with<T>(
        &mut self,
        array: &'static str,
        body: impl FnOnce(&NpyHeader, &mut dyn Read) -> Result<T, NpyError>,
    ) -> Result<T, NpzError> {
        let bytes = self.bytes;
        self.open(array, |header, values| {
            header.check_archive(bytes)?;
            body(header, values)
        })
    }

    fn open<T>(
        &mut self,
        array: &'static str,
        body: impl FnOnce(&NpyHeader, &mut dyn Read) -> Result<T, NpyError>,
    ) -> Result<T, NpzError> {
        let name = format!("{array}.npy");
        let mut file = self
            .zip
            .by_name(&name)
            .map_err(|e| NpzError::Archive(e.into()))?;
        NpyHeader::read(&mut file)
            .and_then(|header| body(&header, &mut file))
            .map_err(|source| NpzError::Array { array, source })
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use crate::{NpzReader, NpzWriter};

    #[test]
    fn shapes_that_the_archive_does_not_justify_are_refused_before_memory_is_taken() {
        let mut npz = NpzWriter::deflated(Cursor::new(Vec::new()));
        let zeros = |count: u64| (0..count).map(|_| 0.0_f32);
        npz.array("few", &[2000, 8000], zeros(16_000_000)).unwrap();
        npz.array("many", &[2100, 8000], zeros(16_800_000)).unwrap();
        let file = npz.finish().unwrap();
        let bytes = file.get_ref().len();
        assert!(bytes < 1 << 20, "{bytes}");
        let mut npz = NpzReader::new(file).unwrap();
        let (shape, values) = npz.values("few", usize::MAX).unwrap();
        assert_eq!((shape, values.len()), (vec![2000, 8000], 16_000_000));
        let mut taken = 0;
        let refused = npz.with("many", |header, mut values| {
            header.read_values(&mut values, usize::MAX, |_, _| taken += 1)
        });
        let said = refused.unwrap_err().to_string();
        let expected = format!("claims 16800000 values, which an archive of {bytes} bytes");
        assert!(
            said.contains("`many`") && said.contains(&expected),
            "{said}"
        );
        assert_eq!(taken, 0);
        assert_eq!(npz.shape("many").unwrap(), [2100, 8000]);
    }
}
