//! The frame of a plot: title, axes with ticks and labels, legend, colour bar.

use super::colour::{Colour, Palette};
use super::drawing::{
    Anchor, DEFAULT_SCALE, Drawing, Item, Rect, Stroke, Text, line, rectangle, snap,
};
use super::font;
use super::legend::{self, Entry};
use super::ticks::{self, Tick};

/// How values are spread along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AxisScale {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm; values at or below zero are left out.
    Log,
}

/// An axis: what it shows, in which unit, and over which range.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The quantity.
    pub label: String,
    /// Its unit; may be empty for pure numbers.
    pub unit: String,
    /// Linear or logarithmic.
    pub scale: AxisScale,
    /// Lowest and highest value shown; taken from the data where not given.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// A linear axis over the range of its data.
    #[must_use]
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            unit: unit.into(),
            scale: AxisScale::Linear,
            range: None,
        }
    }

    /// The same axis, logarithmic.
    #[must_use]
    pub fn log(self) -> Self {
        Self {
            scale: AxisScale::Log,
            ..self
        }
    }

    /// The same axis, over `[low, high]`.
    #[must_use]
    pub fn range(self, low: f64, high: f64) -> Self {
        Self {
            range: Some([low, high]),
            ..self
        }
    }

    fn title(&self) -> String {
        if self.unit.is_empty() {
            self.label.clone()
        } else {
            format!("{} ({})", self.label, self.unit)
        }
    }

    /// The range to show: as stated, else that of `values`, widened by `pad` of itself; never
    /// empty.
    pub(super) fn resolve(&self, values: impl Iterator<Item = f64>, pad: f64) -> [f64; 2] {
        let log = self.scale == AxisScale::Log;
        let usable = |v: f64| v.is_finite() && (!log || v > 0.0);
        if let Some([low, high]) = self.range
            && usable(low)
            && usable(high)
            && low != high
        {
            return [low.min(high), low.max(high)];
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|v| usable(*v)) {
            low = low.min(value);
            high = high.max(value);
        }
        if low > high {
            return if log { [0.1, 10.0] } else { [0.0, 1.0] };
        }
        if log {
            let ratio = (high / low)
                .powf(pad)
                .max(if high > low { 1.0 } else { 2.0 });
            return [low / ratio, high * ratio];
        }
        // A constant is shown in the middle of a range wide enough to be labelled.
        let room = if high - low > 1e-12 * high.abs().max(low.abs()) {
            pad * (high - low)
        } else {
            (0.1 * high.abs()).max(0.5)
        };
        [low - room, high + room]
    }
}

/// How large the plot is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Size {
    /// The whole figure's width, and the plot's own height.
    Free { width: f32, plot_height: f32 },
    /// The whole figure's greatest width and the plot's greatest height; one unit of x is as long
    /// as one of y.
    Equal { width: f32, plot_height: f32 },
}

/// The scale of colours at the right of a plot.
#[derive(Clone, Debug)]
pub(super) struct ColourBar {
    pub title: String,
    pub palette: Palette,
    pub range: [f64; 2],
    pub log: bool,
}

/// Ticks along the upper edge, at positions of the x axis.
#[derive(Clone, Debug)]
pub(super) struct TopAxis {
    pub title: String,
    pub ticks: Vec<Tick>,
}

pub(super) struct FrameSpec<'a> {
    pub title: &'a str,
    pub x: &'a Axis,
    pub y: &'a Axis,
    pub x_range: [f64; 2],
    pub y_range: [f64; 2],
    pub y_downwards: bool,
    pub size: Size,
    pub legend: &'a [Entry],
    pub colour_bar: Option<ColourBar>,
    pub top: Option<TopAxis>,
    /// Names in place of numbers along y.
    pub y_names: Option<Vec<Tick>>,
}

/// A laid-out frame: the plot's place and the ways from values to pixels.
pub(super) struct Frame {
    pub plot: Rect,
    width: f32,
    height: f32,
    /// Above everything: texts, ticks, border.
    over: Vec<Item>,
    grid: Vec<Item>,
    title: String,
    x: Way,
    y: Way,
}

/// The way from a value to a pixel along one axis.
#[derive(Clone, Copy)]
struct Way {
    from: [f64; 2],
    to: [f32; 2],
    log: bool,
}

impl Way {
    fn at(&self, value: f64) -> f32 {
        let fraction = if self.log {
            (value / self.from[0]).ln() / (self.from[1] / self.from[0]).ln()
        } else {
            (value - self.from[0]) / (self.from[1] - self.from[0])
        };
        // Far outside is as good as just outside, and keeps the rasteriser's numbers small.
        let fraction = fraction.clamp(-20.0, 21.0);
        self.to[0] + fraction as f32 * (self.to[1] - self.to[0])
    }
}

