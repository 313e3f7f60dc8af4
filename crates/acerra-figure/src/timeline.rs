//! Time lines: which of several states held when.

use super::axis::Axis;
use super::colour::Colour;
use super::drawing::{Drawing, Rect, rectangle};
use super::error::FigureError;
use super::frame::{Frame, FrameSpec, Size, Stacking};
use super::ticks::Tick;

/// One state of a time line and the stretches during which it held.
#[derive(Clone, Debug, PartialEq)]
pub struct TimelineRow {
    /// The state, written at the left.
    pub label: String,
    /// Colour.
    pub colour: Colour,
    /// Begin and end of each stretch.
    pub stretches: Vec<[f64; 2]>,
}

/// Rows of coloured bars over a common axis.
///
/// ```
/// use acerra_figure::{Axis, Colour, Timeline, TimelineRow};
///
/// let row = |label: &str, series, stretches| TimelineRow {
///     label: label.to_owned(),
///     colour: Colour::Series(series),
///     stretches,
/// };
/// let timeline = Timeline {
///     title: "Solution status".to_owned(),
///     x: Axis::new("time", "s"),
///     rows: vec![
///         row("fixed", 2, vec![[0.0, 4.0], [5.0, 17.5]]),
///         row("float", 1, vec![[4.0, 5.0]]),
///     ],
///     width_px: 860.0,
/// };
/// assert!(timeline.draw()?.to_svg().contains("float"));
/// # Ok::<(), acerra_figure::FigureError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Timeline {
    /// Title above; may be empty.
    pub title: String,
    /// The axis along which the states change.
    pub x: Axis,
    /// The states, drawn downwards.
    pub rows: Vec<TimelineRow>,
    /// Width of the figure in CSS pixels.
    pub width_px: f32,
}

impl Timeline {
    /// Lays the figure out. Stretches that are not finite are left out; stretches shorter than a pixel are
    /// drawn one pixel wide, so that every stretch is visible.
    ///
    /// # Errors
    /// [`FigureError::NothingToDraw`] without rows.
    pub fn draw(&self) -> Result<Drawing, FigureError> {
        self.check()?;
        let frame = self.frame(self.x.resolve(self.x_values(), 0.0), Stacking::default());
        Ok(self.fill(frame))
    }

    pub(super) fn check(&self) -> Result<(), FigureError> {
        if self.rows.is_empty() {
            return Err(FigureError::NothingToDraw {
                what: "timeline",
                reason: "it has no rows",
            });
        }
        Ok(())
    }

    /// Begin and end of every stretch.
    pub(super) fn x_values(&self) -> impl Iterator<Item = f64> {
        let stretches = self.rows.iter().flat_map(|r| &r.stretches);
        stretches.filter(finite).flatten().copied()
    }

    pub(super) fn frame(&self, x_range: [f64; 2], stacking: Stacking) -> Frame {
        let names = self.rows.iter().enumerate().map(|(i, row)| Tick {
            value: i as f64 + 0.5,
            label: row.label.clone(),
        });
        let size = Size::Free {
            width: self.width_px,
            plot_height: 26.0 * self.rows.len() as f32,
        };
        let y_range = [0.0, self.rows.len() as f64];
        Frame::new(&FrameSpec {
            title: &self.title,
            y_downwards: true,
            y_names: Some(names.collect()),
            stacking,
            ..FrameSpec::new([&self.x, &Axis::new("", "")], x_range, y_range, size)
        })
    }

    /// Draws the bars into `frame`.
    pub(super) fn fill(&self, frame: Frame) -> Drawing {
        let mut bars = Vec::new();
        for (i, row) in self.rows.iter().enumerate() {
            for stretch in row.stretches.iter().filter(finite) {
                let from = frame.at(stretch[0], i as f64 + 0.2);
                let to = frame.at(stretch[1], i as f64 + 0.8);
                let (Some((x0, y0)), Some((x1, y1))) = (from, to) else {
                    continue;
                };
                let rect = Rect {
                    x: x0,
                    y: y0,
                    width: (x1 - x0).max(1.0),
                    height: y1 - y0,
                };
                bars.push(rectangle(rect, Some(row.colour.into()), None));
            }
        }
        let drawing = frame.finish(Vec::new(), true, bars, Vec::new());
        if !self.title.is_empty() {
            return drawing;
        }
        let names: Vec<&str> = self.rows.iter().map(|row| row.label.as_str()).collect();
        drawing.described(format!("{} over {}", names.join(", "), self.x.title()))
    }
}

fn finite(stretch: &&[f64; 2]) -> bool {
    stretch[0].is_finite() && stretch[1].is_finite()
}
