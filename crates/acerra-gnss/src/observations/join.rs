//! Joining the files of one receiver, such as the hourly files of a reference station.

use std::fmt;

use acerra_geo::time::GpsTime;

use super::observation::{EPOCH_TOLERANCE_S, ObservationData, ObservationEpoch};

/// Pauses longer than this many usual intervals count as gaps.
const GAP_INTERVALS: f64 = 1.5;
/// Largest distance (m) of approximate positions of one place.
const SAME_PLACE_M: f64 = 10.0;
/// Largest difference of pseudoranges of one receiver at one time tag between files, by rounding (m).
const SAME_RANGE_M: f64 = 0.01;

/// One file of a receiver.
#[derive(Debug, Clone, PartialEq)]
pub struct LogPart {
    /// Name in messages.
    pub name: String,
    /// Content of the file.
    pub data: ObservationData,
}

/// Remarks on joining the files, in order of time.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum JoinRemark {
    /// Two files cover the same time: for an epoch in both, the earlier file's epoch is kept.
    Overlap {
        /// The two files.
        files: [String; 2],
        /// First and last epoch in both.
        span: (GpsTime, GpsTime),
        /// Epochs in both.
        epochs: usize,
        /// Epochs whose pseudoranges differ between the files by more than rounding: two receivers.
        contradicting: usize,
    },
    /// No epochs between one file and the next for longer than the usual interval.
    Gap {
        /// The two files.
        files: [String; 2],
        /// Last epoch before and first one after.
        span: (GpsTime, GpsTime),
    },
    /// The headers give different markers.
    Marker {
        /// The two files.
        files: [String; 2],
        /// The markers.
        markers: [String; 2],
    },
    /// The headers give different antennas.
    Antenna {
        /// The two files.
        files: [String; 2],
        /// The antennas.
        antennas: [String; 2],
    },
    /// The headers give places far apart.
    Place {
        /// The two files.
        files: [String; 2],
        /// Distance (m).
        distance_m: f64,
    },
    /// A file without any epoch.
    Empty {
        /// The file.
        file: String,
    },
}

impl fmt::Display for JoinRemark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overlap {
                files: [a, b],
                span: (from, to),
                epochs,
                contradicting: 0,
            } => write!(f, "{a} and {b} both hold {epochs} epochs, {from} to {to}"),
            Self::Overlap {
                files: [a, b],
                span: (from, to),
                epochs,
                contradicting,
            } => write!(
                f,
                "{a} and {b} both hold {epochs} epochs, {from} to {to}, and contradict each \
                 other at {contradicting} of them: two receivers?"
            ),
            Self::Gap {
                files: [a, b],
                span: (from, to),
            } => write!(
                f,
                "no epochs for {:.1} s between {a} and {b}, {from} to {to}",
                to.seconds_since(*from)
            ),
            Self::Marker {
                files: [a, b],
                markers: [x, y],
            } => write!(f, "{a} is of marker {x:?}, {b} of {y:?}: two stations?"),
            Self::Antenna {
                files: [a, b],
                antennas: [x, y],
            } => write!(
                f,
                "{a} has antenna {x:?}, {b} has {y:?}: that of {a} is used"
            ),
            Self::Place {
                files: [a, b],
                distance_m,
            } => write!(
                f,
                "the headers of {a} and {b} give places {distance_m:.1} m apart: two stations?"
            ),
            Self::Empty { file } => write!(f, "{file} holds no epochs"),
        }
    }
}

/// Joins the files of one receiver into one log, in order of time for any order of the files.
///
/// The station is taken from the earliest file; blank fields are filled from later files. An epoch in two
/// files is taken from the earlier file, with the satellites that only the later file has.
///
/// ```
/// use acerra_gnss::{LogPart, ObservationData, join_logs};
/// let part = |name: &str| LogPart { name: name.to_owned(), data: ObservationData::default() };
/// let (log, remarks) = join_logs(vec![part("hour00.rnx"), part("hour01.rnx")]);
/// assert!(log.epochs.is_empty());
/// assert_eq!(remarks[0].to_string(), "hour00.rnx holds no epochs");
/// ```
pub fn join_logs(parts: Vec<LogPart>) -> (ObservationData, Vec<JoinRemark>) {
    let mut remarks = Vec::new();
    if parts.len() == 1 {
        return (
            parts.into_iter().next().map(|p| p.data).unwrap_or_default(),
            remarks,
        );
    }
    let (mut parts, empty): (Vec<LogPart>, Vec<LogPart>) =
        parts.into_iter().partition(|p| !p.data.epochs.is_empty());
    remarks.extend(
        empty
            .into_iter()
            .map(|p| JoinRemark::Empty { file: p.name }),
    );
    parts.sort_by_key(|p| p.data.epochs.first().map(|e| e.time));
    let mut parts = parts.into_iter();
    let Some(mut joined) = parts.next() else {
        return (ObservationData::default(), remarks);
    };
    for part in parts {
        remarks.extend(station_remarks(&joined, &part));
        joined = append(joined, part, &mut remarks);
    }
    (joined.data, remarks)
}

