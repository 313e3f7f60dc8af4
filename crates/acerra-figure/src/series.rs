//! Contents of a line plot: series, shaded spans, reference lines.

use super::colour::Colour;

/// One series of a line plot.
#[derive(Clone, Debug)]
pub struct Series<'a> {
    /// Name in the legend; a series without a name is not listed.
    pub label: String,
    /// Abscissae.
    pub x: &'a [f64],
    /// Ordinates, one per abscissa; NaN breaks the line.
    pub y: &'a [f64],
    /// Longest step of the abscissa that is joined: a longer one is a gap and breaks the line.
    pub longest_step: f64,
    /// Half-widths of a band about `y` (for ±1σ), one per point; may be empty.
    pub half_width: &'a [f64],
    /// Whether points are joined by a line.
    pub joined: bool,
    /// Radius of the dot on each point in CSS pixels; none where zero.
    pub dot_px: f32,
    /// Width of the line in CSS pixels.
    pub line_px: f32,
    /// Whether the line is dashed.
    pub dashed: bool,
    /// Colour; by the place of the series in the plot where not given.
    pub colour: Option<Colour>,
}

impl<'a> Series<'a> {
    /// A joined line.
    #[must_use]
    pub fn line(label: impl Into<String>, x: &'a [f64], y: &'a [f64]) -> Self {
        Self {
            label: label.into(),
            x,
            y,
            longest_step: f64::INFINITY,
            half_width: &[],
            joined: true,
            dot_px: 0.0,
            line_px: 1.7,
            dashed: false,
            colour: None,
        }
    }

    /// Dots that are not joined.
    #[must_use]
    pub fn dots(label: impl Into<String>, x: &'a [f64], y: &'a [f64]) -> Self {
        Self {
            joined: false,
            dot_px: 2.2,
            ..Self::line(label, x, y)
        }
    }

    /// This series with a shaded band of `half_width` about it.
    #[must_use]
    pub fn band(self, half_width: &'a [f64]) -> Self {
        Self { half_width, ..self }
    }

    /// This series, its line broken where the abscissa steps by more than `longest_step`.
    #[must_use]
    pub fn broken_after(self, longest_step: f64) -> Self {
        Self {
            longest_step,
            ..self
        }
    }

    /// The same series, dashed.
    #[must_use]
    pub fn dashed(self) -> Self {
        Self {
            dashed: true,
            ..self
        }
    }

    /// This series in `colour`.
    #[must_use]
    pub fn colour(self, colour: Colour) -> Self {
        Self {
            colour: Some(colour),
            ..self
        }
    }
}

/// A stretch of the x axis that is shaded.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Where it begins and ends.
    pub x: [f64; 2],
    /// Colour.
    pub colour: Colour,
    /// Name in the legend; equal names are listed once, empty ones not at all.
    pub label: String,
}

/// A straight line across the plot at one value.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceLine {
    /// Whether the line is at an x value (vertical) or a y value (horizontal).
    pub at_x: bool,
    /// The value.
    pub value: f64,
    /// Label next to the line; may be empty.
    pub label: String,
}
