//! Radargrams: traces against fast time.

use super::axis::Axis;
use super::colour::{Colour, look_up};
use super::drawing::{DEFAULT_SCALE, Drawing, Item, Stroke, line};
use super::error::{FigureError, check_len};
use super::frame::{Frame, FrameSpec, SecondAxis, Size};
use super::legend::{DARK, Entry, Sample};
use super::polyline::{runs, thin};
use super::radargram_colours::{Colouring, RadargramColours};
use super::resample::peak_pool;
use super::ticks::{self, Tick};
use rayon::prelude::*;

/// A curve of fast time over the traces, drawn on a radargram.
#[derive(Clone, Debug, PartialEq)]
pub struct FastTimeCurve {
    /// Name in the legend; equal names are listed once, empty ones not at all.
    pub label: String,
    /// One fast time per trace, in nanoseconds; NaN leaves a gap.
    pub fast_time_ns: Vec<f64>,
    /// Whether it is drawn dashed (limits, gates) or solid (picks, predictions).
    pub dashed: bool,
}

/// A radargram: traces from left to right, fast time downwards.
///
/// ```
/// use acerra_figure::Radargram;
///
/// let samples: Vec<f32> = (0..30 * 200).map(|i| ((i % 200) as f32 * 0.3).sin()).collect();
/// let radargram = Radargram::new("Raw", &samples, 30, 200).fast_time(0.0, 0.061);
/// assert!(radargram.draw()?.to_png()?.len() > 1000);
/// # Ok::<(), acerra_figure::FigureError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Radargram<'a> {
    /// Title above the plot; may be empty.
    pub title: String,
    /// Samples, row-major `[traces, samples_per_trace]`.
    pub samples: &'a [f32],
    /// Traces.
    pub traces: usize,
    /// Samples in each trace.
    pub samples_per_trace: usize,
    /// Number of the first trace.
    pub first_trace: usize,
    /// Fast time of the first sample in nanoseconds.
    pub start_ns: f64,
    /// Time between samples in nanoseconds.
    pub step_ns: f64,
    /// The unit of the samples, for the colour bar.
    pub unit: String,
    /// Colours.
    pub colours: RadargramColours,
    /// Values of the traces, rising, for a second axis at the top; may be empty.
    pub top: &'a [f64],
    /// Title of that axis, with its unit.
    pub top_title: String,
    /// Fast times (ns) and their values for a second axis at the right, both rising; may be empty.
    pub right: Vec<[f64; 2]>,
    /// Title of that axis, with its unit.
    pub right_title: String,
    /// Curves over the samples: 2h/c, gate edges, the surface echo as picked.
    pub curves: Vec<FastTimeCurve>,
    /// Width of the figure in CSS pixels.
    pub width_px: f32,
    /// Height of the plot in CSS pixels.
    pub plot_height_px: f32,
}

impl<'a> Radargram<'a> {
    /// A radargram of signed amplitudes.
    #[must_use]
    pub fn new(
        title: impl Into<String>,
        samples: &'a [f32],
        traces: usize,
        samples_per_trace: usize,
    ) -> Self {
        Self {
            title: title.into(),
            samples,
            traces,
            samples_per_trace,
            first_trace: 0,
            start_ns: 0.0,
            step_ns: 1.0,
            unit: "counts".to_owned(),
            colours: RadargramColours::Signed { limit: None },
            top: &[],
            top_title: "time (s)".to_owned(),
            right: Vec::new(),
            right_title: String::new(),
            curves: Vec::new(),
            width_px: 860.0,
            plot_height_px: 460.0,
        }
    }

    /// This radargram with its first sample at `start_ns` and samples `step_ns` apart.
    #[must_use]
    pub fn fast_time(self, start_ns: f64, step_ns: f64) -> Self {
        Self {
            start_ns,
            step_ns,
            ..self
        }
    }

