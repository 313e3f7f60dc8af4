//! Figures of measured fields and time series: images in decibels, radargrams, line plots, maps and
//! time lines, as PNG bytes or inline SVG.
//!
//! The crate is independent of what is drawn: its input is plain slices with their axes, its output pictures.
//! An image of ten million pixels, or a plot of a million points, becomes a small and crisp picture, bitwise
//! equal on every run, without losing one bright pixel.
//!
//! ```text
//!  ImageDb ────┐  levels, gain, marks
//!  Radargram ──┤  amplitudes, curves                   ┌─ to_png() ─► PNG bytes, light ground
//!  Map ────────┼─ draw() ─► frame ─► Drawing (shapes) ─┤
//!  LinePlot ─┬─┤  series, spans                        └─ to_svg() ─► SVG text, themed by CSS
//!  Timeline ─┤ │  states                                              variables
//!  Stack ◄───┘─┘  panels over one x axis                 sheet(): drawings in rows and columns
//! ```
//!
//! A figure is a plain struct whose public fields hold its data; `draw` lays it out into a [`Drawing`], a
//! short list of shapes with a description in words. Errors ([`FigureError`]) name the array that does not
//! fit. No sampling is random: equal input gives equal bytes.
//!
//! ```
//! use acerra_figure::{Axis, ImageDb, LevelWindow, LinePlot, PixelValues, Series, TargetMark};
//!
//! // An image of 60 × 40 pixels of 10 cm with one bright pixel, over its own range of levels.
//! let mut amplitude: Vec<f32> = (0..60 * 40).map(|i| 0.01 + 1e-5 * i as f32).collect();
//! amplitude[20 * 60 + 30] = 1.0;
//! let mut image = ImageDb::new("Image", PixelValues::Amplitude(&amplitude), 60, 40)
//!     .at(0.0, -2.0, 0.1);
//! image.window = LevelWindow::Percentile { share: 0.25 };
//! image.targets.push(TargetMark { x_m: 3.0, y_m: 0.0, label: "1".to_owned() });
//! assert_eq!(image.levels().floor_db, -36.0);
//! assert_eq!(&image.draw()?.to_png()?[1..4], b"PNG");
//!
//! // A line plot, as SVG for a page.
//! let x: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.1).collect();
//! let y: Vec<f64> = x.iter().map(|x| x.sin()).collect();
//! let plot = LinePlot::new("Height", Axis::new("time", "s"), Axis::new("height", "m"))
//!     .with(Series::line("antenna", &x, &y));
//! assert!(plot.draw()?.to_svg().starts_with("<svg"));
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
mod overlay;
mod pixel_values;
mod placement;
mod polyline;
mod radargram;
mod radargram_colours;
mod raster;
mod resample;
mod scale;
mod series;
mod sheet;
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
pub use image_db::{ImageDb, Levels};
pub use image_marks::{GhostMark, SurveyMark, TargetMark};
pub use level_window::LevelWindow;
pub use line_plot::LinePlot;
pub use map::Map;
pub use pixel_values::PixelValues;
pub use radargram::{FastTimeCurve, Radargram};
pub use radargram_colours::RadargramColours;
pub use series::{ReferenceLine, Series, Span};
pub use sheet::sheet;
pub use stack::{Panel, Stack};
pub use timeline::{Timeline, TimelineRow};

#[cfg(test)]
mod tests;
