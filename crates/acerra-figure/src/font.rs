//! The embedded font: outlines and widths.

use skrifa::instance::{LocationRef, Size};
use skrifa::metrics::GlyphMetrics;
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::raw::TableProvider;
use skrifa::raw::tables::kern::SubtableKind;
use skrifa::{FontRef, GlyphId, MetadataProvider};
use std::sync::LazyLock;

/// A subset of DejaVu Sans; the font's licence is in the same folder.
static BYTES: &[u8] = include_bytes!("fonts/DejaVuSans-subset.ttf");

static FACE: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    // The bytes are part of the program and parsed by a test.
    FontRef::new(BYTES).expect("the embedded font is well formed")
});

fn units_per_em(font: &FontRef<'_>) -> f32 {
    font.head()
        .map_or(1000.0, |head| f32::from(head.units_per_em()))
}

/// Glyphs of `text` with their pen positions in em, kerned, and the total width in em.
fn lay_out(text: &str) -> (Vec<(GlyphId, f32)>, f32) {
    let font = &*FACE;
    let em = units_per_em(font);
    let charmap = font.charmap();
    let metrics = GlyphMetrics::new(font, Size::unscaled(), LocationRef::default());
    let mut pen = 0.0;
    let mut previous = None;
    let mut glyphs = Vec::with_capacity(text.len());
    for character in text.chars() {
        let glyph = charmap
            .map(character)
            .or_else(|| charmap.map('\u{FFFD}'))
            .unwrap_or(GlyphId::NOTDEF);
        if let Some(previous) = previous {
            pen += kerning(font, previous, glyph) / em;
        }
        glyphs.push((glyph, pen));
        pen += metrics.advance_width(glyph).unwrap_or(0.0) / em;
        previous = Some(glyph);
    }
    (glyphs, pen)
}

/// The kerning of a pair in font units, from the first horizontal subtable that holds it.
fn kerning(font: &FontRef<'_>, left: GlyphId, right: GlyphId) -> f32 {
    let Ok(table) = font.kern() else {
        return 0.0;
    };
    table
        .subtables()
        .filter_map(Result::ok)
        .filter(|subtable| subtable.is_horizontal() && !subtable.is_variable())
        .find_map(|subtable| match subtable.kind().ok()? {
            SubtableKind::Format0(pairs) => pairs.kerning(left, right),
            SubtableKind::Format2(classes) => classes.kerning(left, right),
            SubtableKind::Format3(classes) => classes.kerning(left, right),
            SubtableKind::Format1(_) => None,
        })
        .map_or(0.0, |units| units as f32)
}

/// Width of `text` in pixels at `size_px`.
pub(super) fn width(text: &str, size_px: f32) -> f32 {
    lay_out(text).1 * size_px
}

/// Collects glyph outlines in font units into a path in pixels.
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

impl OutlinePen for Outline {
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

/// The outline of `text` at `size_px`, its baseline starting at the origin, y downwards; none where the text
/// has no visible glyph.
pub(super) fn outline(text: &str, size_px: f32) -> Option<tiny_skia::Path> {
    let font = &*FACE;
    let outlines = font.outline_glyphs();
    let mut outline = Outline {
        builder: tiny_skia::PathBuilder::new(),
        factor: size_px / units_per_em(font),
        x: 0.0,
    };
    for (glyph, pen) in lay_out(text).0 {
        outline.x = pen * size_px;
        if let Some(glyph) = outlines.get(glyph) {
            let unscaled = DrawSettings::unhinted(Size::unscaled(), LocationRef::default());
            // A glyph that cannot be read is drawn as far as it could be.
            let _ = glyph.draw(unscaled, &mut outline);
        }
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
                FACE.charmap().map(character).is_some(),
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

    #[test]
    fn every_glyph_of_the_figures_has_an_outline() {
        for character in "aZ09−±×·°µΔσλφ²³⁻⁴₀→≤≥∞…–’√".chars() {
            let path = outline(&character.to_string(), 12.0);
            assert!(path.is_some(), "{character} draws nothing");
        }
    }
}
