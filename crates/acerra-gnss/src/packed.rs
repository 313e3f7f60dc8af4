//! Packed files: gzip, UNIX `compress`, and zip archives of services and receivers.

use std::io::{Cursor, Error, ErrorKind, Read};
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
    let mut zip = ZipArchive::new(Cursor::new(archive)).map_err(broken)?;
    for index in 0..zip.len().min(MAX_MEMBERS) {
        let member = zip.by_index(index).map_err(broken)?;
        let name = member.name().map_err(broken)?.into_owned();
        if member.is_dir() || name.starts_with("__MACOSX/") {
            continue;
        }
        let packed = member.compressed_size().min(archive.len() as u64);
        let mut content = Unpacked::new(member, Arc::new(AtomicU64::new(packed)), Arc::default());
        take(name, &mut content)?;
    }
    Ok(())
}
