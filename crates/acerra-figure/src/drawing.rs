//! A laid-out figure as a list of shapes, independent of the output format.

use super::colour::Colour;
use super::font;

/// A rectangle in CSS pixels, y downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rect {
    pub x: f32,
    pub y: f32,
    pub width: f32,
    pub height: f32,
}

impl Rect {
    pub fn right(&self) -> f32 {
        self.x + self.width
    }
    pub fn bottom(&self) -> f32 {
        self.y + self.height
    }
    pub fn contains(&self, x: f32, y: f32) -> bool {
        x >= self.x && x <= self.right() && y >= self.y && y <= self.bottom()
    }
    /// The rectangle with every edge moved outwards by `by`.
    pub fn grown(&self, by: f32) -> Self {
        Self {
            x: self.x - by,
            y: self.y - by,
            width: self.width + 2.0 * by,
            height: self.height + 2.0 * by,
        }
    }
    pub fn overlaps(&self, other: &Self) -> bool {
        self.x < other.right()
            && other.x < self.right()
            && self.y < other.bottom()
            && other.y < self.bottom()
    }
    pub fn encloses(&self, other: &Self) -> bool {
        self.contains(other.x, other.y) && self.contains(other.right(), other.bottom())
    }
    fn corners(&self) -> Vec<(f32, f32)> {
        vec![
            (self.x, self.y),
            (self.right(), self.y),
            (self.right(), self.bottom()),
            (self.x, self.bottom()),
        ]
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    pub colour: Colour,
    pub width: f32,
    pub opacity: f32,
    pub dash: Option<[f32; 2]>,
}

impl Stroke {
    pub fn new(colour: Colour, width: f32) -> Self {
        Self {
            colour,
            width,
            opacity: 1.0,
            dash: None,
        }
    }
    pub fn dashed(self, on: f32, off: f32) -> Self {
        Self {
            dash: Some([on, off]),
            ..self
        }
    }
    pub fn faint(self, opacity: f32) -> Self {
        Self { opacity, ..self }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fill {
    pub colour: Colour,
    pub opacity: f32,
}

impl From<Colour> for Fill {
    fn from(colour: Colour) -> Self {
        Self {
            colour,
            opacity: 1.0,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Clone, Debug)]
pub(super) struct Text {
    pub x: f32,
    /// The baseline.
    pub y: f32,
    pub text: String,
    pub size: f32,
    pub anchor: Anchor,
    pub colour: Colour,
    /// Turned a quarter to the left (reads upwards) about (x, y).
    pub upwards: bool,
    /// An outline that keeps the text readable over an image.
    pub halo: Option<Colour>,
}

impl Text {
    pub fn new(x: f32, y: f32, size: f32, text: impl Into<String>) -> Self {
        Self {
            x,
            y,
            text: text.into(),
            size,
            anchor: Anchor::Start,
            colour: Colour::Ink,
            upwards: false,
            halo: None,
        }
    }
    pub fn anchor(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }
    pub fn colour(self, colour: Colour) -> Self {
        Self { colour, ..self }
    }
    pub fn halo(self, colour: Colour) -> Self {
        Self {
            halo: Some(colour),
            ..self
        }
    }
    pub fn width(&self) -> f32 {
        font::width(&self.text, self.size)
    }
}

#[derive(Clone, Debug)]
pub(super) enum Item {
    Path {
        points: Vec<(f32, f32)>,
        closed: bool,
        fill: Option<Fill>,
        stroke: Option<Stroke>,
    },
    Circle {
        x: f32,
        y: f32,
        radius: f32,
        fill: Option<Fill>,
        stroke: Option<Stroke>,
    },
    Text(Text),
    Raster {
        rect: Rect,
        columns: usize,
        rows: usize,
        rgb: Vec<u8>,
    },
    Clip {
        rect: Rect,
        items: Vec<Item>,
    },
}

impl Item {
    /// The item moved to the right and downwards by `by` pixels.
    pub fn moved(self, by: [f32; 2]) -> Self {
        let [right, down] = by;
        let move_rect = |rect: Rect| Rect {
            x: rect.x + right,
            y: rect.y + down,
            ..rect
        };
        match self {
            Self::Path {
                mut points,
                closed,
                fill,
                stroke,
            } => {
                for point in &mut points {
                    *point = (point.0 + right, point.1 + down);
                }
                Self::Path {
                    points,
                    closed,
                    fill,
                    stroke,
                }
            }
            Self::Circle {
                x,
                y,
                radius,
                fill,
                stroke,
            } => Self::Circle {
                x: x + right,
                y: y + down,
                radius,
                fill,
                stroke,
            },
            Self::Text(text) => Self::Text(Text {
                x: text.x + right,
                y: text.y + down,
                ..text
            }),
            Self::Raster {
                rect,
                columns,
                rows,
                rgb,
            } => Self::Raster {
                rect: move_rect(rect),
                columns,
                rows,
                rgb,
            },
            Self::Clip { rect, items } => Self::Clip {
                rect: move_rect(rect),
                items: items.into_iter().map(|item| item.moved(by)).collect(),
            },
        }
    }
}

/// A finished figure, ready to be written as PNG or SVG.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Width in CSS pixels.
    pub width_px: u32,
    /// Height in CSS pixels.
    pub height_px: u32,
    /// Device pixels per CSS pixel in the PNG.
    pub scale: u32,
    /// Description for readers who cannot see the figure.
    pub description: String,
    pub(super) items: Vec<Item>,
}

impl Drawing {
    /// This figure, described by `description` for readers who cannot see it.
    #[must_use]
    pub fn described(self, description: impl Into<String>) -> Self {
        Self {
            description: description.into(),
            ..self
        }
    }
}

/// Default device pixels per CSS pixel: crisp on dense screens and in print.
pub(super) const DEFAULT_SCALE: u32 = 2;

pub(super) fn line(points: Vec<(f32, f32)>, stroke: Stroke) -> Item {
    Item::Path {
        points,
        closed: false,
        fill: None,
        stroke: Some(stroke),
    }
}

pub(super) fn rectangle(rect: Rect, fill: Option<Fill>, stroke: Option<Stroke>) -> Item {
    Item::Path {
        points: rect.corners(),
        closed: true,
        fill,
        stroke,
    }
}

pub(super) fn polygon(points: Vec<(f32, f32)>, fill: Fill) -> Item {
    Item::Path {
        points,
        closed: true,
        fill: Some(fill),
        stroke: None,
    }
}

/// The middle of the pixel that `v` falls into, where a one-pixel line is crisp.
pub(super) fn snap(v: f32) -> f32 {
    v.floor() + 0.5
}
