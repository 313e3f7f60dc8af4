//! Reading any file that holds observations or navigation data.

use std::collections::BTreeSet;
use std::io::{BufReader, Cursor, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use flate2::read::MultiGzDecoder;

use crate::collect::Collector;
use crate::crinex::CrinexLines;
use crate::input::{
    FileKind, Limits, LineSource, Lines, Place, ReadError, ReadReport, UnixCompressed,
};
use crate::observations::observation::ObservationData;
use crate::observations::recorded::RecordedEpoch;
use crate::observations::select::SignalChoice;
use crate::orbits::navigation::Navigation;
use crate::orbits::products::PreciseProducts;
use crate::packed::{Counted, Unpacked, each_member};
use crate::precise::{read_clock_lines, read_sp3_lines};
use crate::rinex::{ObservationRecord, RinexObservations, read_navigation_lines};
use crate::rtcm::{self, RtcmHints, RtcmLog, read_rtcm};
use crate::sniff::{SNIFF_BYTES, sniff};
use crate::ubx::{self, UbxLog, read_ubx};

/// Contents of a GNSS file.
#[derive(Debug, Clone, PartialEq)]
pub struct GnssFile {
    /// Recognised kind of the content, inside any gzip.
    pub kind: FileKind,
    /// Observations, with one signal per frequency slot; `None` for navigation files.
    pub observations: Option<ObservationData>,
    /// Navigation data; `None` for RINEX observation files. Raw logs hold both.
    pub navigation: Option<Navigation>,
    /// Data dropped by the reader.
    pub report: ReadReport,
}

/// Reads any supported file: RINEX 2–4 observation or navigation data, Hatanaka-compressed
/// (CRINEX 1 and 3), UBX raw logs, RTCM 3 logs, SP3 orbits, RINEX
/// clocks, each also inside gzip, UNIX `compress` or a zip archive.
/// Recognised by content.
///
/// RTCM 3 logs that do not state their date need [`read_gnss_near`].
///
/// ```
/// use acerra_gnss::{input::Limits, read_gnss};
/// let text = "     2.11           OBSERVATION DATA    G (GPS)             RINEX VERSION / TYPE\n\
///             \x20    1    C1                                                # / TYPES OF OBSERV\n\
///             \x20                                                           END OF HEADER\n\
///             \x2026 11 21 12  0  0.0000000  0  1G07\n\
///             \x20 20311445.258\n";
/// let file = read_gnss(text.as_bytes(), Limits::default())?;
/// let epoch = &file.observations.unwrap().epochs[0];
/// assert_eq!(epoch.satellites[0].first_pseudorange_m(), Some(20_311_445.258));
/// # Ok::<(), acerra_gnss::input::ReadError>(())
/// ```
///
/// # Errors
/// [`ReadError::WrongKind`] for content of another kind, [`ReadError::Empty`], and any error of the reader of
/// the kind found.
pub fn read_gnss(reader: impl Read, limits: Limits) -> Result<GnssFile, ReadError> {
    read_gnss_near(reader, limits, &RtcmHints::default())
}

/// As [`read_gnss`], with data that an RTCM 3 log may lack: its date, and the frequency channels of GLONASS
/// satellites.
///
/// # Errors
/// As [`read_gnss`]; [`ReadError::NoDate`] for an RTCM 3 log whose week neither its messages nor
/// the hints give.
pub fn read_gnss_near(
    reader: impl Read,
    limits: Limits,
    hints: &RtcmHints,
) -> Result<GnssFile, ReadError> {
    let (kind, head, rest) = peek(reader)?;
    let packed = Counted::new(Cursor::new(head).chain(rest));
    let count = packed.packed();
    let (name, inner): (_, Box<dyn Read + '_>) = match kind {
        FileKind::Gzip => ("gzip", Box::new(MultiGzDecoder::new(packed))),
        FileKind::UnixCompress => ("compress", Box::new(UnixCompressed::new(packed))),
        FileKind::Zip => return read_zip(&whole(packed, limits)?, limits, hints),
        _ => return read_kind(kind, packed, limits, hints),
    };
    let cut = Arc::new(AtomicBool::new(false));
    let decoder = Unpacked::new(inner, count, Arc::clone(&cut));
    let mut file = read_member(decoder, limits, hints)?;
    file.report.format.push_str(&format!(", {name}"));
    if cut.load(Ordering::Relaxed) {
        file.report
            .remarks
            .push(format!("the {name} stream is cut off"));
    }
    Ok(file)
}

/// Reads packed content; content packed twice is refused.
fn read_member(
    reader: impl Read,
    limits: Limits,
    hints: &RtcmHints,
) -> Result<GnssFile, ReadError> {
    let (kind, head, rest) = peek(reader)?;
    read_kind(kind, Cursor::new(head).chain(rest), limits, hints)
}

/// The logs in a zip archive: one file of observations at most, and all navigation data.
fn read_zip(archive: &[u8], limits: Limits, hints: &RtcmHints) -> Result<GnssFile, ReadError> {
    let problem = |problem: String| ReadError::Archive { problem };
    let mut log: Option<(String, GnssFile)> = None;
    let mut navigation: Option<Navigation> = None;
    each_member(archive, |name, content| {
        let mut file = match read_member(content, limits, hints) {
            Ok(file) => file,
            // Other members, such as solutions, notes and pictures, are ignored.
            Err(ReadError::WrongKind { .. } | ReadError::Empty) => return Ok(()),
            Err(cause) => return Err(problem(format!("{name:?}: {cause}"))),
        };
        if let Some(more) = file.navigation.take() {
            navigation.get_or_insert_default().merge(more);
        }
        match (&log, file.observations.is_some()) {
            (Some((first, _)), true) => Err(problem(format!(
                "several files of observations ({first:?}, {name:?}): unpack it and name one"
            ))),
            (None, true) => {
                log = Some((name, file));
                Ok(())
            }
            (_, false) => Ok(()),
        }
    })?;
    if let Some(navigation) = &mut navigation {
        navigation.normalise();
    }
    let (kind, observations, report) = match log {
        Some((name, mut file)) => {
            file.report
                .format
                .push_str(&format!(", {name:?} in a zip archive"));
            (file.kind, file.observations, file.report)
        }
        None if navigation.is_some() => {
            let report = ReadReport {
                format: "navigation data in a zip archive".to_owned(),
                ..ReadReport::default()
            };
            (FileKind::RinexNavigation, None, report)
        }
        None => return Err(problem("no GNSS data in it".to_owned())),
    };
    Ok(GnssFile {
        kind,
        observations,
        navigation,
        report,
    })
}

/// As [`read_gnss`], for a file that must hold observations.
///
/// # Errors
/// As [`read_gnss`]; [`ReadError::WrongKind`] for a navigation file.
pub fn read_observations(
    reader: impl Read,
    limits: Limits,
) -> Result<(ObservationData, ReadReport), ReadError> {
    let file = read_gnss(reader, limits)?;
    match file.observations {
        Some(data) => Ok((data, file.report)),
        None => Err(ReadError::WrongKind {
            expected: "observations",
            found: file.kind,
        }),
    }
}

/// As [`read_gnss`], for a file that must hold navigation data.
///
/// # Errors
/// As [`read_gnss`]; [`ReadError::WrongKind`] for a RINEX observation file.
pub fn read_navigation(
    reader: impl Read,
    limits: Limits,
) -> Result<(Navigation, ReadReport), ReadError> {
    let file = read_gnss(reader, limits)?;
    match file.navigation {
        Some(data) => Ok((data, file.report)),
        None => Err(ReadError::WrongKind {
            expected: "navigation data",
            found: file.kind,
        }),
    }
}

/// Reads the beginning of a stream, and returns it with a reader of the whole stream.
fn peek<R: Read>(mut reader: R) -> Result<(FileKind, Vec<u8>, R), ReadError> {
    let mut head = Vec::new();
    reader
        .by_ref()
        .take(SNIFF_BYTES as u64)
        .read_to_end(&mut head)?;
    match sniff(&head) {
        FileKind::Empty => Err(ReadError::Empty),
        kind => Ok((kind, head, reader)),
    }
}

fn read_kind(
    kind: FileKind,
    reader: impl Read,
    limits: Limits,
    hints: &RtcmHints,
) -> Result<GnssFile, ReadError> {
    match kind {
        FileKind::RinexObservation => {
            let lines = Lines::new(BufReader::new(reader), limits);
            Ok(observation_file(kind, observations_of(lines, "")?))
        }
        FileKind::Crinex => {
            let lines = CrinexLines::new(Lines::new(BufReader::new(reader), limits))?;
            let suffix = format!(", Hatanaka {}", lines.version());
            Ok(observation_file(kind, observations_of(lines, &suffix)?))
        }
        FileKind::RinexNavigation => {
            let mut lines = Lines::new(BufReader::new(reader), limits);
            Ok(navigation_file(kind, read_navigation_lines(&mut lines)?))
        }
        FileKind::Sp3 => {
            let mut lines = Lines::new(BufReader::new(reader), limits);
            Ok(precise_file(kind, read_sp3_lines(&mut lines)?))
        }
        FileKind::RinexClock => {
            let mut lines = Lines::new(BufReader::new(reader), limits);
            Ok(precise_file(kind, read_clock_lines(&mut lines)?))
        }
        FileKind::Ubx | FileKind::Rtcm3 => binary_file(kind, &whole(reader, limits)?, hints),
        found => Err(ReadError::WrongKind {
            expected: "RINEX, UBX or RTCM 3 observations or navigation data",
            found,
        }),
    }
}

fn observation_file(kind: FileKind, (data, report): (ObservationData, ReadReport)) -> GnssFile {
    GnssFile {
        kind,
        observations: Some(data),
        navigation: None,
        report,
    }
}

fn navigation_file(kind: FileKind, (data, report): (Navigation, ReadReport)) -> GnssFile {
    GnssFile {
        kind,
        observations: None,
        navigation: Some(data),
        report,
    }
}

fn precise_file(kind: FileKind, (precise, report): (PreciseProducts, ReadReport)) -> GnssFile {
    let navigation = Navigation {
        precise,
        ..Navigation::default()
    };
    navigation_file(kind, (navigation, report))
}

/// The whole content of a reader, within the limits.
fn whole(reader: impl Read, limits: Limits) -> Result<Vec<u8>, ReadError> {
    let mut log = Vec::new();
    let mut reader = reader.take(limits.max_bytes.saturating_add(1));
    reader.read_to_end(&mut log)?;
    if log.len() as u64 > limits.max_bytes {
        return Err(ReadError::Limit {
            what: "the file",
            limit: limits.max_bytes,
        });
    }
    Ok(log)
}

/// A log of UBX frames, RTCM 3 messages, or both from one port: the protocol with observations counts.
fn binary_file(kind: FileKind, log: &[u8], hints: &RtcmHints) -> Result<GnssFile, ReadError> {
    let observes = |file: &GnssFile| {
        let observations = file.observations.as_ref();
        observations.is_some_and(|o| !o.epochs.is_empty())
    };
    if kind == FileKind::Rtcm3 {
        return rtcm_file(log, hints);
    }
    let ubx = ubx_file(log)?;
    if observes(&ubx) {
        return Ok(ubx);
    }
    let (messages, with_observations) = rtcm::counts(log);
    if with_observations > 0 {
        let mut file = rtcm_file(log, hints)?;
        let frames = ubx::frame::pieces(log).filter(|p| matches!(p, ubx::frame::Piece::Frame(_)));
        file.report.format = format!(
            "RTCM 3 ({messages} messages) with UBX ({} frames) between",
            frames.count()
        );
        if let Some(navigation) = ubx.navigation {
            file.navigation.get_or_insert_default().merge(navigation);
        }
        return Ok(file);
    }
    // Raw messages without measurements, from a receiver without a fix, give another error.
    let is_raw = |piece: ubx::frame::Piece<'_>| match piece {
        ubx::frame::Piece::Frame(frame) => matches!(
            (frame.class, frame.id),
            (0x02, 0x10 | 0x11 | 0x13 | 0x15) | (0x0D, 0x03)
        ),
        _ => false,
    };
    if ubx::frame::pieces(log).any(is_raw) {
        return Ok(ubx);
    }
    Err(ReadError::NoMeasurements)
}

