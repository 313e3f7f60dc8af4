//! A focused image in decibels below its maximum.

use super::colour::{Colour, Palette, look_up};
use super::drawing::{Anchor, DEFAULT_SCALE, Drawing, Item, Stroke, Text, line};
use super::error::{FigureError, check_len};
use super::frame::{Axis, ColourBar, Frame, FrameSpec, Size};
use super::legend::{DARK, Entry, Marker, Sample, mark};
use super::resample::peak_pool;
use num_complex::Complex32;
use rayon::prelude::*;

/// The values of an image, row-major `[ny, nx]`.
#[derive(Clone, Copy, Debug)]
pub enum PixelValues<'a> {
    /// Complex amplitudes; the modulus is shown.
    Complex(&'a [Complex32]),
    /// Amplitudes; the modulus is shown.
    Amplitude(&'a [f32]),
    /// Levels that are in decibels already, shown below their maximum.
    Decibel(&'a [f32]),
}

impl PixelValues<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Complex(v) => v.len(),
            Self::Amplitude(v) | Self::Decibel(v) => v.len(),
        }
    }

    /// A number that grows with the level of one pixel and is cheap to have for every pixel; NaN
    /// where there is no finite value.
    fn strength(&self, index: usize) -> f64 {
        let strength = match self {
            Self::Complex(v) => {
                let (re, im) = (f64::from(v[index].re), f64::from(v[index].im));
                re * re + im * im
            }
            Self::Amplitude(v) => f64::from(v[index]).powi(2),
            Self::Decibel(v) => f64::from(v[index]),
        };
        if strength == f64::INFINITY {
            f64::NAN
        } else {
            strength
        }
    }

    /// The level in dB against amplitude 1 that a [`strength`](Self::strength) stands for; −∞ for
    /// zero, NaN where there is no value.
    fn level_db(&self, strength: f64) -> f64 {
        match self {
            Self::Complex(_) | Self::Amplitude(_) => 10.0 * strength.log10(),
            Self::Decibel(_) => strength,
        }
    }
}

/// A target to be marked and numbered.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetMark {
    /// East or along-track coordinate in metres.
    pub x_m: f64,
    /// North or across-track coordinate in metres.
    pub y_m: f64,
    /// What stands beside it, usually its number in the table of targets.
    pub label: String,
}

/// A left–right ghost to be marked.
#[derive(Clone, Debug, PartialEq)]
pub struct GhostMark {
    /// East or along-track coordinate in metres.
    pub x_m: f64,
    /// North or across-track coordinate in metres.
    pub y_m: f64,
    /// What stands beside it; may be empty.
    pub label: String,
}

