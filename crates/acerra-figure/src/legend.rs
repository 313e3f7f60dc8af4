//! Legends: samples of lines and marks with their names, in rows above the plot.

use super::colour::Colour;
use super::drawing::{Fill, Item, Rect, Stroke, Text, line, polygon, rectangle};

/// The shape of a mark on a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Marker {
    Dot,
    Ring,
    DashedRing,
    Triangle,
    Cross,
}

/// Draws `marker` about (x, y); rings carry a dark edge so that they show on any ground.
pub(super) fn mark(marker: Marker, x: f32, y: f32, radius: f32, colour: Colour) -> Vec<Item> {
    let circle = |radius: f32, fill, stroke| Item::Circle {
        x,
        y,
        radius,
        fill,
        stroke: Some(stroke),
    };
    match marker {
        Marker::Dot => {
            vec![Item::Circle {
                x,
                y,
                radius,
                fill: Some(colour.into()),
                stroke: None,
            }]
        }
        Marker::Ring => vec![
            circle(radius, None, Stroke::new(DARK, 3.2).faint(0.7)),
            circle(radius, None, Stroke::new(colour, 1.6)),
        ],
        Marker::DashedRing => vec![
            circle(radius, None, Stroke::new(DARK, 3.2).faint(0.5)),
            circle(radius, None, Stroke::new(colour, 1.4).dashed(2.5, 2.5)),
        ],
        Marker::Cross => {
            let arm = 0.7 * radius;
            let strokes = |stroke: Stroke| {
                [1.0, -1.0].map(|up| {
                    line(
                        vec![(x - arm, y - up * arm), (x + arm, y + up * arm)],
                        stroke,
                    )
                })
            };
            let mut items = strokes(Stroke::new(DARK, 3.6).faint(0.7)).to_vec();
            items.extend(strokes(Stroke::new(colour, 1.6)));
            items
        }
        Marker::Triangle => {
            let points = |r: f32| {
                vec![
                    (x, y - r),
                    (x + 0.87 * r, y + 0.5 * r),
                    (x - 0.87 * r, y + 0.5 * r),
                ]
            };
            vec![
                polygon(
                    points(radius + 2.0),
                    Fill {
                        colour: DARK,
                        opacity: 0.7,
                    },
                ),
                polygon(points(radius), colour.into()),
            ]
        }
    }
}

/// The dark edge of marks and lines that lie on images.
pub(super) const DARK: Colour = Colour::Rgb(0x14, 0x14, 0x18);

#[derive(Clone, Debug)]
pub(super) enum Sample {
    Line(Stroke),
    Mark(Marker, Colour),
    LineAndBand(Stroke, Fill),
    Patch(Fill),
}

#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub label: String,
    pub sample: Sample,
    /// Background colour behind the sample in the plot; `None` for the paper colour.
    pub ground: Option<Colour>,
}

const SIZE: f32 = 12.0;
const ROW: f32 = 19.0;
const SAMPLE: f32 = 24.0;

/// Lays the entries out in rows of at most `width` pixels from (x, y); returns the shapes and the
/// height they take.
pub(super) fn lay_out(entries: &[Entry], x: f32, y: f32, width: f32) -> (Vec<Item>, f32) {
    let mut items = Vec::new();
    if entries.is_empty() {
        return (items, 0.0);
    }
    let (mut pen_x, mut pen_y) = (x, y);
    for entry in entries {
        let text = Text::new(0.0, 0.0, SIZE, entry.label.clone());
        let advance = SAMPLE + 6.0 + text.width() + 18.0;
        if pen_x > x && pen_x + advance - 18.0 > x + width {
            pen_x = x;
            pen_y += ROW;
        }
        let centre = pen_y + ROW / 2.0;
        let ground = Rect {
            x: pen_x,
            y: centre - 7.0,
            width: SAMPLE,
            height: 14.0,
        };
        if let Some(colour) = entry.ground {
            items.push(rectangle(ground, Some(colour.into()), None));
        }
        let ends = vec![(pen_x + 2.0, centre), (pen_x + SAMPLE - 2.0, centre)];
        match entry.sample {
            Sample::Line(stroke) => items.push(line(ends, stroke)),
            Sample::LineAndBand(stroke, fill) => {
                let band = Rect {
                    y: centre - 5.0,
                    height: 10.0,
                    ..ground
                };
                items.push(rectangle(band, Some(fill), None));
                items.push(line(ends, stroke));
            }
            Sample::Mark(marker, colour) => {
                items.extend(mark(marker, pen_x + SAMPLE / 2.0, centre, 4.5, colour));
            }
            Sample::Patch(fill) => {
                let patch = Rect {
                    y: centre - 5.0,
                    height: 10.0,
                    ..ground
                };
                items.push(rectangle(patch, Some(fill), None));
            }
        }
        items.push(Item::Text(Text {
            x: pen_x + SAMPLE + 6.0,
            y: centre + 0.36 * SIZE,
            colour: Colour::Muted,
            ..text
        }));
        pen_x += advance;
    }
    (items, pen_y + ROW - y + 4.0)
}
