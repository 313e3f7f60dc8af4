//! Packed files: gzip, UNIX `compress`, and zip archives of services and receivers.

use std::io::{Cursor, Error, ErrorKind, Read, Seek, SeekFrom};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use zip::ZipArchive;

use crate::input::ReadError;

/// Unpacked size (bytes) that is always accepted.
const FREE_BYTES: u64 = 16 << 20;
/// Largest ratio of unpacked to packed size beyond that: logs shrink to a half, texts to a tenth.
const MOST_TIMES: u64 = 16;

/// Largest number of members of an archive that are read.
const MAX_MEMBERS: usize = 256;

/// Counts the bytes read of a packed stream.
pub(crate) struct Counted<R> {
    inner: R,
    packed: Arc<AtomicU64>,
}

impl<R: Read> Counted<R> {
    pub fn new(inner: R) -> Self {
        Self {
            inner,
            packed: Arc::default(),
        }
    }

    /// The count, to share with [`Unpacked`].
    pub fn packed(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.packed)
    }
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let taken = self.inner.read(buffer)?;
        self.packed.fetch_add(taken as u64, Ordering::Relaxed);
        Ok(taken)
    }
}

impl<R: Seek> Seek for Counted<R> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.inner.seek(to)
    }
}

/// Output of a decoder. The output ends where the packed stream is cut off, which is recorded instead of
/// failing; it fails where a small file unpacks without end.
pub(crate) struct Unpacked<R> {
    inner: R,
    packed: Arc<AtomicU64>,
    unpacked: u64,
    cut: Arc<AtomicBool>,
}

impl<R: Read> Unpacked<R> {
    pub fn new(inner: R, packed: Arc<AtomicU64>, cut: Arc<AtomicBool>) -> Self {
        Self {
            inner,
            packed,
            unpacked: 0,
            cut,
        }
    }
}

impl<R: Read> Read for Unpacked<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = match self.inner.read(buffer) {
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                self.cut.store(true, Ordering::Relaxed);
                0
            }
            other => other?,
        };
        self.unpacked += read as u64;
        let packed = self.packed.load(Ordering::Relaxed);
        if self.unpacked > FREE_BYTES + MOST_TIMES * packed {
            return Err(Error::new(
                ErrorKind::InvalidData,
                format!(
                    "{packed} packed bytes unpack to more than {MOST_TIMES} times as many, more than any \
                     log: unpack the file if it is a log"
                ),
            ));
        }
        Ok(read)
    }
}

/// Calls `take` for each file of a zip archive, with its name.
///
/// # Errors
/// An archive that is broken, and errors of `take`.
pub(crate) fn each_member(
    archive: &[u8],
    mut take: impl FnMut(String, &mut dyn Read) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    let broken = |e: zip::result::ZipError| ReadError::Archive {
        problem: e.to_string(),
    };
    let counted = Counted::new(Cursor::new(archive));
    let packed = counted.packed();
    let mut zip = ZipArchive::new(counted).map_err(broken)?;
    for index in 0..zip.len().min(MAX_MEMBERS) {
        let member = zip.by_index(index).map_err(broken)?;
        let name = member.name().map_err(broken)?.into_owned();
        if member.is_dir() || name.starts_with("__MACOSX/") {
            continue;
        }
        // The share that is read so far, whatever size the archive states.
        packed.store(0, Ordering::Relaxed);
        let mut content = Unpacked::new(member, Arc::clone(&packed), Arc::default());
        take(name, &mut content)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    /// The ratio is that of the share read so far: an archive of some megabytes is refused as soon as one of some kilobytes.
    #[test]
    fn an_archive_that_unpacks_without_end_is_refused_early() {
        let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
        let options = zip::write::SimpleFileOptions::default();
        writer.start_file("a.obs", options).expect("a member");
        for _ in 0..64 {
            writer.write_all(&[b'1'; 1 << 20]).expect("a block");
        }
        let archive = writer.finish().expect("an archive").into_inner();
        let mut unpacked = Vec::new();
        each_member(&archive, |_, content| {
            let error = content.read_to_end(&mut unpacked).expect_err("too much");
            assert!(error.to_string().contains("more than 16 times"), "{error}");
            Ok(())
        })
        .expect("a whole archive");
        assert!(unpacked.len() < 18 << 20, "{}", unpacked.len());
    }
}