const TICK: f32 = 12.0;
const LABEL: f32 = 13.0;
const TITLE: f32 = 15.0;
const PAD: f32 = 14.0;
const BAR: f32 = 14.0;

impl Frame {
    pub fn new(spec: &FrameSpec<'_>) -> Self {
        let (Size::Free { width, plot_height } | Size::Equal { width, plot_height }) = spec.size;
        let x_log = spec.x.scale == AxisScale::Log;
        let y_log = spec.y.scale == AxisScale::Log;
        let y_ticks = |height: f32| match &spec.y_names {
            Some(names) => names.clone(),
            None => tick_set(y_log, spec.y_range, height, false),
        };
        let bar_ticks = |height: f32| {
            spec.colour_bar
                .as_ref()
                .map(|bar| tick_set(bar.log, bar.range, height, false))
        };

        // Margins from the widest labels that the greatest height can bring.
        let label = if spec.y.label.is_empty() {
            0.0
        } else {
            LABEL + 8.0
        };
        let left = PAD + label + widest(&y_ticks(plot_height)) + 9.0;
        let right = match bar_ticks(plot_height) {
            Some(ticks) => 14.0 + BAR + 8.0 + widest(&ticks) + 8.0 + LABEL + PAD,
            None => PAD + 10.0,
        };
        let room = (width - left - right).max(60.0);
        let (plot_width, plot_height) = match spec.size {
            Size::Free { .. } => (room, plot_height),
            Size::Equal { .. } => {
                let across = spec.x_range[1] - spec.x_range[0];
                let down = spec.y_range[1] - spec.y_range[0];
                let per_unit = (f64::from(room) / across).min(f64::from(plot_height) / down);
                ((per_unit * across) as f32, (per_unit * down) as f32)
            }
        };
        let (plot_width, plot_height) = (
            plot_width.round().max(MIN_PLOT),
            plot_height.round().max(MIN_PLOT),
        );
        let width = if matches!(spec.size, Size::Equal { .. }) {
            (left + plot_width + right).max(300.0)
        } else {
            width
        };
        let left = left.ceil();

        let mut over = Vec::new();
        let mut top = PAD;
        let title_lines = wrap(spec.title, TITLE, width - left - PAD);
        for text in &title_lines {
            over.push(Item::Text(Text::new(left, top + TITLE, TITLE, text)));
            top += TITLE + 6.0;
        }
        if !title_lines.is_empty() {
            top += 4.0;
        }
        let (legend, legend_height) = legend::lay_out(spec.legend, left, top, width - left - PAD);
        over.extend(legend);
        top += legend_height;
        if spec.top.is_some() {
            top += LABEL + TICK + 16.0;
        } else {
            top += 4.0;
        }
        let plot = Rect {
            x: left,
            y: top.ceil(),
            width: plot_width,
            height: plot_height,
        };
        let x = Way {
            from: spec.x_range,
            to: [plot.x, plot.right()],
            log: x_log,
        };
        let y_ends = if spec.y_downwards {
            [plot.y, plot.bottom()]
        } else {
            [plot.bottom(), plot.y]
        };
        let y = Way {
            from: spec.y_range,
            to: y_ends,
            log: y_log,
        };

        let mut grid = Vec::new();
        let hair = Stroke::new(Colour::Grid, 1.0);
        let tick_stroke = Stroke::new(Colour::Muted, 1.0);
        for tick in tick_set(x_log, spec.x_range, plot.width, true) {
            let at = snap(x.at(tick.value).min(plot.right() - 0.5));
            grid.push(line(vec![(at, plot.y), (at, plot.bottom())], hair));
            over.push(line(
                vec![(at, plot.bottom()), (at, plot.bottom() + 5.0)],
                tick_stroke,
            ));
            over.push(tick_text(
                at,
                plot.bottom() + 8.0 + TICK,
                tick.label,
                Anchor::Middle,
            ));
        }
        for tick in y_ticks(plot.height) {
            let at = snap(y.at(tick.value).min(plot.bottom() - 0.5));
            grid.push(line(vec![(plot.x, at), (plot.right(), at)], hair));
            over.push(line(vec![(plot.x - 5.0, at), (plot.x, at)], tick_stroke));
            over.push(tick_text(
                plot.x - 8.0,
                at + 0.36 * TICK,
                tick.label,
                Anchor::End,
            ));
        }
        if let Some(axis) = &spec.top {
            for tick in &axis.ticks {
                let at = snap(x.at(tick.value).min(plot.right() - 0.5));
                over.push(line(vec![(at, plot.y - 5.0), (at, plot.y)], tick_stroke));
                over.push(tick_text(
                    at,
                    plot.y - 9.0,
                    tick.label.clone(),
                    Anchor::Middle,
                ));
            }
            over.push(label_text(
                plot.x + plot.width / 2.0,
                plot.y - 13.0 - TICK,
                &axis.title,
                plot.width,
                false,
            ));
        }
        over.push(rectangle(
            Rect {
                x: plot.x - 0.5,
                y: plot.y - 0.5,
                width: plot.width + 1.0,
                height: plot.height + 1.0,
            },
            None,
            Some(Stroke::new(Colour::Muted, 1.0)),
        ));

        let label_y = plot.bottom() + 8.0 + TICK + 8.0 + LABEL;
        let middle_x = plot.x + plot.width / 2.0;
        over.push(label_text(
            middle_x,
            label_y,
            &spec.x.title(),
            width - 2.0 * PAD,
            false,
        ));
        let middle_y = plot.y + plot.height / 2.0;
        let tall = plot.height + 40.0;
        over.push(label_text(
            PAD + 0.8 * LABEL,
            middle_y,
            &spec.y.title(),
            tall,
            true,
        ));
        if let Some(bar) = &spec.colour_bar {
            let ticks = bar_ticks(plot.height).unwrap_or_default();
            over.extend(colour_bar(bar, &plot, ticks, width));
        }
        let height = label_y + 0.4 * LABEL + PAD;
        Self {
            plot,
            width,
            height,
            over,
            grid,
            title: spec.title.to_owned(),
            x,
            y,
        }
    }

