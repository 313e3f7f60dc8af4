//! The evidence: trajectory, alignment, zero-timing, radargrams, cuts.

use super::data::{
    AlignmentEvidence, Cut, ReportData, SurfaceEvidence, TargetRow, TrajectoryEvidence,
};
use super::numbers::{fixed, quantile};
use super::page;
use acerra_figure::{
    Axis, Colour, FigureError, LinePlot, ReferenceLine, Series, Span, Timeline, TimelineRow,
    cut_plot,
};
use acerra_geo::trajectory::SolutionStatus;
use std::fmt::Write as _;

pub(super) fn write(out: &mut String, data: &ReportData) -> Result<(), FigureError> {
    out.push_str("<section id=\"evidence\">\n<h2>Evidence</h2>\n");
    if let Some(trajectory) = &data.trajectory {
        write_trajectory(out, trajectory, &data.targets)?;
    }
    if let Some(alignment) = &data.alignment {
        write_alignment(out, alignment)?;
    }
    if let Some(surface) = &data.surface {
        write_surface(out, surface)?;
    }
    if data.radargram_raw.is_some() || data.radargram_clean.is_some() {
        out.push_str("<h3>Radargrams</h3>\n");
    }
    for picture in data.radargram_raw.iter().chain(&data.radargram_clean) {
        page::picture(out, picture);
    }
    for picture in &data.pictures {
        page::picture(out, picture);
    }
    write_cuts(out, &data.targets)?;
    out.push_str("</section>\n");
    Ok(())
}

/// The colour by which a status is shown.
pub(super) fn colour(status: SolutionStatus) -> Colour {
    match status {
        SolutionStatus::Fixed | SolutionStatus::External => Colour::Series(2),
        SolutionStatus::Float => Colour::Series(4),
        SolutionStatus::Ppp => Colour::Series(0),
        SolutionStatus::Dgps | SolutionStatus::Sbas => Colour::Series(3),
        SolutionStatus::Single => Colour::Series(1),
        _ => Colour::Series(7),
    }
}

fn write_trajectory(
    out: &mut String,
    view: &TrajectoryEvidence,
    targets: &[TargetRow],
) -> Result<(), FigureError> {
    let n = view.time_s.len();
    check(n, view.position_m.len(), "trajectory positions")?;
    check(n, view.status.len(), "trajectory status")?;
    if !view.sigma_m.is_empty() {
        check(n, view.sigma_m.len(), "trajectory standard deviations")?;
    }
    out.push_str("<h3>Trajectory</h3>\n");
    if n == 0 {
        out.push_str("<p class=\"muted\">It holds no positions.</p>\n");
        return Ok(());
    }
    let fixed_count = view.status.iter().filter(|s| s.is_fixed()).count();
    let mut sentence = format!(
        "{n} positions over {} s, {} % of them of imaging grade (fixed ambiguities, or taken at \
         their word)",
        fixed(view.time_s[n - 1] - view.time_s[0], 1),
        fixed(100.0 * fixed_count as f64 / n as f64, 1),
    );
    if !view.sigma_m.is_empty() {
        let median = |axis: usize| {
            let middle = quantile(view.sigma_m.iter().map(|s| s[axis]), 0.5);
            fixed(middle.map(|m| m * 1e3), 0)
        };
        let _ = write!(
            sentence,
            "; median standard deviation {} mm east, {} mm north, {} mm up",
            median(0),
            median(1),
            median(2)
        );
    }
    let _ = writeln!(out, "<p>{sentence}.</p>");

    plan(out, view, targets)?;
    let used = view.used_s.map(|x| Span {
        x,
        colour: Colour::Series(5),
        label: "traces in the image".to_owned(),
    });
    let height: Vec<f64> = view
        .position_m
        .iter()
        .map(|p| p[2] - view.plane_z_m)
        .collect();
    let sigma: Vec<f64> = view.sigma_m.iter().map(|s| s[2]).collect();
    let label = if sigma.is_empty() {
        "height"
    } else {
        "height ±1σ"
    };
    let mut plot = LinePlot::new(
        "",
        Axis::new("time", "s"),
        Axis::new("height above the image plane", "m"),
    )
    .height(220.0)
    .with(Series::line(label, &view.time_s, &height).band(&sigma));
    plot.spans.extend(used.clone());
    page::drawing(out, &plot.draw()?, "");

    let speed = speed_m_s(view);
    let mut plot = LinePlot::new(
        "",
        Axis::new("time", "s"),
        Axis::new("speed over ground", "m/s"),
    )
    .height(160.0)
    .with(Series::line("", &view.time_s, &speed));
    plot.spans.extend(used);
    page::drawing(out, &plot.draw()?, "");

    let timeline = Timeline {
        title: String::new(),
        x: Axis::new("time", "s"),
        rows: status_rows(view),
        width_px: 860.0,
    };
    page::drawing(
        out,
        &timeline.draw()?,
        "Solution status over time. Positions that are not fixed blur the image.",
    );
    Ok(())
}

