//! Figures of a positioning run: the map, and everything over one time axis.

use super::super::status::colour;
use super::run::{Run, SatelliteUse, status};
use acerra_figure::{
    Axis, Colour, Drawing, FigureError, LinePlot, Panel, ReferenceLine, Series, Stack, Timeline,
    TimelineRow,
};
use acerra_geo::geodesy::geodetic_from_ecef;
use acerra_gnss::NotFixedReason;

/// Greatest size of the map: shown on a telephone without text too small to read.
const MAP_WIDTH_PX: f32 = 480.0;
const MAP_HEIGHT_PX: f32 = 440.0;

/// Positions from above, coloured by quality, better ones on top.
pub(super) fn map(run: &Run<'_>) -> Result<Drawing, FigureError> {
    let qualities = run.qualities();
    let series: Vec<_> = qualities
        .iter()
        .map(|q| {
            let east = run.only(*q, |i| run.enu_m[i][0]);
            let north = run.only(*q, |i| run.enu_m[i][1]);
            (*q, east, north)
        })
        .collect();
    let mut plot = LinePlot::new("", Axis::new("east", "m"), Axis::new("north", "m"))
        .equal()
        .height(MAP_HEIGHT_PX);
    plot.width_px = MAP_WIDTH_PX;
    for (quality, east, north) in &series {
        let dots = Series::dots(status(*quality).name(), east, north);
        plot = plot.with(dots.colour(colour(status(*quality))));
    }
    plot.draw()
}

/// Quality, height, precision, ratio, satellites and residuals above each other.
pub(super) fn over_time(
    run: &Run<'_>,
    satellites: &[SatelliteUse],
) -> Result<Drawing, FigureError> {
    let columns = Columns::new(run);
    Stack::new(run.time_axis())
        .with(Panel::Timeline(quality(run)))
        .with(Panel::Plot(height(run, &columns)))
        .with(Panel::Plot(precision(run, &columns)))
        .with(Panel::Plot(ratio(run, &columns)))
        .with(Panel::Plot(satellite_count(run, &columns)))
        .with(Panel::Plot(residuals(run, satellites)))
        .draw()
}

/// Values over time, one per epoch with a position.
struct Columns {
    height_m: Vec<f64>,
    height_sigma_m: Vec<f64>,
    sigma_m: Vec<f64>,
    ratio: Vec<f64>,
    /// NaN where the ratio test did not fail: then the ratio needed was not recorded.
    ratio_needed: Vec<f64>,
    satellites: Vec<f64>,
}

impl Columns {
    fn new(run: &Run<'_>) -> Self {
        let epochs = &run.solution.epochs;
        let norm = |s: &[f64; 3]| s.iter().map(|v| v * v).sum::<f64>().sqrt();
        let tried = |ratio: f64| if ratio > 0.0 { ratio } else { f64::NAN };
        Self {
            height_m: epochs
                .iter()
                .map(|s| geodetic_from_ecef(s.position_ecef_m).height_m)
                .collect(),
            height_sigma_m: run.sigma_m.iter().map(|s| s[2]).collect(),
            sigma_m: run.sigma_m.iter().map(norm).collect(),
            ratio: epochs.iter().map(|s| tried(s.ratio)).collect(),
            ratio_needed: epochs
                .iter()
                .map(|s| match s.not_fixed {
                    Some(NotFixedReason::RatioTooLow { needed, .. }) => needed,
                    _ => f64::NAN,
                })
                .collect(),
            satellites: epochs.iter().map(|s| s.satellites as f64).collect(),
        }
    }
}