    /// Lays the figure out. Samples that are not finite are drawn grey.
    ///
    /// # Errors
    /// [`FigureError::ShapeMismatch`] where samples, times or curves do not fit the number of
    /// traces; [`FigureError::NothingToDraw`] without samples or with an impossible time axis.
    pub fn draw(&self) -> Result<Drawing, FigureError> {
        let cells = self.traces.saturating_mul(self.samples_per_trace);
        check_len("radargram samples", cells, self.samples.len())?;
        if !self.top.is_empty() {
            check_len("radargram traces at the top", self.traces, self.top.len())?;
        }
        for curve in &self.curves {
            check_len("radargram curve", self.traces, curve.fast_time_ns.len())?;
        }
        let nothing = |reason| FigureError::NothingToDraw {
            what: "radargram",
            reason,
        };
        if cells == 0 {
            return Err(nothing("there are no samples"));
        }
        let first = self.first_trace as f64;
        let x_range = [first - 0.5, first + self.traces as f64 - 0.5];
        let y_range = [
            self.start_ns - 0.5 * self.step_ns,
            self.start_ns + (self.samples_per_trace as f64 - 0.5) * self.step_ns,
        ];
        if !y_range.iter().all(|v| v.is_finite()) || y_range[1] <= y_range[0] {
            return Err(nothing(
                "the fast-time axis is not a positive finite length",
            ));
        }

        let colouring = Colouring::new(self.colours, self.samples, &self.unit);
        let size = Size::Free {
            width: self.width_px,
            plot_height: self.plot_height_px,
        };
        let axes = [
            &Axis::new("trace number", ""),
            &Axis::new("fast time", "ns"),
        ];
        let frame = Frame::new(&FrameSpec {
            title: &self.title,
            y_downwards: true,
            legend: &self.legend(y_range),
            colour_bar: Some(colouring.bar.clone()),
            top: self.top_axis(x_range),
            right: self.right_axis(y_range),
            ..FrameSpec::new(axes, x_range, y_range, size)
        });
        let columns = frame.plot.width as usize * DEFAULT_SCALE as usize;
        let rows = frame.plot.height as usize * DEFAULT_SCALE as usize;
        let (traces, per_trace) = (self.traces, self.samples_per_trace);
        // The grid of cells has a row per sample and a column per trace.
        let value =
            |cell: usize| f64::from(self.samples[(cell % traces) * per_trace + cell / traces]);
        let pooled = peak_pool(value, f64::abs, (traces, per_trace), (columns, rows));
        let table = colouring.bar.palette.table();
        let mut rgb = vec![0; 3 * pooled.len()];
        rgb.par_chunks_exact_mut(3 * columns)
            .zip(pooled.par_chunks_exact(columns))
            .for_each(|(line, values)| {
                for (pixel, value) in line.chunks_exact_mut(3).zip(values) {
                    pixel.copy_from_slice(&look_up(&table, colouring.fraction(*value)));
                }
            });
        let raster = Item::Raster {
            rect: frame.plot,
            columns,
            rows,
            rgb,
        };

        let mut inside = Vec::new();
        for (index, curve) in self.curves.iter().enumerate() {
            let stroke = self.stroke(index, curve);
            let given = |i: usize| curve.fast_time_ns[i].is_finite();
            for part in runs(self.traces, given) {
                let at = |i: usize| frame.at(first + i as f64, curve.fast_time_ns[i]);
                let points = thin(part.filter_map(at).collect());
                if points.len() > 1 {
                    let edge = if self.dark() {
                        DARK
                    } else {
                        Colour::Rgb(255, 255, 255)
                    };
                    inside.push(line(points.clone(), Stroke::new(edge, 2.6).faint(0.5)));
                    inside.push(line(points, stroke));
                }
            }
        }
        Ok(frame.finish(vec![raster], false, inside, Vec::new()))
    }

    fn dark(&self) -> bool {
        matches!(self.colours, RadargramColours::Decibel { .. })
    }

