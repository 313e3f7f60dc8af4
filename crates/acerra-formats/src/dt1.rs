//! Sensors & Software DT1 with its HD, and positions in GPS.
//!
//! Sources: Sensors & Software, *pulseEKKO data file formats*, as GPRPy's and RGPR's documentation quote them. A trace
//! has 25 numbers of 32 bits and 28 characters before its samples of 16 bits.

use std::io::Read;

use crate::antenna::AntennaFrequency;
use crate::bytes::Fields;
use crate::error::{FormatError, Place};
use crate::fixes::{Fix, gga, track};
use crate::keys::Keys;
use crate::limits::Limits;
use crate::recording::{Axis, Channel, Format, Recording, Values};
use crate::traces::{Word, records};

const TRACE_HEADER_BYTES: usize = 128;
const FOOT_M: f64 = 0.3048;

/// Whether a text is an HD.
#[must_use]
pub fn is_hd(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head).to_uppercase();
    text.contains("NUMBER OF PTS/TRC") && text.contains('=')
}

/// Whether a file begins as DT1: the numbers of its first trace.
#[must_use]
pub fn is_dt1(head: &[u8]) -> bool {
    if head.len() < TRACE_HEADER_BYTES {
        return false;
    }
    let f = Fields::little(head);
    let (number, points, bytes) = (f.f32(0), f.f32(8), f.f32(20));
    let is_whole = |x: f32, low: f32, high: f32| x.fract() == 0.0 && x >= low && x <= high;
    is_whole(number, 0.0, 1e6)
        && is_whole(points, 2.0, 65_535.0)
        && bytes == 2.0
        && f.f32(4).is_finite()
}

/// Reads DT1 of `length_bytes` with the text of its HD, and of its GPS where it is there.
///
/// # Errors
/// A header that lacks a line or holds no number there, traces of another length than it says, a file that ends before
/// its first whole trace, more than `limits` admit.
pub fn read_dt1(
    mut reader: impl Read,
    length_bytes: u64,
    hd: &str,
    gps: Option<&str>,
    limits: &Limits,
) -> Result<Recording, FormatError> {
    let keys = Keys::parse(hd, '=');
    let samples = keys.count("NUMBER OF PTS/TRC")?;
    limits.check_trace(Place::field("NUMBER OF PTS/TRC"), samples)?;
    let samples = samples as usize;
    let window_ns = keys.positive("TOTAL TIME WINDOW")?;
    let step_s = window_ns * 1e-9 / samples as f64;
    let zero = keys.number("TIMEZERO AT POINT")?.unwrap_or(0.0);
    let units = keys.text("POSITION UNITS").unwrap_or("m").to_lowercase();
    let metre = match units.as_str() {
        "m" | "metres" | "meters" | "metre" | "meter" => 1.0,
        "ft" | "feet" | "foot" => FOOT_M,
        "cm" => 0.01,
        _ => {
            return Err(FormatError::content(
                Place::field("POSITION UNITS"),
                "m, cm or ft",
                units,
            ));
        }
    };
    let mut values = Vec::new();
    let mut position = Vec::new();
    let mut antennas: [Vec<[f64; 3]>; 2] = [Vec::new(), Vec::new()];
    let mut seconds = Vec::new();
    let mut empty = 0;
    let record_bytes = TRACE_HEADER_BYTES + 2 * samples;
    let shape = [record_bytes, samples];
    let (traces, left) = records(&mut reader, length_bytes, shape, limits, |k, bytes| {
        let f = Fields::little(bytes);
        let at = Place::Trace(k as u64 + 1);
        if f.f32(20) != 2.0 {
            return Err(FormatError::content(at, "2 bytes a sample", f.f32(20)));
        }
        if f.f32(8) != samples as f32 {
            return Err(FormatError::content(
                at,
                format!("{samples} samples, as in the HD"),
                f.f32(8),
            ));
        }
        let number = |index: usize| f64::from(f.f32(4 * index));
        position.push(number(1) * metre);
        antennas[0].push([17, 18, 19].map(|i| number(i) * metre));
        antennas[1].push([14, 15, 16].map(|i| number(i) * metre));
        seconds.push(number(23));
        empty += usize::from(number(21) != 0.0);
        Word::I16.decode(&bytes[TRACE_HEADER_BYTES..], &mut values);
        Ok(())
    })?;
    if traces == 0 {
        return Err(FormatError::content(
            Place::Trace(1),
            format!("{record_bytes} bytes"),
            format!("the end of the file after {left}"),
        ));
    }
    let mut recording = Recording::new(Format::Dt1);
    recording.skipped_bytes = left;
    for (key, value) in &keys.lines {
        recording.fact(key, value);
    }
    if empty > 0 {
        recording
            .remarks
            .push(format!("{empty} traces are marked as empty (zero flag)"));
    }
    if position.iter().any(|p| !p.is_finite()) {
        return Err(FormatError::content(
            Place::field("position of a trace"),
            "a finite number",
            "another",
        ));
    }
    check_header(&mut recording, &keys, traces, &position, metre)?;
    let axis = Axis::FastTime {
        start_s: -zero * step_s,
        step_s,
        samples,
    };
    let mut channel = Channel::new("1", traces, axis, Values::Real(values));
    let separation = keys.number("ANTENNA SEPARATION")?.map(|s| s * metre);
    channel.antenna_separation_m = separation.filter(|s| *s > 0.0);
    channel.antenna_frequency = (keys.text("NOMINAL FREQUENCY"))
        .and_then(|text| AntennaFrequency::in_megahertz(text, "NOMINAL FREQUENCY"));
    if position.iter().any(|p| *p != position[0]) {
        channel.along_m = Some(position);
    }
    channel.time_s = times(&seconds);
    let is_known = |places: &[[f64; 3]]| places.iter().flatten().all(|v| v.is_finite());
    if antennas.iter().all(|a| is_known(a)) && antennas[0] != antennas[1] {
        channel.antennas_m = Some(antennas);
    }
    if let Some(gps) = gps {
        match track(positions(gps), traces) {
            Some(tracked) => {
                recording.remarks.extend(tracked.remarks);
                channel.positions = Some(tracked.positions);
                channel.time_s = tracked.time_s.or(channel.time_s);
            }
            None => recording
                .remarks
                .push("GPS: fewer than two positions at different traces".to_owned()),
        }
    }
    recording.channels.push(channel);
    recording.checked()
}

