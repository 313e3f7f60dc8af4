//! GNSS observations and navigation.

use std::collections::BTreeMap;
use std::io::Read;

use acerra_gnss::input::{FileKind, Limits, sniff};
use acerra_gnss::{Navigation, ObservationData, read_gnss};

use super::Description;

/// Whether the first bytes are those of a GNSS file.
pub fn is_gnss(head: &[u8]) -> bool {
    matches!(
        sniff(head),
        FileKind::RinexObservation
            | FileKind::RinexNavigation
            | FileKind::RinexOther
            | FileKind::Crinex
            | FileKind::Ubx
            | FileKind::Gzip
    )
}

pub fn describe(reader: impl Read) -> anyhow::Result<Description> {
    let file = read_gnss(reader, Limits::default())?;
    let mut d = Description::new(file.report.format.clone());
    if let Some(observations) = &file.observations {
        describe_observations(&mut d, observations);
    }
    if let Some(navigation) = &file.navigation {
        describe_navigation(&mut d, navigation);
    }
    d.notes.extend(file.report.remarks.iter().cloned());
    for dropped in &file.report.dropped {
        d.notes.push(format!(
            "{}: {}, first at {}",
            dropped.reason, dropped.count, dropped.first
        ));
    }
    Ok(d)
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
    d.fact("ionosphere_model", navigation.klobuchar.is_some());
}
