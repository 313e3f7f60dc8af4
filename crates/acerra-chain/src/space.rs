//! What an image needs in memory and on disk, against what there is.

use std::path::Path;

use anyhow::ensure;

use super::ground::{grid_of, volume_of};
use crate::campaign::Campaign;
use crate::memory::available_memory_bytes;

const VALUE: u128 = size_of::<acerra_imaging::Complex32>() as u128;

/// The level of a pixel while an image is measured and drawn.
const LEVEL: u128 = size_of::<f32>() as u128;

/// Bytes that tables, traces, pictures and threads take beside the pixels of an ordinary run.
const BESIDE_PIXELS: u128 = 64 << 20;

/// Bytes of memory and of disk that a campaign's pixels ask for, beside tables and traces.
///
/// # Errors
/// A grid or volume that is none.
pub fn needed_bytes(campaign: &Campaign) -> anyhow::Result<(u128, u128)> {
    let grid = grid_of(campaign)?;
    let plane = grid.len() as u128;
    let (mut memory, mut disk) = (plane * (VALUE + LEVEL), plane * VALUE);
    if campaign.image.terrain.is_some() {
        memory += plane * 4;
        disk += plane * 8;
    }
    if let Some(looks) = campaign.image.looks {
        memory += plane * (VALUE + 4);
        disk += plane * (VALUE * looks as u128 + 4);
    }
    if let Some(volume) = volume_of(campaign, grid)? {
        let slices = volume.nz as u128;
        memory += projections_bytes(grid.nx, grid.ny, volume.nz);
        disk += plane * (VALUE * slices + 8);
    }
    Ok((memory, disk))
}

/// Bytes of a volume's maximum projections, beside one slice.
pub fn projections_bytes(nx: usize, ny: usize, nz: usize) -> u128 {
    let (nx, ny, nz) = (nx as u128, ny as u128, nz as u128);
    // Seen from above a value, its modulus and a height; from the side and the front a power.
    nx * ny * (2 * VALUE + 4) + nz * (nx + ny) * 4
}

/// Refuses a campaign whose pixels do not fit memory or disk, before anything is read.
///
/// # Errors
/// With the bytes needed and available.
pub fn check_space(campaign: &Campaign, output: &Path) -> anyhow::Result<()> {
    let (memory, disk) = needed_bytes(campaign)?;
    if let Some(available) = available_memory_bytes() {
        ensure!(
            memory + BESIDE_PIXELS <= u128::from(available),
            "[image] needs {memory} bytes of memory and about {BESIDE_PIXELS} for all else, \
             {available} bytes are available"
        );
    }
    if let Some(free) = free_disk_bytes(output) {
        ensure!(
            disk <= u128::from(free),
            "[image] needs {disk} bytes on disk, {free} bytes are free at {}",
            output.display()
        );
    }
    Ok(())
}

/// Bytes free at `path`, where the system tells.
#[cfg(unix)]
fn free_disk_bytes(path: &Path) -> Option<u64> {
    let place = rustix::fs::statvfs(path).ok()?;
    Some(place.f_bavail.saturating_mul(place.f_frsize))
}

#[cfg(not(unix))]
fn free_disk_bytes(_: &Path) -> Option<u64> {
    None
}
