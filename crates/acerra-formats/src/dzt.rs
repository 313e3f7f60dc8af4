//! GSSI DZT: radargrams of 8, 16 or 32 bits with one to several channels, positions in DZG, marks in DZX.
//!
//! Sources: GSSI, *SIR-3000 User's Manual* (appendix on the file format), as the documentation of readgssi quotes it.
//! Samples of 8 and 16 bits are unsigned, those of 32 bits signed. The first two words of a scan hold its number and
//! its mark.

use std::io::Read;

use crate::antenna::AntennaFrequency;
use crate::bytes::{Fields, fill};
use crate::error::{FormatError, Place};
use crate::fixes::{Fix, gga, track};
use crate::limits::Limits;
use crate::recording::{Axis, Channel, Format, Recording, Values};
use crate::traces::{Word, records};

/// Bytes of the header of one channel.
const HEADER_BYTES: usize = 1024;
/// Channels read at most.
const MAX_CHANNELS: u16 = 16;

/// Whether a file's first bytes are a DZT header.
#[must_use]
pub fn is_dzt(head: &[u8]) -> bool {
    if head.len() < HEADER_BYTES {
        return false;
    }
    let f = Fields::little(head);
    let is_sane = |x: f32, low: f32, high: f32| x.is_finite() && x >= low && x <= high;
    // A tag of a channel, and numbers that a radar can have.
    let tag = f.u16(0);
    (tag & 0x00ff == 0x00ff || tag & 0x00ff == 0)
        && matches!(f.u16(6), 8 | 16 | 32)
        && f.u16(4) >= 2
        && (1..=MAX_CHANNELS).contains(&f.u16(52))
        && is_sane(f.f32(10), 0.0, 1e6)
        && is_sane(f.f32(14), -1e6, 1e6)
        && is_sane(f.f32(26), 1e-3, 1e6)
        && is_sane(f.f32(22), -1e6, 1e6)
        && f.u16(2) > 0
}

/// Reads a DZT file of `length_bytes`, with the texts of the DZG and DZX next to it if they exist.
///
/// # Errors
/// A header that makes no sense, a file that ends before its first whole scan, more than `limits` admit.
pub fn read_dzt(
    mut reader: impl Read,
    length_bytes: u64,
    [dzg, dzx]: [Option<&str>; 2],
    limits: &Limits,
) -> Result<Recording, FormatError> {
    let mut head = vec![0; HEADER_BYTES];
    let found = fill(&mut reader, &mut head)?;
    if found < HEADER_BYTES {
        return Err(FormatError::content(
            Place::Byte(found as u64),
            "a header of 1024 bytes",
            format!("the end of the file after {found}"),
        ));
    }
    let (samples, word, channels) = shape(Fields::little(&head), limits)?;
    let offset = Fields::little(&head).u16(2);
    let data_at = if usize::from(offset) < HEADER_BYTES {
        HEADER_BYTES * usize::from(offset)
    } else {
        // An offset in bytes is not always that of the data; one header per channel is.
        (HEADER_BYTES * channels).max(usize::from(offset))
    };
    head.resize(data_at.max(HEADER_BYTES), 0);
    let found = HEADER_BYTES + fill(&mut reader, &mut head[HEADER_BYTES..])?;
    if found < head.len() {
        return Err(FormatError::content(
            Place::Byte(found as u64),
            format!("headers of {} bytes", head.len()),
            "the end of the file",
        ));
    }
    let scan_words = samples * channels;
    let mut planes: Vec<Vec<f32>> = vec![Vec::new(); channels];
    let mut service: Vec<[f32; 2]> = Vec::new();
    let (traces, left) = records(
        &mut reader,
        length_bytes.saturating_sub(head.len() as u64),
        [scan_words * word.bytes(), scan_words],
        limits,
        |_, bytes| {
            for (plane, part) in planes.iter_mut().zip(bytes.chunks(samples * word.bytes())) {
                word.decode(part, plane);
            }
            let first = &planes[0][planes[0].len() - samples..];
            service.push([first[0], first[1]]);
            Ok(())
        },
    )?;
    if traces == 0 {
        return Err(FormatError::content(
            Place::Byte(head.len() as u64),
            format!("a scan of {} bytes", scan_words * word.bytes()),
            format!("the end of the file after {left}"),
        ));
    }
    let mut recording = Recording::new(Format::Dzt);
    recording.skipped_bytes = left;
    if samples > 2 {
        // The service words are not measurements: the first sample replaces them.
        for plane in &mut planes {
            for scan in plane.chunks_mut(samples) {
                scan[0] = scan[2];
                scan[1] = scan[2];
            }
        }
        recording.remarks.push(
            "the first two samples of each trace are its number and mark: the third replaces them"
                .to_owned(),
        );
    }
    describe(&mut recording, &head, word, planes, samples, traces)?;
    if let Some(text) = dzg {
        with_positions(&mut recording, text, traces);
    }
    match dzx {
        Some(text) => recording.marks = marks(text, traces, &mut recording.remarks),
        None => recording.marks = marks_within(&service, word),
    }
    recording.checked()
}

