//! Choice of the log's sources that make the trajectory.

use std::borrow::Cow;

use crate::error::LogError;
use crate::format::LogFormat;
use crate::options::{GimbalChoice, LogOptions};
use crate::report::LogWarning;
use crate::sample::{AttitudeSource, GimbalSource, PositionSource, Recording, SourceKind};

/// Source of the positions: the named one, else the only receiver, else the only filter.
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
        ([first, ..], None) if options.takes_first_positions => Ok(first),
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

/// Remark where the first of several sources is used.
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

/// Source of the attitudes: the named one, else that of the positions, else the only one other than the named
/// gimbal; none without any.
pub fn attitudes<'a>(
    recording: &'a Recording,
    options: &LogOptions,
    positions: &str,
    warnings: &mut Vec<LogWarning>,
) -> Result<Option<&'a AttitudeSource>, LogError> {
    let sources = &recording.attitudes;
    let own: Vec<&AttitudeSource> = sources.iter().filter(|s| s.name == positions).collect();
    let is_vehicle = |s: &&AttitudeSource| options.gimbal.name() != Some(s.name.as_str());
    let others = || sources.iter().filter(is_vehicle);
    let lowest = others().map(|s| s.rank).min();
    let candidates: Vec<&AttitudeSource> = match own.as_slice() {
        [] => others().filter(|s| Some(s.rank) == lowest).collect(),
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

/// Gimbal that carries the antenna: the named one, else the only one; none where none is requested. In an
/// MCAP file it must be named: no message of ROS 2 states that its attitude is a gimbal's.
pub fn gimbal<'a>(
    recording: &'a Recording,
    options: &LogOptions,
    warnings: &mut Vec<LogWarning>,
) -> Result<Option<Cow<'a, GimbalSource>>, LogError> {
    let gimbals = &recording.gimbals;
    let usable = |s: &&GimbalSource| !s.samples.is_empty();
    let lowest = gimbals.iter().filter(usable).map(|s| s.rank).min();
    let candidates: Vec<&GimbalSource> = match &options.gimbal {
        GimbalChoice::None => return Ok(None),
        GimbalChoice::Named(name) => return named_gimbal(recording, name).map(Some),
        GimbalChoice::Only if recording.format == LogFormat::Mcap => Vec::new(),
        GimbalChoice::Only => gimbals
            .iter()
            .filter(|s| usable(s) && Some(s.rank) == lowest)
            .collect(),
    };
    match candidates.as_slice() {
        [] => Err(LogError::NoGimbal {
            format: recording.format,
            expected: expected_gimbal_records(recording),
        }),
        [one] => Ok(Some(Cow::Borrowed(*one))),
        [first, ..] => {
            let names = gimbal_names(recording);
            several("gimbals", "gimbal_source", names, options.takes_first).map(|warning| {
                warnings.push(warning);
                Some(Cow::Borrowed(*first))
            })
        }
    }
}

/// The gimbal of that name; in an MCAP file any topic of attitudes.
fn named_gimbal<'a>(
    recording: &'a Recording,
    wanted: &str,
) -> Result<Cow<'a, GimbalSource>, LogError> {
    let mut gimbals = recording.gimbals.iter().filter(|s| !s.samples.is_empty());
    if let Some(one) = gimbals.find(|s| s.name == wanted) {
        return Ok(Cow::Borrowed(one));
    }
    let mut topics = recording.attitudes.iter();
    let is_topic = recording.format == LogFormat::Mcap;
    match topics.find(|s| is_topic && s.name == wanted) {
        Some(topic) => Ok(Cow::Owned(topic.into())),
        None => Err(LogError::NoSuchSource {
            what: "gimbals",
            key: "gimbal_source",
            wanted: wanted.to_owned(),
            names: gimbal_names(recording),
        }),
    }
}

/// Possible names of a gimbal of this log: in an MCAP file every topic of attitudes.
fn gimbal_names(recording: &Recording) -> Vec<String> {
    let usable = recording.gimbals.iter().filter(|s| !s.samples.is_empty());
    let gimbals = usable.map(|s| s.name.clone());
    let topics = recording.attitudes.iter().map(|s| s.name.clone());
    let is_topic = recording.format == LogFormat::Mcap;
    gimbals.chain(topics.filter(|_| is_topic)).collect()
}

fn expected_gimbal_records(recording: &Recording) -> String {
    match recording.format {
        LogFormat::ArduPilot => "records MNT with the actual roll, pitch and yaw".to_owned(),
        LogFormat::Px4 => "messages gimbal_device_attitude_status".to_owned(),
        LogFormat::Mavlink => {
            "messages GIMBAL_DEVICE_ATTITUDE_STATUS or MOUNT_ORIENTATION".to_owned()
        }
        LogFormat::Mcap => {
            let topics = gimbal_names(recording).join(", ");
            format!("[trajectory] gimbal_source to name a topic of attitudes; it has {topics}")
        }
    }
}
