//! Line plots: several series over one pair of axes.

use super::axis::Axis;
use super::colour::Colour;
use super::drawing::{
    Anchor, Drawing, Fill, Item, Rect, Stroke, Text, line, polygon, rectangle, snap,
};
use super::error::{FigureError, check_len};
use super::frame::{Frame, FrameSpec, Size, Stacking};
use super::legend::{Entry, Marker, Sample, mark};
use super::polyline::{column_extremes, runs, thin, without_gaps};
use super::series::{ReferenceLine, Series, Span};

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

    /// This plot with one more series.
    #[must_use]
    pub fn with(mut self, series: Series<'a>) -> Self {
        self.series.push(series);
        self
    }

    /// This plot with one more shaded stretch.
    #[must_use]
    pub fn span(mut self, span: Span) -> Self {
        self.spans.push(span);
        self
    }

    /// This plot with one more line across it.
    #[must_use]
    pub fn reference(mut self, reference: ReferenceLine) -> Self {
        self.references.push(reference);
        self
    }

    /// This plot with another height of its plot area.
    #[must_use]
    pub fn height(self, plot_height_px: f32) -> Self {
        Self {
            plot_height_px,
            ..self
        }
    }

    /// This plot, one unit of x as long as one of y.
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
        self.check()?;
        let x_range = self.x_range();
        let frame = self.frame(x_range, Stacking::default());
        Ok(self.fill(frame, x_range))
    }

    pub(super) fn check(&self) -> Result<(), FigureError> {
        for series in &self.series {
            check_len("series ordinates", series.x.len(), series.y.len())?;
            if !series.half_width.is_empty() {
                check_len("series band", series.x.len(), series.half_width.len())?;
            }
        }
        Ok(())
    }

    /// The abscissae to show: as stated, else all that occur.
    fn x_range(&self) -> [f64; 2] {
        let pad = if self.equal_aspect { 0.05 } else { 0.0 };
        self.x.resolve(self.x_values(), pad)
    }

    /// All abscissae, or the ends of the range stated.
    pub(super) fn x_values(&self) -> Box<dyn Iterator<Item = f64> + '_> {
        if let Some(range) = self.x.range {
            return Box::new(range.into_iter());
        }
        let xs = self.series.iter().flat_map(|s| s.x.iter().copied());
        let spans = self.spans.iter().flat_map(|span| span.x);
        Box::new(xs.chain(spans).chain(self.reference_values(true)))
    }

    fn reference_values(&self, at_x: bool) -> impl Iterator<Item = f64> {
        self.references
            .iter()
            .filter(move |r| r.at_x == at_x)
            .map(|r| r.value)
    }

    /// Range of ordinates to show: the stated range, else the range of the points within `x_range`, including
    /// their bands.
    fn y_range(&self, x_range: [f64; 2]) -> [f64; 2] {
        let ys = self.series.iter().flat_map(|s| {
            let seen = move |i: &usize| s.x[*i] >= x_range[0] && s.x[*i] <= x_range[1];
            (0..s.y.len()).filter(seen).flat_map(|i| {
                let half = s.half_width.get(i).copied();
                let half = half.filter(|h| h.is_finite()).unwrap_or(0.0);
                [s.y[i] - half, s.y[i] + half]
            })
        });
        self.y.resolve(ys.chain(self.reference_values(false)), 0.06)
    }

    pub(super) fn frame(&self, x_range: [f64; 2], stacking: Stacking) -> Frame {
        let (width, plot_height) = (self.width_px, self.plot_height_px);
        let y_range = self.y_range(x_range);
        let (x_range, y_range, size) = if self.equal_aspect {
            let (x_range, y_range) = widen(x_range, y_range);
            (x_range, y_range, Size::Equal { width, plot_height })
        } else {
            (x_range, y_range, Size::Free { width, plot_height })
        };
        Frame::new(&FrameSpec {
            title: &self.title,
            legend: &self.legend(x_range),
            stacking,
            ..FrameSpec::new([&self.x, &self.y], x_range, y_range, size)
        })
    }

    /// Draws the contents into `frame`, which was laid out over `x_range`.
    pub(super) fn fill(&self, frame: Frame, x_range: [f64; 2]) -> Drawing {
        let plot = frame.plot;
        let corner = [x_range[0], self.y_range(x_range)[0]];
        let ground = self
            .spans
            .iter()
            .filter_map(|span| shade(&frame, span, corner[1]))
            .collect();
        let mut inside = Vec::new();
        let mut above = Vec::new();
        for reference in &self.references {
            draw_reference(&frame, reference, corner, &mut inside, &mut above);
        }
        for (index, series) in self.series.iter().enumerate() {
            draw_series(&frame, plot, series, colour_of(series, index), &mut inside);
        }
        let drawing = frame.finish(ground, true, inside, above);
        if self.title.is_empty() {
            drawing.described(format!("{} over {}", self.y.title(), self.x.title()))
        } else {
            drawing
        }
    }

    /// Names of the marks visible over `x_range`.
    fn legend(&self, x_range: [f64; 2]) -> Vec<Entry> {
        let mut entries = Vec::new();
        for (index, series) in self.series.iter().enumerate() {
            let seen = |x: &f64| *x >= x_range[0] && *x <= x_range[1];
            if series.label.is_empty() || !(series.x.is_empty() || series.x.iter().any(seen)) {
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
            let outside = span.x[1] < x_range[0] || span.x[0] > x_range[1];
            let listed = |e: &Entry| e.label == span.label;
            if span.label.is_empty() || outside || entries.iter().any(listed) {
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

fn shade(frame: &Frame, span: &Span, y_lowest: f64) -> Option<Item> {
    let plot = frame.plot;
    let x0 = frame.at(span.x[0], y_lowest)?.0.clamp(plot.x, plot.right());
    let x1 = frame.at(span.x[1], y_lowest)?.0.clamp(plot.x, plot.right());
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
    let usable = runs(series.x.len(), |i| at(i).is_some());
    let unbroken = usable
        .into_iter()
        .flat_map(|run| without_gaps(run, series.x, series.longest_step));
    for run in unbroken {
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
