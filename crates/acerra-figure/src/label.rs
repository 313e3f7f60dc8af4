//! Titles and labels: sizes, placement about a point, line breaks.

use super::colour::Colour;
use super::drawing::{Anchor, Item, Text};
use super::font;

/// Size of tick labels in CSS pixels.
pub(super) const TICK: f32 = 12.0;
/// Size of axis labels.
pub(super) const LABEL: f32 = 13.0;
/// Size to which an axis label shrinks at most.
pub(super) const LEAST_LABEL: f32 = 9.0;
/// Size of titles.
pub(super) const TITLE: f32 = 15.0;
/// Room between the figure's edge and its contents.
pub(super) const PAD: f32 = 14.0;

/// A tick label.
pub(super) fn tick_text(x: f32, y: f32, label: String, anchor: Anchor) -> Item {
    Item::Text(
        Text::new(x, y, TICK, label)
            .anchor(anchor)
            .colour(Colour::Muted),
    )
}

/// An axis label about (x, y), made smaller where it would be longer than `room`.
pub(super) fn label_text(x: f32, y: f32, label: &str, room: f32, upwards: bool) -> Item {
    let natural = font::width(label, LABEL);
    let size = if natural > room {
        (LABEL * room / natural).max(LEAST_LABEL)
    } else {
        LABEL
    };
    Item::Text(Text {
        upwards,
        ..Text::new(x, y, size, label).anchor(Anchor::Middle)
    })
}

/// Breaks `text` at blanks into lines of at most `room` pixels.
pub(super) fn wrap(text: &str, size: f32, room: f32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(last) if font::width(&format!("{last} {word}"), size) <= room => {
                last.push(' ');
                last.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
