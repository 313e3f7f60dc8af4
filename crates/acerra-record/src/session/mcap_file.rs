//! A session's log as one MCAP file.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

use acerra_gnss::ubx::epoch_time;

use super::aside::AsideFile;
use super::finish_error::FinishError;
use super::outcome::{CLOCK_NAME, LOG_NAME, MCAP_NAME};
use crate::driver::Intake;
use crate::gnss::FrameFinder;
use crate::log::{LogReader, Record, RecordKind};
use crate::mcap::{
    McapWriter, acerra_topics, epoch, pulse, scan, topic, wrapped_bytes, wrapped_text,
};
use crate::pps::PulseStamp;

/// Writes `session.mcap` out of the log in a session's directory; an older one is replaced once the new one is
/// whole. Returns its messages.
///
/// Messages are logged at the host's clock counted from the start of the recording as the settings state it, or
/// from 1970 where they do not.
///
/// # Errors
/// A log that cannot be read, a file that cannot be written.
pub fn write_mcap(directory: &Path) -> Result<u64, FinishError> {
    let (log, path) = (directory.join(LOG_NAME), directory.join(MCAP_NAME));
    let log_io = |cause| FinishError::Io {
        path: log.clone(),
        cause,
    };
    let out_io = |cause| FinishError::Io {
        path: path.clone(),
        cause,
    };
    let file = File::open(&log).map_err(log_io)?;
    let mut reader = LogReader::new(BufReader::new(file)).map_err(|cause| FinishError::Log {
        path: log.clone(),
        cause,
    })?;
    let out = AsideFile::create(directory, MCAP_NAME)?;
    let mut copying = Copying::new(out).map_err(out_io)?;
    while let Some(record) = reader.next_record().map_err(log_io)? {
        copying.take(&record).map_err(out_io)?;
    }
    // A recording without a clock has no clock file.
    if let Ok(text) = std::fs::read_to_string(directory.join(CLOCK_NAME)) {
        let at_ns = copying.latest_ns;
        copying
            .put(topic::CLOCK_FIT, at_ns, &wrapped_text(at_ns, &text))
            .map_err(out_io)?;
    }
    let messages = copying.messages;
    copying.out.finish().map_err(out_io)?.publish()?;
    Ok(messages)
}

/// Records to be written as messages.
struct Copying<W: io::Write> {
    out: McapWriter<W>,
    intake: Intake,
    frames: FrameFinder,
    /// Nanoseconds since 1970 at the beginning of the host's clock.
    began_ns: u64,
    latest_ns: u64,
    messages: u64,
}

impl<W: io::Write> Copying<W> {
    fn new(out: W) -> io::Result<Self> {
        let library = concat!("acerra ", env!("CARGO_PKG_VERSION"));
        Ok(Self {
            out: McapWriter::new(out, library, &acerra_topics())?,
            intake: Intake::default(),
            frames: FrameFinder::default(),
            began_ns: 0,
            latest_ns: 0,
            messages: 0,
        })
    }

    fn put(&mut self, topic: usize, at_ns: u64, content: &[u8]) -> io::Result<()> {
        self.messages += 1;
        self.out
            .message(topic, self.began_ns.saturating_add(at_ns), content)
    }

    fn take(&mut self, record: &Record) -> io::Result<()> {
        let Record {
            kind,
            at_ns,
            payload,
        } = record;
        let at_ns = *at_ns;
        self.latest_ns = at_ns;
        let text = || wrapped_text(at_ns, &String::from_utf8_lossy(payload));
        match kind {
            RecordKind::Settings => {
                self.began_ns = began_ns(payload);
                self.put(topic::SETTINGS, at_ns, &text())
            }
            RecordKind::Radio => {
                self.put(topic::MESSAGE, at_ns, &wrapped_bytes(at_ns, payload))?;
                self.intake.take(payload);
                while let Some(whole) = self.intake.next_scan() {
                    self.put(topic::WHOLE_SCAN, at_ns, &scan(at_ns, &whole))?;
                }
                Ok(())
            }
            RecordKind::RadioConfig => {
                self.put(topic::CONFIGURATION, at_ns, &wrapped_bytes(at_ns, payload))
            }
            RecordKind::Gnss => self.gnss(at_ns, payload),
            RecordKind::Note => self.put(topic::NOTE, at_ns, &text()),
            RecordKind::End => self.put(topic::END, at_ns, &text()),
            RecordKind::Pulse => self.pulse(at_ns, payload),
            RecordKind::Other(_) => Ok(()),
        }
    }

    /// A pulse; text that is no stamp is left out, as by `finish`.
    fn pulse(&mut self, at_ns: u64, payload: &[u8]) -> io::Result<()> {
        match PulseStamp::parse(payload) {
            Ok(stamp) => self.put(topic::CLOCK_PULSE, at_ns, &pulse(at_ns, stamp)),
            Err(_) => Ok(()),
        }
    }

    fn gnss(&mut self, at_ns: u64, payload: &[u8]) -> io::Result<()> {
        self.put(topic::GNSS, at_ns, &wrapped_bytes(at_ns, payload))?;
        let mut epochs = Vec::new();
        self.frames
            .take(payload, 1e-9 * at_ns as f64, |frame, host_s| {
                epochs.extend(epoch_time(frame).map(|time| (time, (1e9 * host_s).round() as u64)));
            });
        for (time, host_ns) in epochs {
            self.put(topic::CLOCK_EPOCH, host_ns, &epoch(host_ns, time))?;
        }
        Ok(())
    }
}

/// The start that a session's text states in its first line, `# begun at 1571133000.123 s since 1970`.
fn began_ns(settings: &[u8]) -> u64 {
    let line = settings
        .split(|&byte| byte == b'\n')
        .next()
        .unwrap_or_default();
    let text = String::from_utf8_lossy(line);
    let seconds = text
        .strip_prefix("# begun at ")
        .and_then(|rest| rest.split_whitespace().next())
        .and_then(|seconds| seconds.parse::<f64>().ok());
    // Conversions saturate; a value that is not a number becomes the beginning of 1970.
    seconds.map_or(0, |seconds| (1e3 * seconds).round() as u64 * 1_000_000)
}
