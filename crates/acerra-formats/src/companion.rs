//! Files that belong to another by their name.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::error::{FormatError, Place};
use crate::limits::Limits;

/// Bytes of a text header at most.
const MAX_TEXT_BYTES: u64 = 1 << 26;

/// Files in the same directory with the same name up to the last dot, sorted; without `path` itself.
pub fn beside(path: &Path) -> Vec<PathBuf> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let stem = path.file_stem();
    let mut found: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|other| other.file_stem() == stem && other.file_name() != path.file_name())
        .filter(|other| other.is_file())
        .collect();
    found.sort();
    found
}

/// The first file next to `path` whose first bytes match `wanted`.
pub fn find(path: &Path, wanted: impl Fn(&[u8]) -> bool) -> Option<PathBuf> {
    beside(path)
        .into_iter()
        .find(|other| head(other, 1 << 12).is_ok_and(|head| wanted(&head)))
}

/// The first bytes of a file.
pub fn head(path: &Path, bytes: u64) -> Result<Vec<u8>, FormatError> {
    let mut head = Vec::new();
    File::open(path)?.take(bytes).read_to_end(&mut head)?;
    Ok(head)
}

/// A text file, whole; bytes that are no UTF-8 are replaced.
pub fn text(path: &Path) -> Result<String, FormatError> {
    let bytes = whole(path, MAX_TEXT_BYTES)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// A file, whole.
pub fn contents(path: &Path, limits: &Limits) -> Result<Vec<u8>, FormatError> {
    whole(path, limits.max_file_bytes)
}

fn whole(path: &Path, limit: u64) -> Result<Vec<u8>, FormatError> {
    let file = File::open(path)?;
    let found = file.metadata()?.len();
    let too_large = |found| FormatError::TooLarge {
        place: Place::Whole,
        what: "bytes",
        limit,
        found,
    };
    if found > limit {
        return Err(too_large(found));
    }
    let mut bytes = Vec::new();
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(too_large(bytes.len() as u64));
    }
    Ok(bytes)
}

/// This error, for a file next to the named one.
pub fn of(path: &Path, cause: FormatError) -> FormatError {
    FormatError::Companion {
        path: path.to_owned(),
        cause: Box::new(cause),
    }
}
