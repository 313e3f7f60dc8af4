//! Writing: revision 1, big-endian, IEEE floats, as programs for ground-penetrating radar read it.

use std::io::{self, Write};

use super::binary::{BINARY_BYTES, TEXT_BYTES};
use super::trace::TRACE_HEADER_BYTES;

/// What is written.
#[derive(Debug, Clone, Copy)]
pub struct SegyTraces<'a> {
    /// Samples, row-major `[traces, samples]`.
    pub values: &'a [f32],
    /// Samples in a trace, 1 to 65,535.
    pub samples: usize,
    /// Spacing of samples, s; rounded to whole picoseconds.
    pub step_s: f64,
    /// Fast time of the first sample, s; rounded to whole nanoseconds.
    pub start_s: f64,
    /// Places of traces, x east, y north, z up, m; kept to millimetres.
    pub position_m: Option<&'a [[f64; 3]]>,
    /// Lines of the text header, of which 39 are kept.
    pub text: &'a [String],
}

/// Writes traces. The sample interval counts picoseconds and the delay nanoseconds, as radars write them.
///
/// # Errors
/// Numbers that the format cannot hold (`InvalidInput`), and those of the stream.
///
/// ```
/// use acerra_formats::segy::{SegyTraces, read_segy, write_segy};
/// let traces = SegyTraces {
///     values: &[1.0, 2.0, 3.0, 4.0],
///     samples: 2,
///     step_s: 61e-12,
///     start_s: 3e-9,
///     position_m: None,
///     text: &[],
/// };
/// let mut bytes = Vec::new();
/// write_segy(&mut bytes, &traces)?;
/// let read = read_segy(bytes.as_slice(), &acerra_formats::Limits::default())?;
/// assert_eq!(read.channels[0].traces, 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_segy(to: &mut impl Write, traces: &SegyTraces<'_>) -> io::Result<()> {
    let wrong = |what: String| io::Error::new(io::ErrorKind::InvalidInput, what);
    let samples = u16::try_from(traces.samples)
        .ok()
        .filter(|n| *n > 0 && traces.values.len().is_multiple_of(traces.samples))
        .ok_or_else(|| {
            wrong(format!(
                "SEG-Y holds 1 to 65535 samples a trace, found {}",
                traces.samples
            ))
        })?;
    let interval = (traces.step_s * 1e12).round();
    if !(1.0..=65_535.0).contains(&interval) {
        return Err(wrong(format!(
            "SEG-Y holds a sample interval of 1 to 65535 ps, found {} ps",
            traces.step_s * 1e12
        )));
    }
    let delay = (traces.start_s * 1e9).round();
    if !(-32_768.0..=32_767.0).contains(&delay) {
        return Err(wrong(format!(
            "SEG-Y holds a delay of up to 32767 ns, found {delay} ns"
        )));
    }
    let (interval, delay) = (interval as u16, delay as i16);
    let mut text = [b' '; TEXT_BYTES];
    let last = "END TEXTUAL HEADER".to_owned();
    let lines = traces.text.iter().take(39).chain([&last]);
    for (k, line) in lines.enumerate() {
        let line: Vec<u8> = format!("C{:2} {line}", k + 1)
            .bytes()
            .filter(|b| (0x20..0x7f).contains(b))
            .take(80)
            .collect();
        text[k * 80..k * 80 + line.len()].copy_from_slice(&line);
    }
    to.write_all(&text)?;
    let mut binary = [0; BINARY_BYTES];
    put(&mut binary, 12, &1i16.to_be_bytes());
    put(&mut binary, 16, &interval.to_be_bytes());
    put(&mut binary, 20, &samples.to_be_bytes());
    put(&mut binary, 24, &5i16.to_be_bytes());
    put(&mut binary, 54, &1i16.to_be_bytes());
    put(&mut binary, 300, &[1, 0]);
    put(&mut binary, 302, &1i16.to_be_bytes());
    to.write_all(&binary)?;
    for (k, row) in traces.values.chunks(traces.samples).enumerate() {
        let mut header = [0; TRACE_HEADER_BYTES];
        let number = (k as i32 + 1).to_be_bytes();
        for at in [0, 4, 8] {
            put(&mut header, at, &number);
        }
        put(&mut header, 12, &1i32.to_be_bytes());
        put(&mut header, 28, &1i16.to_be_bytes());
        if let Some(p) = traces.position_m.and_then(|p| p.get(k)) {
            let mut millimetres = [0i32; 3];
            for (to, m) in millimetres.iter_mut().zip(p) {
                let value = (m * 1e3).round();
                if value.abs() > f64::from(i32::MAX) {
                    return Err(wrong(format!(
                        "SEG-Y holds coordinates of up to 2147 km, found {m} m"
                    )));
                }
                *to = value as i32;
            }
            for (at, value) in [
                (40, 2),
                (72, 0),
                (76, 1),
                (80, 0),
                (84, 1),
                (180, 0),
                (184, 1),
            ] {
                put(&mut header, at, &millimetres[value].to_be_bytes());
            }
            put(&mut header, 68, &(-1000i16).to_be_bytes());
            put(&mut header, 70, &(-1000i16).to_be_bytes());
            put(&mut header, 88, &1i16.to_be_bytes());
        }
        put(&mut header, 108, &delay.to_be_bytes());
        put(&mut header, 114, &samples.to_be_bytes());
        put(&mut header, 116, &interval.to_be_bytes());
        to.write_all(&header)?;
        for value in row {
            to.write_all(&value.to_be_bytes())?;
        }
    }
    Ok(())
}

fn put(to: &mut [u8], at: usize, bytes: &[u8]) {
    to[at..at + bytes.len()].copy_from_slice(bytes);
}
