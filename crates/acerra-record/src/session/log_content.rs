//! A session's log read: the capture and the receiver's bytes written, clock data kept.

use std::fs::File;
use std::io::{self, BufReader, Write};
use std::path::Path;

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::{epoch_time, rising_edge};
use acerra_radar::mrm::{CONFIG_BYTES, RadarConfig};

use super::aside::AsideFile;
use super::capture::{ArrivalTimes, CaptureWriter};
use super::finish_error::FinishError;
use super::fix_source::FixSource;
use super::fix_spans::FixSpans;
use super::outcome::{CAPTURE_NAME, Finished, LOG_NAME, ROVER_NAME};
use super::settings::Session;
use crate::gnss::FrameFinder;
use crate::log::{LogReader, Record, RecordKind};
use crate::pps::PulseStamp;
use crate::timing::Pulse;

/// Content of the log other than the capture and the receiver's bytes, which are written while the log is read.
pub(super) struct LogContent {
    /// The settings that were recorded with last.
    pub session: Session,
    /// When scans came, one list a start of the recording.
    pub arrivals: Vec<ArrivalTimes>,
    /// GPS epochs, each with its start of the recording.
    pub gps: Vec<Epoch>,
    /// Rising edges on the receiver's time-mark input.
    pub marks: Vec<GpsTime>,
    /// Pulses per second, each with its start of the recording.
    pub pulses: Vec<(usize, Pulse)>,
}

/// An epoch of the receiver.
pub(super) struct Epoch {
    /// Start of the recording in which it arrived: each start has a separate host clock.
    pub start: usize,
    /// When it was.
    pub time: GpsTime,
    /// Host clock at its first byte (s).
    pub host_s: f64,
}

/// Reads the log, and writes the capture and the receiver's bytes as it goes.
///
/// # Errors
/// A log that cannot be read, files that cannot be written.
pub(super) fn read_log(
    directory: &Path,
    finished: &mut Finished,
) -> Result<LogContent, FinishError> {
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
    capture: CaptureWriter<AsideFile>,
    rover: AsideFile,
    frames: FrameFinder,
    gps: Vec<Epoch>,
    marks: Vec<GpsTime>,
    /// Start of the recording, number and host time (s) of each pulse.
    pulses: Vec<(usize, u32, f64)>,
    unread_pulses: u64,
    fix: (FixSource, FixSpans),
    arrivals: Vec<ArrivalTimes>,
}

impl<'a> Reading<'a> {
    fn new(directory: &'a Path) -> Result<Self, FinishError> {
        Ok(Self {
            directory,
            settings: String::new(),
            starts: 0,
            capture: CaptureWriter::new(AsideFile::create(directory, CAPTURE_NAME)?),
            rover: AsideFile::create(directory, ROVER_NAME)?,
            frames: FrameFinder::default(),
            gps: Vec::new(),
            marks: Vec::new(),
            pulses: Vec::new(),
            unread_pulses: 0,
            fix: Default::default(),
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
                self.fix.0 = FixSource::default();
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
                let (gps, marks) = (&mut self.gps, &mut self.marks);
                let (source, spans) = &mut self.fix;
                self.frames.take(&payload, host_s, |frame, host_s| {
                    if let Some(state) = source.take(frame, host_s) {
                        spans.take(&state, start, host_s);
                    }
                    gps.extend(epoch_time(frame).map(|time| Epoch {
                        start,
                        time,
                        host_s,
                    }));
                    marks.extend(rising_edge(frame).map(|edge| edge.time));
                });
            }
            RecordKind::Pulse => match PulseStamp::parse(&payload) {
                Ok(stamp) => {
                    let host_s = 1e-9 * at_ns as f64;
                    self.pulses.push((self.starts, stamp.sequence, host_s));
                }
                Err(_) => self.unread_pulses += 1,
            },
            RecordKind::End => finished.ended_in_order = true,
            RecordKind::Note | RecordKind::Other(_) => {}
        }
        Ok(())
    }

    fn end(mut self, session: Session, finished: &mut Finished) -> Result<LogContent, FinishError> {
        let radar = self.failed(CAPTURE_NAME);
        self.arrivals.push(self.capture.take_arrivals());
        let (capture, left_out) = self.capture.finish().map_err(radar)?;
        capture.publish()?;
        if left_out > 0 {
            finished.remarks.push(format!(
                "{left_out} messages came too late to be put in their place in {CAPTURE_NAME}"
            ));
        }
        self.rover.publish()?;
        if self.unread_pulses > 0 {
            finished.remarks.push(format!(
                "{} records of pulses in {LOG_NAME} hold no pulse",
                self.unread_pulses
            ));
        }
        let (_, spans) = &self.fix;
        let pulse = |&(start, sequence, host_s): &(usize, u32, f64)| {
            let pulse = Pulse {
                sequence,
                host_s,
                has_fix: spans.is_settled(start, host_s),
            };
            (start, pulse)
        };
        let pulses = self.pulses.iter().map(pulse).collect();
        Ok(LogContent {
            session,
            arrivals: self.arrivals,
            gps: self.gps,
            marks: self.marks,
            pulses,
        })
    }
}