/// An image in decibels below its maximum, over axes in metres, with what was found in it.
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
    /// The lowest level shown, in dB below the reference (negative); lower levels take its colour.
    pub floor_db: f64,
    /// The level shown as 0 dB, in dB against amplitude 1; the image's maximum where not given.
    pub reference_db: Option<f64>,
    /// Colours.
    pub palette: Palette,
    /// The track over ground, as (x, y) in metres; NaN breaks the line.
    pub track_m: &'a [[f64; 2]],
    /// Targets, marked by rings.
    pub targets: Vec<TargetMark>,
    /// Ghosts, marked by dashed rings.
    pub ghosts: Vec<GhostMark>,
    /// The x axis' name.
    pub x_label: String,
    /// The y axis' name.
    pub y_label: String,
    /// Greatest width of the figure in CSS pixels.
    pub width_px: f32,
    /// Greatest height of the plot in CSS pixels.
    pub plot_height_px: f32,
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
            floor_db: -40.0,
            reference_db: None,
            palette: Palette::Inferno,
            track_m: &[],
            targets: Vec::new(),
            ghosts: Vec::new(),
            x_label: "x".to_owned(),
            y_label: "y".to_owned(),
            width_px: 860.0,
            plot_height_px: 680.0,
        }
    }

    /// The same image with pixel (0, 0) centred on (`x0_m`, `y0_m`) and pixels of `pixel_m`.
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
        let floor_db = if self.floor_db < 0.0 && self.floor_db.is_finite() {
            self.floor_db
        } else {
            -40.0
        };

        let slender = {
            let aspect = self.nx as f64 / self.ny as f64;
            !(1.0 / 15.0..=15.0).contains(&aspect)
        };
        let note = if slender { ", not to scale" } else { "" };
        let x_axis = Axis::new(&self.x_label, "m");
        let y_axis = Axis::new(&self.y_label, format!("m{note}"));
        let frame = Frame::new(&FrameSpec {
            title: &self.title,
            x: &x_axis,
            y: &y_axis,
            x_range,
            y_range,
            y_downwards: false,
            size: Size::Equal {
                width: self.width_px,
                plot_height: self.plot_height_px,
            },
            legend: &self.legend(),
            colour_bar: Some(ColourBar {
                title: "level relative to the maximum (dB)".to_owned(),
                palette: self.palette,
                range: [floor_db, 0.0],
                log: false,
            }),
            top: None,
            y_names: None,
        });
        let raster = self.raster(&frame, floor_db);
        let (inside, above) = self.overlay(&frame);
        Ok(frame.finish(vec![raster], false, inside, above))
    }

    fn legend(&self) -> Vec<Entry> {
        let on_image = |label: &str, sample| Entry {
            label: label.to_owned(),
            sample,
            ground: Some(Colour::Rgb(0x3A, 0x2A, 0x50)),
        };
        let mut entries = Vec::new();
        if !self.track_m.is_empty() {
            entries.push(on_image(
                "radar track",
                Sample::Line(Stroke::new(TRACK, 1.6)),
            ));
            entries.push(on_image(
                "its beginning",
                Sample::Mark(Marker::Triangle, START),
            ));
        }
        if !self.targets.is_empty() {
            entries.push(on_image("target", Sample::Mark(Marker::Ring, TARGET)));
        }
        if !self.ghosts.is_empty() {
            entries.push(on_image(
                "its left–right ghost",
                Sample::Mark(Marker::DashedRing, GHOST),
            ));
        }
        entries
    }

    fn raster(&self, frame: &Frame, floor_db: f64) -> Item {
        let columns = frame.plot.width as usize * DEFAULT_SCALE as usize;
        let rows = frame.plot.height as usize * DEFAULT_SCALE as usize;
        let strength = |i: usize| self.pixels.strength(i);
        let pooled = peak_pool(strength, |v| v, (self.nx, self.ny), (columns, rows));
        // Every cell is shown by some pixel, so the shown maximum is the image's.
        let maximum = pooled
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .fold(f64::NEG_INFINITY, f64::max);
        let reference = self
            .reference_db
            .unwrap_or_else(|| self.pixels.level_db(maximum));
        let table = self.palette.table();
        let mut rgb = vec![0; 3 * pooled.len()];
        rgb.par_chunks_exact_mut(3 * columns)
            .zip(pooled.par_chunks_exact(columns).rev())
            .for_each(|(line, row)| {
                for (pixel, strength) in line.chunks_exact_mut(3).zip(row) {
                    let level = self.pixels.level_db(*strength);
                    let fraction = if level == f64::NEG_INFINITY {
                        0.0
                    } else {
                        1.0 - (level - reference) / floor_db
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

    /// Track and marks: what is clipped to the image, and what may overlap its border.
    fn overlay(&self, frame: &Frame) -> (Vec<Item>, Vec<Item>) {
        let mut inside = Vec::new();
        for part in self
            .track_m
            .split(|p| !p[0].is_finite() || !p[1].is_finite())
        {
            let points: Vec<_> = part.iter().filter_map(|p| frame.at(p[0], p[1])).collect();
            let points = thin(points);
            if points.len() > 1 {
                inside.push(line(points.clone(), Stroke::new(DARK, 3.6).faint(0.55)));
                inside.push(line(points, Stroke::new(TRACK, 1.6)));
            }
        }
        let mut above = Vec::new();
        let place = |x: f64, y: f64| {
            frame
                .at(x, y)
                .filter(|(px, py)| frame.plot.contains(*px, *py))
        };
        // A track that begins outside is marked where it comes in.
        let start = self.track_m.iter().find_map(|p| place(p[0], p[1]));
        if let Some((x, y)) = start {
            above.extend(mark(Marker::Triangle, x, y, 6.0, START));
        }
        let ghosts = self
            .ghosts
            .iter()
            .map(|g| (g.x_m, g.y_m, &g.label, Marker::DashedRing));
        let targets = self
            .targets
            .iter()
            .map(|t| (t.x_m, t.y_m, &t.label, Marker::Ring));
        for (x, y, label, marker) in ghosts.chain(targets) {
            let Some((px, py)) = place(x, y) else {
                continue;
            };
            let colour = if marker == Marker::Ring {
                TARGET
            } else {
                GHOST
            };
            above.extend(mark(marker, px, py, 10.0, colour));
            let left = px + 40.0 > frame.plot.right();
            let (offset, anchor) = if left {
                (-14.0, Anchor::End)
            } else {
                (14.0, Anchor::Start)
            };
            above.push(Item::Text(
                Text::new(px + offset, py - 7.0, 13.0, label.as_str())
                    .anchor(anchor)
                    .colour(colour)
                    .halo(DARK),
            ));
        }
        (inside, above)
    }
}

const TRACK: Colour = Colour::Rgb(0xFF, 0xFF, 0xFF);
const START: Colour = Colour::Rgb(0x4A, 0xDE, 0x80);
const TARGET: Colour = Colour::Rgb(0x6E, 0xE7, 0xFF);
const GHOST: Colour = Colour::Rgb(0xD6, 0xDC, 0xE4);

/// Drops points that lie within a third of a pixel of the last one kept.
pub(super) fn thin(points: Vec<(f32, f32)>) -> Vec<(f32, f32)> {
    let mut kept: Vec<(f32, f32)> = Vec::with_capacity(points.len().min(4096));
    for point in points {
        match kept.last() {
            Some(last) if (last.0 - point.0).hypot(last.1 - point.1) < 0.34 => {}
            _ => kept.push(point),
        }
    }
    kept
}
