//! Line plots: several series over one pair of axes.

use super::colour::Colour;
use super::drawing::{
    Anchor, Drawing, Fill, Item, Rect, Stroke, Text, line, polygon, rectangle, snap,
};
use super::error::{FigureError, check_len};
use super::frame::{Axis, Frame, FrameSpec, Size};
use super::image_db::thin;
use super::legend::{Entry, Marker, Sample, mark};

/// One series of a line plot.
#[derive(Clone, Debug)]
pub struct Series<'a> {
    /// Its name in the legend; a series without a name is not listed.
    pub label: String,
    /// Abscissae.
    pub x: &'a [f64],
    /// Ordinates, one per abscissa; NaN breaks the line.
    pub y: &'a [f64],
    /// Half-widths of a band about `y` (for ±1σ), one per point; may be empty.
    pub half_width: &'a [f64],
    /// Whether points are joined by a line.
    pub joined: bool,
    /// Radius of the dot on each point in CSS pixels; none where zero.
    pub dot_px: f32,
    /// Width of the line in CSS pixels.
    pub line_px: f32,
    /// Whether the line is dashed.
    pub dashed: bool,
    /// Its colour; by its place in the plot where not given.
    pub colour: Option<Colour>,
}

impl<'a> Series<'a> {
    /// A joined line.
    #[must_use]
    pub fn line(label: impl Into<String>, x: &'a [f64], y: &'a [f64]) -> Self {
        Self {
            label: label.into(),
            x,
            y,
            half_width: &[],
            joined: true,
            dot_px: 0.0,
            line_px: 1.7,
            dashed: false,
            colour: None,
        }
    }

    /// Dots that are not joined.
    #[must_use]
    pub fn dots(label: impl Into<String>, x: &'a [f64], y: &'a [f64]) -> Self {
        Self {
            joined: false,
            dot_px: 2.2,
            ..Self::line(label, x, y)
        }
    }

    /// The same series with a shaded band of `half_width` about it.
    #[must_use]
    pub fn band(self, half_width: &'a [f64]) -> Self {
        Self { half_width, ..self }
    }

    /// The same series, dashed.
    #[must_use]
    pub fn dashed(self) -> Self {
        Self {
            dashed: true,
            ..self
        }
    }

    /// The same series in `colour`.
    #[must_use]
    pub fn colour(self, colour: Colour) -> Self {
        Self {
            colour: Some(colour),
            ..self
        }
    }
}

/// A stretch of the x axis that is shaded.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Where it begins and ends.
    pub x: [f64; 2],
    /// Its colour.
    pub colour: Colour,
    /// Its name in the legend; equal names are listed once, empty ones not at all.
    pub label: String,
}

/// A straight line across the plot at one value.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceLine {
    /// Whether it stands at an x value (upright) or a y value (level).
    pub at_x: bool,
    /// The value.
    pub value: f64,
    /// What stands beside it; may be empty.
    pub label: String,
}

/// Several series over one pair of axes.
#[derive(Clone, Debug)]
pub struct LinePlot<'a> {
    /// Title above the plot; may be empty.
    pub title: String,
    /// The abscissa.
    pub x: Axis,
    /// The ordinate.
    pub y: Axis,
    /// The series, the first drawn first.
    pub series: Vec<Series<'a>>,
    /// Shaded stretches under the series.
    pub spans: Vec<Span>,
    /// Lines across the plot.
    pub references: Vec<ReferenceLine>,
    /// Whether one unit of x is as long as one of y (plans of tracks).
    pub equal_aspect: bool,
    /// Width of the figure in CSS pixels.
    pub width_px: f32,
    /// Height of the plot in CSS pixels.
    pub plot_height_px: f32,
}

