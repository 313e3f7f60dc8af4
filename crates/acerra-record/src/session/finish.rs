//! From a session's log to what `focus` takes: a capture, the receiver's bytes, the clock, a campaign.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use acerra_gnss::ubx::epoch_time;
use acerra_radar::mrm::{CONFIG_BYTES, RadarConfig, read_mrm};
use acerra_radar::{Limits, RadargramOptions};
use thiserror::Error;

use super::campaign::campaign_text;
use super::capture::{ArrivalTimes, CaptureWriter};
use super::outcome::{CAMPAIGN_NAME, CAPTURE_NAME, CLOCK_NAME, Finished, LOG_NAME, ROVER_NAME};
use super::plausibility::shortest_interval_s;
use super::settings::{Session, SettingsError};
use crate::gnss::FrameFinder;
use crate::log::{LogReadError, LogReader, Record, RecordKind};
use crate::timing::{Latency, Pair, Stamps, logged_clock};

/// Why a session cannot be finished.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FinishError {
    /// A file of the directory.
    #[error("{}: {cause}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// The log.
    #[error("{}: {cause}", path.display())]
    Log {
        /// The file.
        path: PathBuf,
        /// Why it cannot be read.
        cause: LogReadError,
    },
    /// The log holds no session, or one that cannot be.
    #[error("{}: the settings in the log: {cause}", path.display())]
    Settings {
        /// The log.
        path: PathBuf,
        /// What is wrong.
        cause: SettingsError,
    },
}

/// Writes `radar.mrm`, `rover.ubx`, `radar.clock.json` and `campaign.toml` out of the log in a session's
/// directory, whether the recording ended in order or not. They are written anew each time.
///
/// # Errors
/// A log that cannot be read, files that cannot be written.
pub fn finish(directory: &Path) -> Result<Finished, FinishError> {
    let mut finished = Finished::default();
    remove_clock(directory)?;
    let log = read_log(directory, &mut finished)?;
    let scans = describe_scans(directory, &log, &mut finished)?;
    if let (Some(scans), false) = (scans, log.gps.is_empty()) {
        write_clock(directory, &log, scans, &mut finished)?;
    } else if log.session.gnss.is_some() {
        let remark = "no GPS epoch in the log: trace times are those of the radio alone";
        finished.remarks.push(remark.to_owned());
    }
    let text = campaign_text(&log.session, &finished);
    write_file(directory, CAMPAIGN_NAME, text.as_bytes())?;
    Ok(finished)
}

/// Removes the clock of an earlier call: a log that tells none is not to be read with another's.
fn remove_clock(directory: &Path) -> Result<(), FinishError> {
    let path = directory.join(CLOCK_NAME);
    match std::fs::remove_file(&path) {
        Err(cause) if cause.kind() != io::ErrorKind::NotFound => {
            Err(FinishError::Io { path, cause })
        }
        _ => Ok(()),
    }
}

/// What the log holds beside the capture and the receiver's bytes, which are written as it is read.
struct LogContent {
    session: Session,
    arrivals: Vec<ArrivalTimes>,
    /// GPS epochs with host time (s), one list a start of the recording: each has its own host clock.
    gps: Vec<(usize, acerra_geo::time::GpsTime, f64)>,
}

fn read_log(directory: &Path, finished: &mut Finished) -> Result<LogContent, FinishError> {
    let path = directory.join(LOG_NAME);
    let io_error = |cause| FinishError::Io {
        path: path.clone(),
        cause,
    };
    let log_error = |cause| FinishError::Log {
        path: path.clone(),
        cause,
    };
    let file = File::open(&path).map_err(io_error)?;
    let mut reader = LogReader::new(BufReader::new(file)).map_err(log_error)?;
    let mut reading = Reading::new(directory)?;
    while let Some(record) = reader.next_record().map_err(io_error)? {
        reading.take(record, finished)?;
    }
    finished.damage = reader.damage();
    let text = std::mem::take(&mut reading.settings);
    let session = Session::parse(&text).map_err(|cause| FinishError::Settings {
        path: path.clone(),
        cause,
    })?;
    reading.end(session, finished)
}