fn shape(f: Fields<'_>, limits: &Limits) -> Result<(usize, Word, usize), FormatError> {
    let samples = f.u16(4);
    if samples < 2 {
        return Err(FormatError::content(
            Place::Byte(4),
            "at least 2 samples a scan",
            samples,
        ));
    }
    limits.check_trace(Place::Byte(4), u64::from(samples))?;
    let word = match f.u16(6) {
        8 => Word::U8,
        16 => Word::U16,
        32 => Word::I32,
        other => {
            return Err(FormatError::content(
                Place::Byte(6),
                "8, 16 or 32 bits a sample",
                other,
            ));
        }
    };
    let channels = f.u16(52);
    if !(1..=MAX_CHANNELS).contains(&channels) {
        return Err(FormatError::content(
            Place::Byte(52),
            format!("1 to {MAX_CHANNELS} channels"),
            channels,
        ));
    }
    Ok((usize::from(samples), word, usize::from(channels)))
}

/// Axes, header facts and channels.
fn describe(
    recording: &mut Recording,
    head: &[u8],
    word: Word,
    planes: Vec<Vec<f32>>,
    samples: usize,
    traces: usize,
) -> Result<(), FormatError> {
    let f = Fields::little(head);
    let range_ns = f64::from(f.f32(26));
    if !(range_ns.is_finite() && range_ns > 0.0) {
        return Err(FormatError::content(
            Place::Byte(26),
            "a positive range in ns",
            range_ns,
        ));
    }
    let step_s = range_ns * 1e-9 / samples as f64;
    // The zero is a sample, or the level without signal; the position is that of the first sample.
    let position_ns = f64::from(f.f32(22));
    let position_ns = if position_ns.is_finite() {
        position_ns
    } else {
        0.0
    };
    let zero = usize::from(f.u16(8));
    let is_sample = zero > 0 && zero < samples && zero != 0x80;
    let start_s = if is_sample {
        -(zero as f64) * step_s
    } else {
        position_ns * 1e-9
    };
    if is_sample && position_ns != 0.0 {
        recording.compare(
            "fast time of the first sample: time zero, position",
            [start_s * 1e9, position_ns],
            "ns",
            0.01,
        );
    }
    let (a_second, a_metre) = (f64::from(f.f32(10)), f64::from(f.f32(14)));
    let is_positive = |x: f64| x.is_finite() && x > 0.0;
    recording.fact("bits", word.bytes() * 8);
    recording.fact("range_ns", range_ns);
    recording.fact("scans_per_second", a_second);
    recording.fact("scans_per_metre", a_metre);
    recording.fact("position_ns", position_ns);
    recording.fact("relative_permittivity", f.f32(54));
    if let Some(created) = date(f.u32(32)) {
        recording.fact("created", created);
    }
    for (k, plane) in planes.into_iter().enumerate() {
        let antenna = f.text(98 + HEADER_BYTES * k, 14);
        if !antenna.is_empty() {
            recording.fact(&format!("antenna_{}", k + 1), &antenna);
        }
        let axis = Axis::FastTime {
            start_s,
            step_s,
            samples,
        };
        let mut channel = Channel::new((k + 1).to_string(), traces, axis, Values::Real(plane));
        channel.antenna_frequency = AntennaFrequency::in_text(&antenna, "name of the antenna");
        // By a wheel traces are even in place, without one in time.
        if is_positive(a_metre) {
            channel.along_m = Some((0..traces).map(|i| i as f64 / a_metre).collect());
        } else if is_positive(a_second) {
            channel.time_s = Some((0..traces).map(|i| i as f64 / a_second).collect());
        }
        recording.channels.push(channel);
    }
    Ok(())
}