/// Fields in which the headers of two files disagree.
fn station_remarks(first: &LogPart, later: &LogPart) -> Vec<JoinRemark> {
    let files = || [first.name.clone(), later.name.clone()];
    let (a, b) = (&first.data.station, &later.data.station);
    let differ = |x: &str, y: &str| !x.is_empty() && !y.is_empty() && x != y;
    let mut out = Vec::new();
    if differ(&a.marker, &b.marker) {
        out.push(JoinRemark::Marker {
            files: files(),
            markers: [a.marker.clone(), b.marker.clone()],
        });
    }
    if differ(&a.antenna, &b.antenna) {
        out.push(JoinRemark::Antenna {
            files: files(),
            antennas: [a.antenna.clone(), b.antenna.clone()],
        });
    }
    if let (Some(x), Some(y)) = (a.position_ecef_m, b.position_ecef_m) {
        let distance_m = (0..3).map(|k| (x[k] - y[k]).powi(2)).sum::<f64>().sqrt();
        if distance_m > SAME_PLACE_M {
            out.push(JoinRemark::Place {
                files: files(),
                distance_m,
            });
        }
    }
    out
}

/// Appends a file to those already joined; the result has the name of the later file, for remarks on the
/// next.
fn append(mut joined: LogPart, later: LogPart, remarks: &mut Vec<JoinRemark>) -> LogPart {
    let files = [joined.name, later.name.clone()];
    let usual_s = usual_interval_s(&joined.data.epochs);
    let data = &mut joined.data;
    let (station, other) = (&mut data.station, later.data.station);
    for (own, others) in [
        (&mut station.marker, other.marker),
        (&mut station.receiver, other.receiver),
        (&mut station.antenna, other.antenna),
    ] {
        if own.is_empty() {
            *own = others;
        }
    }
    station.position_ecef_m = station.position_ecef_m.or(other.position_ecef_m);
    for (number, channel) in later.data.glonass_channels {
        data.glonass_channels.entry(number).or_insert(channel);
    }
    let mut shared = Shared::default();
    let mut gap = None;
    for epoch in later.data.epochs {
        let at = data
            .epochs
            .partition_point(|e| e.time.seconds_since(epoch.time) < -EPOCH_TOLERANCE_S);
        match data.epochs.get_mut(at) {
            Some(own) if own.time.seconds_since(epoch.time) < EPOCH_TOLERANCE_S => {
                shared.take(own, epoch);
            }
            Some(_) => data.epochs.insert(at, epoch),
            None => {
                if let Some(last) = data.epochs.last()
                    && gap.is_none()
                {
                    gap = Some((last.time, epoch.time));
                }
                data.epochs.push(epoch);
            }
        }
    }
    if let Some(span) = shared.span {
        remarks.push(JoinRemark::Overlap {
            files: files.clone(),
            span,
            epochs: shared.epochs,
            contradicting: shared.contradicting,
        });
    }
    if let (Some(span), Some(usual_s)) = (gap, usual_s)
        && span.1.seconds_since(span.0) > GAP_INTERVALS * usual_s
    {
        remarks.push(JoinRemark::Gap { files, span });
    }
    for event in later.data.events {
        if !data.events.contains(&event) {
            data.events.push(event);
        }
    }
    data.events.sort_by_key(|e| e.time);
    joined.name = later.name;
    joined
}

/// The epochs that two files share.
#[derive(Default)]
struct Shared {
    span: Option<(GpsTime, GpsTime)>,
    epochs: usize,
    contradicting: usize,
}

impl Shared {
    /// Compares an epoch with the epoch kept, and adds the satellites that the latter lacks.
    fn take(&mut self, own: &mut ObservationEpoch, other: ObservationEpoch) {
        let (from, to) = self.span.unwrap_or((own.time, own.time));
        self.span = Some((from.min(own.time), to.max(own.time)));
        self.epochs += 1;
        let mut differs = false;
        for satellite in other.satellites {
            let place = own
                .satellites
                .binary_search_by_key(&satellite.satellite, |s| s.satellite);
            match place {
                Ok(at) => {
                    let ranges = (
                        own.satellites[at].first_pseudorange_m(),
                        satellite.first_pseudorange_m(),
                    );
                    differs |= matches!(ranges, (Some(a), Some(b)) if (a - b).abs() > SAME_RANGE_M);
                }
                Err(at) => own.satellites.insert(at, satellite),
            }
        }
        self.contradicting += usize::from(differs);
    }
}

