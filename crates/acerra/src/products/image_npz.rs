//! `image.npz`: the complex image and its axes, as NumPy reads them.

use std::io::{self, Write};

use npyz::WriterBuilder;
use npyz::npz::NpzWriter;
use num_complex::Complex32;

use crate::chain::ground::Ground;

/// Writes `image` (complex64, `[ny, nx]`, row 0 at the smallest y), `x_m` `[nx]`, `y_m` `[ny]` and
/// `z_m`: a scalar, or `[ny, nx]` on terrain.
///
/// # Errors
/// Those of the writer.
///
/// # Panics
/// If `image` does not hold one value for each pixel of `grid`.
pub fn write(file: impl Write + io::Seek, image: &[Complex32], ground: &Ground) -> io::Result<()> {
    let grid = &ground.grid;
    assert_eq!(image.len(), grid.len(), "one value a pixel");
    let mut npz = NpzWriter::new(file);
    let options = || {
        npyz::zip::write::FileOptions::default()
            .compression_method(npyz::zip::CompressionMethod::Stored)
            // Equal images are equal files, whenever they are written.
            .last_modified_time(npyz::zip::DateTime::default())
            .large_file(image.len() >= 1 << 28)
    };
    let mut writer = npz
        .array("image", options())?
        .default_dtype()
        .shape(&[grid.ny as u64, grid.nx as u64])
        .begin_nd()?;
    writer.extend(image.iter().copied())?;
    writer.finish()?;

    let mut axis = |name: &str, shape: &[u64], values: &mut dyn Iterator<Item = f64>| {
        let mut writer = npz
            .array(name, options())?
            .default_dtype()
            .shape(shape)
            .begin_nd()?;
        writer.extend(values)?;
        writer.finish()
    };
    axis(
        "x_m",
        &[grid.nx as u64],
        &mut (0..grid.nx).map(|i| grid.x_m(i)),
    )?;
    axis(
        "y_m",
        &[grid.ny as u64],
        &mut (0..grid.ny).map(|j| grid.y_m(j)),
    )?;
    match &ground.surface {
        Some(surface) => axis(
            "z_m",
            &[grid.ny as u64, grid.nx as u64],
            &mut (0..surface.len()).map(|k| surface.z_m(k)),
        ),
        None => axis("z_m", &[], &mut std::iter::once(grid.z_m)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use npyz::npz::NpzArchive;

    #[test]
    fn arrays_have_the_shapes_of_the_contract() {
        let campaign = "[radar]\nfile = 'a'\n[image]\nx_m = [1, 2]\ny_m = [-2, -1.5]\n\
                        z_m = 0.25\npixel_m = 0.5\n";
        let campaign = crate::campaign::Campaign::parse(campaign).unwrap();
        let mut warnings = crate::chain::Warnings::default();
        let ground = Ground::find(&campaign, &[], &mut warnings).unwrap();
        let image: Vec<_> = (0..6_u8)
            .map(|k| Complex32::new(f32::from(k), -0.5))
            .collect();
        let mut bytes = io::Cursor::new(Vec::new());
        write(&mut bytes, &image, &ground).unwrap();

        let mut npz = NpzArchive::new(bytes).unwrap();
        let stored = npz.by_name("image").unwrap().unwrap();
        assert_eq!(stored.shape(), [2, 3]);
        assert_eq!(stored.dtype().descr(), "'<c8'");
        assert_eq!(stored.into_vec::<Complex32>().unwrap(), image);
        let x = npz
            .by_name("x_m")
            .unwrap()
            .unwrap()
            .into_vec::<f64>()
            .unwrap();
        assert_eq!(x, [1.0, 1.5, 2.0]);
        let y = npz
            .by_name("y_m")
            .unwrap()
            .unwrap()
            .into_vec::<f64>()
            .unwrap();
        assert_eq!(y, [-2.0, -1.5]);
        let z = npz.by_name("z_m").unwrap().unwrap();
        assert_eq!(z.shape(), [0_u64; 0]);
        assert_eq!(z.into_vec::<f64>().unwrap(), [0.25]);
    }
}
