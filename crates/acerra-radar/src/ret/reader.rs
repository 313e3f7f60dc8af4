//! Reading an MRM-RET log.

use std::io::{BufReader, Read};

use super::fields::Fields;
use super::lines::{Line, Lines};
use crate::limits::Limits;
use crate::log::{LogBuilder, LogFormat, RadarLog, ReadError};
use crate::mrm::RadarConfig;
use crate::report::{BlemishKind, Place, ReadReport};
use crate::scan::{Filtering, Scan, ScanWindow};

/// Field of a scan line at which its samples begin.
const FIRST_SAMPLE: usize = 17;

const EVENTS: [&str; 5] = [
    "Config",
    "MrmControlRequest",
    "MrmControlConfirm",
    "MrmFullScanInfo",
    "MrmDetectionListInfo",
];

/// Whether a file's first bytes are an MRM-RET log: text, with a known event or heading.
pub(crate) fn recognise(head: &[u8]) -> bool {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    head.split(|b| matches!(b, b'\n' | b'\r'))
        .take(100)
        .any(|line| {
            // A first line may be cut off by the look-ahead, and other lines may be unreadable.
            let line = String::from_utf8_lossy(&line[..line.len().min(256)]);
            let fields = Fields::new(&line);
            let event = fields.get(2).unwrap_or_default();
            EVENTS.contains(&event)
                && (fields.get(1) == Some("Timestamp") || fields.parse::<f64>(1, "a time").is_ok())
        })
}

/// Reads an MRM-RET text log.
///
/// Every scan line that is whole is kept, whatever its filtering and window; choose among them with
/// [`RadarLog::radargram`]. Unreadable lines are reported and skipped.
///
/// # Errors
/// If the input fails, holds no whole scan, or more samples than [`Limits::max_samples`].
///
/// ```
/// use acerra_radar::{Limits, ret::read_ret};
/// let text = "Timestamp, MrmFullScanInfo, …headings…\n\
///             12.5, MrmFullScanInfo, 7, 100, 4000, , , , , 0, 122, 32, 1, 2, 1, 2, -5, 9\n";
/// let log = read_ret(text.as_bytes(), &Limits::default())?;
/// assert_eq!(log.scans[0].samples, [-5, 9]);
/// assert_eq!(log.scans[0].host_time_s, Some(12.5));
/// # Ok::<(), acerra_radar::ReadError>(())
/// ```
pub fn read_ret(reader: impl Read, limits: &Limits) -> Result<RadarLog, ReadError> {
    let reader = BufReader::with_capacity(1 << 16, reader);
    let mut lines = Lines::new(reader, limits.max_line_bytes);
    let mut builder = LogBuilder::new(LogFormat::MrmRet, limits.max_samples);
    let mut report = ReadReport::default();
    let mut number = 0;
    while let Some(line) = lines.next()? {
        report.bytes = lines.bytes();
        number += 1;
        let place = Place::Line(number);
        let ended = match line {
            Line::Text { ended } => ended,
            Line::TooLong => {
                report.add(
                    place,
                    BlemishKind::LongLine {
                        limit: limits.max_line_bytes,
                    },
                );
                continue;
            }
        };
        let mut text = String::from_utf8_lossy(lines.text());
        if number == 1
            && let Some(rest) = text.strip_prefix('\u{feff}')
        {
            text = rest.to_owned().into();
        }
        if text.trim().is_empty() {
            continue;
        }
        match event(&text, limits) {
            Ok(Event::Scan(scan)) => {
                report.scan_messages += 1;
                report.whole_scans += 1;
                if !ended {
                    report.add(place, BlemishKind::UnterminatedLine);
                }
                builder.scan(place, *scan, &mut report)?;
            }
            Ok(Event::Config(config)) => builder.config(place, config, &mut report),
            Ok(Event::Interval(interval_us)) => {
                builder.interval(interval_us);
                report.count_other("MrmControlRequest");
            }
            Ok(Event::Other(name)) => report.count_other(&name),
            Ok(Event::Heading) => {}
            Err(_) if !ended => report.add(place, BlemishKind::CutOffLine),
            Err(kind) => report.add(place, kind),
        }
    }
    report.bytes = lines.bytes();
    builder.finish(report)
}

enum Event {
    Heading,
    Scan(Box<Scan>),
    Config(RadarConfig),
    Interval(u32),
    Other(String),
}

