//! Plots above each other that share one x axis.

use super::axis::Axis;
use super::drawing::Drawing;
use super::error::FigureError;
use super::frame::{Frame, Stacking};
use super::line_plot::LinePlot;
use super::sheet::sheet;
use super::timeline::Timeline;

/// One plot of a [`Stack`].
#[derive(Clone, Debug)]
pub enum Panel<'a> {
    /// Series over the common axis.
    Plot(LinePlot<'a>),
    /// States over the common axis.
    Timeline(Timeline),
}

/// Plots above each other over one x axis: one range, one width, ticks named once at the bottom, so that
/// simultaneous events are on one vertical line.
///
/// ```
/// use acerra_figure::{Axis, LinePlot, Panel, Series, Stack};
///
/// let time_s = [0.0, 1.0, 2.0];
/// let (height_m, speed_m_s) = ([4.0, 4.1, 4.0], [1.9, 2.0, 2.1]);
/// let time = Axis::new("time", "s");
/// let plot = |name: &str, unit: &str, values| {
///     LinePlot::new("", time.clone(), Axis::new(name, unit))
///         .with(Series::line("", &time_s, values))
///         .height(120.0)
/// };
/// let stack = Stack::new(time.clone())
///     .with(Panel::Plot(plot("height", "m", &height_m)))
///     .with(Panel::Plot(plot("speed", "m/s", &speed_m_s)));
/// assert!(stack.draw()?.to_svg().contains("height (m)"));
/// # Ok::<(), acerra_figure::FigureError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Stack<'a> {
    /// The common axis; its range is that of all panels where not given.
    pub x: Axis,
    /// The plots, from the top downwards. Their own x axes and widths are not used.
    pub panels: Vec<Panel<'a>>,
    /// Width of the figure in CSS pixels.
    pub width_px: f32,
}

impl<'a> Stack<'a> {
    /// An empty stack.
    #[must_use]
    pub fn new(x: Axis) -> Self {
        Self {
            x,
            panels: Vec::new(),
            width_px: 860.0,
        }
    }

    /// This stack with one more panel at the bottom.
    #[must_use]
    pub fn with(mut self, panel: Panel<'a>) -> Self {
        self.panels.push(panel);
        self
    }

    /// Lays the figure out.
    ///
    /// # Errors
    /// [`FigureError::NothingToDraw`] without panels, and errors of the panels.
    pub fn draw(&self) -> Result<Drawing, FigureError> {
        if self.panels.is_empty() {
            return Err(FigureError::NothingToDraw {
                what: "stack",
                reason: "it has no panels",
            });
        }
        let panels: Vec<Panel<'_>> = self.panels.iter().map(|p| self.fitted(p)).collect();
        for panel in &panels {
            panel.check()?;
        }
        let x_range = self.x.resolve(panels.iter().flat_map(Panel::x_values), 0.0);
        let left = |panel: &Panel<'_>| panel.frame(x_range, Stacking::default()).plot.x;
        let least_left = panels.iter().map(left).fold(0.0, f32::max);
        let last = panels.len() - 1;
        let drawings = panels.iter().enumerate().map(|(i, panel)| {
            let stacking = Stacking {
                least_left,
                without_x_labels: i < last,
            };
            panel.fill(panel.frame(x_range, stacking), x_range)
        });
        let rows: Vec<Vec<Drawing>> = drawings.map(|drawing| vec![drawing]).collect();
        Ok(sheet(rows))
    }

    /// A panel with the stack's axis and width.
    fn fitted(&self, panel: &Panel<'a>) -> Panel<'a> {
        let (x, width_px) = (self.x.clone(), self.width_px);
        match panel.clone() {
            Panel::Plot(plot) => Panel::Plot(LinePlot {
                x: Axis {
                    range: plot.x.range,
                    ..x
                },
                width_px,
                ..plot
            }),
            Panel::Timeline(timeline) => Panel::Timeline(Timeline {
                x: Axis {
                    range: timeline.x.range,
                    ..x
                },
                width_px,
                ..timeline
            }),
        }
    }
}

impl Panel<'_> {
    fn check(&self) -> Result<(), FigureError> {
        match self {
            Self::Plot(plot) => plot.check(),
            Self::Timeline(timeline) => timeline.check(),
        }
    }

    fn x_values(&self) -> Box<dyn Iterator<Item = f64> + '_> {
        match self {
            Self::Plot(plot) => plot.x_values(),
            Self::Timeline(timeline) => Box::new(timeline.x_values()),
        }
    }

    fn frame(&self, x_range: [f64; 2], stacking: Stacking) -> Frame {
        match self {
            Self::Plot(plot) => plot.frame(x_range, stacking),
            Self::Timeline(timeline) => timeline.frame(x_range, stacking),
        }
    }

    fn fill(&self, frame: Frame, x_range: [f64; 2]) -> Drawing {
        match self {
            Self::Plot(plot) => plot.fill(frame, x_range),
            Self::Timeline(timeline) => timeline.fill(frame),
        }
    }
}
