//! Reading.

use std::io::Read;

use super::binary::{BINARY_BYTES, BinaryHeader, TEXT_BYTES};
use super::place::{FOOT_M, places, times};
use super::text::{decode, interval_in_text_ps};
use super::trace::{TRACE_HEADER_BYTES, TraceHeader};
use crate::bytes::{Fields, fill};
use crate::error::{FormatError, Place};
use crate::limits::Limits;
use crate::recording::{Axis, Channel, Format, Recording, Values};
use crate::traces::records;

/// Extended texts and headers of a trace that are read at most.
const MAX_TEXTS: usize = 1024;
const MAX_EXTRA_HEADERS: usize = 256;

/// Reads SEG-Y of `length_bytes`. Traces of several antennas, numbered in each record, become channels.
///
/// # Errors
/// A header that makes no sense, a file that ends within its headers or before its first whole trace, traces of
/// different lengths, numbers that are not finite, more than `limits` admit.
pub fn read_segy(
    mut reader: impl Read,
    length_bytes: u64,
    limits: &Limits,
) -> Result<Recording, FormatError> {
    let mut head = [0; TEXT_BYTES + BINARY_BYTES];
    let found = fill(&mut reader, &mut head)?;
    if found < head.len() {
        return Err(FormatError::content(
            Place::Byte(found as u64),
            "headers of 3600 bytes",
            format!("the end of the file after {found}"),
        ));
    }
    let binary = BinaryHeader::read(&head[TEXT_BYTES..])?;
    let mut recording = Recording::new(Format::SegY);
    let mut text = decode(&head[..TEXT_BYTES]);
    let (first_trace_byte, skipped) = skip_to_traces(&mut reader, &binary, &mut text)?;
    let (samples, first) = lengths(&mut reader, &binary, limits)?;
    if binary.extra_trace_headers > MAX_EXTRA_HEADERS {
        return Err(FormatError::content(
            Place::Byte(3506),
            format!("at most {MAX_EXTRA_HEADERS} further trace headers"),
            binary.extra_trace_headers,
        ));
    }
    let header_bytes = TRACE_HEADER_BYTES * (1 + binary.extra_trace_headers);
    let record_bytes = header_bytes + samples * binary.format.bytes();
    let mut headers: Vec<TraceHeader> = Vec::new();
    let mut values = Vec::new();
    let mut other_length: Option<(usize, u16)> = None;
    let mut stream = first.as_slice().chain(reader);
    let (traces, left) = records(
        &mut stream,
        length_bytes.saturating_sub(first_trace_byte),
        [record_bytes, samples],
        limits,
        |trace, bytes| {
            let header = TraceHeader::read(Fields {
                bytes: &bytes[..TRACE_HEADER_BYTES],
                order: binary.order,
            });
            let stated = usize::from(header.samples);
            if stated != 0 && stated != samples && samples <= usize::from(u16::MAX) {
                other_length.get_or_insert((trace, header.samples));
            }
            headers.push(header);
            binary
                .format
                .decode(binary.order, &bytes[header_bytes..], &mut values);
            Ok(())
        },
    )?;
    if traces == 0 {
        return Err(FormatError::content(
            Place::Trace(1),
            format!("{record_bytes} bytes"),
            format!("the end of the file after {left}"),
        ));
    }
    if let Some((trace, found)) = other_length {
        let differ = headers.iter().any(|h| h.samples != headers[0].samples);
        if differ || left > 0 {
            return Err(FormatError::content(
                Place::Trace(trace as u64 + 1),
                format!("{samples} samples, as in the binary header"),
                found,
            ));
        }
        recording.compare(
            "samples of a trace: binary header, trace headers",
            [samples as f64, f64::from(found)],
            "samples",
            0.0,
        );
    }
    recording.skipped_bytes = skipped + left;
    facts(&mut recording, &binary, &text);
    let axis = axis(&mut recording, &binary, &headers[0], samples);
    compare_intervals(&mut recording, &binary, &headers, &text, &axis);
    for (name, chosen) in antennas(&headers, binary.ensemble_traces) {
        let own: Vec<TraceHeader> = chosen.iter().map(|&i| headers[i]).collect();
        let values = if own.len() == headers.len() {
            std::mem::take(&mut values)
        } else {
            let of_trace = |i: &usize| values[i * samples..(i + 1) * samples].iter().copied();
            chosen.iter().flat_map(of_trace).collect()
        };
        let channel = channel(&mut recording, name, &own, values, &axis, &binary);
        recording.channels.push(channel);
    }
    recording.checked()
}

