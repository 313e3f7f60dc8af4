//! A focused image in decibels below its maximum.

use super::axis::Axis;
use super::colour::{Palette, look_up};
use super::colour_bar::{ColourBar, alone};
use super::display_gain::DisplayGain;
use super::drawing::{DEFAULT_SCALE, Drawing, Item};
use super::error::{FigureError, check_len};
use super::frame::{Frame, FrameSpec, Size};
use super::image_marks::{GhostMark, Marks, SurveyMark, TargetMark};
use super::level_window::LevelWindow;
use super::pixel_values::PixelValues;
use super::resample::peak_pool;
use rayon::prelude::*;

/// An image in decibels below its maximum, over axes in metres, with its targets.
///
/// ```
/// use acerra_figure::{ImageDb, PixelValues};
///
/// let mut amplitude = vec![0.01_f32; 60 * 40];
/// amplitude[20 * 60 + 30] = 1.0;
/// let image = ImageDb::new("One bright pixel", PixelValues::Amplitude(&amplitude), 60, 40)
///     .at(0.0, -2.0, 0.1);
/// assert!(image.draw()?.to_png()?.len() > 1000);
/// # Ok::<(), acerra_figure::FigureError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ImageDb<'a> {
    /// Title above the image; may be empty.
    pub title: String,
    /// The pixels, row-major `[ny, nx]`; row 0 has the smallest y and is drawn lowest.
    pub pixels: PixelValues<'a>,
    /// Pixels along x.
    pub nx: usize,
    /// Pixels along y.
    pub ny: usize,
    /// Centre of the first pixel along x, in metres.
    pub x0_m: f64,
    /// Centre of the first pixel along y, in metres.
    pub y0_m: f64,
    /// Pixel spacing in metres.
    pub pixel_m: f64,
    /// The levels shown.
    pub window: LevelWindow,
    /// A gain over the image for display, such as one that compensates range.
    pub gain: Option<DisplayGain>,
    /// The level shown as 0 dB, in dB against amplitude 1; the largest level, the gain included,
    /// where not given.
    pub reference_db: Option<f64>,
    /// Colours.
    pub palette: Palette,
    /// The track over ground, as (x, y) in metres; NaN breaks the line.
    pub track_m: &'a [[f64; 2]],
    /// Targets, marked by rings.
    pub targets: Vec<TargetMark>,
    /// Ghosts, marked by dashed rings.
    pub ghosts: Vec<GhostMark>,
    /// Surveyed points, marked by crosses.
    pub survey: Vec<SurveyMark>,
    /// Whether a colour bar is drawn next to the image.
    pub colour_bar: bool,
    /// Whether a legend of the marks is drawn above the image.
    pub legend: bool,
    /// The x axis' name.
    pub x_label: String,
    /// The y axis' name.
    pub y_label: String,
    /// Greatest width of the figure in CSS pixels.
    pub width_px: f32,
    /// Greatest height of the plot in CSS pixels.
    pub plot_height_px: f32,
    /// Reference and floor, where computed before.
    settled: Option<Levels>,
}

impl<'a> ImageDb<'a> {
    /// An image down to −40 dB with pixel (0, 0) at the origin and pixels of one metre.
    #[must_use]
    pub fn new(title: impl Into<String>, pixels: PixelValues<'a>, nx: usize, ny: usize) -> Self {
        Self {
            title: title.into(),
            pixels,
            nx,
            ny,
            x0_m: 0.0,
            y0_m: 0.0,
            pixel_m: 1.0,
            window: LevelWindow::Fixed { floor_db: -40.0 },
            gain: None,
            reference_db: None,
            palette: Palette::Inferno,
            track_m: &[],
            targets: Vec::new(),
            ghosts: Vec::new(),
            survey: Vec::new(),
            colour_bar: true,
            legend: true,
            x_label: "x".to_owned(),
            y_label: "y".to_owned(),
            width_px: 860.0,
            plot_height_px: 680.0,
            settled: None,
        }
    }

    /// This image with pixel (0, 0) centred on (`x0_m`, `y0_m`) and pixels of `pixel_m`.
    #[must_use]
    pub fn at(self, x0_m: f64, y0_m: f64, pixel_m: f64) -> Self {
        Self {
            x0_m,
            y0_m,
            pixel_m,
            ..self
        }
    }

