//! The frame of a plot: title, axes with ticks and labels, legend, colour bar.

use super::axis::{Axis, AxisScale};
use super::colour::Colour;
use super::colour_bar::{BAR, ColourBar, colour_bar};
use super::drawing::{
    Anchor, DEFAULT_SCALE, Drawing, Item, Rect, Stroke, Text, line, rectangle, snap,
};
use super::font;
use super::label::{LABEL, PAD, TICK, TITLE, label_text, tick_text, wrap};
use super::legend::{self, Entry};
use super::scale::Scale;
use super::ticks::{self, Tick};

/// How large the plot is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Size {
    /// The whole figure's width, and the height of its plot.
    Free { width: f32, plot_height: f32 },
    /// The whole figure's greatest width and the plot's greatest height; one unit of x is as long
    /// as one of y.
    Equal { width: f32, plot_height: f32 },
}

impl Size {
    /// Greatest width of the figure and height of its plot.
    fn greatest(self) -> (f32, f32) {
        let (Self::Free { width, plot_height } | Self::Equal { width, plot_height }) = self;
        (width, plot_height)
    }
}

/// A second scale along the upper or the right edge: its ticks are at positions of the x or the y axis.
#[derive(Clone, Debug)]
pub(super) struct SecondAxis {
    pub title: String,
    pub ticks: Vec<Tick>,
}

impl SecondAxis {
    /// Room that the axis takes to the right of the plot.
    fn width(&self) -> f32 {
        9.0 + widest(&self.ticks) + 6.0 + LABEL
    }
}

/// Input of a frame's layout.
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
    pub top: Option<SecondAxis>,
    pub right: Option<SecondAxis>,
    /// Names in place of numbers along y.
    pub y_names: Option<Vec<Tick>>,
    pub stacking: Stacking,
}

impl<'a> FrameSpec<'a> {
    /// A frame with y upwards, and neither title, legend nor colour bar.
    pub fn new([x, y]: [&'a Axis; 2], x_range: [f64; 2], y_range: [f64; 2], size: Size) -> Self {
        Self {
            title: "",
            x,
            y,
            x_range,
            y_range,
            y_downwards: false,
            size,
            legend: &[],
            colour_bar: None,
            top: None,
            right: None,
            y_names: None,
            stacking: Stacking::default(),
        }
    }

    fn y_ticks(&self, height: f32) -> Vec<Tick> {
        match &self.y_names {
            Some(names) => names.clone(),
            None => tick_set(self.y, self.y_range, height, false),
        }
    }

    fn bar_ticks(&self, height: f32) -> Option<Vec<Tick>> {
        let bar = self.colour_bar.as_ref()?;
        Some(tick_set(&bar.axis(), bar.range, height, false))
    }

    /// Room at the left and right of the plot, from the widest labels that `height` can bring.
    fn margins(&self, height: f32) -> [f32; 2] {
        let label = if self.y.label.is_empty() {
            0.0
        } else {
            LABEL + 8.0
        };
        let left = PAD + label + widest(&self.y_ticks(height)) + 9.0;
        let right = match self.bar_ticks(height) {
            Some(ticks) => 14.0 + BAR + 8.0 + widest(&ticks) + 8.0 + LABEL + PAD,
            None => PAD + 10.0,
        };
        let second = self.right.as_ref().map_or(0.0, SecondAxis::width);
        [left.max(self.stacking.least_left), second + right]
    }

    /// Width and height of the plot, in whole pixels.
    fn plot_size(&self, [left, right]: [f32; 2]) -> (f32, f32) {
        let (width, height) = self.size.greatest();
        let room = (width - left - right).max(60.0);
        let (wide, high) = match self.size {
            Size::Free { .. } => (room, height),
            Size::Equal { .. } => {
                let across = self.x_range[1] - self.x_range[0];
                let down = self.y_range[1] - self.y_range[0];
                let per_unit = (f64::from(room) / across).min(f64::from(height) / down);
                ((per_unit * across) as f32, (per_unit * down) as f32)
            }
        };
        (wide.round().max(MIN_PLOT), high.round().max(MIN_PLOT))
    }
}

/// Layout of a frame stacked above other frames with the same x axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stacking {
    /// Least room at the left of the plot, so that stacked plots align.
    pub least_left: f32,
    /// Whether ticks and name of the x axis are left to the frame below.
    pub without_x_labels: bool,
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
    x: Scale,
    y: Scale,
}