/// When each quality held, and when there was no position.
fn quality(run: &Run<'_>) -> Timeline {
    let interval_s = run.interval_s();
    let row = |label: &str, colour, times: &mut dyn Iterator<Item = f64>| {
        let mut stretches: Vec<[f64; 2]> = Vec::new();
        for t in times {
            match stretches.last_mut() {
                Some(last) if t <= last[1] + 0.5 * interval_s => last[1] = t + interval_s,
                _ => stretches.push([t, t + interval_s]),
            }
        }
        TimelineRow {
            label: label.to_owned(),
            colour,
            stretches,
        }
    };
    let mut rows = Vec::new();
    for quality in run.qualities().into_iter().rev() {
        let of_quality = |i: &usize| run.solution.epochs[*i].quality == quality;
        let mut times = (0..run.time_s.len())
            .filter(of_quality)
            .map(|i| run.time_s[i]);
        let status = status(quality);
        rows.push(row(status.name(), colour(status), &mut times));
    }
    if !run.solution.lost.is_empty() {
        let lost = run.solution.lost.iter();
        let mut times = lost.map(|l| l.time.seconds_since(run.start));
        rows.push(row("none", Colour::Series(7), &mut times));
    }
    Timeline {
        title: String::new(),
        x: run.time_axis(),
        rows,
        width_px: 860.0,
    }
}

fn height<'a>(run: &'a Run<'_>, columns: &'a Columns) -> LinePlot<'a> {
    LinePlot::new("", run.time_axis(), Axis::new("height", "m"))
        .height(170.0)
        .with(
            Series::line("height ±1σ", &run.time_s, &columns.height_m)
                .band(&columns.height_sigma_m)
                .broken_after(run.longest_step_s()),
        )
}

/// The filter's stated error and the difference of the two passes.
fn precision<'a>(run: &'a Run<'_>, columns: &'a Columns) -> LinePlot<'a> {
    let plot = LinePlot::new("", run.time_axis(), Axis::new("σ, difference", "m").log())
        .height(150.0)
        .with(Series::line(
            "σ of the position",
            &run.time_s,
            &columns.sigma_m,
        ));
    if run.pass_difference_m.iter().all(|d| d.is_nan()) {
        return plot;
    }
    let dots = Series::dots(
        "forward against backward pass",
        &run.time_s,
        &run.pass_difference_m,
    );
    plot.with(Series {
        dot_px: 1.4,
        ..dots
    })
}

/// The ratio found, and the one needed.
fn ratio<'a>(run: &'a Run<'_>, columns: &'a Columns) -> LinePlot<'a> {
    let dots = |label: &str, values: &'a [f64]| Series {
        dot_px: 1.4,
        ..Series::dots(label, &run.time_s, values)
    };
    let mut plot = LinePlot::new("", run.time_axis(), Axis::new("ratio", "").log())
        .height(140.0)
        .with(dots("ratio found", &columns.ratio));
    let usual = run.ratio_threshold;
    let differs = |needed: &f64| usual.is_none_or(|usual| (needed - usual).abs() > 1e-6 * usual);
    if columns
        .ratio_needed
        .iter()
        .any(|r| r.is_finite() && differs(r))
    {
        plot = plot.with(dots(
            "ratio needed where it was too low",
            &columns.ratio_needed,
        ));
    }
    match usual {
        Some(value) => plot.reference(ReferenceLine {
            at_x: false,
            value,
            label: format!("needed: {value}"),
        }),
        None => plot,
    }
}

fn satellite_count<'a>(run: &'a Run<'_>, columns: &'a Columns) -> LinePlot<'a> {
    let most = columns.satellites.iter().copied().fold(0.0, f64::max);
    let axis = Axis::new("satellites", "").range(0.0, most + 1.0);
    LinePlot::new("", run.time_axis(), axis)
        .height(110.0)
        .with(Series::line("", &run.time_s, &columns.satellites).broken_after(run.longest_step_s()))
}

fn residuals<'a>(run: &Run<'_>, satellites: &'a [SatelliteUse]) -> LinePlot<'a> {
    let axis = Axis::new("phase residual", "mm");
    let mut plot = LinePlot::new("", run.time_axis(), axis).height(200.0);
    for one in satellites {
        let dots = Series::dots(one.satellite.to_string(), &one.time_s, &one.phase_mm);
        plot = plot.with(Series {
            dot_px: 1.2,
            ..dots
        });
    }
    plot
}
