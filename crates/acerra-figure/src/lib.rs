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

mod colour;
mod contour;
mod drawing;
mod error;
mod font;
mod frame;
mod image_db;
mod legend;
mod line_plot;
mod map;
pub mod markup;
mod radargram;
mod raster;
mod resample;
mod svg;
mod ticks;
mod timeline;

pub use colour::{Colour, Palette};
pub use drawing::Drawing;
pub use error::FigureError;
pub use frame::{Axis, AxisScale};
pub use image_db::{GhostMark, ImageDb, PixelValues, TargetMark};
pub use line_plot::{LinePlot, ReferenceLine, Series, Span, cut_plot};
pub use map::Map;
pub use radargram::{FastTimeCurve, Radargram, RadargramColours};
pub use timeline::{Timeline, TimelineRow};

#[cfg(test)]
mod tests;