impl<'a> LinePlot<'a> {
    /// An empty plot.
    #[must_use]
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            series: Vec::new(),
            spans: Vec::new(),
            references: Vec::new(),
            equal_aspect: false,
            width_px: 860.0,
            plot_height_px: 280.0,
        }
    }

    /// The same plot with one more series.
    #[must_use]
    pub fn with(mut self, series: Series<'a>) -> Self {
        self.series.push(series);
        self
    }

    /// The same plot with one more shaded stretch.
    #[must_use]
    pub fn span(mut self, span: Span) -> Self {
        self.spans.push(span);
        self
    }

    /// The same plot with one more line across it.
    #[must_use]
    pub fn reference(mut self, reference: ReferenceLine) -> Self {
        self.references.push(reference);
        self
    }

    /// The same plot with another height of its plot area.
    #[must_use]
    pub fn height(self, plot_height_px: f32) -> Self {
        Self {
            plot_height_px,
            ..self
        }
    }

    /// The same plot, one unit of x as long as one of y.
    #[must_use]
    pub fn equal(self) -> Self {
        Self {
            equal_aspect: true,
            ..self
        }
    }

    /// Lays the figure out. Points that are not finite are left out; a plot without any point is
    /// an empty frame.
    ///
    /// # Errors
    /// [`FigureError::ShapeMismatch`] where the arrays of a series differ in length.
    pub fn draw(&self) -> Result<Drawing, FigureError> {
        for series in &self.series {
            check_len("series ordinates", series.x.len(), series.y.len())?;
            if !series.half_width.is_empty() {
                check_len("series band", series.x.len(), series.half_width.len())?;
            }
        }
        let xs = self.series.iter().flat_map(|s| s.x.iter().copied());
        let spans = self.spans.iter().flat_map(|span| span.x);
        let lines = |at_x: bool| {
            self.references
                .iter()
                .filter(move |r| r.at_x == at_x)
                .map(|r| r.value)
        };
        let x_pad = if self.equal_aspect { 0.05 } else { 0.0 };
        let x_range = self.x.resolve(xs.chain(spans).chain(lines(true)), x_pad);
        let ys = self.series.iter().flat_map(|s| {
            // The range follows the points that can be seen, with their bands.
            let seen = move |i: &usize| s.x[*i] >= x_range[0] && s.x[*i] <= x_range[1];
            (0..s.y.len()).filter(seen).flat_map(|i| {
                let half = s
                    .half_width
                    .get(i)
                    .copied()
                    .filter(|h| h.is_finite())
                    .unwrap_or(0.0);
                [s.y[i] - half, s.y[i] + half]
            })
        });
        let y_range = self.y.resolve(ys.chain(lines(false)), 0.06);
        let (x_range, y_range) = if self.equal_aspect {
            widen(x_range, y_range)
        } else {
            (x_range, y_range)
        };
        let size = if self.equal_aspect {
            Size::Equal {
                width: self.width_px,
                plot_height: self.plot_height_px,
            }
        } else {
            Size::Free {
                width: self.width_px,
                plot_height: self.plot_height_px,
            }
        };
        let frame = Frame::new(&FrameSpec {
            title: &self.title,
            x: &self.x,
            y: &self.y,
            x_range,
            y_range,
            y_downwards: false,
            size,
            legend: &self.legend(),
            colour_bar: None,
            top: None,
            y_names: None,
        });

        let plot = frame.plot;
        let ground = self
            .spans
            .iter()
            .filter_map(|span| shade(&frame, span, y_range))
            .collect();
        let mut inside = Vec::new();
        let mut above = Vec::new();
        for reference in &self.references {
            draw_reference(
                &frame,
                reference,
                [x_range[0], y_range[0]],
                &mut inside,
                &mut above,
            );
        }
        for (index, series) in self.series.iter().enumerate() {
            draw_series(&frame, plot, series, colour_of(series, index), &mut inside);
        }
        Ok(frame.finish(ground, true, inside, above))
    }

    fn legend(&self) -> Vec<Entry> {
        let mut entries = Vec::new();
        for (index, series) in self.series.iter().enumerate() {
            if series.label.is_empty() {
                continue;
            }
            let colour = colour_of(series, index);
            let sample = if !series.joined {
                Sample::Mark(Marker::Dot, colour)
            } else if series.half_width.is_empty() {
                Sample::Line(stroke_of(series, colour))
            } else {
                Sample::LineAndBand(stroke_of(series, colour), band_fill(colour))
            };
            entries.push(Entry {
                label: series.label.clone(),
                sample,
                ground: None,
            });
        }
        for span in &self.spans {
            if span.label.is_empty() || entries.iter().any(|e: &Entry| e.label == span.label) {
                continue;
            }
            let sample = Sample::Patch(span_fill(span.colour));
            entries.push(Entry {
                label: span.label.clone(),
                sample,
                ground: None,
            });
        }
        entries
    }
}

