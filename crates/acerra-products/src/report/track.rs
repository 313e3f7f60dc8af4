//! Inputs of the image, track by track: trajectory, alignment in time, surface echo.

use super::data::{
    AlignmentEvidence, SurfaceEvidence, TargetRow, TrackEvidence, TrajectoryEvidence,
};
use super::html::{self, Fit};
use super::numbers::{fixed, quantile, with_minus_signs};
use super::status;
use acerra_figure::{
    Axis, Colour, FigureError, LinePlot, Panel, ReferenceLine, Series, Span, Stack, Timeline,
};
use maud::{Markup, html};

/// One map of all tracks; then each track with its time axis.
pub(super) fn section(
    tracks: &[TrackEvidence],
    targets: &[TargetRow],
) -> Result<Markup, FigureError> {
    for track in tracks {
        check(track)?;
    }
    let flown = |track: &&TrackEvidence| {
        let trajectory = track.trajectory.as_ref();
        trajectory.is_some_and(|t| !t.time_s.is_empty())
    };
    let map = match tracks.iter().any(|track| flown(&track)) {
        true => map(tracks, targets)?,
        false => html! {},
    };
    let mut parts = Vec::new();
    for track in tracks {
        parts.push(one(track)?);
    }
    Ok(html! {
        @if tracks.iter().any(|track| track.trajectory.is_some()) {
            h3 { (if tracks.len() > 1 { "Tracks" } else { "Trajectory" }) }
        }
        (map)
        @for part in parts { (part) }
    })
}

/// "Track" before a name that does not contain it.
fn titled(name: &str) -> String {
    if name.to_lowercase().starts_with("track") {
        name.to_owned()
    } else {
        format!("Track {name}")
    }
}

fn one(track: &TrackEvidence) -> Result<Markup, FigureError> {
    let trajectory = track.trajectory.as_ref().map(trajectory).transpose()?;
    let alignment = track.alignment.as_ref().map(alignment).transpose()?;
    let surface = track.surface.as_ref().map(surface).transpose()?;
    let heading = |text: &str| {
        html! {
            @if track.name.is_empty() {
                h3 { (text) }
            } @else {
                h4 { (text) }
            }
        }
    };
    let part = html! {
        (trajectory.unwrap_or_default())
        @if let Some(alignment) = alignment {
            (heading("Alignment in time"))
            (alignment)
        }
        @if let Some(surface) = surface {
            (heading("Zero-timing: surface echo against height"))
            (surface)
        }
    };
    Ok(html! {
        @if track.name.is_empty() {
            (part)
        } @else {
            section.track {
                h3 { (titled(&track.name)) }
                (part)
            }
        }
    })
}

fn trajectory(view: &TrajectoryEvidence) -> Result<Markup, FigureError> {
    if view.time_s.is_empty() {
        return Ok(html! { p.muted { "It holds no positions." } });
    }
    let plots = over_time(view)?;
    Ok(html! {
        p { (grade(view)) }
        (plots)
    })
}

/// Number of positions, and their stated quality.
fn grade(view: &TrajectoryEvidence) -> String {
    let n = view.time_s.len();
    let fixed_count = view.status.iter().filter(|s| s.is_fixed()).count();
    let over = match view.is_untimed {
        true => String::new(),
        false => format!(" over {} s", fixed(view.time_s[n - 1] - view.time_s[0], 1)),
    };
    let mut sentence = format!(
        "{n} positions{over}, {} % of them of imaging grade (fixed ambiguities, or accepted as stated)",
        fixed(100.0 * fixed_count as f64 / n as f64, 1),
    );
    if !view.sigma_m.is_empty() {
        let [east, north, up] = [0, 1, 2].map(|axis| {
            let middle = quantile(view.sigma_m.iter().map(|s| s[axis]), 0.5);
            fixed(middle.map(|m| m * 1e3), 0)
        });
        sentence.push_str(&format!(
            "; median standard deviation {east} mm east, {north} mm north, {up} mm up"
        ));
    }
    sentence.push('.');
    sentence
}

