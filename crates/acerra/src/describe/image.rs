//! Focused images.

use std::io::{Read, Seek};

use acerra_npz::NpzReader;

use super::description::Description;

/// Whether the first bytes belong to an `image.npz`.
pub fn is_image(head: &[u8]) -> bool {
    // The name of the first member is right behind its 30-byte local header.
    head.starts_with(b"PK\x03\x04") && head.get(30..).is_some_and(|b| b.starts_with(b"image.npy"))
}

pub fn describe(reader: impl Read + Seek) -> anyhow::Result<Description> {
    let mut npz = NpzReader::new(reader)?;
    let mut d = Description::new("focused image");
    let image = npz.shape("image")?;
    let [ny, nx] = image[..] else {
        anyhow::bail!("image: expected two dimensions, found {}", image.len());
    };
    d.fact("rows", ny);
    d.fact("columns", nx);
    for (name, expected) in [("x_m", nx), ("y_m", ny)] {
        let found = npz.shape(name)?;
        if found != [expected] {
            anyhow::bail!("{name}: expected {expected} values, found shape {found:?}");
        }
    }
    Ok(d)
}
