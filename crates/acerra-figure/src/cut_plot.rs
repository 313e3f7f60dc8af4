//! Cuts through an image peak.

use super::axis::Axis;
use super::line_plot::LinePlot;
use super::series::{ReferenceLine, Series};

/// A cut through an image peak in decibels, down to `floor_db`, with the −3 and −6 dB levels.
///
/// Each item of `cuts` is a name, the distances from the peak in metres, and the levels in dB.
#[must_use]
pub fn cut_plot<'a>(
    title: impl Into<String>,
    cuts: &[(&str, &'a [f64], &'a [f64])],
    floor_db: f64,
) -> LinePlot<'a> {
    let mut plot = LinePlot::new(
        title,
        Axis::new("distance from the peak", "m"),
        Axis::new("level", "dB").range(floor_db, 2.0),
    );
    for (label, distance_m, level_db) in cuts {
        plot = plot.with(Series::line(*label, distance_m, level_db));
    }
    for level in [-3.0, -6.0] {
        let label = format!("−{} dB", -level);
        plot = plot.reference(ReferenceLine {
            at_x: false,
            value: level,
            label,
        });
    }
    plot
}
