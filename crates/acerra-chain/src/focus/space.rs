//! Memory and disk space of an image.

use acerra_imaging::VolumeGrid;

use crate::scene::{SceneError, SceneHeights, SceneOptions};

const VALUE: u128 = size_of::<acerra_imaging::Complex32>() as u128;

/// Bytes of a pixel's level while an image is measured and drawn.
const LEVEL: u128 = size_of::<f32>() as u128;

/// Bytes of the pixels, in addition to tables and traces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NeededBytes {
    /// In memory.
    pub memory: u128,
    /// On disk, where image, looks and volume are written whole.
    pub disk: u128,
}

/// Bytes needed for the pixels of a scene and its looks.
///
/// # Errors
/// An invalid grid or volume.
pub fn needed_bytes(scene: &SceneOptions, looks: Option<usize>) -> Result<NeededBytes, SceneError> {
    let Some(grid) = scene.grid()? else {
        // Sides left to the flight: the size is unknown until the flight is read.
        return Ok(NeededBytes { memory: 0, disk: 0 });
    };
    let plane = grid.len() as u128;
    let (mut memory, mut disk) = (plane * (VALUE + LEVEL), plane * VALUE);
    if matches!(scene.heights, SceneHeights::Terrain(_)) {
        memory += plane * 4;
        disk += plane * 8;
    }
    if let Some(looks) = looks {
        memory += plane * (VALUE + 4);
        disk += plane * (VALUE * looks as u128 + 4);
    }
    if let Some(volume) = scene.volume(grid)? {
        memory += projections_bytes(&volume);
        disk += plane * (VALUE * volume.nz as u128 + 8);
    }
    Ok(NeededBytes { memory, disk })
}

/// Bytes of a volume's maximum projections, in addition to one slice.
pub(crate) fn projections_bytes(volume: &VolumeGrid) -> u128 {
    let [nx, ny, nz] = [volume.base.nx, volume.base.ny, volume.nz].map(|n| n as u128);
    // The view from above has a value, a modulus and a height; the views from the side and the front have a
    // power.
    nx * ny * (2 * VALUE + 4) + nz * (nx + ny) * 4
}
