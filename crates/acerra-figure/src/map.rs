//! Maps: a quantity over two others, as colours with labelled contours.

use super::axis::Axis;
use super::colour::{Colour, Palette, look_up};
use super::colour_bar::ColourBar;
use super::contour;
use super::drawing::{Anchor, DEFAULT_SCALE, Drawing, Item, Rect, Stroke, Text, line};
use super::error::{FigureError, check_len};
use super::frame::{Frame, FrameSpec, Size};
use super::legend::DARK;
use super::resample::peak_pool;

/// A quantity over a regular grid of two others, with labelled contours.
///
/// ```
/// use acerra_figure::{Axis, Map};
///
/// let values: Vec<f64> = (0..30 * 20).map(|i| (i % 30) as f64 + (i / 30) as f64).collect();
/// let map = Map::new("Sum", Axis::new("a", "m"), Axis::new("b", "m"), &values, 30, 20)
///     .grid([0.0, 1.0], [0.0, 1.0])
///     .contours(&[10.0, 20.0, 30.0]);
/// assert!(map.draw()?.to_png()?.len() > 1000);
/// # Ok::<(), acerra_figure::FigureError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Map<'a> {
    /// Title above the map; may be empty.
    pub title: String,
    /// The abscissa; its range is that of the grid.
    pub x: Axis,
    /// The ordinate; its range is that of the grid.
    pub y: Axis,
    /// Values, row-major `[rows, columns]`, row 0 at the lowest ordinate.
    pub values: &'a [f64],
    /// Grid points along x.
    pub columns: usize,
    /// Grid points along y.
    pub rows: usize,
    /// First abscissa and step.
    pub x_grid: [f64; 2],
    /// First ordinate and step.
    pub y_grid: [f64; 2],
    /// Quantity of the values, with their unit, for the colour bar.
    pub value_title: String,
    /// Whether colours follow the logarithm of the values.
    pub log_colours: bool,
    /// Values at the ends of the colour bar; the range of the data where not given.
    pub range: Option<[f64; 2]>,
    /// Values at which contours are drawn.
    pub levels: Vec<f64>,
    /// Colours.
    pub palette: Palette,
    /// Whether one unit of x is as long as one of y.
    pub equal_aspect: bool,
    /// Width of the figure in CSS pixels.
    pub width_px: f32,
    /// Height of the plot in CSS pixels.
    pub plot_height_px: f32,
}

impl<'a> Map<'a> {
    /// A map with grid points at whole numbers and no contours.
    #[must_use]
    pub fn new(
        title: impl Into<String>,
        x: Axis,
        y: Axis,
        values: &'a [f64],
        columns: usize,
        rows: usize,
    ) -> Self {
        Self {
            title: title.into(),
            x,
            y,
            values,
            columns,
            rows,
            x_grid: [0.0, 1.0],
            y_grid: [0.0, 1.0],
            value_title: "value".to_owned(),
            log_colours: false,
            range: None,
            levels: Vec::new(),
            palette: Palette::Viridis,
            equal_aspect: false,
            width_px: 860.0,
            plot_height_px: 460.0,
        }
    }

    /// This map on the grid of first value and step along x and y.
    #[must_use]
    pub fn grid(self, x_grid: [f64; 2], y_grid: [f64; 2]) -> Self {
        Self {
            x_grid,
            y_grid,
            ..self
        }
    }

    /// This map with contours at `levels`.
    #[must_use]
    pub fn contours(self, levels: &[f64]) -> Self {
        Self {
            levels: levels.to_vec(),
            ..self
        }
    }

    /// This map with its values named.
    #[must_use]
    pub fn values_are(self, value_title: impl Into<String>) -> Self {
        Self {
            value_title: value_title.into(),
            ..self
        }
    }

