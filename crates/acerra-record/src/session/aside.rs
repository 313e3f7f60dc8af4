//! Files of a session that are whole or absent: written aside, put on the disk, then renamed.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::finish_error::FinishError;
use crate::log::sync_folder;

/// A staging file in the same directory, removed unless it is published. The staging file of a killed run is
/// overwritten by the next.
pub(super) struct AsideFile {
    path: PathBuf,
    aside: PathBuf,
    out: BufWriter<File>,
    is_published: bool,
}

impl AsideFile {
    /// Begins the file `name` of `directory`.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub(super) fn create(directory: &Path, name: &str) -> Result<Self, FinishError> {
        let (path, aside) = (
            directory.join(name),
            directory.join(format!(".{name}.part")),
        );
        match File::create(&aside) {
            Ok(file) => Ok(Self {
                path,
                aside,
                out: BufWriter::new(file),
                is_published: false,
            }),
            Err(cause) => Err(FinishError::Io { path, cause }),
        }
    }

    /// Writes a whole file.
    ///
    /// # Errors
    /// A full disk, or another failure of the file system.
    pub(super) fn put(directory: &Path, name: &str, bytes: &[u8]) -> Result<(), FinishError> {
        let mut file = Self::create(directory, name)?;
        let path = file.path.clone();
        file.write_all(bytes)
            .map_err(|cause| FinishError::Io { path, cause })?;
        file.publish()
    }

    /// Puts the content on the disk and the file in its place.
    ///
    /// # Errors
    /// A full disk, or another failure of the file system; the place is then left as it was.
    pub(super) fn publish(mut self) -> Result<(), FinishError> {
        let synced = self
            .out
            .flush()
            .and_then(|()| self.out.get_ref().sync_all());
        let failed = |cause| FinishError::Io {
            path: self.path.clone(),
            cause,
        };
        synced
            .and_then(|()| std::fs::rename(&self.aside, &self.path))
            .map_err(failed)?;
        self.is_published = true;
        sync_folder(&self.path).map_err(failed)
    }
}

impl Drop for AsideFile {
    fn drop(&mut self) {
        if !self.is_published {
            // Left where it cannot be removed: the next run writes over it.
            let _ = std::fs::remove_file(&self.aside);
        }
    }
}

impl Write for AsideFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
