//! The finding on the spacing of traces that the ends of lines place, by the shapes of echoes.

use crate::control::{Cancelled, Control};
use crate::focus::Focused;
use crate::journal::finding::{DOUBTFUL_SIGMAS, Finding, Verdict};
use crate::position::Positions;
use crate::prepare::{Prepared, Track};
use crate::soil::evidence::spacing_below;
use crate::soil::spacing::Spacing;

/// Share by which odometers and stated ends of lines may be off.
const TOLERANCE: f64 = 0.05;

/// Judges the spacing of a track's traces; no finding where positions were measured, for images above ground, and where no
/// echo exceeds the clutter along its line.
///
/// # Errors
/// The caller asked to stop.
pub(super) fn weigh(
    prepared: &Prepared,
    focused: &Focused,
    track: &Track,
    control: &Control<'_>,
) -> Result<Option<Finding>, Cancelled> {
    match &track.positions {
        Positions::PerTrace(places) if places.is_by_line_ends => {}
        _ => return Ok(None),
    }
    let top = (focused.underground.as_ref()).and_then(|ground| ground.layers.first());
    let in_force = top.map(|layer| layer.soil.relative_permittivity);
    let spacing = spacing_below(prepared, focused, track, control)?;
    let stated_m = stated_m(prepared, track);
    Ok(spacing
        .zip(in_force)
        .zip(stated_m)
        .map(|((spacing, in_force), stated_m)| trace_spacing(&spacing, in_force, stated_m)))
}

/// Median distance between traces that follow one another on a line (m).
fn stated_m(prepared: &Prepared, track: &Track) -> Option<f64> {
    let places = prepared.aligned.position_m.get(track.range.clone())?;
    let lines = prepared.aligned.lines(track.range.clone());
    let apart_m = |pair: &[[f64; 3]]| {
        let squares = (0..3).map(|k| (pair[1][k] - pair[0][k]).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let mut steps_m: Vec<f64> = (lines.into_iter())
        .flat_map(|line| places[line].windows(2).map(apart_m))
        .collect();
    steps_m.sort_by(f64::total_cmp);
    steps_m.get(steps_m.len() / 2).copied()
}

fn trace_spacing(spacing: &Spacing, in_force: f64, stated_m: f64) -> Finding {
    let found_m = stated_m / spacing.stretch;
    let [least, most] = spacing.bounds.map(|stretch| stated_m / stretch);
    let is_off = (spacing.stretch.ln()).abs() > TOLERANCE.ln_1p();
    let verdict = match spacing.sigmas > DOUBTFUL_SIGMAS && is_off {
        true => Verdict::Doubtful,
        false => Verdict::Agrees,
    };
    let echoes = spacing.echoes;
    let seen = format!(
        "by the hyperbolas of {echoes} buried {} traces are {found_m:.4} m apart, {most:.4} to {least:.4} m within three \
         standard deviations; stated are {stated_m:.4} m",
        if echoes == 1 { "point" } else { "points" },
    );
    let permittivity = match spacing.permittivity {
        Some(value) => format!(
            "or the relative permittivity of the soil is about {value:.1}, and not {in_force:.1}"
        ),
        None => "and no permittivity of a soil from 1 to 100 explains them otherwise".to_owned(),
    };
    let explanation = match verdict {
        Verdict::Agrees => seen,
        _ => format!(
            "{seen}, {:.1} standard deviations away: the stated spacing is {:.2} times what the hyperbolas show ([radar] \
             line_start_m, line_end_m, distances that the file counts), {permittivity} ([ground] relative_permittivity). \
             Other possible causes: heights of the antennas, and pipes that cross the line obliquely",
            spacing.sigmas, spacing.stretch,
        ),
    };
    Finding {
        sigma: Some(found_m * (least / most).ln() / (2.0 * DOUBTFUL_SIGMAS)),
        ..Finding::judged("trace_spacing", found_m, "m", verdict).expecting(stated_m)
    }
    .because(explanation)
}
