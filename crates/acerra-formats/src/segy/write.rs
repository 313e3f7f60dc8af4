//! Writing: big-endian, IEEE floats, as programs for ground-penetrating radar read it. Revision 1, or 2 where the
//! sample interval is no whole number of picoseconds or a trace holds more samples than revision 1 can say.

use std::io::{self, Write};

use super::binary::{BINARY_BYTES, TEXT_BYTES};
use super::trace::TRACE_HEADER_BYTES;
use crate::recording::Positions;

/// What is written.
#[derive(Debug, Clone, Copy)]
pub struct SegyTraces<'a> {
    /// Samples, row-major `[traces, samples]`.
    pub values: &'a [f32],
    /// Samples in a trace.
    pub samples: usize,
    /// Spacing of samples, s.
    pub step_s: f64,
    /// Fast time of the first sample, s; kept to a thousandth of a nanosecond up to 32 ns, to a hundredth up to 327 ns
    /// and so on.
    pub start_s: f64,
    /// Places of traces: local ones are kept to millimetres, those on the Earth to a thousandth of a second of arc
    /// (3 cm), or a tenth of that within 59° of Greenwich; heights to millimetres.
    pub positions: Option<&'a Positions>,
    /// Transmitter and receiver of each trace in the axes of local positions, m; kept to millimetres, east and north.
    pub antennas_m: Option<&'a [Vec<[f64; 3]>; 2]>,
    /// Lines of the text header, of which 39 are kept.
    pub text: &'a [String],
}

/// Writes traces. The sample interval counts picoseconds and the delay nanoseconds, as radars write them; in revision 2
/// the interval is written in double precision as well, in the standard's microseconds.
///
/// # Errors
/// Numbers that the format cannot hold (`InvalidInput`), and errors of the stream.
///
/// ```
/// use acerra_formats::segy::{SegyTraces, read_segy, write_segy};
/// let traces = SegyTraces {
///     values: &[1.0, 2.0, 3.0, 4.0],
///     samples: 2,
///     step_s: 61e-12,
///     start_s: 3e-9,
///     positions: None,
///     antennas_m: None,
///     text: &[],
/// };
/// let mut bytes = Vec::new();
/// write_segy(&mut bytes, &traces)?;
/// let read = read_segy(bytes.as_slice(), bytes.len() as u64, &acerra_formats::Limits::default())?;
/// assert_eq!(read.channels[0].traces, 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_segy(to: &mut impl Write, traces: &SegyTraces<'_>) -> io::Result<()> {
    let scales = Scales::of(traces)?;
    to.write_all(&text(traces.text))?;
    to.write_all(&binary(traces, &scales))?;
    for (k, row) in traces.values.chunks(traces.samples).enumerate() {
        to.write_all(&trace_header(k, traces, &scales)?)?;
        for value in row {
            to.write_all(&value.to_be_bytes())?;
        }
    }
    Ok(())
}

fn wrong(what: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what)
}

/// Whole numbers of the axis and the places of all traces.
struct Scales {
    /// Whether the integers of revision 1 are insufficient.
    is_two: bool,
    /// Sample interval to the nearest picosecond.
    interval: u16,
    /// Samples in a trace; 0 where they are too many for the old field.
    samples: u16,
    /// Delay of the first sample, and number of its units in a nanosecond.
    delay: i16,
    delay_scale: i16,
    /// Number of units of coordinates in a metre or a second of arc.
    places_scale: i16,
}

impl Scales {
    fn of(traces: &SegyTraces<'_>) -> io::Result<Self> {
        let n = traces.samples;
        if n == 0 || i32::try_from(n).is_err() || !traces.values.len().is_multiple_of(n) {
            return Err(wrong(format!(
                "SEG-Y holds 1 to 2147483647 samples a trace, as many in each, found {n} of {}",
                traces.values.len()
            )));
        }
        let interval_ps = traces.step_s * 1e12;
        let interval = interval_ps.round();
        if !(interval_ps > 0.0 && interval <= 65_535.0) {
            return Err(wrong(format!(
                "SEG-Y holds a sample interval of up to 65535 ps, found {interval_ps} ps"
            )));
        }
        let is_whole = (interval_ps - interval).abs() <= 1e-9 * interval_ps;
        let delay = |scale: &i16| traces.start_s * 1e9 * f64::from(*scale);
        let fits = |scale: &i16| delay(scale).abs() <= f64::from(i16::MAX);
        let delay_scale = [1000, 100, 10, 1].into_iter().find(fits).ok_or_else(|| {
            wrong(format!(
                "SEG-Y holds a delay of up to 32767 ns, found {} ns",
                1e9 * traces.start_s
            ))
        })?;
        Ok(Self {
            is_two: !is_whole || n > usize::from(u16::MAX),
            interval: (interval as u16).max(1),
            samples: u16::try_from(n).unwrap_or(0),
            delay: delay(&delay_scale).round() as i16,
            delay_scale,
            places_scale: match traces.positions {
                Some(Positions::Geodetic(places)) if places.iter().all(|p| p[1].abs() < 59.0) => {
                    10_000
                }
                _ => 1000,
            },
        })
    }
}

