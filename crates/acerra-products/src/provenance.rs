//! Origin of a product, as every format for other programs carries it.

use std::path::Path;

use acerra_geo::time::GpsTime;
use serde_json::Value;

use crate::outcome::Outcome;

/// Names and values: program, campaign, inputs with SHA-256, time span, frame and datum, evidence.
pub(crate) fn items(outcome: &Outcome) -> Vec<(String, String)> {
    let mut items = vec![
        (
            "ACERRA_VERSION".to_owned(),
            env!("CARGO_PKG_VERSION").to_owned(),
        ),
        ("CAMPAIGN".to_owned(), outcome.name.clone()),
        ("EVIDENCE".to_owned(), outcome.evidence.summary()),
    ];
    if !outcome.unchecked.is_empty() {
        let settings: Vec<&str> = outcome.unchecked.iter().map(|one| one.setting).collect();
        items.push(("UNCHECKED".to_owned(), settings.join(", ")));
    }
    if let Ok(mut configuration) = serde_json::to_value(&outcome.campaign) {
        let paths: Vec<&Path> = outcome.inputs.iter().map(|i| i.path.as_path()).collect();
        without_folders(&mut configuration, &paths);
        items.push(("CONFIGURATION".to_owned(), configuration.to_string()));
    }
    items.extend(frame(outcome));
    if let Some(span) = time_span(outcome) {
        let [first, last] = span.map(|at| at.format_calendar(3));
        items.push(("TIME_SPAN_GPST".to_owned(), format!("{first} to {last}")));
    }
    for input in &outcome.inputs {
        let name = input.path.file_name().unwrap_or(input.path.as_os_str());
        let name = format!("INPUT_{}", name.to_string_lossy());
        items.push((name, format!("sha256 {}", input.sha256)));
    }
    items
}

/// Inputs by their names alone: their folders on one computer are meaningless on another, and products of the
/// same inputs are bitwise equal.
pub(crate) fn without_folders(value: &mut Value, inputs: &[&Path]) {
    match value {
        Value::String(text) => {
            let named = inputs.iter().find(|path| **path == Path::new(text));
            if let Some(name) = named.and_then(|path| path.file_name()) {
                *text = name.to_string_lossy().into_owned();
            }
        }
        Value::Array(values) => values.iter_mut().for_each(|v| without_folders(v, inputs)),
        Value::Object(map) => map.values_mut().for_each(|v| without_folders(v, inputs)),
        Value::Null | Value::Bool(_) | Value::Number(_) => {}
    }
}

fn frame(outcome: &Outcome) -> Vec<(String, String)> {
    let z_m = outcome.focused.pixels.middle_m();
    let item = |name: &str, value: String| (name.to_owned(), value);
    let Some(frame) = outcome.prepared.first().positions.earth_frame() else {
        return vec![
            item(
                "FRAME",
                "local; its place on the Earth is not known".to_owned(),
            ),
            item("IMAGE_HEIGHT_M", format!("{z_m} in the local frame")),
        ];
    };
    let origin = frame.origin();
    vec![
        item("FRAME", "east, north, up about the origin".to_owned()),
        item(
            "ORIGIN_DEG_M",
            format!(
                "{:.10} {:.10} {:.4}",
                origin.latitude_deg(),
                origin.longitude_deg(),
                origin.height_m
            ),
        ),
        item(
            "HORIZONTAL_DATUM",
            "WGS 84, as realised by the coordinates of the base".to_owned(),
        ),
        item(
            "VERTICAL_DATUM",
            "WGS 84 ellipsoid (heights are not above the sea)".to_owned(),
        ),
        item(
            "IMAGE_HEIGHT_M",
            format!(
                "{:.4} above the ellipsoid at the origin",
                origin.height_m + z_m
            ),
        ),
    ]
}

/// First and last time of the traces imaged of the first track.
pub(crate) fn time_span(outcome: &Outcome) -> Option<[GpsTime; 2]> {
    let first = outcome.prepared.first();
    let zero = first.positions.time_origin().gps_time()?;
    let time_s = outcome.prepared.aligned.time_s.get(first.range.clone())?;
    let at = |radar_s: f64| zero + (radar_s + first.time_offset_s);
    Some([at(*time_s.first()?), at(*time_s.last()?)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_named_without_their_folders() {
        let input = Path::new("/home/someone/flight/radar.mrm");
        let mut campaign = serde_json::json!({
            "radar": { "file": "/home/someone/flight/radar.mrm" },
            "trajectory": [{ "note": "/home" }, 3],
        });
        without_folders(&mut campaign, &[input]);
        assert_eq!(campaign["radar"]["file"], "radar.mrm");
        assert_eq!(campaign["trajectory"][0]["note"], "/home");
    }
}