fn rtcm_file(log: &[u8], hints: &RtcmHints) -> Result<GnssFile, ReadError> {
    let RtcmLog {
        epochs,
        station,
        navigation,
        glonass_channels,
        date,
        mut report,
    } = read_rtcm(log, hints);
    if date.is_none() {
        return Err(ReadError::NoDate);
    }
    let choice = choice_of(&epochs);
    let mut collector = Collector::default();
    for (offset, epoch) in epochs {
        collector.epoch(&epoch, &choice, Place::Byte(offset), log.len() as u64)?;
    }
    let mut data = ObservationData {
        station,
        glonass_channels,
        ..ObservationData::default()
    };
    collector.finish(&mut data, &mut report);
    Ok(GnssFile {
        kind: FileKind::Rtcm3,
        observations: Some(data),
        navigation: Some(navigation),
        report,
    })
}

/// The choice of signals for a RINEX 3 file of these epochs.
fn choice_of(epochs: &[(u64, RecordedEpoch)]) -> SignalChoice {
    let listed: BTreeSet<_> = epochs
        .iter()
        .flat_map(|(_, epoch)| &epoch.satellites)
        .flat_map(|s| {
            s.signals
                .iter()
                .map(|signal| (s.satellite.system(), signal.code))
        })
        .collect();
    SignalChoice::per_file(listed)
}