/// The header's counts and places against those of the traces.
fn check_header(
    recording: &mut Recording,
    keys: &Keys,
    traces: usize,
    position_m: &[f64],
    metre: f64,
) -> Result<(), FormatError> {
    if let Some(stated) = keys.number("NUMBER OF TRACES")? {
        recording.compare(
            "traces: file, NUMBER OF TRACES",
            [traces as f64, stated],
            "traces",
            0.0,
        );
    }
    let step = keys.number("STEP SIZE USED")?.unwrap_or(0.0) * metre;
    if traces > 1 && step != 0.0 {
        let way = (position_m[traces - 1] - position_m[0]).abs() / (traces as f64 - 1.0);
        if way > 0.0 {
            recording.compare(
                "distance between traces: their positions, STEP SIZE USED",
                [way, step.abs()],
                "m",
                0.05,
            );
        }
    }
    Ok(())
}

/// Seconds from the first trace, from seconds of the day; none unless they grow.
fn times(seconds: &[f64]) -> Option<Vec<f64>> {
    const DAY_S: f64 = 86_400.0;
    let mut out = Vec::with_capacity(seconds.len());
    let mut add = 0.0;
    for (i, s) in seconds.iter().enumerate() {
        if !(0.0..=DAY_S).contains(s) {
            return None;
        }
        if i > 0 && *s < seconds[i - 1] - DAY_S / 2.0 {
            add += DAY_S;
        }
        out.push(s + add);
    }
    let first = *out.first()?;
    out.iter_mut().for_each(|t| *t -= first);
    let grows = out.windows(2).all(|w| w[1] >= w[0]) && out.last() > Some(&0.0);
    grows.then_some(out)
}

/// `Trace #n at position …` before each sentence of a receiver; traces count from 1.
fn positions(gps: &str) -> Vec<Fix> {
    let mut trace = None;
    let mut fixes = Vec::new();
    for line in gps.lines() {
        if let Some((_, rest)) = line.split_once('#') {
            let digits: String = rest
                .trim_start()
                .chars()
                .take_while(char::is_ascii_digit)
                .collect();
            trace = digits.parse::<f64>().ok().map(|n| n - 1.0);
        } else if let (Some(trace), Some((time_s, place))) = (trace, gga(line)) {
            fixes.push(Fix {
                trace,
                time_of_day_s: Some(time_s),
                place,
            });
        }
    }
    fixes
}
