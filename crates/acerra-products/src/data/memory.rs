//! A run's contents from memory.

use std::path::Path;

use anyhow::Context;
use num_complex::Complex32;

use super::contents::{ImageContents, PulseContents, RadargramContents, RunContents, TargetPlace};
use super::table::Table;
use crate::outcome::Outcome;
use crate::provenance;

/// Data of a run whose product `trajectory.csv` is at `trajectory`.
pub(super) fn contents<'a>(
    outcome: &'a Outcome,
    trajectory: &Path,
) -> anyhow::Result<RunContents<'a>> {
    let pixels = &outcome.focused.pixels;
    let grid = &pixels.grid;
    let table = std::fs::read_to_string(trajectory).map_err(anyhow::Error::from);
    let table = table
        .and_then(|text| Table::parse(&text))
        .context("trajectory.csv")?;
    let frame = outcome.prepared.first().positions.earth_frame();
    let target = |target: &acerra_imaging::metrics::Target| {
        let place_m = [target.x_m, target.y_m, target.z_m];
        let place = frame.map(|f| f.geodetic_from_enu(place_m));
        TargetPlace {
            place_m,
            level_db: target.level_db,
            place_deg_m: place.map(|p| [p.latitude_deg(), p.longitude_deg(), p.height_m]),
        }
    };
    Ok(RunContents {
        name: outcome.name.clone(),
        items: provenance::items(outcome),
        image: ImageContents {
            values: (&*outcome.focused.image).into(),
            x_m: (0..grid.nx).map(|i| grid.x_m(i)).collect(),
            y_m: (0..grid.ny).map(|j| grid.y_m(j)).collect(),
            z_m: match &pixels.surface {
                Some(surface) => (0..surface.len()).map(|k| surface.z_m(k)).collect(),
                None => vec![grid.z_m],
            },
        },
        trajectory: table,
        targets: outcome.measured.targets.iter().map(target).collect(),
        pulses: Some(pulses(outcome)),
    })
}

fn pulses(outcome: &Outcome) -> PulseContents<'_> {
    let prepared = &outcome.prepared;
    let (aligned, spectrum) = (&prepared.aligned, &prepared.spectrum);
    let mut first_row = 0;
    let (mut trace, mut number) = (Vec::new(), Vec::new());
    for (k, track) in prepared.tracks.iter().enumerate() {
        let own = aligned.traces.get(track.range.clone()).unwrap_or_default();
        trace.extend(own.iter().map(|t| (first_row + t) as i32));
        number.extend(own.iter().map(|_| k as i32 + 1));
        first_row += track.traces_in_log;
    }
    let radargrams = prepared.tracks.iter().enumerate().filter_map(|(k, track)| {
        Some(RadargramContents {
            track: k + 1,
            radargram: &track.cleaned.as_ref()?.clean,
            unit: track.radar.unit,
        })
    });
    PulseContents {
        position_m: &aligned.position_m,
        trace,
        track: number,
        frequency_hz: &spectrum.frequency_hz,
        spectrum: spectrum
            .values
            .iter()
            .map(|v| Complex32::new(v.re as f32, v.im as f32))
            .collect(),
        radargrams: radargrams.collect(),
    }
}