impl Frame {
    pub fn new(spec: &FrameSpec<'_>) -> Self {
        let (greatest_width, greatest_height) = spec.size.greatest();
        let margins = spec.margins(greatest_height);
        let (plot_width, plot_height) = spec.plot_size(margins);
        let left = margins[0].ceil();
        let width = match spec.size {
            Size::Equal { .. } => (margins[0] + plot_width + margins[1]).max(300.0),
            Size::Free { .. } => greatest_width,
        };
        let (mut over, top) = headline(spec, left, width);
        let plot = Rect {
            x: left,
            y: top.ceil(),
            width: plot_width,
            height: plot_height,
        };
        let y_ends = if spec.y_downwards {
            [plot.y, plot.bottom()]
        } else {
            [plot.bottom(), plot.y]
        };
        let mut frame = Self {
            plot,
            width,
            height: 0.0,
            over: Vec::new(),
            grid: Vec::new(),
            title: spec.title.to_owned(),
            x: Scale {
                from: spec.x_range,
                to: [plot.x, plot.right()],
                log: spec.x.scale == AxisScale::Log,
            },
            y: Scale {
                from: spec.y_range,
                to: y_ends,
                log: spec.y.scale == AxisScale::Log,
            },
        };
        frame.over.append(&mut over);
        frame.x_ticks(spec);
        frame.y_ticks(spec);
        if let Some(axis) = &spec.top {
            frame.top_ticks(axis);
        }
        let mut beside = plot;
        if let Some(axis) = &spec.right {
            frame.right_ticks(axis);
            beside.width += axis.width();
        }
        frame.over.push(rectangle(
            plot.grown(0.5),
            None,
            Some(Stroke::new(Colour::Muted, 1.0)),
        ));
        frame.height = frame.axis_labels(spec);
        if let Some(bar) = &spec.colour_bar {
            if !bar.has_room_for_title(plot.height) {
                frame.bar_title_below(bar);
            }
            let ticks = spec.bar_ticks(plot.height).unwrap_or_default();
            frame.over.extend(colour_bar(bar, &beside, ticks, width));
        }
        frame
    }

    fn x_ticks(&mut self, spec: &FrameSpec<'_>) {
        let plot = self.plot;
        for tick in tick_set(spec.x, spec.x_range, plot.width, true) {
            let at = snap(self.x.at(tick.value).min(plot.right() - 0.5));
            self.grid
                .push(line(vec![(at, plot.y), (at, plot.bottom())], hairline()));
            if spec.stacking.without_x_labels {
                continue;
            }
            let mark = vec![(at, plot.bottom()), (at, plot.bottom() + 5.0)];
            self.over.push(line(mark, tick_stroke()));
            let below = plot.bottom() + 8.0 + TICK;
            self.over
                .push(tick_text(at, below, tick.label, Anchor::Middle));
        }
    }

    fn y_ticks(&mut self, spec: &FrameSpec<'_>) {
        let plot = self.plot;
        for tick in spec.y_ticks(plot.height) {
            let at = snap(self.y.at(tick.value).min(plot.bottom() - 0.5));
            self.grid
                .push(line(vec![(plot.x, at), (plot.right(), at)], hairline()));
            let mark = vec![(plot.x - 5.0, at), (plot.x, at)];
            self.over.push(line(mark, tick_stroke()));
            let baseline = at + 0.36 * TICK;
            self.over
                .push(tick_text(plot.x - 8.0, baseline, tick.label, Anchor::End));
        }
    }