/// A cut through an image peak in decibels, down to `floor_db`, with the −3 and −6 dB levels.
///
/// Each item of `cuts` is a name, the distances from the peak in metres, and the levels in dB.
#[must_use]
pub fn cut_plot<'a>(
    title: impl Into<String>,
    cuts: &[(&str, &'a [f64], &'a [f64])],
    floor_db: f64,
) -> LinePlot<'a> {
    let mut plot = LinePlot::new(
        title,
        Axis::new("distance from the peak", "m"),
        Axis::new("level", "dB").range(floor_db, 2.0),
    );
    for (label, distance_m, level_db) in cuts {
        plot = plot.with(Series::line(*label, distance_m, level_db));
    }
    for level in [-3.0, -6.0] {
        let label = format!("−{} dB", -level);
        plot = plot.reference(ReferenceLine {
            at_x: false,
            value: level,
            label,
        });
    }
    plot
}

/// Widens the narrower of two ranges about its middle to a quarter of the other, so that a straight
/// track does not make a plot too thin to read.
fn widen(x: [f64; 2], y: [f64; 2]) -> ([f64; 2], [f64; 2]) {
    let grow = |range: [f64; 2], other: [f64; 2]| {
        let missing = 0.25 * (other[1] - other[0]) - (range[1] - range[0]);
        let room = 0.5 * missing.max(0.0);
        [range[0] - room, range[1] + room]
    };
    (grow(x, y), grow(y, x))
}

fn colour_of(series: &Series<'_>, index: usize) -> Colour {
    series.colour.unwrap_or(Colour::Series(index))
}

fn stroke_of(series: &Series<'_>, colour: Colour) -> Stroke {
    let stroke = Stroke::new(colour, series.line_px);
    if series.dashed {
        stroke.dashed(6.0, 4.0)
    } else {
        stroke
    }
}

fn band_fill(colour: Colour) -> Fill {
    Fill {
        colour,
        opacity: 0.2,
    }
}

fn span_fill(colour: Colour) -> Fill {
    Fill {
        colour,
        opacity: 0.16,
    }
}

fn shade(frame: &Frame, span: &Span, y_range: [f64; 2]) -> Option<Item> {
    let plot = frame.plot;
    let x0 = frame
        .at(span.x[0], y_range[0])?
        .0
        .clamp(plot.x, plot.right());
    let x1 = frame
        .at(span.x[1], y_range[0])?
        .0
        .clamp(plot.x, plot.right());
    let rect = Rect {
        x: x0.min(x1),
        width: (x1 - x0).abs(),
        ..plot
    };
    (rect.width > 0.0).then(|| rectangle(rect, Some(span_fill(span.colour)), None))
}