fn ubx_file(log: &[u8]) -> Result<GnssFile, ReadError> {
    let UbxLog {
        epochs,
        events,
        navigation,
        glonass_channels,
        mut report,
    } = read_ubx(log);
    let mut collector = Collector::default();
    for (offset, epoch) in epochs {
        let choice = SignalChoice::PerSatellite;
        collector.epoch(&epoch, &choice, Place::Byte(offset), log.len() as u64)?;
    }
    for event in events {
        collector.event(event);
    }
    let mut data = ObservationData {
        glonass_channels,
        ..ObservationData::default()
    };
    collector.finish(&mut data, &mut report);
    Ok(GnssFile {
        kind: FileKind::Ubx,
        observations: Some(data),
        navigation: Some(navigation),
        report,
    })
}

fn observations_of(
    lines: impl LineSource,
    suffix: &str,
) -> Result<(ObservationData, ReadReport), ReadError> {
    let mut reader = RinexObservations::new(lines)?;
    let mut collector = Collector::default();
    // The choice follows the header, which a record in mid-file may change.
    let mut choice = reader.signal_choice();
    let mut changes = reader.header_changes();
    while let Some(record) = reader.next_record()? {
        if reader.header_changes() != changes {
            changes = reader.header_changes();
            choice = reader.signal_choice();
        }
        match record {
            ObservationRecord::Epoch(epoch) => {
                collector.epoch(&epoch, &choice, reader.place(), reader.read_bytes())?;
            }
            ObservationRecord::Event(event) => collector.event(event),
        }
    }
    let mut report = reader.take_report();
    let header = reader.header();
    report.format = format!(
        "RINEX {}.{:02} observation{suffix}",
        header.version / 100,
        header.version % 100
    );
    let mut data = ObservationData {
        station: header.station.clone(),
        glonass_channels: header.glonass_channels.clone(),
        ..ObservationData::default()
    };
    collector.finish(&mut data, &mut report);
    Ok((data, report))
}
