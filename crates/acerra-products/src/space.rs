//! Whether memory and disk suffice for a campaign.

use std::path::Path;

use acerra_chain::ChainError;
use acerra_chain::campaign::{Campaign, ProductFormat};
use acerra_chain::focus::memory::available_memory_bytes;
use acerra_chain::focus::space::{NeededBytes, needed_bytes};
use acerra_chain::scene::size::{bytes_text, fitting_pixel_m};
use acerra_chain::scene::{SceneError, SceneHeights, SceneOptions};
use anyhow::ensure;

/// Bytes of tables, traces, pictures and threads of an ordinary run, in addition to the pixels.
const BESIDE_PIXELS: u128 = 64 << 20;

/// Refuses a campaign whose pixels do not fit memory or disk, before anything is read.
///
/// # Errors
/// With the bytes needed and available.
pub fn check_space(campaign: &Campaign, output: &Path) -> anyhow::Result<()> {
    let scene = campaign.survey().scene;
    let looks = campaign.image.looks;
    let mut needed = needed_bytes(&scene, looks).map_err(ChainError::from)?;
    let formats = format_bytes(&campaign.products.formats, &scene).map_err(ChainError::from)?;
    needed.memory += formats.memory;
    needed.disk += formats.disk;
    if let Some(available) = available_memory_bytes() {
        let needed_bytes = needed.memory + BESIDE_PIXELS;
        ensure!(
            needed_bytes <= u128::from(available),
            "[image] needs {} of memory, {} are available{}",
            bytes_text(needed_bytes),
            bytes_text(available.into()),
            remedy(&scene, needed_bytes, available)
        );
    }
    if let Some(free) = free_disk_bytes(output) {
        ensure!(
            needed.disk <= u128::from(free),
            "[image] needs {} on disk, {} are free at {}{}",
            bytes_text(needed.disk),
            bytes_text(free.into()),
            output.display(),
            remedy(&scene, needed.disk, free)
        );
    }
    Ok(())
}

/// How to make the pixels fit, as the end of a sentence.
fn remedy(scene: &SceneOptions, needed_bytes: u128, available_bytes: u64) -> String {
    let pixel_m = fitting_pixel_m(scene.pixel_m, needed_bytes, available_bytes.into());
    let more = match scene.heights {
        SceneHeights::Volume { .. } => ", fewer slices (z_m, pixel_z_m)",
        _ => "",
    };
    format!(
        ": expected a smaller extent (x_m, y_m){more} or pixel_m = {pixel_m} and more, not {}",
        scene.pixel_m
    )
}

/// Bytes of data for other programs without compression. The volume's slices pass one by one; HDF5 writes the
/// real and imaginary parts of the image one after the other.
fn format_bytes(
    formats: &[ProductFormat],
    scene: &SceneOptions,
) -> Result<NeededBytes, SceneError> {
    let mut needed = NeededBytes { memory: 0, disk: 0 };
    let Some(grid) = scene.grid()? else {
        return Ok(needed);
    };
    let plane = grid.len() as u128;
    let slices = scene.volume(grid)?.map_or(0, |volume| volume.nz as u128);
    for format in formats {
        // Bytes of a pixel in memory and on disk, and of a point of the volume on disk.
        let [memory, disk, point] = match format {
            ProductFormat::Zarr => [LEVEL_BYTES, COMPLEX_BYTES + LEVEL_BYTES, COMPLEX_BYTES],
            ProductFormat::Hdf5 => {
                let parts = COMPLEX_BYTES + LEVEL_BYTES;
                [parts, parts, COMPLEX_BYTES]
            }
            ProductFormat::Vtk => {
                let arrays = COMPLEX_BYTES + LEVEL_BYTES;
                [LEVEL_BYTES, arrays, arrays]
            }
            _ => continue,
        };
        // Formats are written one after the other.
        needed.memory = needed.memory.max(plane * memory);
        needed.disk += plane * (disk + point * slices);
    }
    Ok(needed)
}

/// Bytes of a complex value and of a level in files.
const COMPLEX_BYTES: u128 = 8;
const LEVEL_BYTES: u128 = 4;

/// Free bytes at `path`, where the system reports them.
#[cfg(unix)]
fn free_disk_bytes(path: &Path) -> Option<u64> {
    let place = rustix::fs::statvfs(path).ok()?;
    Some(place.f_bavail.saturating_mul(place.f_frsize))
}

#[cfg(not(unix))]
fn free_disk_bytes(_: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_ask_for_their_bytes() {
        let of = |z_m: &str, formats: &[ProductFormat]| {
            let text = format!(
                "[radar]\nfile = 'a.npz'\n[image]\nx_m = [0.0, 0.9]\ny_m = [0.0, 0.9]\n\
                 pixel_m = 0.1\nz_m = {z_m}\n"
            );
            let scene = Campaign::parse(&text).unwrap().survey().scene;
            let needed = format_bytes(formats, &scene).unwrap();
            [needed.memory, needed.disk]
        };
        use ProductFormat::{Geotiff, Hdf5, Vtk, Zarr};
        assert_eq!(of("0.0", &[Geotiff]), [0, 0]);
        assert_eq!(of("0.0", &[Zarr, Hdf5, Vtk]), [1200, 3600]);
        let slices = "[0.0, 0.4]\npixel_z_m = 0.1";
        assert_eq!(of(slices, &[Zarr, Vtk]), [400, 2400 + 5 * 2000]);
        assert_eq!(of(slices, &[Hdf5]), [1200, 1200 + 5 * 800]);
    }
}
