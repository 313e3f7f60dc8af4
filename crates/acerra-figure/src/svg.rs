//! Drawing to inline SVG.

use super::drawing::{Anchor, Drawing, Fill, Item, Stroke, Text};
use super::escape::escape;
use super::raster::encode_png;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use std::fmt::Write as _;

impl Drawing {
    /// The figure as an SVG element for embedding in an HTML page or for a separate file.
    ///
    /// The element refers to no other file and has no identifiers, so that any number of figures can share a
    /// page. Colours by role follow the CSS variables named at [`Colour`](super::Colour).
    #[must_use]
    pub fn to_svg(&self) -> String {
        let (w, h) = (self.width_px, self.height_px);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"figure\" viewBox=\"0 0 {w} {h}\" \
             width=\"{w}\" height=\"{h}\" role=\"img\" aria-label=\"{}\" \
             font-family=\"DejaVu Sans,Verdana,sans-serif\">",
            escape(&self.description)
        );
        items(&mut out, &self.items);
        out.push_str("</svg>");
        out
    }
}

fn items(out: &mut String, list: &[Item]) {
    for item in list {
        match item {
            Item::Path {
                points,
                closed,
                fill,
                stroke,
            } => {
                let name = if *closed { "polygon" } else { "polyline" };
                let _ = write!(out, "<{name} points=\"");
                for (i, (x, y)) in points.iter().enumerate() {
                    let space = if i == 0 { "" } else { " " };
                    let _ = write!(out, "{space}{},{}", number(*x), number(*y));
                }
                let _ = write!(out, "\"{}/>", style(*fill, *stroke));
            }
            Item::Circle {
                x,
                y,
                radius,
                fill,
                stroke,
            } => {
                let _ = write!(
                    out,
                    "<circle cx=\"{}\" cy=\"{}\" r=\"{}\"{}/>",
                    number(*x),
                    number(*y),
                    number(*radius),
                    style(*fill, *stroke)
                );
            }
            Item::Text(t) => text(out, t),
            Item::Raster {
                rect,
                columns,
                rows,
                rgb,
            } => {
                // A raster that cannot be encoded has no pixels to show.
                if let Ok(png) = encode_png(*columns as u32, *rows as u32, rgb) {
                    let _ = write!(
                        out,
                        "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" \
                         preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
                         href=\"data:image/png;base64,{}\"/>",
                        number(rect.x),
                        number(rect.y),
                        number(rect.width),
                        number(rect.height),
                        BASE64.encode(&png)
                    );
                }
            }
            Item::Clip { rect, items: inner } => {
                let (x, y) = (number(rect.x), number(rect.y));
                let (w, h) = (number(rect.width), number(rect.height));
                // A nested viewport clips without needing an identifier.
                let _ = write!(
                    out,
                    "<svg x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" \
                     viewBox=\"{x} {y} {w} {h}\">"
                );
                items(out, inner);
                out.push_str("</svg>");
            }
        }
    }
}

fn style(fill: Option<Fill>, stroke: Option<Stroke>) -> String {
    let mut css = match fill {
        Some(fill) => format!("fill:{}", fill.colour.css()),
        None => "fill:none".to_owned(),
    };
    if let Some(fill) = fill.filter(|fill| fill.opacity < 1.0) {
        let _ = write!(css, ";fill-opacity:{}", fill.opacity);
    }
    if let Some(stroke) = stroke {
        let _ = write!(
            css,
            ";stroke:{};stroke-width:{}",
            stroke.colour.css(),
            stroke.width
        );
        css.push_str(";stroke-linejoin:round");
        if stroke.opacity < 1.0 {
            let _ = write!(css, ";stroke-opacity:{}", stroke.opacity);
        }
        match stroke.dash {
            Some([on, off]) => {
                let _ = write!(css, ";stroke-dasharray:{on} {off}");
            }
            None => css.push_str(";stroke-linecap:round"),
        }
    }
    format!(" style=\"{css}\"")
}

fn text(out: &mut String, text: &Text) {
    let (x, y) = (number(text.x), number(text.y));
    let _ = write!(
        out,
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\"",
        number(text.size)
    );
    match text.anchor {
        Anchor::Start => {}
        Anchor::Middle => out.push_str(" text-anchor=\"middle\""),
        Anchor::End => out.push_str(" text-anchor=\"end\""),
    }
    if text.upwards {
        let _ = write!(out, " transform=\"rotate(-90 {x} {y})\"");
    }
    let _ = write!(out, " style=\"fill:{}", text.colour.css());
    if let Some(halo) = text.halo {
        let _ = write!(
            out,
            ";stroke:{};stroke-width:3;stroke-opacity:.75;stroke-linejoin:round;paint-order:stroke",
            halo.css()
        );
    }
    let _ = write!(out, "\">{}</text>", escape(&text.text));
}

/// At most two decimals, without trailing zeros.
fn number(v: f32) -> String {
    let text = format!("{v:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}
