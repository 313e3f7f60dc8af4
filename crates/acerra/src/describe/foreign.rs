//! Radar files of other makers.

use std::path::Path;

use acerra_formats::{Axis, Channel, Limits, Positions, Values, open};
use serde_json::{Value, json};

use super::description::Description;

/// Header lines that are shown at most, and characters of each.
const HEADER_LINES: usize = 60;
const HEADER_CHARACTERS: usize = 400;

pub fn describe(path: &Path) -> anyhow::Result<Description> {
    let recording = open(path, &Limits::default())?;
    let mut d = Description::new(recording.format.name());
    let channel = recording.channel(None)?;
    d.fact("traces", channel.traces);
    d.fact("samples", channel.axis.samples());
    axis(&mut d, &channel.axis);
    let names: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
    d.fact("channels", json!(names));
    d.fact("complex", matches!(channel.values, Values::Complex(_)));
    places(&mut d, channel);
    d.fact("marks", recording.marks.len());
    d.fact("skipped_bytes", recording.skipped_bytes);
    d.fact("largest_amplitude", largest(&channel.values));
    let mut header = serde_json::Map::new();
    for (name, value) in recording.header.iter().take(HEADER_LINES) {
        let text: String = value.chars().take(HEADER_CHARACTERS).collect();
        header.insert(name.clone(), Value::from(text));
    }
    if !header.is_empty() {
        d.fact("header", header);
    }
    d.notes.extend(recording.remarks.iter().cloned());
    d.notes.extend(recording.contradictions.iter().map(|c| {
        format!(
            "contradiction: {}: {} and {} {}",
            c.about, c.used, c.other, c.unit
        )
    }));
    Ok(d)
}

fn axis(d: &mut Description, axis: &Axis) {
    match axis {
        Axis::FastTime {
            start_s,
            step_s,
            samples,
        } => {
            d.fact("sample_interval_s", *step_s);
            d.fact("fast_time_start_ns", start_s * 1e9);
            d.fact("window_ns", step_s * *samples as f64 * 1e9);
        }
        Axis::Frequency(hz) => {
            let (first, last) = (hz.first().copied(), hz.last().copied());
            d.fact(
                "frequency_hz",
                json!({"first": first, "last": last, "count": hz.len()}),
            );
        }
    }
}

fn places(d: &mut Description, channel: &Channel) {
    d.fact("positions", channel.positions.is_some());
    if let Some(Positions::Geodetic(places)) = &channel.positions {
        let ends = [places.first(), places.last()];
        d.fact("first_and_last_place_deg", json!(ends));
    }
    if let Some(Positions::Local(places)) = &channel.positions {
        let ends = [places.first(), places.last()];
        d.fact("first_and_last_place", json!(ends));
    }
    let ends = |v: &Option<Vec<f64>>| v.as_ref().and_then(|v| Some(v.last()? - v.first()?));
    if let Some(duration_s) = ends(&channel.time_s) {
        d.fact("duration_s", duration_s);
    }
    if let Some(way_m) = ends(&channel.along_m) {
        d.fact("way_m", way_m);
        if channel.traces > 1 {
            d.fact("trace_spacing_m", way_m / (channel.traces as f64 - 1.0));
        }
    }
    if let Some(apart_m) = channel.antenna_separation_m {
        d.fact("antenna_separation_m", apart_m);
    }
}

fn largest(values: &Values) -> f64 {
    match values {
        Values::Real(v) => f64::from(v.iter().fold(0.0f32, |m, x| m.max(x.abs()))),
        Values::Complex(v) => f64::from(v.iter().fold(0.0f32, |m, z| m.max(z.norm()))),
    }
}