    /// Lays the figure out. An image without any finite, non-zero value is drawn at its floor.
    ///
    /// # Errors
    /// [`FigureError::ShapeMismatch`] where the pixels do not fill `nx × ny`;
    /// [`FigureError::NothingToDraw`] for an empty grid or an extent that is not finite.
    pub fn draw(&self) -> Result<Drawing, FigureError> {
        check_len("image", self.nx.saturating_mul(self.ny), self.pixels.len())?;
        let nothing = |reason| FigureError::NothingToDraw {
            what: "image",
            reason,
        };
        if self.nx == 0 || self.ny == 0 {
            return Err(nothing("the grid has no pixels"));
        }
        let range = |start: f64, n: usize| {
            let half = 0.5 * self.pixel_m;
            [start - half, start + (n - 1) as f64 * self.pixel_m + half]
        };
        let (x_range, y_range) = (range(self.x0_m, self.nx), range(self.y0_m, self.ny));
        let finite = x_range.iter().chain(&y_range).all(|v| v.is_finite());
        if !finite || x_range[1] <= x_range[0] || y_range[1] <= y_range[0] {
            return Err(nothing("the grid's extent is not a positive finite length"));
        }
        let shown = self.levels();
        let marks = self.marks(x_range, y_range);
        let aspect = self.nx as f64 / self.ny as f64;
        let slender = !(1.0 / 15.0..=15.0).contains(&aspect);
        let note = if slender { ", not to scale" } else { "" };
        let x_axis = Axis::new(&self.x_label, "m");
        let y_axis = Axis::new(&self.y_label, format!("m{note}"));
        let size = Size::Equal {
            width: self.width_px,
            plot_height: self.plot_height_px,
        };
        let legend = if self.legend {
            marks.legend()
        } else {
            Vec::new()
        };
        let colour_bar = self.colour_bar.then(|| ColourBar {
            title: self.colour_title(),
            palette: self.palette,
            range: [shown.floor_db, 0.0],
            log: false,
        });
        let frame = Frame::new(&FrameSpec {
            title: &self.title,
            legend: &legend,
            colour_bar,
            ..FrameSpec::new([&x_axis, &y_axis], x_range, y_range, size)
        });
        let raster = self.raster(&frame, shown);
        let items = marks.items(&frame);
        Ok(frame.finish(vec![raster], false, items, Vec::new()))
    }

    /// Legend of the colours as a separate figure: the colour bar with its ticks and caption.
    ///
    /// ```
    /// use acerra_figure::{ImageDb, PixelValues};
    /// let image = ImageDb::new("", PixelValues::Amplitude(&[1.0, 0.1]), 2, 1);
    /// let legend = image.legend();
    /// assert!(legend.to_png()?.len() > 500 && legend.width_px < 120);
    /// # Ok::<(), acerra_figure::FigureError>(())
    /// ```
    #[must_use]
    pub fn legend(&self) -> Drawing {
        let bar = ColourBar {
            title: self.colour_title(),
            palette: self.palette,
            range: [self.levels().floor_db, 0.0],
            log: false,
        };
        alone(&bar, LEGEND_HEIGHT_PX)
    }

    /// The levels that the figure shows. They depend on all pixels, the gain and the window.
    ///
    /// ```
    /// use acerra_figure::{ImageDb, PixelValues};
    /// let image = ImageDb::new("", PixelValues::Amplitude(&[10.0, 1.0]), 2, 1);
    /// let levels = image.levels();
    /// assert_eq!((levels.reference_db, levels.floor_db), (20.0, -40.0));
    /// ```
    #[must_use]
    pub fn levels(&self) -> Levels {
        self.settled.unwrap_or_else(|| self.found_levels())
    }

    /// This image with the levels of another figure of the same pixels, gain and window, so that they are not
    /// computed again.
    #[must_use]
    pub const fn with_levels(mut self, levels: Levels) -> Self {
        self.settled = Some(levels);
        self
    }

