//! Which of a log's sources make the trajectory.

use crate::error::LogError;
use crate::options::LogOptions;
use crate::report::LogWarning;
use crate::sample::{AttitudeSource, PositionSource, Recording, SourceKind};

/// What the positions come from: the source named, else the only receiver, else the only filter.
///
/// The receiver goes first: its positions carry GPS time and the status and accuracy of their
/// solution, and with carrier phase they are good to centimetres. The filter's are smoothed by inertial
/// sensors and barometer, stamped by the autopilot's clock, and state no accuracy that holds for them.
pub fn positions<'a>(
    recording: &'a Recording,
    options: &LogOptions,
    warnings: &mut Vec<LogWarning>,
) -> Result<&'a PositionSource, LogError> {
    let sources = &recording.positions;
    let of_kind = |kind| -> Vec<&PositionSource> {
        let usable = |s: &&PositionSource| s.kind == kind && !s.samples.is_empty();
        let lowest = sources.iter().filter(usable).map(|s| s.rank).min();
        let is_first = |s: &&PositionSource| usable(s) && Some(s.rank) == lowest;
        sources.iter().filter(is_first).collect()
    };
    let candidates = match options.source.as_deref() {
        None => match of_kind(SourceKind::Gnss) {
            none if none.is_empty() => of_kind(SourceKind::Filter),
            some => some,
        },
        Some("gnss") => of_kind(SourceKind::Gnss),
        Some("ekf") => of_kind(SourceKind::Filter),
        Some(name) => {
            let named = |s: &&PositionSource| s.name == name && !s.samples.is_empty();
            sources.iter().filter(named).collect()
        }
    };
    match (candidates.as_slice(), options.source.as_deref()) {
        ([one], _) => Ok(one),
        ([], Some(wanted)) => Err(LogError::NoSuchSource {
            what: "positions",
            key: "source",
            wanted: wanted.to_owned(),
            names: described(sources),
        }),
        ([], None) => Err(LogError::NoPositions {
            format: recording.format,
            why: why_none(sources),
        }),
        ([first, ..], _) => {
            let names = candidates.iter().map(|s| s.name.clone()).collect();
            several("positions", "source", names, options.takes_first).map(|warning| {
                warnings.push(warning);
                *first
            })
        }
    }
}

/// What there is to say where the first of several sources is taken.
fn several(
    what: &'static str,
    key: &'static str,
    names: Vec<String>,
    takes_first: bool,
) -> Result<LogWarning, LogError> {
    if takes_first {
        Ok(LogWarning::FirstOfSeveral { what, key, names })
    } else {
        Err(LogError::SeveralSources { what, key, names })
    }
}

fn why_none(sources: &[PositionSource]) -> String {
    if sources.is_empty() {
        return String::new();
    }
    format!(": it has {}", described(sources).join(", "))
}

fn described(sources: &[PositionSource]) -> Vec<String> {
    let one = |s: &PositionSource| match s.samples.len() {
        0 => format!("{} ({} records without a fix)", s.name, s.without_position),
        count => format!("{} ({count} positions)", s.name),
    };
    sources.iter().map(one).collect()
}

/// What the attitudes come from: the source named, else that of the positions, else the only one; none
/// where there is none.
pub fn attitudes<'a>(
    recording: &'a Recording,
    options: &LogOptions,
    positions: &str,
    warnings: &mut Vec<LogWarning>,
) -> Result<Option<&'a AttitudeSource>, LogError> {
    let sources = &recording.attitudes;
    let own: Vec<&AttitudeSource> = sources.iter().filter(|s| s.name == positions).collect();
    let lowest = sources.iter().map(|s| s.rank).min();
    let candidates: Vec<&AttitudeSource> = match own.as_slice() {
        [] => sources.iter().filter(|s| Some(s.rank) == lowest).collect(),
        _ => own,
    };
    let names = || sources.iter().map(|s| s.name.clone()).collect();
    match (options.attitude_source.as_deref(), candidates.as_slice()) {
        (Some(wanted), _) => match sources.iter().find(|s| s.name == wanted) {
            Some(one) => Ok(Some(one)),
            None => Err(LogError::NoSuchSource {
                what: "attitudes",
                key: "attitude_source",
                wanted: wanted.to_owned(),
                names: names(),
            }),
        },
        (None, []) => Ok(None),
        (None, [one]) => Ok(Some(one)),
        (None, [first, ..]) => {
            several("attitudes", "attitude_source", names(), options.takes_first).map(|warning| {
                warnings.push(warning);
                Some(*first)
            })
        }
    }
}
