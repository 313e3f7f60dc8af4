//! Drawing to PNG.

use super::colour::Colour;
use super::drawing::{Anchor, Drawing, Fill, Item, Rect, Stroke, Text};
use super::error::FigureError;
use super::font;
use tiny_skia::{
    FillRule, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, StrokeDash, Transform,
};

impl Drawing {
    /// The figure as a PNG (8-bit RGB) of `scale` device pixels per CSS pixel.
    ///
    /// # Errors
    /// [`FigureError::Encode`] where the picture is too large to hold.
    pub fn to_png(&self) -> Result<Vec<u8>, FigureError> {
        let (width, height, rgb) = self.to_rgb()?;
        encode_png(width, height, &rgb)
    }

    /// Width, height and RGB bytes of the figure in device pixels.
    pub(super) fn to_rgb(&self) -> Result<(u32, u32, Vec<u8>), FigureError> {
        let (width, height) = (self.width_px * self.scale, self.height_px * self.scale);
        let mut pixmap = Pixmap::new(width, height)
            .ok_or_else(|| FigureError::Encode(format!("no picture of {width} × {height}")))?;
        pixmap.fill(skia_colour(Colour::Paper, 1.0));
        let mut painter = Painter {
            pixmap,
            scale: self.scale as f32,
        };
        painter.items(&self.items, None);
        let painted = painter.pixmap.data().chunks_exact(4);
        let mut rgb = vec![0; 3 * painted.len()];
        for (rgb, painted) in rgb.chunks_exact_mut(3).zip(painted) {
            rgb.copy_from_slice(&painted[..3]);
        }
        Ok((width, height, rgb))
    }
}

/// Encodes 8-bit RGB as PNG; equal bytes for equal pictures.
pub(super) fn encode_png(width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>, FigureError> {
    // An encoder made for PNG needs a tenth of zlib's time where neighbours differ, and is slower where they
    // are equal, as in enlarged drawings.
    let encoding = if is_in_runs(rgb, width as usize) {
        Encoding::Runs(4)
    } else {
        Encoding::Gradual
    };
    encode([width, height], png::ColorType::Rgb, rgb, encoding)
}

/// Encodes 8-bit RGBA as PNG; equal bytes for equal pictures.
pub(super) fn encode_png_rgba(
    width: u32,
    height: u32,
    rgba: &[u8],
) -> Result<Vec<u8>, FigureError> {
    encode(
        [width, height],
        png::ColorType::Rgba,
        rgba,
        Encoding::Runs(3),
    )
}

/// How the samples of a picture are compressed: a tenth larger than by zlib's sixth level at most, in a fraction of
/// its time.
enum Encoding {
    /// Differences of neighbours, filters chosen row by row.
    Gradual,
    /// The colours as they are, by zlib at this level: differences of colours that jump compress worse.
    Runs(u8),
}

/// Whether three quarters of the pixels have the colour of their left neighbour; every eighth row is read.
fn is_in_runs(rgb: &[u8], width: usize) -> bool {
    let rows = rgb.chunks_exact(3 * width.max(1)).step_by(8);
    let (mut equal, mut all) = (0, 0);
    for row in rows {
        let (before, after) = (row.chunks_exact(3), row.chunks_exact(3).skip(1));
        equal += before.zip(after).filter(|(a, b)| a == b).count();
        all += width;
    }
    4 * equal > 3 * all
}

fn encode(
    [width, height]: [u32; 2],
    colour: png::ColorType,
    samples: &[u8],
    encoding: Encoding,
) -> Result<Vec<u8>, FigureError> {
    let encode = |error: png::EncodingError| FigureError::Encode(error.to_string());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(colour);
    encoder.set_depth(png::BitDepth::Eight);
    match encoding {
        Encoding::Gradual => {
            encoder.set_compression(png::Compression::Fast);
            encoder.set_filter(png::Filter::Adaptive);
        }
        Encoding::Runs(level) => {
            encoder.set_deflate_compression(png::DeflateCompression::Level(level));
            encoder.set_filter(png::Filter::NoFilter);
        }
    }
    let mut writer = encoder.write_header().map_err(encode)?;
    writer.write_image_data(samples).map_err(encode)?;
    writer.finish().map_err(encode)?;
    Ok(bytes)
}

fn skia_colour(colour: Colour, opacity: f32) -> tiny_skia::Color {
    let [r, g, b] = colour.rgb();
    let mut colour = tiny_skia::Color::from_rgba8(r, g, b, 255);
    colour.set_alpha(opacity.clamp(0.0, 1.0));
    colour
}

fn paint(colour: Colour, opacity: f32) -> Paint<'static> {
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    paint.set_color(skia_colour(colour, opacity));
    paint
}

