//! Figures: images in decibels, radargrams, line plots and maps, as PNG bytes or inline SVG.
//!
//! A figure is described by a plain struct ([`ImageDb`], [`Radargram`], [`LinePlot`], [`Map`])
//! whose `draw` lays it out into a [`Drawing`], a short list of shapes. The drawing is then turned
//! into a PNG ([`Drawing::to_png`], always on a light ground) or into SVG
//! ([`Drawing::to_svg`], whose colours follow CSS variables so that a page can darken them).
//! Equal input gives equal bytes.
//!
//! ```
//! use acerra_figure::{Axis, LinePlot, Series};
//!
//! let x: Vec<f64> = (0..100).map(|i| i as f64 * 0.1).collect();
//! let y: Vec<f64> = x.iter().map(|x| x.sin()).collect();
//! let plot = LinePlot::new("Height", Axis::new("time", "s"), Axis::new("height", "m"))
//!     .with(Series::line("antenna", &x, &y));
//! let drawing = plot.draw()?;
//! assert!(drawing.to_svg().starts_with("<svg"));
//! assert_eq!(&drawing.to_png()?[1..4], b"PNG");
//! # Ok::<(), acerra_figure::FigureError>(())
//! ```

mod axis;
mod colour;
mod colour_bar;
mod contour;
mod cut_plot;
mod display_gain;
mod drawing;
mod error;
mod escape;
mod font;
mod frame;
mod image_db;
mod image_marks;
mod label;
mod legend;
mod level_window;
mod line_plot;
mod map;
mod pixel_values;
mod placement;
mod polyline;
mod radargram;
mod radargram_colours;
mod raster;
mod resample;
mod scale;
mod series;
mod stack;
mod svg;
mod ticks;
mod timeline;

pub use axis::{Axis, AxisScale};
pub use colour::{Colour, Palette};
pub use cut_plot::cut_plot;
pub use display_gain::DisplayGain;
pub use drawing::Drawing;
pub use error::FigureError;
pub use image_db::ImageDb;
pub use image_marks::{GhostMark, SurveyMark, TargetMark};
pub use level_window::LevelWindow;
pub use line_plot::LinePlot;
pub use map::Map;
pub use pixel_values::PixelValues;
pub use radargram::{FastTimeCurve, Radargram};
pub use radargram_colours::RadargramColours;
pub use series::{ReferenceLine, Series, Span};
pub use stack::{Panel, Stack};
pub use timeline::{Timeline, TimelineRow};

#[cfg(test)]
mod tests;
