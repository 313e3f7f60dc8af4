//! The colour bar at the right of a plot.

use super::axis::{Axis, AxisScale};
use super::colour::{Colour, Palette};
use super::drawing::{Anchor, DEFAULT_SCALE, Drawing, Item, Rect, Stroke, line, rectangle, snap};
use super::font;
use super::label::{LABEL, LEAST_LABEL, PAD, TICK, label_text, tick_text, wrap};
use super::scale::Scale;
use super::ticks::{self, Tick};

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

/// Largest excess of a caption along the bar over the bar's length, above and below together.
const BEYOND: f32 = 40.0;

impl ColourBar {
    /// Whether the caption has room along a plot of `height` CSS pixels; under the plot it has its place otherwise.
    pub fn has_room_for_title(&self, height: f32) -> bool {
        LEAST_LABEL / LABEL * font::width(&self.title, LABEL) <= height + BEYOND
    }

    /// The caption in lines of at most `room` CSS pixels, for under the plot.
    pub fn title_lines(&self, room: f32) -> Vec<String> {
        wrap(&format!("Colours: {}", self.title), TICK, room)
    }
}

/// Lays out `bar` to the right of `plot`, within a figure of `width` CSS pixels, with its caption where the
/// caption fits.
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
    if !bar.has_room_for_title(plot.height) {
        return items;
    }
    let middle = plot.y + plot.height / 2.0;
    let title_x = (width - PAD).min(rect.right() + 120.0);
    items.push(label_text(
        title_x,
        middle,
        &bar.title,
        plot.height + BEYOND,
        true,
    ));
    items
}

/// The bar as a separate figure, `height` CSS pixels long.
pub(super) fn alone(bar: &ColourBar, height: f32) -> Drawing {
    let axis = bar.axis();
    let ticks = match axis.scale {
        AxisScale::Log => ticks::logarithmic(bar.range[0], bar.range[1], height, TICK, false),
        AxisScale::Linear => ticks::linear(bar.range[0], bar.range[1], height, TICK, false),
    };
    let labels = ticks.iter().map(|tick| font::width(&tick.label, TICK));
    let width = PAD + BAR + 8.0 + labels.fold(8.0, f32::max) + 8.0 + LABEL + PAD;
    // The bar lies 14 pixels to the right of a plot.
    let plot = Rect {
        x: PAD - 14.0,
        y: 0.5 * BEYOND,
        width: 0.0,
        height,
    };
    Drawing {
        width_px: width.ceil() as u32,
        height_px: (height + BEYOND).ceil() as u32,
        scale: DEFAULT_SCALE,
        description: bar.title.clone(),
        items: colour_bar(bar, &plot, ticks, width),
    }
}