fn text(lines: &[String]) -> [u8; TEXT_BYTES] {
    let mut text = [b' '; TEXT_BYTES];
    let last = "END TEXTUAL HEADER".to_owned();
    let lines = lines.iter().take(39).chain([&last]);
    for (k, line) in lines.enumerate() {
        let line: Vec<u8> = format!("C{:2} {line}", k + 1)
            .bytes()
            .filter(|b| (0x20..0x7f).contains(b))
            .take(80)
            .collect();
        text[k * 80..k * 80 + line.len()].copy_from_slice(&line);
    }
    text
}

fn binary(traces: &SegyTraces<'_>, scales: &Scales) -> [u8; BINARY_BYTES] {
    let mut binary = [0; BINARY_BYTES];
    put(&mut binary, 12, &1i16.to_be_bytes());
    put(&mut binary, 16, &scales.interval.to_be_bytes());
    put(&mut binary, 20, &scales.samples.to_be_bytes());
    put(&mut binary, 24, &5i16.to_be_bytes());
    put(&mut binary, 54, &1i16.to_be_bytes());
    if scales.is_two {
        put(&mut binary, 68, &(traces.samples as i32).to_be_bytes());
        put(&mut binary, 72, &(traces.step_s * 1e6).to_be_bytes());
        put(&mut binary, 96, &[1, 2, 3, 4]);
    }
    put(&mut binary, 300, &[if scales.is_two { 2 } else { 1 }, 0]);
    put(&mut binary, 302, &1i16.to_be_bytes());
    binary
}

fn trace_header(
    k: usize,
    traces: &SegyTraces<'_>,
    scales: &Scales,
) -> io::Result<[u8; TRACE_HEADER_BYTES]> {
    let mut header = [0; TRACE_HEADER_BYTES];
    let number = (k as i32 + 1).to_be_bytes();
    for at in [0, 4, 8] {
        put(&mut header, at, &number);
    }
    put(&mut header, 12, &1i32.to_be_bytes());
    put(&mut header, 28, &1i16.to_be_bytes());
    put(&mut header, 108, &scales.delay.to_be_bytes());
    put(&mut header, 114, &scales.samples.to_be_bytes());
    put(&mut header, 116, &scales.interval.to_be_bytes());
    put(&mut header, 214, &(-scales.delay_scale).to_be_bytes());
    // East, north, up, and the unit of the first two: a length, seconds of arc.
    let place = match traces.positions {
        None => None,
        Some(Positions::Local(places)) => places.get(k).map(|p| (*p, 1i16)),
        Some(Positions::Geodetic(places)) => places
            .get(k)
            .map(|p| ([p[1] * 3600.0, p[0] * 3600.0, p[2]], 2)),
    };
    let Some((place, unit)) = place else {
        return Ok(header);
    };
    let apart = |antenna: usize| {
        let all = traces.antennas_m.filter(|_| unit == 1)?;
        all[antenna].get(k).copied()
    };
    let [source, group] = [0, 1].map(|antenna| apart(antenna).unwrap_or(place));
    let whole = |value: f64, scale: i16| {
        let number = (value * f64::from(scale)).round();
        if number.abs() <= f64::from(i32::MAX) {
            Ok(number as i32)
        } else {
            Err(wrong(format!(
                "SEG-Y holds coordinates of up to 2147 km, found {value} in trace {}",
                k + 1
            )))
        }
    };
    put(&mut header, 40, &whole(place[2], 1000)?.to_be_bytes());
    for (at, value) in [
        (72, source[0]),
        (76, source[1]),
        (80, group[0]),
        (84, group[1]),
        (180, place[0]),
        (184, place[1]),
    ] {
        let number = whole(value, scales.places_scale)?;
        put(&mut header, at, &number.to_be_bytes());
    }
    put(&mut header, 68, &(-1000i16).to_be_bytes());
    put(&mut header, 70, &(-scales.places_scale).to_be_bytes());
    put(&mut header, 88, &unit.to_be_bytes());
    Ok(header)
}

