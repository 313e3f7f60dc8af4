//! An array whose tiles are written in any order, by any number of processes.

use std::fs;
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use num_complex::Complex32;
use tempfile::NamedTempFile;

use crate::cut::Stored;
use crate::error::CubeError;

/// Bytes of a complex value.
const VALUE_BYTES: usize = 8;

/// A complex array that is cut along its first dimension into tiles. Each tile is a chunk in a separate file,
/// which appears whole or not at all.
///
/// ```
/// use acerra_cubes::{TiledArray, Variable, ZarrGroup};
/// # let folder = tempfile::tempdir()?;
/// let mut group = ZarrGroup::create(folder.path())?;
/// let image = Variable::new("image", &["y", "x"], Vec::<num_complex::Complex32>::new().into());
/// group.tiled(&image, &[5, 3], 2)?;
/// group.finish(&[])?;
///
/// // Another process:
/// let array = TiledArray::of(folder.path(), "image", &[5, 3], 2);
/// assert_eq!((array.count(), array.range(2)), (3, 4..5));
/// array.write(2, &[num_complex::Complex32::ONE; 3])?;
/// assert!(array.holds(2) && !array.holds(0));
/// assert_eq!(array.read(2)?.len(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct TiledArray {
    folder: PathBuf,
    shape: Vec<usize>,
    per_tile: usize,
}

impl TiledArray {
    /// The array `name` of the group in the directory `group`: its shape, and the length of a tile along the
    /// first dimension.
    #[must_use]
    pub fn of(group: &Path, name: &str, shape: &[usize], per_tile: usize) -> Self {
        Self {
            folder: group.join(name),
            shape: shape.to_vec(),
            per_tile: per_tile.max(1),
        }
    }

    /// Shape of a chunk.
    pub(super) fn chunk(&self) -> Vec<usize> {
        let mut chunk = self.shape.clone();
        if let Some(first) = chunk.first_mut() {
            *first = self.per_tile;
        }
        chunk
    }

    /// Number of tiles.
    #[must_use]
    pub fn count(&self) -> usize {
        self.length().div_ceil(self.per_tile)
    }

    /// Indices of the first dimension in tile `k`.
    #[must_use]
    pub fn range(&self, k: usize) -> Range<usize> {
        let start = (k * self.per_tile).min(self.length());
        start..(start + self.per_tile).min(self.length())
    }

    /// Whether tile `k` is there.
    #[must_use]
    pub fn holds(&self, k: usize) -> bool {
        self.path(k).is_file()
    }

    /// Writes tile `k`, `[range, …]` row by row. The values of a last, shorter tile are filled up with
    /// NaN in its chunk.
    ///
    /// # Errors
    /// The number of values differs from that of the tile, or the file cannot be written.
    pub fn write(&self, k: usize, values: &[Complex32]) -> Result<(), CubeError> {
        let path = self.path(k);
        let expected = self.range(k).len() * self.row();
        if values.len() != expected {
            return Err(CubeError::Length {
                variable: path.display().to_string(),
                expected,
                found: values.len(),
            });
        }
        let mut bytes = Vec::with_capacity(self.chunk_bytes());
        values.iter().for_each(|value| value.put(&mut bytes));
        while bytes.len() < self.chunk_bytes() {
            Complex32::FILL.put(&mut bytes);
        }
        let parent = path.parent().unwrap_or(&self.folder);
        fs::create_dir_all(parent)?;
        let mut file = aside(parent)?;
        file.write_all(&bytes)?;
        file.as_file().sync_all()?;
        file.persist(path).map_err(|failed| failed.error)?;
        Ok(())
    }

    /// The values of tile `k`.
    ///
    /// # Errors
    /// A file that cannot be read, or is of another length than a chunk.
    pub fn read(&self, k: usize) -> Result<Vec<Complex32>, CubeError> {
        let path = self.path(k);
        let bytes = fs::read(&path)
            .map_err(|e| io::Error::new(e.kind(), format!("{}: {e}", path.display())))?;
        if bytes.len() != self.chunk_bytes() {
            return Err(CubeError::Tile {
                path,
                expected: self.chunk_bytes(),
                found: bytes.len(),
            });
        }
        let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        let values = bytes.chunks_exact(VALUE_BYTES);
        let kept = self.range(k).len() * self.row();
        let value = |v: &[u8]| Complex32::new(number(&v[..4]), number(&v[4..]));
        Ok(values.take(kept).map(value).collect())
    }

    fn length(&self) -> usize {
        self.shape.first().copied().unwrap_or(0)
    }

    /// Values of one index of the first dimension.
    fn row(&self) -> usize {
        self.shape.iter().skip(1).product()
    }

    fn chunk_bytes(&self) -> usize {
        self.per_tile * self.row() * VALUE_BYTES
    }

    /// The file of a tile: its index, and zero along each further dimension.
    fn path(&self, k: usize) -> PathBuf {
        let first = self.folder.join("c").join(k.to_string());
        (1..self.shape.len()).fold(first, |path, _| path.join("0"))
    }
}

/// A file of this process alone, which all may read once it is put in place.
fn aside(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tile-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_come_back_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let array = TiledArray::of(folder.path(), "image", &[5, 2, 2], 2);
        let tile = |k: usize| -> Vec<Complex32> {
            let count = array.range(k).len() * 4;
            (0..count)
                .map(|v| Complex32::new(v as f32, -(k as f32)))
                .collect()
        };
        for k in [2, 0, 1] {
            array.write(k, &tile(k)).unwrap();
        }
        for k in 0..3 {
            assert_eq!(array.read(k).unwrap(), tile(k));
        }
        let message = array.write(2, &tile(0)).unwrap_err().to_string();
        assert!(message.contains("expected 4 values, found 8"), "{message}");
        fs::write(folder.path().join("image/c/1/0/0"), [0; 9]).unwrap();
        let message = array.read(1).unwrap_err().to_string();
        assert!(message.contains("expected 64 bytes, found 9"), "{message}");
    }
}