/// Height, speed and status above each other over one time axis; without speed where the traces have no times.
fn over_time(view: &TrajectoryEvidence) -> Result<Markup, FigureError> {
    let used = view.used_s.map(|x| Span {
        x,
        colour: Colour::Series(5),
        label: "traces in the image".to_owned(),
    });
    let heights = view.position_m.iter().map(|p| p[2] - view.plane_z_m);
    let height: Vec<f64> = heights.collect();
    let sigma: Vec<f64> = view.sigma_m.iter().map(|s| s[2]).collect();
    let speed = speed_m_s(view);
    let gap_s = status::longest_step_s(&view.time_s);
    let name = match sigma.is_empty() {
        true => "height",
        false => "height ±1σ",
    };
    let axis = || match view.is_untimed {
        true => Axis::new("number of the trace", ""),
        false => Axis::new("trajectory time", "s"),
    };
    let plot = |label: &str, unit: &str, series, height_px| {
        let plot = LinePlot::new("", axis(), Axis::new(label, unit));
        let mut plot = plot.height(height_px).with(series);
        plot.spans.extend(used.clone());
        Panel::Plot(plot)
    };
    let height_above = Series::line(name, &view.time_s, &height)
        .band(&sigma)
        .broken_after(gap_s);
    let mut stack = Stack::new(axis()).with(plot(
        "height above the image plane",
        "m",
        height_above,
        220.0,
    ));
    if !view.is_untimed {
        let speed = Series::line("", &view.time_s, &speed).broken_after(gap_s);
        stack = stack.with(plot("speed over ground", "m/s", speed, 150.0));
    }
    let stack = stack.with(Panel::Timeline(Timeline {
        title: String::new(),
        x: axis(),
        rows: status::rows(&view.time_s, &view.status),
        width_px: 860.0,
    }));
    let [alt, caption] = match view.is_untimed {
        true => [
            "Height above the image plane and solution status over the traces",
            "Height and solution status of the traces.",
        ],
        false => [
            "Height above the image plane, speed over ground and solution status over time",
            "Height, speed and solution status over time. Positions that are not fixed blur the image.",
        ],
    };
    Ok(html::drawing(stack.draw()?, Fit::Scrolled, alt, caption))
}

/// All tracks from above, with the targets.
fn map(tracks: &[TrackEvidence], targets: &[TargetRow]) -> Result<Markup, FigureError> {
    let several = tracks.len() > 1;
    let mut lines = Vec::new();
    for track in tracks {
        if let Some(view) = &track.trajectory {
            lines.push((track, view, columns(view, |_| true)));
        }
    }
    let used: Vec<_> = lines
        .iter()
        .filter_map(|(_, view, _)| {
            let [from, to] = view.used_s?;
            Some(columns(view, |time_s| (from..=to).contains(&time_s)))
        })
        .collect();
    let mut plot = LinePlot::new("", Axis::new("x", "m"), Axis::new("y", "m"))
        .equal()
        .height(MAP_HEIGHT_PX);
    plot.width_px = MAP_WIDTH_PX;
    for (k, (track, _, (x, y))) in lines.iter().enumerate() {
        let name = match (several, used.is_empty()) {
            (true, _) => titled(&track.name),
            (false, true) => "track".to_owned(),
            (false, false) => "whole track".to_owned(),
        };
        let line = Series {
            line_px: if several { 1.8 } else { 1.2 },
            ..Series::line(name, x, y)
        };
        plot = plot.with(match (several, used.is_empty()) {
            (true, _) => line.colour(Colour::Series(TRACK_COLOURS[k % TRACK_COLOURS.len()])),
            (false, true) => line,
            (false, false) => line.colour(Colour::Series(7)),
        });
    }
    for (x, y) in used.iter().filter(|_| !several) {
        let part = Series::line("traces in the image", x, y).colour(Colour::Series(0));
        plot = plot.with(Series {
            line_px: 2.6,
            ..part
        });
    }
    let (start_x, start_y): (Vec<f64>, Vec<f64>) = lines
        .iter()
        .filter_map(|(_, _, (x, y))| Some((*x.first()?, *y.first()?)))
        .unzip();
    let (target_x, target_y): (Vec<f64>, Vec<f64>) = targets.iter().map(|t| (t.x_m, t.y_m)).unzip();
    let dots = |label: &str, x, y, colour| {
        let dots = Series::dots(label, x, y).colour(Colour::Series(colour));
        Series {
            dot_px: 4.5,
            ..dots
        }
    };
    plot = plot.with(dots("start", &start_x, &start_y, 2));
    if !targets.is_empty() {
        plot = plot.with(dots("targets", &target_x, &target_y, 1));
    }
    Ok(html::drawing(
        plot.draw()?,
        Fit::Whole,
        "Map of the flight from above, with its start and the targets",
        "The flight from above; x and y to the same scale.",
    ))
}

/// Greatest size of maps: shown on a telephone without text too small to read.
const MAP_WIDTH_PX: f32 = 480.0;
const MAP_HEIGHT_PX: f32 = 420.0;
/// Colours of tracks, apart from those of start and targets.
const TRACK_COLOURS: [usize; 4] = [0, 3, 4, 6];

