//! Stacks of images in NPZ files, written image by image: `volume.npz` and `looks.npz`.

use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use acerra_chain::focus::sink::{ImageSink, SinkError, StackArray, StackHeader};
use acerra_imaging::PlaneGrid;
use acerra_npz::{NpzWriter, OwnedArrayWriter};
use num_complex::Complex32;

/// Writes each stack into a file of its name in one directory: the images as complex64
/// `[count, ny, nx]`, the arrays that describe them, `x_m` and `y_m`.
#[derive(Default)]
pub struct NpzSink {
    directory: PathBuf,
    open: Option<OpenStack<BufWriter<File>>>,
}

impl NpzSink {
    /// A sink that writes into `directory`.
    #[must_use]
    pub fn new(directory: &Path) -> Self {
        Self {
            directory: directory.to_owned(),
            open: None,
        }
    }
}

impl ImageSink for NpzSink {
    fn begin(&mut self, stack: &StackHeader) -> Result<(), SinkError> {
        let name = format!("{}.npz", stack.kind.name());
        let open = File::create(self.directory.join(&name))
            .map(|file| BufWriter::with_capacity(1 << 20, file))
            .and_then(|file| OpenStack::new(file, stack))
            .map_err(|cause| cannot_write(&name, cause))?;
        self.open = Some(open);
        Ok(())
    }

    fn put(&mut self, image: &[Complex32]) -> Result<(), SinkError> {
        let stack = self.open.as_mut().ok_or_else(not_begun)?;
        stack
            .array
            .extend(image.iter().copied())
            .map_err(|cause| cannot_write(&stack.name, cause))
    }

    fn finish(&mut self, arrays: Vec<StackArray>) -> Result<(), SinkError> {
        let stack = self.open.take().ok_or_else(not_begun)?;
        let name = stack.name.clone();
        stack
            .finish(arrays)
            .and_then(|mut file| file.flush())
            .map_err(|cause| cannot_write(&name, cause))
    }
}

fn cannot_write(name: &str, cause: io::Error) -> SinkError {
    SinkError {
        place: format!("{name}: cannot write"),
        cause: cause.into(),
    }
}

fn not_begun() -> SinkError {
    SinkError {
        place: "NPZ".to_owned(),
        cause: "an image came before its stack began".into(),
    }
}

/// A stack whose images are being written.
struct OpenStack<W: Write + Seek> {
    name: String,
    grid: PlaneGrid,
    array: OwnedArrayWriter<W, Complex32>,
}

impl<W: Write + Seek> OpenStack<W> {
    fn new(file: W, stack: &StackHeader) -> io::Result<Self> {
        let grid = stack.grid;
        let shape = [stack.count, grid.ny, grid.nx].map(|n| n as u64);
        let name = stack.kind.name();
        Ok(Self {
            name: format!("{name}.npz"),
            grid,
            array: NpzWriter::stored(file).into_array(name, &shape)?,
        })
    }

    /// Writes the arrays that describe the images; another number of images than announced fails.
    fn finish(self, arrays: Vec<StackArray>) -> io::Result<W> {
        let grid = self.grid;
        let mut npz = self.array.finish()?;
        for array in arrays {
            let shape: Vec<u64> = array.shape.iter().map(|n| *n as u64).collect();
            npz.array(array.name, &shape, array.values)?;
        }
        npz.array("x_m", &[grid.nx as u64], (0..grid.nx).map(|i| grid.x_m(i)))?;
        npz.array("y_m", &[grid.ny as u64], (0..grid.ny).map(|j| grid.y_m(j)))?;
        npz.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_chain::focus::sink::StackKind;

    fn stack(count: usize) -> OpenStack<io::Cursor<Vec<u8>>> {
        let header = StackHeader {
            kind: StackKind::Volume,
            grid: PlaneGrid::new([0.0, 1.0, 0.0], 0.5, [2, 1]).unwrap(),
            count,
        };
        OpenStack::new(io::Cursor::new(Vec::new()), &header).unwrap()
    }

    #[test]
    fn images_follow_one_another() {
        let mut open = stack(3);
        for k in 0..3_u8 {
            let image = [Complex32::new(f32::from(k), 0.0), Complex32::new(0.0, 1.0)];
            open.array.extend(image).unwrap();
        }
        let z_m = StackArray {
            name: "z_m",
            shape: vec![3],
            values: vec![0.0, 0.1, 0.2],
        };
        let bytes = open.finish(vec![z_m]).unwrap();
        let mut npz = acerra_npz::NpzReader::new(bytes).unwrap();
        let (shape, values) = npz.values("volume", 6).unwrap();
        assert_eq!(shape, [3, 1, 2]);
        assert_eq!(values[4], (2.0, 0.0));
        let (_, z) = npz.values("z_m", 3).unwrap();
        assert_eq!(z, [(0.0, 0.0), (0.1, 0.0), (0.2, 0.0)]);
        // One image too few is no array.
        let mut short = stack(2);
        short.array.extend([Complex32::ONE; 2]).unwrap();
        assert!(short.finish(Vec::new()).is_err());
    }

    #[test]
    fn a_directory_that_is_not_there_is_named_with_its_file() {
        let mut sink = NpzSink::new(Path::new("/nowhere/at/all"));
        let header = StackHeader {
            kind: StackKind::Looks,
            grid: PlaneGrid::new([0.0, 1.0, 0.0], 0.5, [2, 1]).unwrap(),
            count: 1,
        };
        let message = sink.begin(&header).unwrap_err().to_string();
        assert!(
            message.starts_with("looks.npz: cannot write: "),
            "{message}"
        );
        assert!(sink.put(&[]).is_err());
    }
}
