//! The colour bar at the right of a plot.

use super::axis::Axis;
use super::colour::{Colour, Palette};
use super::drawing::{Anchor, DEFAULT_SCALE, Item, Rect, Stroke, line, rectangle, snap};
use super::label::{PAD, TICK, label_text, tick_text};
use super::scale::Scale;
use super::ticks::Tick;

/// The scale of colours at the right of a plot.
#[derive(Clone, Debug)]
pub(super) struct ColourBar {
    pub title: String,
    pub palette: Palette,
    pub range: [f64; 2],
    pub log: bool,
}

impl ColourBar {
    /// The bar's scale as an axis.
    pub fn axis(&self) -> Axis {
        let axis = Axis::new("", "");
        if self.log { axis.log() } else { axis }
    }
}

/// Width of the bar in CSS pixels.
pub(super) const BAR: f32 = 14.0;

/// Lays out `bar` to the right of `plot`, within a figure of `width` CSS pixels.
pub(super) fn colour_bar(bar: &ColourBar, plot: &Rect, ticks: Vec<Tick>, width: f32) -> Vec<Item> {
    let rect = Rect {
        x: plot.right() + 14.0,
        y: plot.y,
        width: BAR,
        height: plot.height,
    };
    let rows = (rect.height as usize).max(2) * DEFAULT_SCALE as usize;
    let rgb = (0..rows)
        .flat_map(|row| bar.palette.at(1.0 - (row as f64 + 0.5) / rows as f64))
        .collect();
    let mut items = vec![
        Item::Raster {
            rect,
            columns: 1,
            rows,
            rgb,
        },
        rectangle(rect.grown(0.5), None, Some(Stroke::new(Colour::Muted, 1.0))),
    ];
    let way = Scale {
        from: bar.range,
        to: [rect.bottom(), rect.y],
        log: bar.log,
    };
    for tick in ticks {
        let at = snap(way.at(tick.value).min(rect.bottom() - 0.5));
        let mark = vec![(rect.right() + 0.5, at), (rect.right() + 5.0, at)];
        items.push(line(mark, Stroke::new(Colour::Muted, 1.0)));
        items.push(tick_text(
            rect.right() + 8.0,
            at + 0.36 * TICK,
            tick.label,
            Anchor::Start,
        ));
    }
    let middle = plot.y + plot.height / 2.0;
    let title_x = (width - PAD).min(rect.right() + 120.0);
    items.push(label_text(
        title_x,
        middle,
        &bar.title,
        plot.height + 40.0,
        true,
    ));
    items
}
