//! Stacks of images in NPZ files, written image by image: `volume.npz` and `looks.npz`.

use std::io::{self, Seek, Write};

use acerra_imaging::PlaneGrid;
use acerra_radar::npz::NpzWriter;
use num_complex::Complex32;

/// A float64 array and its shape.
pub type Axis = (&'static str, Vec<u64>, Vec<f64>);

/// Writes `name` (complex64, `[count, ny, nx]`) from the images that `make` hands to its argument
/// one after another, then the arrays that it returns, `x_m` and `y_m`.
///
/// # Errors
/// Those of the writer and of `make`; another number of images than `count`.
pub fn write<E: From<io::Error>>(
    file: impl Write + Seek,
    name: &str,
    grid: &PlaneGrid,
    count: usize,
    make: impl FnOnce(&mut dyn FnMut(&[Complex32]) -> io::Result<()>) -> Result<Vec<Axis>, E>,
) -> Result<(), E> {
    let mut npz = NpzWriter::stored(file);
    let mut writer = npz.begin(name, &[count as u64, grid.ny as u64, grid.nx as u64])?;
    let mut axes = make(&mut |image| writer.extend(image.iter().copied()))?;
    writer.finish()?;
    axes.push((
        "x_m",
        vec![grid.nx as u64],
        (0..grid.nx).map(|i| grid.x_m(i)).collect(),
    ));
    axes.push((
        "y_m",
        vec![grid.ny as u64],
        (0..grid.ny).map(|j| grid.y_m(j)).collect(),
    ));
    for (name, shape, values) in axes {
        npz.array(name, &shape, values)?;
    }
    npz.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_follow_one_another() {
        let grid = PlaneGrid::new([0.0, 1.0, 0.0], 0.5, [2, 1]).unwrap();
        let mut bytes = io::Cursor::new(Vec::new());
        write(&mut bytes, "volume", &grid, 3, |put| {
            for k in 0..3_u8 {
                put(&[Complex32::new(f32::from(k), 0.0), Complex32::new(0.0, 1.0)])?;
            }
            Ok::<_, io::Error>(vec![("z_m", vec![3], vec![0.0, 0.1, 0.2])])
        })
        .unwrap();
        let mut npz = acerra_radar::npz::NpzReader::new(bytes).unwrap();
        let (shape, values) = npz.values("volume", 6).unwrap();
        assert_eq!(shape, [3, 1, 2]);
        assert_eq!(values[4], (2.0, 0.0));
        let (_, z) = npz.values("z_m", 3).unwrap();
        assert_eq!(z, [(0.0, 0.0), (0.1, 0.0), (0.2, 0.0)]);
        // One image too few is no array.
        let short = write(io::Cursor::new(Vec::new()), "volume", &grid, 2, |put| {
            put(&[Complex32::ONE; 2])?;
            Ok::<_, io::Error>(vec![])
        });
        assert!(short.is_err());
    }
}
