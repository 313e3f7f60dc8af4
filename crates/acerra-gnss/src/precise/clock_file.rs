//! RINEX clock files, versions 2 and 3 (RINEX extensions to handle clock information, 3.04).

use acerra_geo::time::GpsTime;

use crate::input::{DropReason, LineSource, Place, ReadError, ReadReport};
use crate::observations::satellite::SatelliteId;
use crate::orbits::products::PreciseProducts;
use crate::rinex::{calendar, real};

/// Reads the satellite clocks (`AS`) of a RINEX clock file; station clocks are skipped.
///
/// # Errors
/// [`ReadError`] where the header is not that of a clock file in GPS time, or the input fails.
pub(crate) fn read_clock_lines(
    source: &mut impl LineSource,
) -> Result<(PreciseProducts, ReadReport), ReadError> {
    let version = header(source)?;
    let mut products = PreciseProducts::default();
    let mut report = ReadReport::default();
    while source.advance()? {
        let line = source.line();
        if !line.starts_with(b"AS ") {
            continue;
        }
        let place = Place::Line(source.number());
        match record(line, source.terminated()) {
            Ok((satellite, time, clock_s)) => {
                let series = products.clocks.entry(satellite).or_default();
                series.insert(time, clock_s);
            }
            Err(reason) => report.drop_one(reason, place),
        }
    }
    report.absorb(source.take_report());
    report.format = format!("RINEX {version:.2} clock");
    Ok((products, report))
}

/// Reads the header; version 3.04 has labels five columns further right than earlier versions.
fn header(source: &mut impl LineSource) -> Result<f64, ReadError> {
    if !source.advance()? {
        return Err(ReadError::Empty);
    }
    let (line, number) = (source.line(), source.number());
    let version = real(&line[..line.len().min(9)]).ok().flatten();
    let labelled = contains(line, b"RINEX VERSION / TYPE")
        && line.get(20..22).is_some_and(|t| t.contains(&b'C'));
    let Some(version) = version.filter(|_| labelled) else {
        return Err(ReadError::format(
            number,
            "RINEX VERSION / TYPE of clock data",
            line,
        ));
    };
    if !(1.0..4.0).contains(&version) {
        return Err(ReadError::Unsupported {
            line: number,
            what: format!("RINEX clock version {version:.2}"),
        });
    }
    while source.advance()? {
        let (line, number) = (source.line(), source.number());
        if contains(line, b"END OF HEADER") {
            return Ok(version);
        }
        if contains(line, b"TIME SYSTEM ID") {
            let name = line[..line.len().min(20)].trim_ascii();
            if !matches!(name, b"GPS" | b"GAL" | b"QZS" | b"") {
                return Err(ReadError::Unsupported {
                    line: number,
                    what: format!("time system {}", String::from_utf8_lossy(name)),
                });
            }
        }
    }
    Err(ReadError::MissingHeader {
        line: source.number(),
        missing: "END OF HEADER",
    })
}

fn contains(line: &[u8], label: &[u8]) -> bool {
    line.windows(label.len()).any(|w| w == label)
}

/// Satellite, time and offset (s) of a line `AS G01 2023 05 19 00 00  0.000000  2   …`.
fn record(line: &[u8], terminated: bool) -> Result<(SatelliteId, GpsTime, f64), DropReason> {
    let words: Vec<&[u8]> = line
        .split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty())
        .collect();
    let missing = if terminated {
        DropReason::UnreadableNumber
    } else {
        DropReason::CutOff
    };
    let Some([_, name, time @ .., count, value]) = words.get(..10) else {
        return Err(missing);
    };
    let name = String::from_utf8_lossy(name);
    let satellite = name
        .parse()
        .map_err(|_| DropReason::UnknownSatellite(name.into_owned()))?;
    let time = calendar(&time.join(&b' ')).ok_or(DropReason::UnreadableEpoch)?;
    let clock_s = real(value).ok().flatten().filter(|c| c.abs() < 1.0);
    // A number at the very end of a file may be cut off.
    let whole = terminated || words.len() > 10;
    match (clock_s, count, whole) {
        (Some(clock_s), count, true) if *count != b"0" => {
            Ok((satellite, GpsTime::from_calendar(&time), clock_s))
        }
        (_, _, false) => Err(DropReason::CutOff),
        _ => Err(DropReason::UnreadableNumber),
    }
}
