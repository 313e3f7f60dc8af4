//! MALÅ rd3 (16 bits) and rd7 (32 bits) with rad, and positions in cor.
//!
//! Sources: MALÅ Geoscience's *RAMAC/GPR file format*, as RGPR's and ridal's documentation quote it. The data file has
//! no header: the length of a sample follows from the numbers of samples and traces that the rad states.

use std::io::Read;

use crate::antenna::AntennaFrequency;
use crate::error::{FormatError, Place};
use crate::fixes::{Fix, track};
use crate::keys::Keys;
use crate::limits::Limits;
use crate::recording::{Axis, Channel, Format, Recording, Values};
use crate::traces::{Word, records};

/// Whether a text is a rad.
#[must_use]
pub fn is_rad(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head).to_uppercase();
    text.contains("SAMPLES:") && text.contains("FREQUENCY:")
}

/// Kind of samples by the name of the data file, where their number does not show it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamedAs {
    /// rd3, or another name.
    Short,
    /// rd7.
    Long,
}

/// Reads rd3 or rd7 of `length_bytes` with the text of its rad, and of its cor where it is there.
///
/// # Errors
/// A rad that lacks a line or holds no number there, data that make no whole trace, more than `limits` admit.
pub fn read_mala(
    mut reader: impl Read,
    length_bytes: u64,
    named: NamedAs,
    rad: &str,
    cor: Option<&str>,
    limits: &Limits,
) -> Result<Recording, FormatError> {
    let keys = Keys::parse(rad, ':');
    let samples = keys.count("SAMPLES")?;
    limits.check_trace(Place::field("SAMPLES"), samples)?;
    let frequency_mhz = keys.positive("FREQUENCY")?;
    let stated = keys.number("LAST TRACE")?.filter(|n| *n >= 1.0);
    let word = match stated {
        Some(n) if n * samples as f64 * 2.0 == length_bytes as f64 => Word::I16,
        Some(n) if n * samples as f64 * 4.0 == length_bytes as f64 => Word::I32,
        _ if named == NamedAs::Long => Word::I32,
        _ => Word::I16,
    };
    let samples = samples as usize;
    let mut values = Vec::new();
    let record_bytes = samples * word.bytes();
    let shape = [record_bytes, samples];
    let (traces, left) = records(&mut reader, length_bytes, shape, limits, |_, bytes| {
        word.decode(bytes, &mut values);
        Ok(())
    })?;
    if traces == 0 {
        return Err(FormatError::content(
            Place::Trace(1),
            format!("{record_bytes} bytes"),
            format!("the end of the file after {left}"),
        ));
    }
    let mut recording = Recording::new(Format::Mala);
    recording.skipped_bytes = left;
    for (key, value) in &keys.lines {
        recording.fact(key, value);
    }
    let step_s = 1e-6 / frequency_mhz;
    let zero = keys.number("SIGNAL POSITION")?.unwrap_or(0.0);
    let is_sample = zero > 0.0 && zero < samples as f64;
    let axis = Axis::FastTime {
        start_s: if is_sample { -zero * step_s } else { 0.0 },
        step_s,
        samples,
    };
    check_header(&mut recording, &keys, traces, step_s * 1e9, samples)?;
    let mut channel = Channel::new("1", traces, axis, Values::Real(values));
    channel.antenna_separation_m = keys.number("ANTENNA SEPARATION")?.filter(|s| *s > 0.0);
    channel.antenna_frequency =
        (keys.text("ANTENNAS")).and_then(|text| AntennaFrequency::in_text(text, "ANTENNAS"));
    let is_set = |key: &str| Ok::<bool, FormatError>(keys.number(key)?.unwrap_or(0.0) != 0.0);
    if let Some(step_m) = keys.number("DISTANCE INTERVAL")?.filter(|s| *s > 0.0)
        && (is_set("DISTANCE FLAG")? || !is_set("TIME FLAG")?)
    {
        let start_m = keys.number("START POSITION")?.unwrap_or(0.0);
        channel.along_m = Some((0..traces).map(|i| start_m + i as f64 * step_m).collect());
    }
    let time_step_s = keys.number("TIME INTERVAL")?.filter(|s| *s > 0.0);
    if let Some(step_s) = time_step_s
        && is_set("TIME FLAG")?
    {
        channel.time_s = Some((0..traces).map(|i| i as f64 * step_s).collect());
    }
    if let Some(cor) = cor {
        match track(positions(cor), traces) {
            Some(tracked) => {
                recording.remarks.extend(tracked.remarks);
                channel.positions = Some(tracked.positions);
                channel.time_s = tracked.time_s.or(channel.time_s);
            }
            None => recording
                .remarks
                .push("cor: fewer than two positions at different traces".to_owned()),
        }
    }
    recording.channels.push(channel);
    recording.checked()
}

fn check_header(
    recording: &mut Recording,
    keys: &Keys,
    traces: usize,
    step_ns: f64,
    samples: usize,
) -> Result<(), FormatError> {
    if let Some(window_ns) = keys.number("TIMEWINDOW")?.filter(|w| *w > 0.0) {
        // Some count the intervals between samples.
        let tolerance = 1.5 / samples as f64 + 1e-4;
        recording.compare(
            "time window: samples / FREQUENCY, TIMEWINDOW",
            [step_ns * samples as f64, window_ns],
            "ns",
            tolerance,
        );
    }
    if let Some(stated) = keys.number("LAST TRACE")?.filter(|n| *n > 0.0) {
        recording.compare(
            "traces: file, LAST TRACE",
            [traces as f64, stated],
            "traces",
            0.0,
        );
    }
    let step_m = keys.number("DISTANCE INTERVAL")?.unwrap_or(0.0);
    let start_m = keys.number("START POSITION")?.unwrap_or(0.0);
    if let Some(stop_m) = keys.number("STOP POSITION")?
        && step_m > 0.0
        && stop_m > start_m
        && traces > 1
    {
        recording.compare(
            "distance between traces: DISTANCE INTERVAL, STOP POSITION over traces",
            [step_m, (stop_m - start_m) / (traces as f64 - 1.0)],
            "m",
            0.05,
        );
    }
    Ok(())
}

/// Trace, date, time, latitude, N or S, longitude, E or W, height, M and more; traces count from 1.
fn positions(cor: &str) -> Vec<Fix> {
    cor.lines()
        .filter_map(|line| {
            let fields: Vec<&str> = line.split_whitespace().collect();
            let [trace, _, time, latitude, ns, longitude, ew, height, ..] = fields[..] else {
                return None;
            };
            let mut clock = time.split(':').map(str::parse::<f64>);
            let mut part = || clock.next()?.ok();
            let time_s = part()? * 3600.0 + part()? * 60.0 + part()?;
            let signed = |text: &str, side: &str, minus: &str| -> Option<f64> {
                let value: f64 = text.parse().ok()?;
                Some(if side.eq_ignore_ascii_case(minus) {
                    -value.abs()
                } else {
                    value
                })
            };
            Some(Fix {
                trace: trace.parse::<f64>().ok()? - 1.0,
                time_of_day_s: Some(time_s),
                place: [
                    signed(latitude, ns, "S")?,
                    signed(longitude, ew, "W")?,
                    height.parse().ok()?,
                ],
            })
        })
        .collect()
}