fn put(to: &mut [u8], at: usize, bytes: &[u8]) {
    to[at..at + bytes.len()].copy_from_slice(bytes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::recording::{Axis, Values};
    use crate::segy::read_segy;

    fn back(traces: &SegyTraces<'_>) -> crate::Recording {
        let mut bytes = Vec::new();
        write_segy(&mut bytes, traces).unwrap();
        read_segy(bytes.as_slice(), bytes.len() as u64, &Limits::default()).unwrap()
    }

    fn samples(traces: usize, samples: usize) -> Vec<f32> {
        (0..traces * samples)
            .map(|i| (i as f32 * 0.7).sin() * 1e3)
            .collect()
    }

    #[test]
    fn everything_comes_back() {
        let values = samples(3, 5);
        let near = |found: f64, expected: f64, by: f64| {
            assert!((found - expected).abs() <= by, "{found} {expected}");
        };
        let local = Positions::Local(vec![[1.5, -2.25, 0.5], [1e6, 2.001, 3.0], [7.0, 8.0, 0.0]]);
        let polar = Positions::Geodetic(vec![[69.123_456_7, -160.765_432_1, 12.345]; 3]);
        let near_greenwich = Positions::Geodetic(vec![[-41.123_456_7, 14.765_432_1, 0.25]; 3]);
        for (step_s, start_s, start_by_s, positions, by) in [
            (61e-12, 30.123e-9, 0.6e-12, &local, 0.6e-3),
            (3.8517e-12, 0.0, 0.0, &polar, 0.6e-3 / 3600.0),
            (
                97.65625e-12,
                -120.57e-9,
                6e-12,
                &near_greenwich,
                0.6e-4 / 3600.0,
            ),
        ] {
            let traces = SegyTraces {
                values: &values,
                samples: 5,
                step_s,
                start_s,
                positions: Some(positions),
                antennas_m: None,
                text: &["A LINE".to_owned()],
            };
            let read = back(&traces);
            let [channel] = read.channels.as_slice() else {
                panic!("{} channels", read.channels.len());
            };
            assert_eq!(channel.values, Values::Real(values.clone()));
            let Axis::FastTime {
                start_s: start,
                step_s: step,
                samples,
            } = channel.axis
            else {
                panic!("spectra");
            };
            assert_eq!(samples, 5);
            near(step, step_s, 1e-14 * step_s);
            near(start, start_s, start_by_s);
            let found = channel.positions.as_ref().unwrap();
            let (a, b) = match (found, positions) {
                (Positions::Local(a), Positions::Local(b))
                | (Positions::Geodetic(a), Positions::Geodetic(b)) => (a, b),
                _ => panic!("{found:?}"),
            };
            for (a, b) in a.iter().zip(b) {
                (0..2).for_each(|k| near(a[k], b[k], by));
                near(a[2], b[2], 0.6e-3);
            }
        }
    }

    #[test]
    fn long_traces_and_antennas_apart_come_back() {
        let values = samples(2, 70_000);
        let middle = Positions::Local(vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]);
        let moved = |by: f64| vec![[by, 0.0, 1.0], [1.0 + by, 0.0, 1.0]];
        let antennas_m = [moved(0.03), moved(-0.03)];
        let traces = SegyTraces {
            values: &values,
            samples: 70_000,
            step_s: 10e-12,
            start_s: 0.0,
            positions: Some(&middle),
            antennas_m: Some(&antennas_m),
            text: &[],
        };
        let read = back(&traces);
        assert_eq!(read.channels[0].values, Values::Real(values.clone()));
        assert_eq!(read.channels[0].positions.as_ref(), Some(&middle));
        assert_eq!(read.channels[0].antennas_m.as_ref(), Some(&antennas_m));
    }

    #[test]
    fn what_the_format_cannot_hold_is_refused() {
        let refused = |change: fn(&mut SegyTraces<'_>)| {
            let mut traces = SegyTraces {
                values: &[0.0; 6],
                samples: 3,
                step_s: 61e-12,
                start_s: 0.0,
                positions: None,
                antennas_m: None,
                text: &[],
            };
            change(&mut traces);
            write_segy(&mut Vec::new(), &traces)
                .unwrap_err()
                .to_string()
        };
        assert!(refused(|t| t.samples = 0).contains("samples"));
        assert!(refused(|t| t.samples = 4).contains("samples"));
        assert!(refused(|t| t.step_s = 1e-6).contains("65535 ps"));
        assert!(refused(|t| t.step_s = f64::NAN).contains("65535 ps"));
        assert!(refused(|t| t.start_s = 1e-4).contains("32767 ns"));
    }
}
