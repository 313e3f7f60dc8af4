//! Positions of the cells of a GeoTIFF.

use std::io::{Read, Seek};

use tiff::decoder::Decoder;
use tiff::tags::Tag;

use super::super::TerrainError;
use super::super::raster::Placement;

/// Where cell centres are, from the transformation or tie point and scale.
pub(super) fn placement<R: Read + Seek>(
    decoder: &mut Decoder<R>,
    pixel_is_point: bool,
) -> Result<Placement, TerrainError> {
    // Tie points count from the corner of the first pixel, or from its centre.
    let centre = if pixel_is_point { 0.0 } else { 0.5 };
    if let Some(m) = doubles(decoder, Tag::ModelTransformationTag, "ModelTransformation")? {
        let &[a, b, _, d, e, f, _, h, ..] = m.as_slice() else {
            return Err(too_short("ModelTransformation", "16 numbers", m.len()));
        };
        let origin = [d + centre * (a + b), h + centre * (e + f)];
        return Placement::new(origin, [a, e], [b, f]);
    }
    let Some(scale) = doubles(decoder, Tag::ModelPixelScaleTag, "ModelPixelScale")? else {
        return Err(TerrainError::Tag {
            at: "ModelPixelScale, ModelTransformation",
            expected: "one of them, to place the raster",
            found: "neither (a TIFF without a place)".to_owned(),
        });
    };
    let tie = doubles(decoder, Tag::ModelTiepointTag, "ModelTiepoint")?.unwrap_or_default();
    let (&[sx, sy, ..], &[i, j, _, x, y, ..]) = (scale.as_slice(), tie.as_slice()) else {
        return Err(too_short(
            "ModelPixelScale, ModelTiepoint",
            "3 and 6 numbers",
            scale.len() + tie.len(),
        ));
    };
    Placement::new(
        [x + (centre - i) * sx, y - (centre - j) * sy],
        [sx, 0.0],
        [0.0, -sy],
    )
}

fn too_short(at: &'static str, expected: &'static str, found: usize) -> TerrainError {
    TerrainError::Tag {
        at,
        expected,
        found: format!("{found} numbers"),
    }
}

fn doubles<R: Read + Seek>(
    decoder: &mut Decoder<R>,
    tag: Tag,
    at: &'static str,
) -> Result<Option<Vec<f64>>, TerrainError> {
    let broken = |source| TerrainError::Tiff {
        at: at.to_owned(),
        source,
    };
    decoder
        .find_tag(tag)
        .map_err(broken)?
        .map(|v| v.into_f64_vec().map_err(broken))
        .transpose()
}