fn plan(
    out: &mut String,
    view: &TrajectoryEvidence,
    targets: &[TargetRow],
) -> Result<(), FigureError> {
    let (x, y): (Vec<f64>, Vec<f64>) = view.position_m.iter().map(|p| (p[0], p[1])).unzip();
    let used: Vec<usize> = match view.used_s {
        Some([from, to]) => (0..x.len())
            .filter(|i| (from..=to).contains(&view.time_s[*i]))
            .collect(),
        None => Vec::new(),
    };
    let pick = |list: &[f64]| used.iter().map(|i| list[*i]).collect::<Vec<f64>>();
    let (used_x, used_y) = (pick(&x), pick(&y));
    let (target_x, target_y): (Vec<f64>, Vec<f64>) = targets.iter().map(|t| (t.x_m, t.y_m)).unzip();
    let mut plot = LinePlot::new("", Axis::new("x", "m"), Axis::new("y", "m"))
        .equal()
        .height(420.0);
    let whole = if used.is_empty() {
        "track"
    } else {
        "whole track"
    };
    let thin = Series {
        line_px: 1.2,
        ..Series::line(whole, &x, &y)
    };
    plot = plot.with(if used.is_empty() {
        thin
    } else {
        thin.colour(Colour::Series(7))
    });
    if !used.is_empty() {
        let part = Series::line("traces in the image", &used_x, &used_y);
        plot = plot.with(Series {
            line_px: 2.6,
            ..part.colour(Colour::Series(0))
        });
    }
    let start = Series {
        dot_px: 4.5,
        ..Series::dots("start", &x[..1], &y[..1])
    };
    plot = plot.with(start.colour(Colour::Series(2)));
    if !targets.is_empty() {
        let marks = Series {
            dot_px: 4.5,
            ..Series::dots("targets", &target_x, &target_y)
        };
        plot = plot.with(marks.colour(Colour::Series(1)));
    }
    page::drawing(out, &plot.draw()?, "The track from above.");
    Ok(())
}

/// Speed over ground between neighbouring fixes, given to the later one; NaN where time stands.
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

/// One row per status that occurs, best first, named with its share of the positions. A fix holds
/// until the next one, but no longer than three usual intervals: a gap stays a gap.
fn status_rows(view: &TrajectoryEvidence) -> Vec<TimelineRow> {
    let steps = view.time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let usual = quantile(steps, 0.5)
        .filter(|step| *step > 0.0)
        .unwrap_or(1.0);
    let n = view.time_s.len();
    let mut rows = Vec::new();
    for status in SolutionStatus::ALL {
        let mut stretches: Vec<[f64; 2]> = Vec::new();
        let mut count = 0;
        for i in (0..n).filter(|i| view.status[*i] == status) {
            count += 1;
            let from = view.time_s[i];
            let next = view.time_s.get(i + 1).copied().unwrap_or(from + usual);
            let to = if next - from <= 3.0 * usual {
                next
            } else {
                from + usual
            };
            match stretches.last_mut() {
                Some(last) if last[1] >= from => last[1] = to,
                _ => stretches.push([from, to]),
            }
        }
        if count > 0 {
            let share = fixed(100.0 * f64::from(count) / n as f64, 1);
            let label = format!("{} {share} %", status.name());
            rows.push(TimelineRow {
                label,
                colour: colour(status),
                stretches,
            });
        }
    }
    rows
}

