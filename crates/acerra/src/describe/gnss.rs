//! GNSS observations and navigation.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Seek};

use acerra_chain::position::positioning::written;
use acerra_geo::time::GpsTime;
use acerra_gnss::antex::read_antex;
use acerra_gnss::input::{FileKind, Limits, Lines, ReadError, ReadReport, sniff};
use acerra_gnss::rtcm::RtcmHints;
use acerra_gnss::{GnssFile, Navigation, ObservationData, read_gnss_near};

use super::description::Description;

/// Whether the first bytes belong to a zip archive whose first member is no array.
pub fn is_archive(head: &[u8]) -> bool {
    let length = head
        .get(26..28)
        .map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])));
    let name = length.and_then(|length| head.get(30..30 + length));
    head.starts_with(b"PK\x03\x04") && name.is_some_and(|name| !name.ends_with(b".npy"))
}

/// Whether the first bytes belong to a GNSS file.
pub fn is_gnss(head: &[u8]) -> bool {
    matches!(
        sniff(head),
        FileKind::RinexObservation
            | FileKind::RinexNavigation
            | FileKind::RinexOther
            | FileKind::Crinex
            | FileKind::RinexClock
            | FileKind::Ubx
            | FileKind::Rtcm3
            | FileKind::Sp3
            | FileKind::Antex
            | FileKind::Gzip
            | FileKind::UnixCompress
            | FileKind::Zip
    )
}

pub fn describe(mut reader: BufReader<File>) -> anyhow::Result<Description> {
    if sniff(reader.fill_buf()?) == FileKind::Antex {
        return describe_antennas(reader);
    }
    let hints = RtcmHints {
        not_after: written(reader.get_ref()),
        ..RtcmHints::default()
    };
    match read_gnss_near(&mut reader, Limits::default(), &hints) {
        Ok(file) => Ok(describe_file(&file)),
        // All but the times can be known.
        Err(error @ ReadError::NoDate) => {
            reader.rewind()?;
            let anywhere = RtcmHints {
                near: Some(GpsTime::EPOCH),
                ..RtcmHints::default()
            };
            let mut d = describe_file(&read_gnss_near(reader, Limits::default(), &anywhere)?);
            d.facts.remove("start_gpst");
            d.facts.remove("end_gpst");
            d.notes.insert(0, error.to_string());
            Ok(d)
        }
        Err(error) => Err(error.into()),
    }
}

fn describe_antennas(reader: impl BufRead) -> anyhow::Result<Description> {
    let (antex, report) = read_antex(&mut Lines::new(reader, Limits::default()))?;
    let mut d = Description::new("ANTEX antenna calibrations");
    d.fact("receiver_antennas", antex.antennas.len());
    add_notes(&mut d, &report);
    Ok(d)
}

fn describe_file(file: &GnssFile) -> Description {
    let mut d = Description::new(file.report.format.clone());
    if let Some(observations) = &file.observations {
        describe_observations(&mut d, observations);
    }
    if let Some(navigation) = &file.navigation {
        describe_navigation(&mut d, navigation);
    }
    add_notes(&mut d, &file.report);
    d
}

fn add_notes(d: &mut Description, report: &ReadReport) {
    d.notes.extend(report.remarks.iter().cloned());
    for dropped in &report.dropped {
        d.notes.push(format!(
            "{}: {}, first at {}",
            dropped.reason, dropped.count, dropped.first
        ));
    }
}

fn describe_observations(d: &mut Description, data: &ObservationData) {
    d.fact("epochs", data.epochs.len());
    if let (Some(first), Some(last)) = (data.epochs.first(), data.epochs.last()) {
        d.fact("start_gpst", first.time.to_string());
        d.fact("end_gpst", last.time.to_string());
    }
    let mut satellites: BTreeMap<String, usize> = BTreeMap::new();
    for epoch in &data.epochs {
        for satellite in &epoch.satellites {
            *satellites
                .entry(satellite.satellite.to_string())
                .or_default() += 1;
        }
    }
    d.fact("satellites", satellites.len());
    let list: Vec<String> = satellites.keys().cloned().collect();
    if !list.is_empty() {
        d.notes.push(format!("satellites: {}", list.join(" ")));
    }
    d.fact("events", data.events.len());
}

fn describe_navigation(d: &mut Description, navigation: &Navigation) {
    d.fact("ephemerides", navigation.ephemerides.len());
    let mut systems: BTreeMap<char, usize> = BTreeMap::new();
    for ephemeris in &navigation.ephemerides {
        *systems
            .entry(ephemeris.satellite().system().letter())
            .or_default() += 1;
    }
    for (letter, count) in systems {
        d.fact(&format!("ephemerides_{letter}"), count);
    }
    if let Some((from, to)) = navigation.precise.span() {
        d.fact(
            "precise_satellites",
            navigation.precise.satellites().count(),
        );
        d.fact("precise_start_gpst", from.to_string());
        d.fact("precise_end_gpst", to.to_string());
    }
    d.fact("ionosphere_model", navigation.klobuchar.is_some());
}