struct Painter {
    pixmap: Pixmap,
    scale: f32,
}

impl Painter {
    fn items(&mut self, items: &[Item], mask: Option<&Mask>) {
        for item in items {
            match item {
                Item::Path {
                    points,
                    closed,
                    fill,
                    stroke,
                } => {
                    if let Some(path) = polyline(points, *closed) {
                        self.path(&path, *fill, *stroke, mask);
                    }
                }
                Item::Circle {
                    x,
                    y,
                    radius,
                    fill,
                    stroke,
                } => {
                    if let Some(path) = PathBuilder::from_circle(*x, *y, *radius) {
                        self.path(&path, *fill, *stroke, mask);
                    }
                }
                Item::Text(text) => self.text(text, mask),
                Item::Raster {
                    rect,
                    columns,
                    rows,
                    rgb,
                } => {
                    self.raster(rect, *columns, *rows, rgb);
                }
                Item::Clip { rect, items } => {
                    if let Some(mask) = self.clip_mask(rect) {
                        self.items(items, Some(&mask));
                    }
                }
            }
        }
    }

    fn transform(&self) -> Transform {
        Transform::from_scale(self.scale, self.scale)
    }

    fn clip_mask(&self, rect: &Rect) -> Option<Mask> {
        let mut mask = Mask::new(self.pixmap.width(), self.pixmap.height())?;
        let rect = tiny_skia::Rect::from_xywh(rect.x, rect.y, rect.width, rect.height)?;
        let path = PathBuilder::from_rect(rect);
        mask.fill_path(&path, FillRule::Winding, false, self.transform());
        Some(mask)
    }

    fn path(
        &mut self,
        path: &Path,
        fill: Option<Fill>,
        stroke: Option<Stroke>,
        mask: Option<&Mask>,
    ) {
        let transform = self.transform();
        if let Some(fill) = fill {
            let paint = paint(fill.colour, fill.opacity);
            self.pixmap
                .fill_path(path, &paint, FillRule::Winding, transform, mask);
        }
        if let Some(stroke) = stroke {
            let paint = paint(stroke.colour, stroke.opacity);
            let style = tiny_skia::Stroke {
                width: stroke.width,
                line_join: LineJoin::Round,
                line_cap: if stroke.dash.is_some() {
                    LineCap::Butt
                } else {
                    LineCap::Round
                },
                dash: stroke
                    .dash
                    .and_then(|dash| StrokeDash::new(dash.to_vec(), 0.0)),
                ..tiny_skia::Stroke::default()
            };
            self.pixmap
                .stroke_path(path, &paint, &style, transform, mask);
        }
    }

    fn text(&mut self, text: &Text, mask: Option<&Mask>) {
        let Some(path) = font::outline(&text.text, text.size) else {
            return;
        };
        let shift = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -text.width() / 2.0,
            Anchor::End => -text.width(),
        };
        let place = if text.upwards {
            Transform::from_row(0.0, -1.0, 1.0, 0.0, text.x, text.y).pre_translate(shift, 0.0)
        } else {
            Transform::from_translate(text.x + shift, text.y)
        };
        let Some(path) = path.transform(place) else {
            return;
        };
        if let Some(halo) = text.halo {
            self.path(&path, None, Some(Stroke::new(halo, 3.0).faint(0.75)), mask);
        }
        self.path(&path, Some(text.colour.into()), None, mask);
    }

    /// Copies a raster to whole device pixels, nearest neighbour.
    fn raster(&mut self, rect: &Rect, columns: usize, rows: usize, rgb: &[u8]) {
        let (width, height) = (self.pixmap.width() as usize, self.pixmap.height() as usize);
        let x0 = (rect.x * self.scale).round() as usize;
        let y0 = (rect.y * self.scale).round() as usize;
        let wide = ((rect.width * self.scale).round() as usize).min(width.saturating_sub(x0));
        let high = ((rect.height * self.scale).round() as usize).min(height.saturating_sub(y0));
        let data = self.pixmap.data_mut();
        for y in 0..high {
            let row = y * rows / high;
            for x in 0..wide {
                let from = 3 * (row * columns + x * columns / wide);
                let to = 4 * ((y0 + y) * width + x0 + x);
                data[to..to + 3].copy_from_slice(&rgb[from..from + 3]);
                data[to + 3] = 255;
            }
        }
    }
}

fn polyline(points: &[(f32, f32)], closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    let mut points = points.iter();
    let &(x, y) = points.next()?;
    builder.move_to(x, y);
    for &(x, y) in points {
        builder.line_to(x, y);
    }
    if closed {
        builder.close();
    }
    builder.finish()
}