    fn stroke(&self, index: usize, curve: &FastTimeCurve) -> Stroke {
        const ON_LIGHT: [Colour; 4] = [
            Colour::Rgb(0x11, 0x11, 0x11),
            Colour::Rgb(0x00, 0x6B, 0x4F),
            Colour::Rgb(0x7A, 0x1F, 0xA2),
            Colour::Rgb(0x9A, 0x62, 0x00),
        ];
        const ON_DARK: [Colour; 4] = [
            Colour::Rgb(0xFF, 0xFF, 0xFF),
            Colour::Rgb(0x6E, 0xE7, 0xFF),
            Colour::Rgb(0x4A, 0xDE, 0x80),
            Colour::Rgb(0xFF, 0xB4, 0xE0),
        ];
        let set = if self.dark() { ON_DARK } else { ON_LIGHT };
        // Limits share one colour; the others take the remaining ones in turn.
        if curve.dashed {
            return Stroke::new(set[0], 1.4).dashed(5.0, 4.0);
        }
        let solid = self.curves[..index].iter().filter(|c| !c.dashed).count();
        Stroke::new(set[1 + solid % (set.len() - 1)], 1.3)
    }

    /// Names of the curves that come into `y_range`.
    fn legend(&self, y_range: [f64; 2]) -> Vec<Entry> {
        let ground = self.dark().then_some(Colour::Rgb(0x3A, 0x2A, 0x50));
        let mut entries: Vec<Entry> = Vec::new();
        for (index, curve) in self.curves.iter().enumerate() {
            let within = |t: &f64| *t >= y_range[0] && *t <= y_range[1];
            let seen = curve.fast_time_ns.iter().any(within);
            let listed = entries.iter().any(|e| e.label == curve.label);
            if seen && !listed && !curve.label.is_empty() {
                let sample = Sample::Line(self.stroke(index, curve));
                entries.push(Entry {
                    label: curve.label.clone(),
                    sample,
                    ground,
                });
            }
        }
        entries
    }

    /// Round values of the top axis at the (fractional) traces that they fall on.
    fn top_axis(&self, x_range: [f64; 2]) -> Option<SecondAxis> {
        let first = self.first_trace as f64;
        let places = (0..self.top.len()).map(|trace| first + trace as f64);
        let scale: Vec<[f64; 2]> = places.zip(self.top).map(|(x, v)| [x, *v]).collect();
        let length = self.width_px - 200.0;
        let ticks = second_ticks(&scale, x_range, (length, true))?;
        let title = self.top_title.clone();
        Some(SecondAxis { title, ticks })
    }

    fn right_axis(&self, y_range: [f64; 2]) -> Option<SecondAxis> {
        let ticks = second_ticks(&self.right, y_range, (self.plot_height_px, false))?;
        let title = self.right_title.clone();
        Some(SecondAxis { title, ticks })
    }
}

/// Ticks at round values of a second axis of this length, whose places on the first one and values are those of `scale`,
/// with straight lines between; none where these do not rise.
fn second_ticks(
    scale: &[[f64; 2]],
    range: [f64; 2],
    (length, across): (f32, bool),
) -> Option<Vec<Tick>> {
    let rises = |pair: &[[f64; 2]]| pair[1][0] > pair[0][0] && pair[1][1] > pair[0][1];
    if scale.len() < 2 || !scale.windows(2).all(rises) {
        return None;
    }
    let between = |v: f64, from: usize, to: usize| {
        let above = scale.partition_point(|p| p[from] < v);
        let [a, b] = [0, 1].map(|k| scale[above.clamp(1, scale.len() - 1) - 1 + k]);
        a[to] + (v - a[from]) / (b[from] - a[from]) * (b[to] - a[to])
    };
    let ends = range.map(|place| between(place, 0, 1));
    let [low, high] = if across {
        [scale[0][1], scale[scale.len() - 1][1]]
    } else {
        ends
    };
    let mut list = ticks::linear(low, high, length, 12.0, across);
    for tick in &mut list {
        tick.value = between(tick.value, 1, 0).clamp(range[0], range[1]);
    }
    Some(list)
}