/// Second/2, minute, hour, day, month, year − 1980 in 5, 6, 5, 5, 4 and 7 bits.
fn date(bits: u32) -> Option<String> {
    let field = |shift: u32, width: u32| (bits >> shift) & ((1 << width) - 1);
    let (second, minute, hour) = (2 * field(0, 5), field(5, 6), field(11, 5));
    let (day, month, year) = (field(16, 5), field(21, 4), 1980 + field(25, 7));
    let is_date = (1..=31).contains(&day) && (1..=12).contains(&month);
    (is_date && hour < 24 && minute < 60)
        .then(|| format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}"))
}

/// `$GSSIS,scan,…` before each sentence of a receiver.
fn with_positions(recording: &mut Recording, dzg: &str, traces: usize) {
    let mut scan = None;
    let mut fixes = Vec::new();
    let mut broken = 0;
    for line in dzg.lines() {
        if let Some(rest) = line.trim().strip_prefix("$GSSIS,") {
            scan = rest
                .split(',')
                .next()
                .and_then(|n| n.trim().parse::<f64>().ok());
        } else if line.contains("GGA,") {
            match (scan, gga(line)) {
                (Some(trace), Some((time_s, place))) => fixes.push(Fix {
                    trace,
                    time_of_day_s: Some(time_s),
                    place,
                }),
                _ => broken += 1,
            }
        }
    }
    if broken > 0 {
        recording.remarks.push(format!(
            "DZG: {broken} sentences without a position or a scan"
        ));
    }
    match track(fixes, traces) {
        Some(tracked) => {
            recording.remarks.extend(tracked.remarks);
            for channel in &mut recording.channels {
                channel.positions = Some(tracked.positions.clone());
                if let Some(time_s) = &tracked.time_s {
                    channel.time_s = Some(time_s.clone());
                }
            }
        }
        None => recording
            .remarks
            .push("DZG: fewer than two positions at different scans".to_owned()),
    }
}

/// Scans that a user marked, from the waypoints of a DZX.
fn marks(dzx: &str, traces: usize, remarks: &mut Vec<String>) -> Vec<usize> {
    let document = match roxmltree::Document::parse(dzx) {
        Ok(document) => document,
        Err(error) => {
            remarks.push(format!("DZX: {error}"));
            return Vec::new();
        }
    };
    let named = |node: &roxmltree::Node<'_, '_>, name: &str| node.tag_name().name() == name;
    let mut found: Vec<usize> = document
        .descendants()
        .filter(|node| named(node, "WayPt") || named(node, "TargetWayPt"))
        .filter_map(|point| {
            let of = |name: &str| {
                let child = point.children().find(|c| named(c, name));
                child.and_then(|c| c.text()).map(str::trim)
            };
            if named(&point, "TargetWayPt") {
                return of("scanSampChanProp")?.split(',').next()?.parse().ok();
            }
            (of("mark") == Some("User")).then_some(())?;
            of("scan")?.parse().ok()
        })
        .filter(|scan| *scan < traces)
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Scans whose second word is set, unless every other one is.
fn marks_within(service: &[[f32; 2]], word: Word) -> Vec<usize> {
    let silence = match word {
        Word::U8 => -128.0,
        Word::U16 => -32_768.0,
        Word::I16 | Word::I32 => 0.0,
    };
    let set: Vec<usize> = (0..service.len())
        .filter(|&i| service[i][1] > silence)
        .collect();
    if 2 * set.len() < service.len() {
        set
    } else {
        Vec::new()
    }
}
