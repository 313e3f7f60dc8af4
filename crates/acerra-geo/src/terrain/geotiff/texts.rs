//! Texts of a TIFF's first directory, checked before the `tiff` crate reads them.

use std::io::{Read, Seek, SeekFrom};

use super::super::TerrainError;

/// Longest text that a tag may hold, bytes.
const MAX_TEXT_BYTES: u64 = 1 << 20;

/// Refuses a directory that claims a text longer than any sensible one: the `tiff` crate refuses such a
/// directory too, but prints a message. Other errors are left to the `tiff` crate.
pub(super) fn check_texts(reader: &mut (impl Read + Seek)) -> Result<(), TerrainError> {
    let found = longest_text(reader);
    reader.seek(SeekFrom::Start(0))?;
    match found {
        Ok(bytes) if bytes > MAX_TEXT_BYTES => Err(TerrainError::Limit {
            what: "bytes of a text in a tag",
            found: u128::from(bytes),
            limit: u128::from(MAX_TEXT_BYTES),
        }),
        _ => Ok(()),
    }
}

/// Longest text claimed by the first directory.
fn longest_text(reader: &mut (impl Read + Seek)) -> std::io::Result<u64> {
    let mut head = [0; 4];
    reader.read_exact(&mut head)?;
    let little = head[0] == b'I';
    // BigTIFF has 43 in place of 42, and counts in eight bytes.
    let big = head[if little { 2 } else { 3 }] == 43;
    let (offset, entries_bytes, count_bytes) = if big {
        number(reader, 4, little)?;
        (number(reader, 8, little)?, 8, 8)
    } else {
        (number(reader, 4, little)?, 2, 4)
    };
    reader.seek(SeekFrom::Start(offset))?;
    let entries = number(reader, entries_bytes, little)?;
    let mut longest = 0;
    for _ in 0..entries.min(1 << 16) {
        number(reader, 2, little)?;
        let kind = number(reader, 2, little)?;
        let count = number(reader, count_bytes, little)?;
        number(reader, count_bytes, little)?;
        if kind == 2 {
            longest = longest.max(count);
        }
    }
    Ok(longest)
}

/// A whole number of a given number of bytes.
fn number(reader: &mut impl Read, bytes: usize, little: bool) -> std::io::Result<u64> {
    let mut value = [0; 8];
    reader.read_exact(&mut value[..bytes])?;
    if !little {
        value[..bytes].reverse();
    }
    Ok(u64::from_le_bytes(value))
}