    fn top_ticks(&mut self, axis: &SecondAxis) {
        let plot = self.plot;
        for tick in &axis.ticks {
            let at = snap(self.x.at(tick.value).min(plot.right() - 0.5));
            let mark = vec![(at, plot.y - 5.0), (at, plot.y)];
            self.over.push(line(mark, tick_stroke()));
            let label = tick.label.clone();
            self.over
                .push(tick_text(at, plot.y - 9.0, label, Anchor::Middle));
        }
        let (middle, baseline) = (plot.x + plot.width / 2.0, plot.y - 13.0 - TICK);
        let title = label_text(middle, baseline, &axis.title, plot.width, false);
        self.over.push(title);
    }

    fn right_ticks(&mut self, axis: &SecondAxis) {
        let plot = self.plot;
        for tick in &axis.ticks {
            let at = snap(self.y.at(tick.value).min(plot.bottom() - 0.5));
            let mark = vec![(plot.right(), at), (plot.right() + 5.0, at)];
            self.over.push(line(mark, tick_stroke()));
            let (x, baseline) = (plot.right() + 8.0, at + 0.36 * TICK);
            let label = tick.label.clone();
            self.over.push(tick_text(x, baseline, label, Anchor::Start));
        }
        let (x, middle) = (plot.right() + axis.width(), plot.y + plot.height / 2.0);
        self.over
            .push(label_text(x, middle, &axis.title, plot.height, true));
    }

    /// Names the axes; returns the height of the figure.
    fn axis_labels(&mut self, spec: &FrameSpec<'_>) -> f32 {
        let plot = self.plot;
        let middle_y = plot.y + plot.height / 2.0;
        let tall = plot.height + 40.0;
        let left = PAD + 0.8 * LABEL;
        self.over
            .push(label_text(left, middle_y, &spec.y.title(), tall, true));
        if spec.stacking.without_x_labels {
            return plot.bottom() + 0.5 * PAD;
        }
        let baseline = plot.bottom() + 8.0 + TICK + 8.0 + LABEL;
        let middle_x = plot.x + plot.width / 2.0;
        let room = self.width - 2.0 * PAD;
        self.over
            .push(label_text(middle_x, baseline, &spec.x.title(), room, false));
        baseline + 0.4 * LABEL + PAD
    }

    /// The caption of the colour bar under everything else.
    fn bar_title_below(&mut self, bar: &ColourBar) {
        for text in bar.title_lines(self.width - self.plot.x - PAD) {
            let baseline = self.height - PAD + TICK;
            let line = Text::new(self.plot.x, baseline, TICK, text);
            self.over.push(Item::Text(line));
            self.height += TICK + 4.0;
        }
    }

    /// The pixel of a point; none where a coordinate has no place on its axis.
    pub fn at(&self, x: f64, y: f64) -> Option<(f32, f32)> {
        let (x, y) = (self.x.at(x), self.y.at(y));
        (x.is_finite() && y.is_finite()).then_some((x, y))
    }

    /// Adds the contents to the frame: `ground` lies under the grid lines, `inside` is clipped to the plot,
    /// `above` may extend beyond it.
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

/// Title and legend above the plot, and the height that they take.
fn headline(spec: &FrameSpec<'_>, left: f32, width: f32) -> (Vec<Item>, f32) {
    let room = width - left - PAD;
    let mut items = Vec::new();
    let mut top = PAD;
    let lines = wrap(spec.title, TITLE, room);
    for text in &lines {
        items.push(Item::Text(Text::new(left, top + TITLE, TITLE, text)));
        top += TITLE + 6.0;
    }
    if !lines.is_empty() {
        top += 4.0;
    }
    let (legend, legend_height) = legend::lay_out(spec.legend, left, top, room);
    items.extend(legend);
    top += legend_height;
    top += if spec.top.is_some() {
        LABEL + TICK + 16.0
    } else {
        4.0
    };
    (items, top)
}

fn hairline() -> Stroke {
    Stroke::new(Colour::Grid, 1.0)
}

fn tick_stroke() -> Stroke {
    Stroke::new(Colour::Muted, 1.0)
}

fn tick_set(axis: &Axis, range: [f64; 2], length: f32, across: bool) -> Vec<Tick> {
    if axis.scale == AxisScale::Log {
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
