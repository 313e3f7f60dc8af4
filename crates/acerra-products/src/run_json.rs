//! `targets.json` and `run.json`.

use serde_json::{Value, json};

use acerra_chain::Outcome;
use acerra_chain::stages::Stage;

/// `targets.json`: what the image shows.
#[must_use]
pub fn targets(outcome: &Outcome) -> Value {
    let measured = &outcome.measured;
    json!({
        "targets": measured.targets,
        "image": measured.statistics,
        "maxima": {
            "above_threshold": measured.maxima,
            "sidelobes": measured.sidelobes,
            "ghosts": measured.ghosts,
            "not_examined": measured.skipped,
        },
    })
}

/// `run.json`: what was done with which input, and what it cost.
#[must_use]
pub fn run(outcome: &Outcome, stages: &[Stage]) -> Value {
    let aligned = &outcome.aligned;
    let search = aligned.search.as_ref().map(|search| {
        json!({
            "time_offset_s": search.time_offset_s,
            "motion_offset_s": search.motion.offset_s,
            "correlation": search.motion.correlation,
            "runner_up": search.motion.runner_up,
            "confidence": search.motion.confidence,
            "sharpness_ratio": search.sharpness_ratio,
            "sharpness": {
                "offset_s": search.sharpness.offset_s,
                "score": search.sharpness.score,
            },
        })
    });
    let traces = outcome.cleaned.traces.as_ref();
    let surface = traces.and_then(|t| t.surface.as_ref()).map(|surface| {
        json!({
            "median_residual_s": surface.median_residual_s,
            "spread_s": surface.spread_s,
            "contrast_db": surface.contrast_db,
        })
    });
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "configuration": outcome.campaign,
        "inputs": outcome.inputs,
        "stages": stages,
        "warnings": outcome.warnings,
        "time_offset_s": aligned.time_offset_s,
        "time_offset_search": search,
        "zero_timing": {
            "shift_ns": traces.map(|t| t.shift_s * 1e9),
            "surface": surface,
        },
        "traces": {
            "in_log": outcome.traces_in_log,
            "selected": aligned.traces.len(),
            "first": aligned.traces.first(),
            "last": aligned.traces.last(),
        },
        "tracks": outcome.tracks.iter().map(|track| json!({
            "name": track.name,
            "traces_in_log": track.radar.content.time_s().len(),
            "selected": track.aligned.traces.len(),
            "time_offset_s": track.aligned.time_offset_s,
            "shift_ns": track.cleaned.traces.as_ref().map(|t| t.shift_s * 1e9),
            "calibration": track.calibration,
        })).collect::<Vec<_>>(),
        "looks": outcome.focused.multilook.as_ref().map(|m| &m.traces),
        "plan": outcome.focused.plan,
        "plan_checked_error": outcome.focused.checked_error,
        "memory": {
            "promised_bytes": outcome.focused.promised_bytes,
            "image_bytes": outcome.focused.image.len() * 8,
        },
    })
}
