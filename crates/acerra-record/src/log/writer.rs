//! Writing a session log: append only, on the disk every second.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use thiserror::Error;

use super::frame::{LOG_SIGNATURE, Record};
use super::reader::{LogDamage, LogReadError, LogReader};

/// Longest time between writing a record and syncing the record to disk.
pub const SYNC_EVERY: Duration = Duration::from_secs(1);

/// Reason why a log cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LogWriteError {
    /// The disk is full.
    #[error("{}: the disk is full; the data written before are kept", path.display())]
    DiskFull {
        /// The log.
        path: PathBuf,
    },
    /// The file system, or a limit of this user, takes no longer file.
    #[error(
        "{}: the file system accepts no longer file (FAT: 4 GB); the data written before are kept",
        path.display()
    )]
    FileTooLong {
        /// The log.
        path: PathBuf,
    },
    /// Another failure of the file system.
    #[error("{}: {cause}", path.display())]
    Io {
        /// The log.
        path: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
    /// An existing log cannot be gone on with.
    #[error("{}: {cause}", path.display())]
    Existing {
        /// The log.
        path: PathBuf,
        /// Cause.
        cause: LogReadError,
    },
    /// Another recording writes the log.
    #[error(
        "{}: another recording writes this log; record into another directory, or end that one first", path.display()
    )]
    InUse {
        /// The log.
        path: PathBuf,
    },
    /// A payload longer than a record's.
    #[error("{}: expected a payload of a megabyte at most, found {found} bytes", path.display())]
    TooLong {
        /// The log.
        path: PathBuf,
        /// Length.
        found: usize,
    },
}

/// Appends records to a log. While it lives it holds the file's advisory lock, which the system lets go of when the
/// process ends, however it ends: no two recordings write one log.
pub struct LogWriter {
    path: PathBuf,
    file: BufWriter<File>,
    synced: Instant,
    bytes: u64,
}

impl LogWriter {
    /// Begins a log; an existing file is never overwritten.
    ///
    /// # Errors
    /// If the file exists, cannot be made, or another recording has begun to write it.
    pub fn create(path: &Path) -> Result<Self, LogWriteError> {
        let failed = |cause| io_error(path, cause);
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(path)
            .map_err(failed)?;
        lock(path, &file)?;
        let writer = Self::over_empty(path, file)?;
        sync_folder(path).map_err(failed)?;
        Ok(writer)
    }

    /// Begins a log in a file that is open and empty; `path` names it in messages.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn over_empty(path: &Path, file: File) -> Result<Self, LogWriteError> {
        let mut writer = Self::over(path, file, 0);
        writer.append(&LOG_SIGNATURE)?;
        writer.sync()?;
        Ok(writer)
    }

    /// Goes on with a log behind its last sound record; a torn end is cut off.
    ///
    /// # Errors
    /// If the file cannot be read, is no session log, cannot be written, or is being written by another recording.
    pub fn resume(path: &Path) -> Result<(Self, LogDamage), LogWriteError> {
        let failed = |cause| io_error(path, cause);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .open(path)
            .map_err(failed)?;
        lock(path, &file)?;
        let existing = |cause| LogWriteError::Existing {
            path: path.to_owned(),
            cause,
        };
        let mut reader = LogReader::new(&file).map_err(existing)?;
        while reader.next_record().map_err(failed)?.is_some() {}
        let (damage, end) = (reader.damage(), reader.sound_until());
        file.set_len(end).map_err(failed)?;
        file.seek(SeekFrom::Start(end)).map_err(failed)?;
        let mut writer = Self::over(path, file, end);
        if end < LOG_SIGNATURE.len() as u64 {
            writer.append(&LOG_SIGNATURE[end as usize..])?;
        }
        writer.sync()?;
        Ok((writer, damage))
    }

    fn over(path: &Path, file: File, bytes: u64) -> Self {
        Self {
            path: path.to_owned(),
            file: BufWriter::with_capacity(1 << 16, file),
            synced: Instant::now(),
            bytes,
        }
    }

    /// Appends a record, and puts everything on the disk where the last time was a second ago.
    ///
    /// # Errors
    /// A full disk, another failure of the file system, a payload too long for a record.
    pub fn write(&mut self, record: &Record) -> Result<(), LogWriteError> {
        let Some(bytes) = record.encode() else {
            return Err(LogWriteError::TooLong {
                path: self.path.clone(),
                found: record.payload.len(),
            });
        };
        self.append(&bytes)?;
        self.sync_if_due()
    }

    /// Puts everything on the disk where the last time was a second ago; to be called also while no
    /// records come.
    ///
    /// # Errors
    /// As [`LogWriter::write`].
    pub fn sync_if_due(&mut self) -> Result<(), LogWriteError> {
        if self.synced.elapsed() >= SYNC_EVERY {
            self.sync()?;
        }
        Ok(())
    }

    /// Puts everything on the disk.
    ///
    /// # Errors
    /// As [`LogWriter::write`].
    pub fn sync(&mut self) -> Result<(), LogWriteError> {
        let done = self
            .file
            .flush()
            .and_then(|()| self.file.get_ref().sync_data());
        self.synced = Instant::now();
        done.map_err(|cause| io_error(&self.path, cause))
    }

    /// Length of the log, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    fn append(&mut self, bytes: &[u8]) -> Result<(), LogWriteError> {
        self.file
            .write_all(bytes)
            .map_err(|cause| io_error(&self.path, cause))?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }
}

/// Takes the file's lock, on file systems that have locks.
fn lock(path: &Path, file: &File) -> Result<(), LogWriteError> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(LogWriteError::InUse {
            path: path.to_owned(),
        }),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

fn io_error(path: &Path, cause: io::Error) -> LogWriteError {
    let path = path.to_owned();
    match cause.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            LogWriteError::DiskFull { path }
        }
        io::ErrorKind::FileTooLarge => LogWriteError::FileTooLong { path },
        _ => LogWriteError::Io { path, cause },
    }
}

/// A new file's name outlives a power cut only once its folder is on the disk.
pub(crate) fn sync_folder(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    #[cfg(unix)]
    File::open(folder.unwrap_or_else(|| Path::new(".")))?.sync_all()?;
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}
