//! `spectra.cphd`: the cleaned spectra with their positions.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufWriter;

use acerra_chain::Track;
use acerra_cphd::{Channel, Description, EvenFrequencies, PhaseHistory, Scene, write_cphd};
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use anyhow::Context;

use crate::outcome::Outcome;
use crate::provenance;
use crate::staging::Staging;

pub(super) const NAME: &str = "spectra.cphd";

/// Reason why a run has no phase history data; none where it has such data.
pub(super) fn why_none(outcome: &Outcome) -> Option<&'static str> {
    parts(outcome).err()
}

/// Writes the spectra of all tracks, a channel each, unless there is a reason for none.
pub(super) fn write(outcome: &Outcome, staging: &Staging) -> anyhow::Result<()> {
    let Ok((frame, frequency)) = parts(outcome) else {
        return Ok(());
    };
    let prepared = &outcome.prepared;
    let start = prepared.first().positions.time_origin().gps_time();
    let names = channel_names(&prepared.tracks);
    let channels = prepared.tracks.iter().zip(names);
    let channels = channels.map(|(track, name)| channel(outcome, track, (name, frequency)));
    let pixels = &outcome.focused.pixels;
    let grid = &pixels.grid;
    let half_m = |n: usize| 0.5 * (n.saturating_sub(1)) as f64 * grid.pixel_m;
    let scene = Scene {
        middle_m: [
            grid.x0_m + half_m(grid.nx),
            grid.y0_m + half_m(grid.ny),
            pixels.middle_m(),
        ],
        pixel_m: grid.pixel_m,
        nx: grid.nx,
        ny: grid.ny,
    };
    let history = PhaseHistory {
        frame,
        start,
        channels: channels.collect(),
        description: Description {
            name: outcome.name.clone(),
            collector: outcome.radar_summary(),
            items: provenance::items(outcome),
        },
    };
    let file = File::create(staging.path(NAME)).with_context(|| format!("{NAME}: cannot write"))?;
    write_cphd(BufWriter::with_capacity(1 << 20, file), &history, &scene).context(NAME)
}

/// The frame and the frequencies of phase history data, or why there are none.
fn parts(outcome: &Outcome) -> Result<(EnuFrame, EvenFrequencies), &'static str> {
    let frame = outcome
        .prepared
        .first()
        .positions
        .earth_frame()
        .ok_or("the positions have no place on the Earth")?;
    let positions = &outcome.prepared.aligned.position_m;
    for track in &outcome.prepared.tracks {
        let moves = |places: &[[f64; 3]]| places.iter().any(|place| *place != places[0]);
        if !positions.get(track.range.clone()).is_some_and(moves) {
            return Err("a track stays at one place");
        }
    }
    let frequency = EvenFrequencies::of(&outcome.prepared.spectrum.frequency_hz)
        .ok_or("the frequencies are not evenly spaced")?;
    Ok((frame, frequency))
}

/// The names of the tracks, or their numbers where two names are equal.
fn channel_names(tracks: &[Track]) -> Vec<String> {
    let names: BTreeSet<&str> = tracks.iter().map(|track| track.name.as_str()).collect();
    let number = |(k, track): (usize, &Track)| match names.len() == tracks.len() {
        true => track.name.clone(),
        false => (k + 1).to_string(),
    };
    tracks.iter().enumerate().map(number).collect()
}

fn channel<'a>(
    outcome: &'a Outcome,
    track: &Track,
    (name, frequency): (String, EvenFrequencies),
) -> Channel<'a> {
    let prepared = &outcome.prepared;
    let (aligned, range) = (&prepared.aligned, track.range.clone());
    let to_start_s = seconds_to_start(outcome, track) + track.time_offset_s;
    let values = range.start * frequency.count..range.end * frequency.count;
    let cleaned = track.cleaned.as_ref().map(|traces| &traces.clean);
    Channel {
        name,
        time_s: aligned.time_s[range.clone()]
            .iter()
            .map(|t| t + to_start_s)
            .collect(),
        position_m: aligned.position_m[range].to_vec(),
        frequency,
        spectrum: (&prepared.spectrum.values[values]).into(),
        fast_time_s: cleaned.map(|c| [c.fast_time_start_s, c.fast_time_end_s()]),
    }
}

/// Offset from the clock of a track's positions to that of the first track's.
fn seconds_to_start(outcome: &Outcome, track: &Track) -> f64 {
    let zero = |track: &Track| -> Option<GpsTime> { track.positions.time_origin().gps_time() };
    match (zero(outcome.prepared.first()), zero(track)) {
        (Some(first), Some(own)) => own.seconds_since(first),
        _ => 0.0,
    }
}
