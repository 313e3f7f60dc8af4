//! The pictures of a run: the image and the radargrams.

use acerra_imaging::Complex32;
use acerra_imaging::metrics::Target;
use acerra_radar::{Radargram, Samples};

use crate::chain::Outcome;
use crate::chain::clean::CleanedTraces;
use crate::figure::{
    FastTimeCurve, FigureError, GhostMark, ImageDb, PixelValues, Radargram as RadargramFigure,
    RadargramColours, TargetMark,
};

/// `image.png`: the image in decibels below its maximum, with track, targets and ghosts.
///
/// # Errors
/// A picture too large to hold.
pub fn image(outcome: &Outcome) -> Result<Vec<u8>, FigureError> {
    let grid = &outcome.focused.ground.grid;
    let track: Vec<[f64; 2]> = outcome
        .aligned
        .position_m
        .iter()
        .map(|p| [p[0], p[1]])
        .collect();
    let pixels: &[Complex32] = &outcome.focused.image;
    let mut figure = ImageDb::new(
        format!("Focused image {}", outcome.focused.ground.describe()),
        PixelValues::Complex(pixels),
        grid.nx,
        grid.ny,
    )
    .at(grid.x0_m, grid.y0_m, grid.pixel_m);
    figure.track_m = &track;
    for (k, target) in outcome.measured.targets.iter().enumerate() {
        figure.targets.push(mark(target, k));
        if let Some(ghost) = target.ghost {
            figure.ghosts.push(GhostMark {
                x_m: ghost.x_m,
                y_m: ghost.y_m,
                label: format!("ghost of {}", k + 1),
            });
        }
    }
    figure.draw()?.to_png()
}

fn mark(target: &Target, k: usize) -> TargetMark {
    TargetMark {
        x_m: target.x_m,
        y_m: target.y_m,
        label: (k + 1).to_string(),
    }
}

/// `radargram-raw.png`: the selected traces, zero-timed, with 2h/c, gate and surface picks.
///
/// # Errors
/// A picture too large to hold.
pub fn radargram_raw(outcome: &Outcome, traces: &CleanedTraces) -> Result<Vec<u8>, FigureError> {
    let mut curves = surface_and_gate(outcome, traces);
    if let Some(surface) = &traces.surface {
        curves.push(FastTimeCurve {
            label: "surface echo as picked".to_owned(),
            fast_time_ns: surface
                .fast_time_s
                .iter()
                .map(|t| t.map_or(f64::NAN, |t| t * 1e9))
                .collect(),
            dashed: false,
        });
    }
    draw(
        "Raw radargram, zero-timed",
        outcome,
        &traces.raw,
        -80.0,
        curves,
    )
}

/// `radargram.png`: the traces that entered the image, with 2h/c and the gate.
///
/// # Errors
/// A picture too large to hold.
pub fn radargram_clean(outcome: &Outcome, traces: &CleanedTraces) -> Result<Vec<u8>, FigureError> {
    draw(
        "Radargram without background, gated",
        outcome,
        &traces.clean,
        -50.0,
        surface_and_gate(outcome, traces),
    )
}

fn draw(
    title: &str,
    outcome: &Outcome,
    radargram: &Radargram,
    floor_db: f64,
    curves: Vec<FastTimeCurve>,
) -> Result<Vec<u8>, FigureError> {
    let moduli;
    let samples: &[f32] = match &radargram.samples {
        Samples::Real(values) => values,
        Samples::Complex(values) => {
            moduli = values.iter().map(|v| v.norm()).collect::<Vec<f32>>();
            &moduli
        }
    };
    let mut figure = RadargramFigure::new(
        title,
        samples,
        radargram.traces,
        radargram.samples_per_trace,
    )
    .fast_time(
        radargram.fast_time_start_s * 1e9,
        radargram.fast_time_step_s * 1e9,
    );
    figure.first_trace = outcome.aligned.traces.first().copied().unwrap_or(0);
    figure.unit = outcome.radar.unit.to_owned();
    figure.colours = RadargramColours::Decibel { floor_db };
    figure.time_s = &outcome.aligned.time_s;
    figure.curves = curves;
    figure.draw()?.to_png()
}

fn surface_and_gate(outcome: &Outcome, traces: &CleanedTraces) -> Vec<FastTimeCurve> {
    let c = outcome.campaign.image.light_speed_m_s;
    let surface_ns: Vec<f64> = outcome
        .aligned
        .height_m
        .iter()
        .map(|h| 2e9 * h / c)
        .collect();
    let shifted = |by_s: f64| surface_ns.iter().map(|t| t + by_s * 1e9).collect();
    let mut curves = vec![FastTimeCurve {
        label: "2h/c".to_owned(),
        fast_time_ns: shifted(0.0),
        dashed: false,
    }];
    for gate_s in traces.gate_s.into_iter().flatten() {
        curves.push(FastTimeCurve {
            label: "gate".to_owned(),
            fast_time_ns: shifted(gate_s),
            dashed: true,
        });
    }
    curves
}