/// x and y of the positions at times that `wanted` accepts; not finite between lines.
fn columns(view: &TrajectoryEvidence, wanted: impl Fn(f64) -> bool) -> (Vec<f64>, Vec<f64>) {
    let mut columns = (Vec::new(), Vec::new());
    let mut starts = view.line_starts.iter().peekable();
    for (k, (time_s, place)) in view.time_s.iter().zip(&view.position_m).enumerate() {
        let begins = starts.next_if(|start| **start == k).is_some();
        if begins && !columns.0.is_empty() {
            columns.0.push(f64::NAN);
            columns.1.push(f64::NAN);
        }
        if wanted(*time_s) {
            columns.0.push(place[0]);
            columns.1.push(place[1]);
        }
    }
    columns
}

/// Speed over ground between neighbouring positions, assigned to the later one; NaN where the time does not
/// advance.
fn speed_m_s(view: &TrajectoryEvidence) -> Vec<f64> {
    let steps = view.time_s.windows(2).zip(view.position_m.windows(2));
    let speeds = steps.map(|(time_s, position_m)| {
        let dt = time_s[1] - time_s[0];
        let [a, b] = [position_m[0], position_m[1]];
        if dt > 0.0 {
            (b[0] - a[0]).hypot(b[1] - a[1]) / dt
        } else {
            f64::NAN
        }
    });
    std::iter::once(f64::NAN).chain(speeds).collect()
}

fn alignment(view: &AlignmentEvidence) -> Result<Markup, FigureError> {
    let score = match view.score_name.as_str() {
        "" => "agreement",
        name => name,
    };
    let plot = LinePlot::new("", Axis::new("time offset", "s"), Axis::new(score, ""))
        .height(200.0)
        .with(Series::line("", &view.offset_s, &view.score))
        .reference(ReferenceLine {
            at_x: true,
            value: view.chosen_s,
            label: format!("taken: {} s", fixed(view.chosen_s, 3)),
        });
    let alt = format!(
        "{score} over time offset; {} s was taken",
        fixed(view.chosen_s, 3)
    );
    let drawing = plot.draw()?;
    Ok(html::drawing(
        drawing,
        Fit::Scrolled,
        &alt,
        &with_minus_signs(&view.remark),
    ))
}

fn surface(view: &SurfaceEvidence) -> Result<Markup, FigureError> {
    let pairs = view.picked_range_m.iter().zip(&view.height_m);
    let difference: Vec<f64> = pairs.map(|(picked, height)| picked - height).collect();
    let median = quantile(difference.iter().copied(), 0.5);
    let from_median = difference.iter().map(|d| (d - median.unwrap_or(0.0)).abs());
    let spread = quantile(from_median, 0.5).map(|mad| 1.4826 * mad);
    let picked = difference.iter().filter(|d| d.is_finite()).count();
    let plot = LinePlot::new(
        "",
        Axis::new("trajectory time", "s"),
        Axis::new("range, height", "m"),
    )
    .height(220.0)
    .with(Series::line(
        "height from the trajectory",
        &view.time_s,
        &view.height_m,
    ))
    .with(Series::dots(
        "range of the surface echo",
        &view.time_s,
        &view.picked_range_m,
    ));
    let drawing = html::drawing(
        plot.draw()?,
        Fit::Scrolled,
        "Range of the surface echo and height from the trajectory over time",
        &with_minus_signs(&view.remark),
    );
    Ok(html! {
        p {
            "Fast time was shifted by " (fixed(view.shift_ns, 3)) " ns. Picked in " (picked) " of "
            (view.time_s.len()) " traces; picked range minus height: median " (fixed(median, 3))
            " m, robust standard deviation " (fixed(spread, 3)) " m."
        }
        (drawing)
    })
}

/// Lists of one track that belong together have one length.
fn check(track: &TrackEvidence) -> Result<(), FigureError> {
    let mut lengths = Vec::new();
    if let Some(view) = &track.trajectory {
        let n = view.time_s.len();
        lengths.push(("trajectory positions", n, view.position_m.len()));
        lengths.push(("trajectory status", n, view.status.len()));
        if !view.sigma_m.is_empty() {
            lengths.push(("trajectory standard deviations", n, view.sigma_m.len()));
        }
    }
    if let Some(view) = &track.surface {
        let n = view.time_s.len();
        lengths.push(("picked surface", n, view.picked_range_m.len()));
        lengths.push(("surface heights", n, view.height_m.len()));
    }
    for (what, expected, found) in lengths {
        if expected != found {
            return Err(FigureError::ShapeMismatch {
                what,
                expected,
                found,
            });
        }
    }
    Ok(())
}