fn write_alignment(out: &mut String, view: &AlignmentEvidence) -> Result<(), FigureError> {
    out.push_str("<h3>Alignment in time</h3>\n");
    let score = if view.score_name.is_empty() {
        "agreement"
    } else {
        &view.score_name
    };
    let plot = LinePlot::new("", Axis::new("time offset", "s"), Axis::new(score, ""))
        .height(200.0)
        .with(Series::line("", &view.offset_s, &view.score))
        .reference(ReferenceLine {
            at_x: true,
            value: view.chosen_s,
            label: format!("taken: {} s", fixed(view.chosen_s, 3)),
        });
    page::drawing(out, &plot.draw()?, &view.remark);
    Ok(())
}

fn write_surface(out: &mut String, view: &SurfaceEvidence) -> Result<(), FigureError> {
    check(
        view.time_s.len(),
        view.picked_range_m.len(),
        "picked surface",
    )?;
    check(view.time_s.len(), view.height_m.len(), "surface heights")?;
    out.push_str("<h3>Zero-timing: surface echo against height</h3>\n");
    let difference: Vec<f64> = view
        .picked_range_m
        .iter()
        .zip(&view.height_m)
        .map(|(p, h)| p - h)
        .collect();
    let median = quantile(difference.iter().copied(), 0.5);
    let spread = quantile(
        difference.iter().map(|d| (d - median.unwrap_or(0.0)).abs()),
        0.5,
    )
    .map(|mad| 1.4826 * mad);
    let picked = difference.iter().filter(|d| d.is_finite()).count();
    let _ = writeln!(
        out,
        "<p>Fast time was shifted by {} ns. Picked in {picked} of {} traces; picked range minus \
         height: median {} m, robust standard deviation {} m.</p>",
        fixed(view.shift_ns, 3),
        view.time_s.len(),
        fixed(median, 3),
        fixed(spread, 3)
    );
    let plot = LinePlot::new("", Axis::new("time", "s"), Axis::new("range, height", "m"))
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
    page::drawing(out, &plot.draw()?, &view.remark);
    Ok(())
}

fn write_cuts(out: &mut String, targets: &[TargetRow]) -> Result<(), FigureError> {
    let with_cuts = |t: &&TargetRow| t.cuts.is_some();
    if targets.iter().any(|t| with_cuts(&t)) {
        out.push_str(
            "<h3>Cuts through the targets</h3>\n<p>Beside each cut stands that of an ideal point \
             seen from the same flight: where the image is wider or its sidelobes are higher, \
             the antennas or the target see less of the flight than an ideal point does, or the \
             positions are off.</p>\n",
        );
    }
    for (i, target) in targets.iter().enumerate() {
        let Some(cuts) = &target.cuts else {
            continue;
        };
        write_cut(
            out,
            format!("Target {}, along the track", i + 1),
            &cuts.along,
        )?;
        write_cut(
            out,
            format!("Target {}, across the track", i + 1),
            &cuts.across,
        )?;
    }
    Ok(())
}

fn write_cut(out: &mut String, title: String, cut: &Cut) -> Result<(), FigureError> {
    let mut curves = vec![("image", cut.distance_m.as_slice(), cut.image_db.as_slice())];
    if !cut.theory_db.is_empty() {
        curves.push((
            "ideal point, Eq. (5)",
            cut.distance_m.as_slice(),
            cut.theory_db.as_slice(),
        ));
    }
    let plot = cut_plot(title, &curves, -40.0).height(210.0);
    page::drawing(out, &plot.draw()?, "");
    Ok(())
}

fn check(expected: usize, found: usize, what: &'static str) -> Result<(), FigureError> {
    if expected == found {
        Ok(())
    } else {
        Err(FigureError::ShapeMismatch {
            what,
            expected,
            found,
        })
    }
}