/// Reads up to the first trace; extended texts are added to `text`. Returns the first trace's byte, and the number of
/// bytes before it that are no text.
fn skip_to_traces(
    reader: &mut impl Read,
    binary: &BinaryHeader,
    text: &mut String,
) -> Result<(u64, u64), FormatError> {
    const END: &str = "((SEG: EndText))";
    let mut at = (TEXT_BYTES + BINARY_BYTES) as u64;
    let count = binary.extended_texts.unwrap_or(MAX_TEXTS);
    if count > MAX_TEXTS {
        return Err(FormatError::content(
            Place::Byte(3504),
            format!("at most {MAX_TEXTS} extended texts"),
            count,
        ));
    }
    for _ in 0..count {
        let mut bytes = vec![0; TEXT_BYTES];
        let found = fill(reader, &mut bytes)?;
        if found < TEXT_BYTES {
            return Err(FormatError::content(
                Place::Byte(at),
                "an extended text of 3200 bytes",
                format!("the end of the file after {found}"),
            ));
        }
        at += TEXT_BYTES as u64;
        let more = decode(&bytes);
        text.push('\n');
        text.push_str(&more);
        if binary.extended_texts.is_none() && more.contains(END) {
            break;
        }
    }
    let Some(first) = binary.first_trace_byte.filter(|first| *first > at) else {
        return Ok((at, 0));
    };
    let skipped = std::io::copy(&mut reader.take(first - at), &mut std::io::sink())?;
    if skipped < first - at {
        return Err(FormatError::content(
            Place::Byte(3520),
            format!("the first trace at byte {first}"),
            format!("the end of the file at byte {}", at + skipped),
        ));
    }
    Ok((first, skipped))
}

/// Samples of a trace, and the bytes read to determine them: from the binary header, else from the first
/// trace.
fn lengths(
    reader: &mut impl Read,
    binary: &BinaryHeader,
    limits: &Limits,
) -> Result<(usize, Vec<u8>), FormatError> {
    if binary.samples > 0 {
        limits.check_trace(Place::Byte(3220), binary.samples as u64)?;
        return Ok((binary.samples, Vec::new()));
    }
    let mut first = vec![0; TRACE_HEADER_BYTES];
    let found = fill(reader, &mut first)?;
    first.truncate(found);
    let header = TraceHeader::read(Fields {
        bytes: &first,
        order: binary.order,
    });
    if header.samples == 0 {
        return Err(FormatError::content(
            Place::Byte(3220),
            "samples of a trace, here or in the first trace's header",
            0,
        ));
    }
    Ok((usize::from(header.samples), first))
}

fn facts(recording: &mut Recording, binary: &BinaryHeader, text: &str) {
    recording.fact(
        "revision",
        format!("{}.{}", binary.revision[0], binary.revision[1]),
    );
    recording.fact("sample_format", binary.format.name());
    recording.fact("byte_order", format!("{:?}", binary.order).to_lowercase());
    if !text.is_empty() {
        recording.fact("text", text);
    }
}

/// Fast time. The integers count picoseconds and nanoseconds: as microseconds they would make no radar's record.
fn axis(
    recording: &mut Recording,
    binary: &BinaryHeader,
    first: &TraceHeader,
    samples: usize,
) -> Axis {
    let stated = match binary.interval {
        0 => first.interval,
        interval => interval,
    };
    let step_s = match binary.extended_interval_us {
        // A true interval in microseconds is below one; a larger number counts picoseconds as the integer does.
        Some(us) if us < 1.0 => us * 1e-6,
        Some(ps) => ps * 1e-12,
        None => f64::from(stated) * 1e-12,
    };
    if binary.extended_interval_us.is_none_or(|us| us >= 1.0) {
        recording
            .remarks
            .push("the sample interval counts picoseconds, the delay nanoseconds".to_owned());
    }
    Axis::FastTime {
        start_s: first.delay * 1e-9,
        step_s,
        samples,
    }
}