    /// Lays the figure out. Values that are not finite are drawn grey.
    ///
    /// # Errors
    /// [`FigureError::ShapeMismatch`] where the values do not fill the grid;
    /// [`FigureError::NothingToDraw`] for an empty grid or steps that are not positive.
    pub fn draw(&self) -> Result<Drawing, FigureError> {
        check_len(
            "map",
            self.columns.saturating_mul(self.rows),
            self.values.len(),
        )?;
        let nothing = |reason| FigureError::NothingToDraw {
            what: "map",
            reason,
        };
        if self.values.is_empty() {
            return Err(nothing("the grid has no points"));
        }
        let range = |[start, step]: [f64; 2], n: usize| {
            [start - 0.5 * step, start + (n as f64 - 0.5) * step]
        };
        let (x_range, y_range) = (
            range(self.x_grid, self.columns),
            range(self.y_grid, self.rows),
        );
        let finite = x_range.iter().chain(&y_range).all(|v| v.is_finite());
        if !finite || x_range[1] <= x_range[0] || y_range[1] <= y_range[0] {
            return Err(nothing("the grid's extent is not a positive finite length"));
        }
        let scale = Axis {
            range: self.range,
            ..Axis::new("", "")
        };
        let scale = if self.log_colours { scale.log() } else { scale };
        let colours = scale.resolve(self.values.iter().copied(), 0.0);
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
        let linear = |axis: &Axis| Axis::new(&axis.label, &axis.unit);
        let frame = Frame::new(&FrameSpec {
            title: &self.title,
            colour_bar: Some(ColourBar {
                title: self.value_title.clone(),
                palette: self.palette,
                range: colours,
                log: self.log_colours,
            }),
            ..FrameSpec::new([&linear(&self.x), &linear(&self.y)], x_range, y_range, size)
        });
        let (lines, labels) = self.contour_items(&frame);
        let raster = self.raster(frame.plot, colours);
        Ok(frame.finish(vec![raster], false, lines, labels))
    }

    fn raster(&self, rect: Rect, range: [f64; 2]) -> Item {
        let columns = rect.width as usize * DEFAULT_SCALE as usize;
        let rows = rect.height as usize * DEFAULT_SCALE as usize;
        let value = |i: usize| self.values[i];
        let pooled = peak_pool(value, |v| v, (self.columns, self.rows), (columns, rows));
        let table = self.palette.table();
        let fraction = |v: f64| {
            if !v.is_finite() {
                f64::NAN
            } else if self.log_colours {
                if v > 0.0 {
                    (v / range[0]).ln() / (range[1] / range[0]).ln()
                } else {
                    f64::NAN
                }
            } else {
                (v - range[0]) / (range[1] - range[0])
            }
        };
        let rgb = pooled
            .chunks_exact(columns)
            .rev()
            .flatten()
            .flat_map(|v| look_up(&table, fraction(*v)))
            .collect();
        Item::Raster {
            rect,
            columns,
            rows,
            rgb,
        }
    }

    /// Contour lines, and their labels where there is room for them.
    fn contour_items(&self, frame: &Frame) -> (Vec<Item>, Vec<Item>) {
        let (mut lines, mut labels) = (Vec::new(), Vec::new());
        let mut taken: Vec<Rect> = Vec::new();
        for &level in &self.levels {
            for points in contour::lines(self.values, self.columns, self.rows, level) {
                let place = |&(column, row): &contour::GridPoint| {
                    let x = self.x_grid[0] + column * self.x_grid[1];
                    let y = self.y_grid[0] + row * self.y_grid[1];
                    frame.at(x, y)
                };
                let points: Vec<_> = points.iter().filter_map(place).collect();
                if points.len() < 2 {
                    continue;
                }
                lines.push(line(points.clone(), Stroke::new(DARK, 3.0).faint(0.4)));
                lines.push(line(points.clone(), Stroke::new(WHITE, 1.3)));
                let text = Text::new(0.0, 0.0, 12.0, level_label(level));
                let width = text.width() + 8.0;
                // The middle of the line first, then other places along it.
                let order = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8];
                let spot = order.iter().find_map(|share| {
                    let (x, y) = points[(share * (points.len() - 1) as f64) as usize];
                    let rect = Rect {
                        x: x - width / 2.0,
                        y: y - 9.0,
                        width,
                        height: 18.0,
                    };
                    let plot = frame.plot;
                    let inside = plot.encloses(&rect.grown(2.0));
                    let free = taken.iter().all(|other| !rect.overlaps(other));
                    (inside && free).then_some((rect, x, y))
                });
                if let Some((rect, x, y)) = spot {
                    taken.push(rect);
                    labels.push(Item::Text(
                        Text {
                            x,
                            y: y + 4.3,
                            ..text
                        }
                        .anchor(Anchor::Middle)
                        .colour(WHITE)
                        .halo(DARK),
                    ));
                }
            }
        }
        (lines, labels)
    }
}

const WHITE: Colour = Colour::Rgb(0xFF, 0xFF, 0xFF);

/// A level in as many digits as it needs, at most six.
fn level_label(level: f64) -> String {
    let text = format!("{level:.6}");
    text.trim_end_matches('0')
        .trim_end_matches('.')
        .replace('-', "−")
}