    fn marks(&self, x_range: [f64; 2], y_range: [f64; 2]) -> Marks<'_> {
        Marks {
            track_m: self.track_m,
            targets: &self.targets,
            ghosts: &self.ghosts,
            survey: &self.survey,
            x_range,
            y_range,
        }
    }

    fn colour_title(&self) -> String {
        let gain = match &self.gain {
            Some(gain) => format!(", {}", gain.name),
            None => String::new(),
        };
        let note = self.window.note();
        format!("level relative to the maximum{gain} (dB{note})")
    }

    /// The gain at pixel (`column`, `row`) of `columns × rows` that cover the image.
    pub(super) fn gain_db(
        &self,
        (column, row): (usize, usize),
        (columns, rows): (usize, usize),
    ) -> f64 {
        let fraction = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        match &self.gain {
            Some(gain) => gain.at(fraction(column, columns), fraction(row, rows)),
            None => 0.0,
        }
    }

    /// Reference and floor. The percentile is computed from an even sample of the pixels.
    fn found_levels(&self) -> Levels {
        let size = (self.nx, self.ny);
        let level = |column: usize, row: usize| {
            let strength = self.pixels.strength(row * self.nx + column);
            self.pixels.level_db(strength) + self.gain_db((column, row), size)
        };
        let largest = || match &self.gain {
            None => self
                .pixels
                .level_db(self.largest(|column, row| self.pixels.strength(row * self.nx + column))),
            Some(_) => self.largest(level),
        };
        let reference_db = self.reference_db.unwrap_or_else(largest);
        let step = ((self.nx * self.ny) as f64 / MOST_SAMPLED).sqrt().ceil() as usize;
        let step = step.max(1);
        let mut sample: Vec<f64> = match self.window {
            LevelWindow::Fixed { .. } => Vec::new(),
            LevelWindow::Percentile { .. } => (0..self.ny.div_ceil(step))
                .into_par_iter()
                .flat_map_iter(|row| {
                    let columns = (0..self.nx).step_by(step);
                    columns.map(move |column| level(column, row * step))
                })
                .collect(),
        };
        Levels {
            reference_db,
            floor_db: self.window.floor_db(&mut sample, reference_db),
        }
    }

    /// The largest finite value over all pixels; −∞ where there is none.
    fn largest(&self, value: impl Fn(usize, usize) -> f64 + Sync) -> f64 {
        let rows = (0..self.ny).into_par_iter();
        let of_row = rows.map(|row| {
            let values = (0..self.nx).map(|column| value(column, row));
            let finite = values.filter(|value| value.is_finite());
            finite.fold(f64::NEG_INFINITY, f64::max)
        });
        of_row.reduce(|| f64::NEG_INFINITY, f64::max)
    }

    fn raster(&self, frame: &Frame, shown: Levels) -> Item {
        let columns = frame.plot.width as usize * DEFAULT_SCALE as usize;
        let rows = frame.plot.height as usize * DEFAULT_SCALE as usize;
        let strength = |i: usize| self.pixels.strength(i);
        let pooled = peak_pool(strength, |v| v, (self.nx, self.ny), (columns, rows));
        let table = self.palette.table();
        let mut rgb = vec![0; 3 * pooled.len()];
        rgb.par_chunks_exact_mut(3 * columns)
            .zip(pooled.par_chunks_exact(columns).enumerate().rev())
            .for_each(|(line, (row, strengths))| {
                for (column, (pixel, strength)) in
                    line.chunks_exact_mut(3).zip(strengths).enumerate()
                {
                    let level = self.pixels.level_db(*strength)
                        + self.gain_db((column, row), (columns, rows));
                    let fraction = if level == f64::NEG_INFINITY {
                        0.0
                    } else {
                        1.0 - (level - shown.reference_db) / shown.floor_db
                    };
                    pixel.copy_from_slice(&look_up(&table, fraction));
                }
            });
        Item::Raster {
            rect: frame.plot,
            columns,
            rows,
            rgb,
        }
    }
}

/// Height of a colour bar as a separate figure, in CSS pixels: its caption fits.
const LEGEND_HEIGHT_PX: f32 = 300.0;

/// Pixels from which a percentile is taken, at most.
const MOST_SAMPLED: f64 = 1e6;

/// Range of levels that the colours of an image represent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// The level shown as 0 dB, in dB against amplitude 1; −∞ for an image without values.
    pub reference_db: f64,
    /// The lowest distinguishable level, relative to `reference_db`, in dB.
    pub floor_db: f64,
}