    /// The pixel of a point; none where a coordinate has no place on its axis.
    pub fn at(&self, x: f64, y: f64) -> Option<(f32, f32)> {
        let (x, y) = (self.x.at(x), self.y.at(y));
        (x.is_finite() && y.is_finite()).then_some((x, y))
    }

    /// Puts the contents into the frame: `ground` lies under the grid lines, `inside` is clipped to
    /// the plot, `above` may reach out of it.
    pub fn finish(
        self,
        ground: Vec<Item>,
        grid: bool,
        inside: Vec<Item>,
        above: Vec<Item>,
    ) -> Drawing {
        let mut items = ground;
        if grid {
            items.extend(self.grid);
        }
        if !inside.is_empty() {
            items.push(Item::Clip {
                rect: self.plot,
                items: inside,
            });
        }
        items.extend(self.over);
        items.extend(above);
        Drawing {
            width_px: self.width.ceil() as u32,
            height_px: self.height.ceil() as u32,
            scale: DEFAULT_SCALE,
            description: self.title,
            items,
        }
    }
}

/// Least width and height of a plot: thinner equal-aspect plots are stretched to it.
const MIN_PLOT: f32 = 40.0;

fn tick_set(log: bool, range: [f64; 2], length: f32, across: bool) -> Vec<Tick> {
    if log {
        ticks::logarithmic(range[0], range[1], length, TICK, across)
    } else {
        ticks::linear(range[0], range[1], length, TICK, across)
    }
}

fn widest(ticks: &[Tick]) -> f32 {
    ticks
        .iter()
        .map(|t| font::width(&t.label, TICK))
        .fold(8.0, f32::max)
}

fn tick_text(x: f32, y: f32, label: String, anchor: Anchor) -> Item {
    Item::Text(
        Text::new(x, y, TICK, label)
            .anchor(anchor)
            .colour(Colour::Muted),
    )
}

/// An axis label about (x, y), made smaller where it would be longer than `room`.
fn label_text(x: f32, y: f32, label: &str, room: f32, upwards: bool) -> Item {
    let natural = font::width(label, LABEL);
    let size = if natural > room {
        (LABEL * room / natural).max(9.0)
    } else {
        LABEL
    };
    Item::Text(Text {
        upwards,
        ..Text::new(x, y, size, label).anchor(Anchor::Middle)
    })
}

/// Breaks `text` at blanks into lines of at most `room` pixels.
fn wrap(text: &str, size: f32, room: f32) -> Vec<String> {
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

fn colour_bar(bar: &ColourBar, plot: &Rect, ticks: Vec<Tick>, width: f32) -> Vec<Item> {
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
        rectangle(
            Rect {
                x: rect.x - 0.5,
                y: rect.y - 0.5,
                width: rect.width + 1.0,
                height: rect.height + 1.0,
            },
            None,
            Some(Stroke::new(Colour::Muted, 1.0)),
        ),
    ];
    let way = Way {
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
