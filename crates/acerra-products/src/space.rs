//! Whether memory and disk hold what a campaign asks for.

use std::path::Path;

use acerra_chain::ChainError;
use acerra_chain::campaign::Campaign;
use acerra_chain::memory::available_memory_bytes;
use acerra_chain::space::needed_bytes;
use anyhow::ensure;

/// Bytes that tables, traces, pictures and threads take beside the pixels of an ordinary run.
const BESIDE_PIXELS: u128 = 64 << 20;

/// Refuses a campaign whose pixels do not fit memory or disk, before anything is read.
///
/// # Errors
/// With the bytes needed and available.
pub fn check_space(campaign: &Campaign, output: &Path) -> anyhow::Result<()> {
    let scene = campaign.survey().scene;
    let needed = needed_bytes(&scene, campaign.image.looks).map_err(ChainError::from)?;
    if let Some(available) = available_memory_bytes() {
        ensure!(
            needed.memory + BESIDE_PIXELS <= u128::from(available),
            "[image] needs {} bytes of memory and about {BESIDE_PIXELS} for all else, {available} \
             bytes are available",
            needed.memory
        );
    }
    if let Some(free) = free_disk_bytes(output) {
        ensure!(
            needed.disk <= u128::from(free),
            "[image] needs {} bytes on disk, {free} bytes are free at {}",
            needed.disk,
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