/// The outputs that a log is read into.
struct Reading<'a> {
    directory: &'a Path,
    settings: String,
    /// Starts of the recording before the present one.
    starts: usize,
    capture: CaptureWriter<BufWriter<File>>,
    rover: BufWriter<File>,
    frames: FrameFinder,
    gps: Vec<(usize, acerra_geo::time::GpsTime, f64)>,
    arrivals: Vec<ArrivalTimes>,
}

impl<'a> Reading<'a> {
    fn new(directory: &'a Path) -> Result<Self, FinishError> {
        let create = |name: &str| {
            let path = directory.join(name);
            match File::create(&path) {
                Ok(file) => Ok(BufWriter::new(file)),
                Err(cause) => Err(FinishError::Io { path, cause }),
            }
        };
        Ok(Self {
            directory,
            settings: String::new(),
            starts: 0,
            capture: CaptureWriter::new(create(CAPTURE_NAME)?),
            rover: create(ROVER_NAME)?,
            frames: FrameFinder::default(),
            gps: Vec::new(),
            arrivals: Vec::new(),
        })
    }

    fn failed(&self, name: &str) -> impl FnOnce(io::Error) -> FinishError + use<> {
        let path = self.directory.join(name);
        move |cause| FinishError::Io { path, cause }
    }

    fn take(&mut self, record: Record, finished: &mut Finished) -> Result<(), FinishError> {
        let Record {
            kind,
            at_ns,
            payload,
        } = record;
        let (radar, rover) = (self.failed(CAPTURE_NAME), self.failed(ROVER_NAME));
        match kind {
            RecordKind::Settings => {
                self.settings = String::from_utf8_lossy(&payload).into_owned();
                self.arrivals.push(self.capture.take_arrivals());
                self.starts += 1;
                finished.ended_in_order = false;
            }
            RecordKind::Radio => self.capture.message(&payload, at_ns).map_err(radar)?,
            RecordKind::RadioConfig => {
                if let Some(bytes) = payload.first_chunk::<CONFIG_BYTES>() {
                    let config = RadarConfig::from_bytes(bytes);
                    self.capture.config(config).map_err(radar)?;
                }
            }
            RecordKind::Gnss => {
                self.rover.write_all(&payload).map_err(rover)?;
                finished.gnss_bytes += payload.len() as u64;
                let start = self.starts;
                let host_s = 1e-9 * at_ns as f64;
                let gps = &mut self.gps;
                self.frames.take(&payload, host_s, |frame, host_s| {
                    gps.extend(epoch_time(frame).map(|time| (start, time, host_s)));
                });
            }
            RecordKind::End => finished.ended_in_order = true,
            RecordKind::Note | RecordKind::Other(_) => {}
        }
        Ok(())
    }

    fn end(mut self, session: Session, finished: &mut Finished) -> Result<LogContent, FinishError> {
        let (radar, rover) = (self.failed(CAPTURE_NAME), self.failed(ROVER_NAME));
        self.arrivals.push(self.capture.take_arrivals());
        let left_out = self.capture.finish().map_err(radar)?;
        if left_out > 0 {
            finished.remarks.push(format!(
                "{left_out} messages came too late to be put in their place in {CAPTURE_NAME}"
            ));
        }
        self.rover.flush().map_err(rover)?;
        Ok(LogContent {
            session,
            arrivals: self.arrivals,
            gps: self.gps,
        })
    }
}

/// Number and stamp of each trace of the run that is imaged, with its radar time (s).
type RunTimes = Vec<((u16, u32), f64)>;

