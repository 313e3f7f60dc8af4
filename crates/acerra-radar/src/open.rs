//! Recognising a radar file from its content.

use std::io::{Read, Seek, SeekFrom};

use thiserror::Error;

use crate::limits::Limits;
use crate::log::{RadarLog, ReadError};
use crate::mrm::{self, Recognised};
use crate::npz::{self, NeutralFile, NpzError};
use crate::report::Place;
use crate::ret;

/// Bytes read to recognise a file. Several messages, so that a damaged first message has no effect.
const HEAD_BYTES: u64 = 1 << 15;

/// A radar file of any kind this crate reads.
#[derive(Debug, Clone, PartialEq)]
pub enum RadarFile {
    /// A log of scans.
    Log(RadarLog),
    /// A neutral NPZ file.
    Neutral(NeutralFile),
}

/// Reason why a file of any kind could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OpenError {
    /// As a log, or as a file of unknown kind.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// As an NPZ archive.
    #[error(transparent)]
    Npz(#[from] NpzError),
}

impl From<std::io::Error> for OpenError {
    fn from(e: std::io::Error) -> Self {
        Self::Read(e.into())
    }
}

/// Reads a radar file, recognising its kind from its content (never its name).
///
/// # Errors
/// If the content is of no known kind, or the reader of its kind fails.
///
/// ```
/// use acerra_radar::{Limits, RadarFile, read};
/// let bytes = std::io::Cursor::new(b"12.5, MrmFullScanInfo, 7, 100, 4000,,,,, 0, 122, 32, 1, 2, 1, 2, -5, 9\n");
/// match read(bytes, &Limits::default())? {
///     RadarFile::Log(log) => assert_eq!(log.scans.len(), 1),
///     RadarFile::Neutral(_) => unreachable!(),
/// }
/// # Ok::<(), acerra_radar::OpenError>(())
/// ```
pub fn read(mut reader: impl Read + Seek, limits: &Limits) -> Result<RadarFile, OpenError> {
    let mut head = Vec::new();
    reader.by_ref().take(HEAD_BYTES).read_to_end(&mut head)?;
    reader.seek(SeekFrom::Start(0))?;
    if head.is_empty() {
        return Err(ReadError::Empty.into());
    }
    if head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06") {
        return Ok(RadarFile::Neutral(npz::read_npz(reader, limits)?));
    }
    if ret::recognise(&head) {
        return Ok(RadarFile::Log(ret::read_ret(reader, limits)?));
    }
    if let Some(kind) = foreign_kind(&head)
        && !mrm::begins_with_scan(&head)
    {
        let found = kind.to_owned();
        return Err(ReadError::Unrecognised { found }.into());
    }
    match mrm::recognise(&head) {
        Recognised::Mrm => Ok(RadarFile::Log(mrm::read_mrm(reader, limits)?)),
        Recognised::Swapped(at) => Err(ReadError::WrongEndian {
            place: Place::Byte(at),
        }
        .into()),
        Recognised::Broken(at, fault) => Err(ReadError::BadHeader {
            place: Place::Byte(at),
            fault,
        }
        .into()),
        Recognised::No => Err(ReadError::Unrecognised {
            found: describe(&head),
        }
        .into()),
    }
}

/// Kinds of files that are not radar logs, by their first bytes.
const FOREIGN: [(&[u8], &str); 14] = [
    (b"\x89PNG\r\n\x1a\n", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"GIF8", "a GIF image"),
    (b"II*\0", "a TIFF image"),
    (b"MM\0*", "a TIFF image"),
    (b"%PDF-", "a PDF document"),
    (b"\x1f\x8b", "a gzip archive: unpack it first"),
    (b"BZh", "a bzip2 archive: unpack it first"),
    (b"\xfd7zXZ\0", "an xz archive: unpack it first"),
    (b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive: unpack it first"),
    (
        b"\x93NUMPY",
        "a single NumPy array: save it in an NPZ archive",
    ),
    (b"\x89HDF\r\n\x1a\n", "an HDF5 or MATLAB 7.3 file"),
    (b"MATLAB 5.0 MAT-file", "a MATLAB file"),
    (b"\x7fELF", "a program"),
];

/// Kind of a file that is not a radar log, by its first bytes.
fn foreign_kind(head: &[u8]) -> Option<&'static str> {
    let known = FOREIGN.iter().find(|(mark, _)| head.starts_with(mark));
    known
        .map(|(_, kind)| *kind)
        .or_else(|| is_pickle(head).then_some("a Python pickle: save it as an NPZ archive"))
}

/// Whether a file begins as a binary pickle does: PROTO with a version of 2 to 5, then, from
/// version 4 on, a frame, else an opcode that can begin an object (Python's `pickletools`).
fn is_pickle(head: &[u8]) -> bool {
    match head {
        [0x80, 4 | 5, 0x95, ..] => head.len() >= 11 && head[9..11] == [0, 0],
        // Short pickles go without a frame.
        [0x80, 2..=5, opcode, ..] => b"](}c)X\x8cKMJUBCGNl".contains(opcode),
        _ => false,
    }
}

/// A file's first bytes in words.
fn describe(head: &[u8]) -> String {
    let first = &head[..head.len().min(32)];
    if first
        .iter()
        .all(|&b| b.is_ascii_graphic() || b.is_ascii_whitespace())
    {
        let line = String::from_utf8_lossy(first);
        return format!(
            "text that begins {:?}",
            line.lines().next().unwrap_or_default()
        );
    }
    let hex: Vec<String> = first.iter().take(8).map(|b| format!("{b:02x}")).collect();
    format!("binary data that begins {}", hex.join(" "))
}
