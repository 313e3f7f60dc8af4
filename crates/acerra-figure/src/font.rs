//! The embedded font: outlines and widths.

use std::sync::LazyLock;
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// A subset of DejaVu Sans; its licence lies beside it.
static BYTES: &[u8] = include_bytes!("fonts/DejaVuSans-subset.ttf");

static FACE: LazyLock<Face<'static>> = LazyLock::new(|| {
    // The bytes are part of the program and parsed by a test.
    Face::parse(BYTES, 0).expect("the embedded font is well formed")
});

/// Glyphs of `text` with their pen positions in em, kerned, and the total width in em.
fn lay_out(text: &str) -> (Vec<(GlyphId, f32)>, f32) {
    let face = &*FACE;
    let em = f32::from(face.units_per_em());
    let mut pen = 0.0;
    let mut previous = None;
    let mut glyphs = Vec::with_capacity(text.len());
    for character in text.chars() {
        let glyph = face
            .glyph_index(character)
            .or_else(|| face.glyph_index('\u{FFFD}'))
            .unwrap_or(GlyphId(0));
        if let Some(previous) = previous {
            pen += kerning(face, previous, glyph) / em;
        }
        glyphs.push((glyph, pen));
        pen += f32::from(face.glyph_hor_advance(glyph).unwrap_or(0)) / em;
        previous = Some(glyph);
    }
    (glyphs, pen)
}

fn kerning(face: &Face<'_>, left: GlyphId, right: GlyphId) -> f32 {
    let Some(table) = face.tables().kern else {
        return 0.0;
    };
    table
        .subtables
        .into_iter()
        .filter(|subtable| subtable.horizontal && !subtable.variable)
        .find_map(|subtable| subtable.glyphs_kerning(left, right))
        .map_or(0.0, f32::from)
}

/// Width of `text` in pixels at `size_px`.
pub(super) fn width(text: &str, size_px: f32) -> f32 {
    lay_out(text).1 * size_px
}

struct Outline {
    builder: tiny_skia::PathBuilder,
    factor: f32,
    x: f32,
}

impl Outline {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.factor, -y * self.factor)
    }
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.builder.line_to(x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }
    fn close(&mut self) {
        self.builder.close();
    }
}

/// The outline of `text` at `size_px`, its baseline starting at the origin, y downwards; none
/// where nothing would be inked.
pub(super) fn outline(text: &str, size_px: f32) -> Option<tiny_skia::Path> {
    let face = &*FACE;
    let mut outline = Outline {
        builder: tiny_skia::PathBuilder::new(),
        factor: size_px / f32::from(face.units_per_em()),
        x: 0.0,
    };
    for (glyph, pen) in lay_out(text).0 {
        outline.x = pen * size_px;
        let _ = face.outline_glyph(glyph, &mut outline);
    }
    outline.builder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_character_of_the_figures_is_in_the_subset() {
        for character in "aZ09 −±×·°µΔσλφ²³⁻⁴₀→≤≥∞…–’√".chars() {
            assert!(
                FACE.glyph_index(character).is_some(),
                "{character} is missing"
            );
        }
    }

    #[test]
    fn width_is_additive_but_for_kerning() {
        let pair = width("AV", 100.0);
        let apart = width("A", 100.0) + width("V", 100.0);
        assert!(
            pair < apart && pair > 0.85 * apart,
            "{pair} against {apart}"
        );
        assert!((width("00", 12.0) - 2.0 * width("0", 12.0)).abs() < 1e-4);
    }
}