fn draw_reference(
    frame: &Frame,
    reference: &ReferenceLine,
    [x0, y0]: [f64; 2],
    inside: &mut Vec<Item>,
    above: &mut Vec<Item>,
) {
    let plot = frame.plot;
    let stroke = Stroke::new(Colour::Muted, 1.0).dashed(4.0, 4.0);
    let text = |x: f32, y: f32| {
        Text::new(x, y, 11.0, reference.label.clone())
            .colour(Colour::Muted)
            .halo(Colour::Paper)
    };
    if reference.at_x {
        let Some((x, _)) = frame.at(reference.value, y0) else {
            return;
        };
        let x = snap(x);
        inside.push(line(vec![(x, plot.y), (x, plot.bottom())], stroke));
        if plot.contains(x, plot.y) && !reference.label.is_empty() {
            let left = x + text(0.0, 0.0).width() + 8.0 > plot.right();
            let (x, anchor) = if left {
                (x - 5.0, Anchor::End)
            } else {
                (x + 5.0, Anchor::Start)
            };
            above.push(Item::Text(text(x, plot.y + 14.0).anchor(anchor)));
        }
    } else {
        let Some((_, y)) = frame.at(x0, reference.value) else {
            return;
        };
        let y = snap(y);
        inside.push(line(vec![(plot.x, y), (plot.right(), y)], stroke));
        if plot.contains(plot.x, y) && !reference.label.is_empty() {
            above.push(Item::Text(
                text(plot.right() - 5.0, y - 4.0).anchor(Anchor::End),
            ));
        }
    }
}

fn draw_series(
    frame: &Frame,
    plot: Rect,
    series: &Series<'_>,
    colour: Colour,
    inside: &mut Vec<Item>,
) {
    let at = |i: usize| frame.at(series.x[i], series.y[i]);
    for run in runs(series.x.len(), |i| at(i).is_some()) {
        if !series.half_width.is_empty() {
            let edge = |i: usize, sign: f64| {
                let half = series.half_width[i];
                let half = if half.is_finite() { half } else { 0.0 };
                frame.at(series.x[i], series.y[i] + sign * half)
            };
            let upper = column_extremes(run.clone().filter_map(|i| edge(i, 1.0)).collect());
            let lower = column_extremes(run.clone().filter_map(|i| edge(i, -1.0)).collect());
            let mut points = upper;
            points.extend(lower.into_iter().rev());
            if points.len() > 2 {
                inside.push(polygon(points, band_fill(colour)));
            }
        }
        let points: Vec<_> = run.filter_map(at).collect();
        if series.joined && points.len() > 1 {
            inside.push(line(
                column_extremes(points.clone()),
                stroke_of(series, colour),
            ));
        }
        // A point with gaps on both sides would leave no trace as a line.
        let radius = if series.joined && points.len() == 1 {
            series.dot_px.max(series.line_px)
        } else {
            series.dot_px
        };
        if radius > 0.0 {
            for (x, y) in thin(points)
                .into_iter()
                .filter(|(x, y)| plot.contains(*x, *y))
            {
                inside.extend(mark(Marker::Dot, x, y, radius, colour));
            }
        }
    }
}

/// The stretches of indices below `len` for which `usable` holds.
fn runs(len: usize, usable: impl Fn(usize) -> bool) -> Vec<std::ops::Range<usize>> {
    let mut out = Vec::new();
    let mut start = 0;
    for i in 0..=len {
        if i == len || !usable(i) {
            if start < i {
                out.push(start..i);
            }
            start = i + 1;
        }
    }
    out
}

/// Reduces consecutive points in one pixel column to the first, lowest, highest and last of them:
/// a line of a million points draws as before, from a few thousand.
fn column_extremes(points: Vec<(f32, f32)>) -> Vec<(f32, f32)> {
    let mut kept = Vec::with_capacity(points.len().min(4096));
    let mut rest = points.as_slice();
    while let Some(first) = rest.first() {
        let column = (first.0 * 2.0).floor();
        let count = rest
            .iter()
            .take_while(|p| (p.0 * 2.0).floor() == column)
            .count();
        let (group, after) = rest.split_at(count);
        rest = after;
        if count <= 4 {
            kept.extend_from_slice(group);
            continue;
        }
        let by_height = |a: &&(f32, f32), b: &&(f32, f32)| a.1.total_cmp(&b.1);
        kept.push(group[0]);
        kept.extend(group.iter().min_by(by_height));
        kept.extend(group.iter().max_by(by_height));
        kept.push(group[count - 1]);
    }
    thin(kept)
}
