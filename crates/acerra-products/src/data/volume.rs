//! `volume.npz`, of which planes are read without the rest.

use std::path::Path;

use acerra_cubes::StackShape;
use anyhow::{Context, ensure};
use num_complex::Complex32;

use super::stacks::Stack;

/// An axis of a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// East.
    X,
    /// North.
    Y,
    /// Up.
    Z,
}

/// The file of a volume: complex64 `[nz, ny, nx]` and its coordinates.
#[derive(Clone, Debug)]
pub struct VolumeFile {
    stack: Stack,
    shape: StackShape,
    /// East of the columns (m).
    pub x_m: Vec<f64>,
    /// North of the rows (m).
    pub y_m: Vec<f64>,
    /// Heights of the slices (m).
    pub z_m: Vec<f64>,
}

impl VolumeFile {
    /// Reads the coordinates of `volume.npz`.
    ///
    /// # Errors
    /// A file that cannot be read, an array that is absent, compressed or of another shape than its
    /// coordinates.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let stack = Stack::new(path, "volume");
        let shape = stack.shape()?;
        let StackShape {
            images,
            rows,
            columns,
        } = shape;
        ensure!(
            images > 0 && rows > 0 && columns > 0,
            "{}: volume: expected pixels, found none",
            path.display()
        );
        stack
            .open()?
            .stored("volume")
            .with_context(|| path.display().to_string())?;
        Ok(Self {
            x_m: stack.coordinates_m("x_m", columns)?,
            y_m: stack.coordinates_m("y_m", rows)?,
            z_m: stack.coordinates_m("z_m", images)?,
            stack,
            shape,
        })
    }

    /// Values along x, y and z.
    #[must_use]
    pub fn size(&self) -> [usize; 3] {
        [self.shape.columns, self.shape.rows, self.shape.images]
    }

    /// Columns and rows of the planes normal to an axis: x and y, x and z, or y and z.
    #[must_use]
    pub fn plane_size(&self, normal: Axis) -> [usize; 2] {
        let [nx, ny, nz] = self.size();
        match normal {
            Axis::Z => [nx, ny],
            Axis::Y => [nx, nz],
            Axis::X => [ny, nz],
        }
    }

    /// The plane normal to an axis at `index` along it, row by row from the lowest coordinates.
    ///
    /// # Errors
    /// An index beyond the volume, a file that cannot be read.
    pub fn plane(&self, normal: Axis, index: usize) -> anyhow::Result<Vec<Complex32>> {
        let [nx, ny, nz] = self.size();
        self.check(normal, index)?;
        let [nx, ny, nz, index] = [nx, ny, nz, index].map(|n| n as u64);
        let mut values = Vec::new();
        match normal {
            Axis::Z => self.rows([(index * nx * ny, nx * ny)], &mut values)?,
            Axis::Y => self.rows((0..nz).map(|k| ((k * ny + index) * nx, nx)), &mut values)?,
            Axis::X => self.rows((0..ny * nz).map(|row| (row * nx + index, 1)), &mut values)?,
        }
        Ok(values)
    }

    /// The value at `[i, j, k]` along x, y and z.
    ///
    /// # Errors
    /// A place beyond the volume, a file that cannot be read.
    pub fn value(&self, [i, j, k]: [usize; 3]) -> anyhow::Result<Complex32> {
        let [nx, ny, _] = self.size();
        for (axis, index) in [(Axis::X, i), (Axis::Y, j), (Axis::Z, k)] {
            self.check(axis, index)?;
        }
        let mut values = Vec::new();
        self.rows([(((k * ny + j) * nx + i) as u64, 1)], &mut values)?;
        values
            .first()
            .copied()
            .context("expected a value, found none")
    }

    fn check(&self, axis: Axis, index: usize) -> anyhow::Result<()> {
        let [nx, ny, nz] = self.size();
        let (name, count) = match axis {
            Axis::X => ("x", nx),
            Axis::Y => ("y", ny),
            Axis::Z => ("z", nz),
        };
        ensure!(
            index < count,
            "{}: {name}: expected an index below {count}, found {index}",
            self.stack.name()
        );
        Ok(())
    }

    /// Adds runs of values, each with its first index and length.
    fn rows(
        &self,
        runs: impl IntoIterator<Item = (u64, u64)>,
        values: &mut Vec<Complex32>,
    ) -> anyhow::Result<()> {
        let mut npz = self.stack.open()?;
        let mut array = npz.stored("volume").with_context(|| self.stack.name())?;
        for (first, count) in runs {
            let take = |re: f64, im: f64| values.push(Complex32::new(re as f32, im as f32));
            array
                .values(first, count, take)
                .with_context(|| self.stack.name())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use acerra_npz::NpzWriter;

    use super::*;

    fn write(path: &Path, deflated: bool, heights: u64) {
        let file = File::create(path).unwrap();
        let mut npz = match deflated {
            true => NpzWriter::deflated(file),
            false => NpzWriter::stored(file),
        };
        let values = (0..24_u8).map(|k| Complex32::new(f32::from(k), 0.5));
        npz.array("volume", &[2, 3, 4], values).unwrap();
        npz.array("z_m", &[heights], (0..heights).map(|k| k as f64))
            .unwrap();
        npz.array("x_m", &[4], [0.0, 1.0, 2.0, 3.0]).unwrap();
        npz.array("y_m", &[3], [0.0, 1.0, 2.0]).unwrap();
        npz.finish().unwrap();
    }

    #[test]
    fn planes_are_cut_along_each_axis() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("volume.npz");
        write(&path, false, 2);
        let volume = VolumeFile::open(&path).unwrap();
        let plane = |normal, index| -> Vec<f32> {
            let values = volume.plane(normal, index).unwrap();
            values.iter().map(|v| v.re).collect()
        };
        assert_eq!(
            plane(Axis::Z, 1),
            (12..24_u8).map(f32::from).collect::<Vec<_>>()
        );
        assert_eq!(
            plane(Axis::Y, 2),
            [8.0, 9.0, 10.0, 11.0, 20.0, 21.0, 22.0, 23.0]
        );
        assert_eq!(plane(Axis::X, 1), [1.0, 5.0, 9.0, 13.0, 17.0, 21.0]);
        assert_eq!(volume.value([3, 1, 1]).unwrap(), Complex32::new(19.0, 0.5));
        assert_eq!(volume.plane_size(Axis::X), [3, 2]);
        for (axis, index) in [
            (Axis::Z, 2),
            (Axis::Y, 3),
            (Axis::X, 4),
            (Axis::X, usize::MAX),
        ] {
            assert!(volume.plane(axis, index).is_err());
        }
        assert!(volume.value([4, 0, 0]).is_err());
    }

    #[test]
    fn broken_volumes_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("volume.npz");
        let message = |path: &Path| format!("{:#}", VolumeFile::open(path).unwrap_err());
        assert!(message(&path).contains("volume.npz"));
        write(&path, true, 2);
        assert!(message(&path).contains("expected an uncompressed array"));
        write(&path, false, 3);
        assert!(
            message(&path).contains("z_m: expected 2"),
            "{}",
            message(&path)
        );
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        assert!(message(&path).contains("not a readable NPZ archive"));
    }
}
