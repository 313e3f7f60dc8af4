//! `image.npz`: the complex image and its axes, as NumPy reads them.

use std::io::{self, Write};

use acerra_geo::geodesy::Geodetic;
use acerra_npz::NpzWriter;
use num_complex::Complex32;

use acerra_chain::Pixels;

/// Writes `image` (complex64, `[ny, nx]`, row 0 at the smallest y), `x_m` `[nx]`, `y_m` `[ny]` and
/// `z_m`: a scalar, or `[ny, nx]` on terrain. Of axes about a place on the Earth, `origin_deg_m` `[3]`
/// holds its latitude and longitude (degrees) and ellipsoidal height (m).
///
/// # Errors
/// Errors of the writer.
///
/// # Panics
/// If `image` does not hold one value for each of `pixels`.
pub fn write(
    file: impl Write + io::Seek,
    image: &[Complex32],
    pixels: &Pixels,
    origin: Option<&Geodetic>,
) -> io::Result<()> {
    let grid = &pixels.grid;
    assert_eq!(image.len(), grid.len(), "one value a pixel");
    let mut npz = NpzWriter::stored(file);
    let (nx, ny) = (grid.nx as u64, grid.ny as u64);
    npz.array("image", &[ny, nx], image.iter().copied())?;
    npz.array("x_m", &[nx], (0..grid.nx).map(|i| grid.x_m(i)))?;
    npz.array("y_m", &[ny], (0..grid.ny).map(|j| grid.y_m(j)))?;
    match &pixels.surface {
        Some(surface) => npz.array("z_m", &[ny, nx], (0..surface.len()).map(|k| surface.z_m(k)))?,
        None => npz.array("z_m", &[], [grid.z_m])?,
    }
    if let Some(place) = origin {
        let origin_deg_m = [place.latitude_deg(), place.longitude_deg(), place.height_m];
        npz.array("origin_deg_m", &[3], origin_deg_m)?;
    }
    npz.finish().map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_imaging::PlaneGrid;
    use acerra_npz::NpzReader;

    #[test]
    fn arrays_have_the_shapes_of_the_contract() {
        let grid = PlaneGrid::from_ranges([1.0, 2.0], [-2.0, -1.5], 0.25, 0.5).unwrap();
        let pixels = Pixels::plane(grid);
        let image: Vec<_> = (0..6_u8)
            .map(|k| Complex32::new(f32::from(k), -0.5))
            .collect();
        let mut bytes = io::Cursor::new(Vec::new());
        let origin = Geodetic::from_degrees(41.0, 14.0, 80.0);
        write(&mut bytes, &image, &pixels, Some(&origin)).unwrap();

        let mut npz = NpzReader::new(bytes).unwrap();
        let (shape, stored) = npz.values("image", 6).unwrap();
        assert_eq!(shape, [2, 3]);
        let expected: Vec<_> = image
            .iter()
            .map(|z| (f64::from(z.re), f64::from(z.im)))
            .collect();
        assert_eq!(stored, expected);
        let mut axis = |name| {
            let (shape, values) = npz.values(name, 3).unwrap();
            (shape, values.iter().map(|v| v.0).collect::<Vec<_>>())
        };
        assert_eq!(axis("x_m"), (vec![3], vec![1.0, 1.5, 2.0]));
        assert_eq!(axis("y_m"), (vec![2], vec![-2.0, -1.5]));
        assert_eq!(axis("z_m"), (vec![], vec![0.25]));
        let (shape, origin) = axis("origin_deg_m");
        assert_eq!(shape, [3]);
        assert!((origin[0] - 41.0).abs() < 1e-12 && (origin[2] - 80.0).abs() < 1e-12);
    }
}
