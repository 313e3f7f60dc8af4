//! First section: the image and what was measured in it.

use super::data::{ReportData, TargetRow, Widths};
use super::numbers::fixed;
use super::page;
use acerra_figure::FigureError;
use acerra_figure::markup::escape;
use std::fmt::Write as _;

pub(super) fn write(out: &mut String, data: &ReportData) -> Result<(), FigureError> {
    out.push_str("<section id=\"result\">\n<h2>Result</h2>\n");
    page::tiles(out, &data.facts);
    if let Some(image) = &data.image {
        page::picture(out, image);
    }
    if data.targets.is_empty() {
        out.push_str("<p class=\"muted\">No targets stand out of the image.</p>\n");
    } else {
        out.push_str("<h3>Targets</h3>\n");
        targets(out, &data.targets);
        for remark in &data.remarks {
            let _ = writeln!(out, "<p class=\"note\">{}</p>", escape(remark));
        }
    }
    out.push_str("</section>\n");
    Ok(())
}

fn targets(out: &mut String, targets: &[TargetRow]) {
    let number = |i: usize| (i + 1).to_string();
    let place: Vec<_> = targets
        .iter()
        .enumerate()
        .map(|(i, t)| {
            vec![
                number(i),
                fixed(t.x_m, 3),
                fixed(t.y_m, 3),
                fixed(t.z_m, 3),
                fixed(t.level_db, 1),
                fixed(t.pslr_db, 1),
                fixed(t.islr_db, 1),
            ]
        })
        .collect();
    page::table(
        out,
        "Where they are and how clean they stand: level relative to the image's maximum, peak and \
         integrated sidelobe ratio.",
        &[
            "target",
            "x (m)",
            "y (m)",
            "z (m)",
            "level (dB)",
            "PSLR (dB)",
            "ISLR (dB)",
        ],
        &place,
    );

    let widths = |w: &Widths| {
        [w.rayleigh_m, w.width_3db_m, w.width_6db_m]
            .map(|v| fixed(v, 3))
            .to_vec()
    };
    let resolution: Vec<_> = targets
        .iter()
        .enumerate()
        .map(|(i, t)| {
            let mut row = vec![number(i)];
            row.extend(widths(&t.along));
            row.extend(widths(&t.across));
            row.extend([t.across.inner_m, t.across.outer_m].map(|v| fixed(v, 3)));
            row
        })
        .collect();
    page::table(
        out,
        "Resolution in metres. Rayleigh: from the peak to the first minimum, across track the mean \
         of the sides towards the track (inner) and away from it (outer). −3 and −6 dB: full \
         widths.",
        &[
            "target",
            "along Rayleigh",
            "along −3\u{a0}dB",
            "along −6\u{a0}dB",
            "across Rayleigh",
            "across −3\u{a0}dB",
            "across −6\u{a0}dB",
            "inner",
            "outer",
        ],
        &resolution,
    );

    let ghosts: Vec<_> = targets
        .iter()
        .enumerate()
        .filter_map(|(i, t)| {
            let ghost = t.ghost?;
            Some(vec![
                number(i),
                fixed(ghost.x_m, 3),
                fixed(ghost.y_m, 3),
                fixed(ghost.level, 3),
                fixed(20.0 * ghost.level.log10(), 1),
            ])
        })
        .collect();
    if !ghosts.is_empty() {
        page::table(
            out,
            "Left–right ghosts: where a target mirrored at the track would stand, and its \
             amplitude relative to the target. A single straight track cannot tell left from right.",
            &[
                "ghost of target",
                "x (m)",
                "y (m)",
                "relative amplitude",
                "level (dB)",
            ],
            &ghosts,
        );
    }
}