fn event(line: &str, limits: &Limits) -> Result<Event, BlemishKind> {
    let fields = Fields::new(line);
    if fields.get(1) == Some("Timestamp") {
        return Ok(Event::Heading);
    }
    let name = fields
        .get(2)
        .filter(|n| !n.is_empty() && n.len() <= 64)
        .ok_or(BlemishKind::MalformedLine {
            field: 2,
            expected: "an event's name",
        })?;
    match name {
        "MrmFullScanInfo" => scan(&fields, limits).map(|s| Event::Scan(Box::new(s))),
        "Config" => config(&fields).map(Event::Config),
        "MrmControlRequest" => fields.parse(5, "an interval in µs").map(Event::Interval),
        _ => {
            fields.parse::<f64>(1, "a host time")?;
            Ok(Event::Other(name.to_owned()))
        }
    }
}

fn config(fields: &Fields<'_>) -> Result<RadarConfig, BlemishKind> {
    let mut segment_samples = [0; 4];
    let mut segment_integration = [0; 4];
    for i in 0..4 {
        segment_samples[i] = fields.parse_or(8 + i, "segment samples", 0)?;
        segment_integration[i] = fields.parse_or(12 + i, "a segment's integration", 0)?;
    }
    Ok(RadarConfig {
        node_id: fields.parse_or(3, "a node's identity", 0)?,
        scan_start_ps: fields.parse(4, "a scan start in ps")?,
        scan_stop_ps: fields.parse(5, "a scan stop in ps")?,
        scan_resolution_bins: fields.parse(6, "a resolution in bins")?,
        integration_index: fields.parse(7, "a pulse integration index")?,
        segment_samples,
        segment_integration,
        antenna_mode: fields.parse_or(16, "an antenna mode", 0)?,
        transmit_gain: fields.parse_or(17, "a transmit gain", 0)?,
        code_channel: fields.parse_or(18, "a code channel", 0)?,
        persist: 0,
    })
}

fn scan(fields: &Fields<'_>, limits: &Limits) -> Result<Scan, BlemishKind> {
    let host_time_s: f64 = fields.parse(1, "a host time")?;
    if !host_time_s.is_finite() {
        return Err(BlemishKind::MalformedLine {
            field: 1,
            expected: "a finite host time",
        });
    }
    let start_ps: i32 = fields.parse(10, "a scan start in ps")?;
    let stop_ps: i32 = fields.parse(11, "a scan stop in ps")?;
    if stop_ps <= start_ps {
        return Err(BlemishKind::MalformedLine {
            field: 11,
            expected: "a scan stop after the start",
        });
    }
    let step_bins: u16 = fields.parse(12, "a scan step in bins")?;
    if !(1..=1024).contains(&step_bins) {
        return Err(BlemishKind::MalformedLine {
            field: 12,
            expected: "a step of 1 to 1024 bins",
        });
    }
    let expected: usize = fields.parse(16, "a number of samples")?;
    let values = fields.from(FIRST_SAMPLE);
    if values.len() != expected {
        return Err(BlemishKind::LineSamples {
            expected,
            found: values.len(),
        });
    }
    if !(1..=limits.max_scan_samples).contains(&expected) {
        return Err(BlemishKind::MalformedLine {
            field: 16,
            expected: "a number of samples within the limits",
        });
    }
    let samples: Vec<i32> = values
        .iter()
        .enumerate()
        .map(|(i, v)| {
            v.parse().map_err(|_| BlemishKind::MalformedLine {
                field: FIRST_SAMPLE + i,
                expected: "an integer sample",
            })
        })
        .collect::<Result<_, _>>()?;
    Ok(Scan {
        source_id: fields.parse_or(4, "a radio's identity", 0)?,
        message_id: fields.parse(3, "a message id")?,
        timestamp_ms: fields.parse(5, "a radio time in ms")?,
        host_time_s: Some(host_time_s),
        window: ScanWindow {
            start_ps,
            stop_ps,
            step_bins,
            samples: expected,
        },
        filtering: Filtering::from_code(fields.parse(13, "a filtering code")?),
        antenna_id: fields.parse_or(14, "an antenna", 0)?,
        operation_mode: fields.parse_or(15, "an operation mode", 0)?,
        samples,
    })
}