/// The sample interval against every other statement of it: the trace headers', the other one of revision 2, the text's.
fn compare_intervals(
    recording: &mut Recording,
    binary: &BinaryHeader,
    headers: &[TraceHeader],
    text: &str,
    axis: &Axis,
) {
    let Axis::FastTime { step_s, .. } = axis else {
        return;
    };
    let used_ps = 1e12 * step_s;
    // The integer of a fractional interval is rounded or cut off.
    let to_a_unit = 1.0 / used_ps.max(1.0);
    if binary.extended_interval_us.is_some() && binary.interval != 0 {
        recording.compare(
            "sample interval: double precision, integer of the binary header",
            [used_ps, f64::from(binary.interval)],
            "ps",
            to_a_unit,
        );
    }
    let other = headers
        .iter()
        .map(|header| f64::from(header.interval))
        .find(|ps| *ps != 0.0 && (*ps - used_ps).abs() > 1.0);
    if let Some(other_ps) = other {
        recording.compare(
            "sample interval: binary header, trace headers",
            [used_ps, other_ps],
            "ps",
            to_a_unit,
        );
    }
    if let Some(stated_ps) = interval_in_text_ps(text) {
        recording.compare(
            "sample interval: binary header, text",
            [used_ps, stated_ps],
            "ps",
            0.01,
        );
    }
}

/// Names of antennas and the traces of each, in order.
fn antennas(headers: &[TraceHeader], ensemble: usize) -> Vec<(String, Vec<usize>)> {
    let all = || vec![("1".to_owned(), (0..headers.len()).collect())];
    // Records number their traces from 1: as many antennas as the largest number, each in every record.
    let period = headers
        .windows(2)
        .position(|w| w[1].record != w[0].record)
        .map_or(headers.len(), |i| i + 1);
    let by_record = period > 1
        && period <= 64
        && headers.len().is_multiple_of(period)
        && headers.chunks(period).all(|record| {
            let numbers = record.iter().map(|h| h.in_record);
            record.iter().all(|h| h.record == record[0].record)
                && numbers.eq(headers[..period].iter().map(|h| h.in_record))
        })
        && headers[..period]
            .windows(2)
            .all(|w| w[1].in_record > w[0].in_record)
        && headers.len() > period;
    let by_ensemble = ensemble > 1
        && ensemble <= 64
        && headers.len().is_multiple_of(ensemble)
        && headers.len() > ensemble
        && headers
            .iter()
            .enumerate()
            .all(|(i, h)| h.in_record == (i % ensemble + 1) as i32);
    let count = match (by_record, by_ensemble) {
        (true, _) => period,
        (false, true) => ensemble,
        (false, false) => return all(),
    };
    (0..count)
        .map(|k| {
            let name = headers[k].in_record.to_string();
            (name, (k..headers.len()).step_by(count).collect())
        })
        .collect()
}

fn channel(
    recording: &mut Recording,
    name: String,
    own: &[TraceHeader],
    values: Vec<f32>,
    axis: &Axis,
    binary: &BinaryHeader,
) -> Channel {
    let mut channel = Channel::new(name, own.len(), axis.clone(), Values::Real(values));
    let placed = places(own, binary.is_feet);
    channel.positions = placed.positions;
    channel.antennas_m = placed.antennas_m;
    if let Some(refused) = placed.refused
        && !recording.remarks.contains(&refused)
    {
        recording.remarks.push(refused);
    }
    channel.time_s = times(own);
    let offset = own[0].offset.abs() * if binary.is_feet { FOOT_M } else { 1.0 };
    if offset > 0.0 && own.iter().all(|h| h.offset == own[0].offset) {
        // Whole metres are too coarse for antennas that are centimetres apart.
        recording.fact("source_to_receiver", offset);
    }
    channel
}