/// The median interval of a log (s).
fn usual_interval_s(epochs: &[ObservationEpoch]) -> Option<f64> {
    let mut steps: Vec<f64> = epochs
        .windows(2)
        .map(|pair| pair[1].time.seconds_since(pair[0].time))
        .collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observations::observation::{SatelliteObservation, SignalObservation};
    use crate::observations::signal::SignalCode;

    fn epoch(time_s: f64, satellites: &[(&str, f64)]) -> ObservationEpoch {
        let observed = |&(name, range_m): &(&str, f64)| {
            let mut s = SatelliteObservation::new(name.parse().unwrap());
            s.signals[0] = Some(SignalObservation {
                pseudorange_m: Some(range_m),
                ..SignalObservation::empty(SignalCode::new(1, 'C'))
            });
            s
        };
        ObservationEpoch {
            time: GpsTime::from_week_tow(2000, time_s),
            satellites: satellites.iter().map(observed).collect(),
        }
    }

    fn part(name: &str, times: &[f64], satellites: &[(&str, f64)]) -> LogPart {
        LogPart {
            name: name.to_owned(),
            data: ObservationData {
                epochs: times.iter().map(|&t| epoch(t, satellites)).collect(),
                ..ObservationData::default()
            },
        }
    }

    fn times(log: &ObservationData) -> Vec<f64> {
        log.epochs.iter().map(|e| e.time.tow_s()).collect()
    }

    #[test]
    fn hours_in_any_order_become_one_log() {
        let g = [("G01", 2e7)];
        let parts = vec![
            part("b", &[3.0, 4.0, 5.0], &g),
            part("a", &[0.0, 1.0, 2.0], &g),
            part("c", &[9.0, 10.0], &g),
            part("d", &[], &g),
        ];
        let (log, remarks) = join_logs(parts);
        assert_eq!(times(&log), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 9.0, 10.0]);
        let said: Vec<String> = remarks.iter().map(ToString::to_string).collect();
        assert_eq!(said.len(), 2, "{said:?}");
        assert_eq!(said[0], "d holds no epochs");
        assert!(
            said[1].starts_with("no epochs for 4.0 s between b and c"),
            "{said:?}"
        );
    }

    #[test]
    fn overlaps_are_taken_once_and_contradictions_are_named() {
        let a = part("a", &[0.0, 1.0, 2.0], &[("G01", 2e7), ("G03", 2.1e7)]);
        let b = part("b", &[1.0, 2.0, 3.0], &[("G01", 2e7), ("G02", 2.2e7)]);
        let other = part("other", &[2.0, 3.0], &[("G01", 2e7 + 5.0)]);
        let (log, remarks) = join_logs(vec![a.clone(), b]);
        assert_eq!(times(&log), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(log.epochs[1].satellites.len(), 3);
        assert!(matches!(
            &remarks[..],
            [JoinRemark::Overlap {
                epochs: 2,
                contradicting: 0,
                ..
            }]
        ));
        let (log, remarks) = join_logs(vec![a, other]);
        assert_eq!(log.epochs[2].satellites[0].first_pseudorange_m(), Some(2e7));
        assert!(matches!(
            &remarks[..],
            [JoinRemark::Overlap {
                epochs: 1,
                contradicting: 1,
                ..
            }]
        ));
    }

    #[test]
    fn two_stations_are_not_taken_for_one_in_silence() {
        let g = [("G01", 2e7)];
        let mut a = part("a", &[0.0, 1.0], &g);
        let mut b = part("b", &[2.0, 3.0], &g);
        a.data.station.marker = "WTZR".to_owned();
        b.data.station.marker = "WTZZ".to_owned();
        b.data.station.antenna = "LEIAR25.R3".to_owned();
        a.data.station.position_ecef_m = Some([4_075_580.0, 931_854.0, 4_801_568.0]);
        b.data.station.position_ecef_m = Some([4_075_680.0, 931_854.0, 4_801_568.0]);
        let (log, remarks) = join_logs(vec![b, a]);
        assert_eq!(log.station.marker, "WTZR");
        assert_eq!(log.station.antenna, "LEIAR25.R3");
        let said: Vec<String> = remarks.iter().map(ToString::to_string).collect();
        assert!(said.iter().any(|s| s.contains("two stations")), "{said:?}");
        assert!(said.iter().any(|s| s.contains("100.0 m apart")), "{said:?}");
    }
}