fn describe_scans(
    directory: &Path,
    log: &LogContent,
    finished: &mut Finished,
) -> Result<Option<RunTimes>, FinishError> {
    let path = directory.join(CAPTURE_NAME);
    let file = File::open(&path).map_err(|cause| FinishError::Io { path, cause })?;
    let capture = match read_mrm(BufReader::new(file), &Limits::default()) {
        Ok(capture) => capture,
        Err(error) => {
            let remark = format!("{CAPTURE_NAME}: {error}");
            finished.remarks.push(remark);
            return Ok(None);
        }
    };
    finished.scans = capture.report.whole_scans;
    finished.incomplete_scans = capture.report.incomplete_scans;
    let made = match capture.radargram(&RadargramOptions::default()) {
        Ok(made) => made,
        Err(error) => {
            finished.remarks.push(format!("{CAPTURE_NAME}: {error}"));
            return Ok(None);
        }
    };
    if made.other_scans > 0 {
        finished.remarks.push(format!(
            "{} of {} scans are of other runs (before or after a restart of the radio) and are not imaged",
            made.other_scans, finished.scans
        ));
    }
    if log.arrivals.len() > 2 {
        finished
            .remarks
            .push("the recording was interrupted and gone on with".to_owned());
    }
    let keys = made.run.scans.iter().map(|&index| {
        let scan = &capture.scans[index];
        (scan.message_id, scan.timestamp_ms)
    });
    Ok(Some(keys.zip(made.radargram.time_s).collect()))
}

fn write_clock(
    directory: &Path,
    log: &LogContent,
    scans: RunTimes,
    finished: &mut Finished,
) -> Result<(), FinishError> {
    let Some((first, _)) = scans.first().copied() else {
        return Ok(());
    };
    // Each start of the recording has a host clock of its own: the one that most traces came in.
    let pairs_of = |arrivals: &ArrivalTimes| -> Vec<Pair> {
        let pair = |(key, radar_s): &((u16, u32), f64)| {
            let at_ns = arrivals.get(key)?;
            Some(Pair {
                sent_s: *radar_s,
                arrived_s: 1e-9 * *at_ns as f64,
            })
        };
        scans.iter().filter_map(pair).collect()
    };
    let starts = log.arrivals.iter().map(pairs_of).enumerate();
    let Some((start, radio)) = starts.max_by_key(|(_, pairs)| pairs.len()) else {
        return Ok(());
    };
    let of_start = log.gps.iter().filter(|(of, ..)| *of == start);
    let stamps = Stamps {
        radio,
        gps: of_start.map(|(_, time, host_s)| (*time, *host_s)).collect(),
        first,
        latency: latencies(&log.session),
    };
    match logged_clock(&stamps) {
        Ok(clock) => {
            write_file(directory, CLOCK_NAME, clock.to_json().as_bytes())?;
            finished.clock = Some(clock);
        }
        Err(error) => finished
            .remarks
            .push(format!("trace times are not on GPS time: {error}")),
    }
    Ok(())
}

/// What all messages of the radio and all epochs of the receiver have in common, as the session states
/// it or as the scan's duration implies.
fn latencies(session: &Session) -> [Latency; 2] {
    let duration_s = shortest_interval_s(&session.radio);
    let radio = Latency {
        delay_s: session
            .radio
            .latency_ms
            .map_or(0.5 * duration_s, |ms| 1e-3 * ms),
        // Anywhere within the scan is all that is known.
        sigma_s: match (session.radio.latency_ms, session.radio.latency_sigma_ms) {
            (_, Some(ms)) => 1e-3 * ms,
            (Some(_), None) => 0.0,
            (None, None) => duration_s / 12.0_f64.sqrt(),
        },
    };
    let gnss = session
        .gnss
        .as_ref()
        .map_or(Latency::default(), |gnss| Latency {
            delay_s: 1e-3 * gnss.latency_ms,
            sigma_s: 1e-3 * gnss.latency_sigma_ms,
        });
    [radio, gnss]
}

/// Writes a file beside its place and renames it, so that it is whole or absent.
fn write_file(directory: &Path, name: &str, bytes: &[u8]) -> Result<(), FinishError> {
    let (path, aside) = (
        directory.join(name),
        directory.join(format!(".{name}.part")),
    );
    let done = std::fs::write(&aside, bytes).and_then(|()| std::fs::rename(&aside, &path));
    done.map_err(|cause| FinishError::Io { path, cause })
}
