//! The image and the measurements in it.

use super::data::{ReportData, TargetRow, Widths};
use super::html::{self, Table};
use super::numbers::fixed;
use crate::surveyed::SurveyRecord;
use maud::{Markup, html};

pub(super) fn section(data: &ReportData) -> Markup {
    html! {
        section #result {
            h2 { "Result" }
            (html::tiles(&data.facts))
            @if data.targets.is_empty() {
                p.muted { "No targets above the clutter." }
            } @else {
                h3 { "Targets" }
                (places(&data.targets))
                (widths(&data.targets))
                (ghosts(&data.targets))
                (surveyed(&data.surveyed))
                @for remark in &data.remarks {
                    p.note { (remark) }
                }
            }
        }
    }
}

fn surveyed(points: &[SurveyRecord]) -> Markup {
    let row = |point: &SurveyRecord| {
        let mut row = vec![point.name.clone()];
        row.extend([point.x_m, point.y_m, point.z_m].map(|v| fixed(v, 3)));
        match point.nearest {
            Some(nearest) => {
                row.push(nearest.target.to_string());
                let [east_m, north_m] = nearest.off_m;
                row.extend([east_m, north_m, nearest.distance_m].map(|v| fixed(v, 3)));
            }
            None => row.extend(["–"; 4].map(str::to_owned)),
        }
        row
    };
    let table = Table {
        caption: "Surveyed points and the target nearest to each: offset of the target from the point, east \
                  and north, and the horizontal distance.",
        head: &[
            "point",
            "x (m)",
            "y (m)",
            "z (m)",
            "nearest target",
            "east of it (m)",
            "north of it (m)",
            "distance (m)",
        ],
        rows: &points.iter().map(row).collect::<Vec<_>>(),
    };
    html! {
        @if !points.is_empty() {
            h3 { "Surveyed points" }
            (html::table(&table))
        }
    }
}

fn number(i: usize) -> String {
    (i + 1).to_string()
}

fn places(targets: &[TargetRow]) -> Markup {
    let is_below = targets.iter().any(|target| target.depth_m.is_some());
    let row = |(i, t): (usize, &TargetRow)| {
        let mut row = vec![number(i), fixed(t.x_m, 3), fixed(t.y_m, 3), fixed(t.z_m, 3)];
        if is_below {
            row.push(depth(t.depth_m));
            row.push(match t.exceeds_clutter {
                Some(true) => "yes".to_owned(),
                Some(false) => "no".to_owned(),
                None => fixed(None, 0),
            });
        }
        row.extend(
            [
                t.level_db,
                t.pslr_db.unwrap_or(f64::NAN),
                t.islr_db.unwrap_or(f64::NAN),
            ]
            .map(|v| fixed(v, 1)),
        );
        row
    };
    let mut head = vec!["target", "x (m)", "y (m)", "z (m)"];
    if is_below {
        head.push("depth below the surface (m)");
        head.push("above the clutter at its depth");
    }
    head.extend(["level (dB)", "PSLR (dB)", "ISLR (dB)"]);
    html::table(&Table {
        caption: "Places and sidelobes: level relative to the image's maximum, \
                  peak and integrated sidelobe ratio.",
        head: &head,
        rows: &targets.iter().enumerate().map(row).collect::<Vec<_>>(),
    })
}

/// A depth with its standard deviation.
fn depth(depth_m: Option<[f64; 2]>) -> String {
    depth_m.map_or_else(
        || fixed(None, 3),
        |[depth_m, sigma_m]| format!("{} ± {}", fixed(depth_m, 3), fixed(sigma_m, 3)),
    )
}

fn widths(targets: &[TargetRow]) -> Markup {
    let three = |w: &Widths| [w.rayleigh_m, w.width_3db_m, w.width_6db_m].map(|v| fixed(v, 3));
    let row = |(i, t): (usize, &TargetRow)| {
        let mut row = vec![number(i)];
        row.extend(three(&t.along));
        row.extend(three(&t.across));
        row.extend([t.across.inner_m, t.across.outer_m].map(|v| fixed(v, 3)));
        row
    };
    html::table(&Table {
        caption: "Widths of the targets in metres. Rayleigh: from the peak to the first minimum, \
                  the mean of both sides; inner and outer: the Rayleigh widths across the track, \
                  towards it and away from it. −3 and −6 dB: full widths between the points of \
                  that level.",
        head: &[
            "target",
            "along, Rayleigh",
            "along, −3\u{a0}dB",
            "along, −6\u{a0}dB",
            "across, Rayleigh",
            "across, −3\u{a0}dB",
            "across, −6\u{a0}dB",
            "across, Rayleigh inner",
            "across, Rayleigh outer",
        ],
        rows: &targets.iter().enumerate().map(row).collect::<Vec<_>>(),
    })
}

fn ghosts(targets: &[TargetRow]) -> Markup {
    let row = |(i, t): (usize, &TargetRow)| {
        let ghost = t.ghost?;
        Some(vec![
            number(i),
            fixed(ghost.x_m, 3),
            fixed(ghost.y_m, 3),
            fixed(ghost.level, 3),
            fixed(20.0 * ghost.level.log10(), 1),
        ])
    };
    let rows: Vec<_> = targets.iter().enumerate().filter_map(row).collect();
    let table = Table {
        caption: "Left–right ghosts: the mirror image of a target at the track, and its amplitude relative \
                  to the target. A single straight track cannot distinguish left from right.",
        head: &[
            "ghost of target",
            "x (m)",
            "y (m)",
            "relative amplitude",
            "level (dB)",
        ],
        rows: &rows,
    };
    html! {
        @if !rows.is_empty() {
            (html::table(&table))
        }
    }
}
