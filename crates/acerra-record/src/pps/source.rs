//! Pulses of a device, each once, put on the host clock.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use thiserror::Error;

use super::stamp::{MAX_STAMP_BYTES, PulseStamp, StampError};
use crate::host::HostClock;
use crate::link::StampPairing;

/// Interval of reading a device: each of its pulses is seen, and the calendar clock's gain on the host clock
/// between pulse and reading is small.
pub const POLL_EVERY: Duration = Duration::from_millis(50);
/// Attempts to read both clocks together, and the time between two readings that is good enough, ns.
const ATTEMPTS: usize = 8;
const TOGETHER_NS: u64 = 5_000;
/// Length of a pulse from which its edges count as exchanged: some receivers keep the wire high for half a second.
const LONGEST_PULSE: Duration = Duration::from_millis(550);
/// Pulses missed in a row beyond which the kernel is taken to count again.
const MOST_MISSED: u32 = 100_000;

/// Reason why no pulses can be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PpsError {
    /// The file cannot be read.
    #[error("PPS at {}: {cause}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
    /// Neither a device of the kernel's nor a file.
    #[error("PPS at {}: expected /dev/ppsN, /sys/class/pps/ppsN/assert or a file of its content", path.display())]
    NoFile {
        /// Name given.
        path: PathBuf,
    },
    /// The file holds something else.
    #[error("PPS at {}: {cause}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Defect found.
        cause: StampError,
    },
}

/// Result of reading a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Poll {
    /// No pulse since the last look.
    Nothing,
    /// A pulse.
    Pulse {
        /// As the kernel stamped it.
        stamp: PulseStamp,
        /// Host clock at its edge, ns; absent where the calendar clock was stepped about it.
        host_ns: Option<u64>,
        /// Pulses that came before it since the last look, or doubled edges.
        missed: u32,
    },
}

/// A device that stamps pulses.
#[derive(Debug)]
pub struct PpsSource {
    path: PathBuf,
    clock: HostClock,
    pairing: StampPairing,
    latest: u32,
}

impl PpsSource {
    /// Opens `/dev/ppsN`, `/sys/class/pps/ppsN/assert`, or a file of the latter's content. The stamp found at
    /// opening is not used: it may be of any time.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else.
    pub fn open(path: &Path, clock: HostClock) -> Result<Self, PpsError> {
        let path = text_of(path);
        let latest = read(&path)?.sequence;
        Ok(Self {
            path,
            clock,
            pairing: StampPairing::default(),
            latest,
        })
    }

    /// Time for which the wire stays high after the edge of `stamp`, where the device stamps both edges;
    /// pulses are short, so that clearly more than half a second means that the wire is inverted, or the
    /// wrong edge stamped.
    #[must_use]
    pub fn inverted(&self, stamp: PulseStamp) -> Option<Duration> {
        if self.path.file_name()? != "assert" {
            return None;
        }
        // Devices that stamp one edge show none here, or an empty one.
        let other = read(&self.path.with_file_name("clear")).ok()?;
        if other.sequence == 0 {
            return None;
        }
        let high = after(stamp.unix, other.unix);
        (high > LONGEST_PULSE).then_some(high)
    }

    /// The file that is read.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Looks for a pulse.
    ///
    /// # Errors
    /// A file that cannot be read any more, or holds something else.
    pub fn poll(&mut self) -> Result<Poll, PpsError> {
        let stamp = read(&self.path)?;
        let (host_ns, calendar) = read_together(self.clock);
        // Clocks are compared at each look, so that a step since the last one shows.
        let edge_ns = self.pairing.host_ns_at(host_ns, calendar, stamp.unix);
        let ahead = stamp.sequence.wrapping_sub(self.latest);
        if ahead == 0 {
            return Ok(Poll::Nothing);
        }
        self.latest = stamp.sequence;
        let missed = ahead - 1;
        Ok(Poll::Pulse {
            stamp,
            host_ns: edge_ns,
            missed: if missed > MOST_MISSED { 0 } else { missed },
        })
    }
}

/// From one time to another within the second that follows it.
fn after(from: Duration, to: Duration) -> Duration {
    let [from_ns, to_ns] = [from, to].map(|time| u64::from(time.subsec_nanos()));
    Duration::from_nanos((1_000_000_000 + to_ns - from_ns) % 1_000_000_000)
}

/// The file that shows the pulses of the named device.
fn text_of(path: &Path) -> PathBuf {
    let device = path.to_str().and_then(|p| p.strip_prefix("/dev/"));
    let is_pps = |name: &&str| {
        let number = name.strip_prefix("pps").unwrap_or_default();
        !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())
    };
    match device.filter(is_pps) {
        Some(name) => Path::new("/sys/class/pps").join(name).join("assert"),
        None => path.to_owned(),
    }
}

fn read(path: &Path) -> Result<PulseStamp, PpsError> {
    let failed = |cause| PpsError::Io {
        path: path.to_owned(),
        cause,
    };
    // A device or a pipe could hold the reader up.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(PpsError::NoFile {
            path: path.to_owned(),
        });
    }
    let mut text = Vec::with_capacity(MAX_STAMP_BYTES + 1);
    File::open(path)
        .and_then(|file| file.take(MAX_STAMP_BYTES as u64 + 1).read_to_end(&mut text))
        .map_err(failed)?;
    PulseStamp::parse(&text).map_err(|cause| PpsError::Content {
        path: path.to_owned(),
        cause,
    })
}

/// The host clock (ns) and the calendar clock (since 1970) at one moment: the closest of several attempts,
/// since this program may be held up between the two.
fn read_together(clock: HostClock) -> (u64, Duration) {
    let attempt = || {
        let before_ns = clock.now_ns();
        let calendar = SystemTime::now().duration_since(UNIX_EPOCH);
        let apart_ns = clock.now_ns().saturating_sub(before_ns);
        let calendar = calendar.unwrap_or(Duration::ZERO);
        (apart_ns, before_ns + apart_ns / 2, calendar)
    };
    let mut best = attempt();
    for _ in 1..ATTEMPTS {
        if best.0 <= TOGETHER_NS {
            break;
        }
        best = best.min(attempt());
    }
    (best.1, best.2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn now() -> Duration {
        SystemTime::now().duration_since(UNIX_EPOCH).unwrap()
    }

    fn put(path: &Path, unix: Duration, sequence: u32) {
        std::fs::write(path, format!("{}\n", PulseStamp { unix, sequence })).unwrap();
    }

    #[test]
    fn each_pulse_is_seen_once_and_missed_ones_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("assert");
        put(&path, now(), u32::MAX - 1);
        let clock = HostClock::start();
        let mut source = PpsSource::open(&path, clock).unwrap();
        assert_eq!(source.poll().unwrap(), Poll::Nothing);
        let before_ns = clock.now_ns();
        put(&path, now(), u32::MAX);
        let after_ns = clock.now_ns();
        std::thread::sleep(Duration::from_millis(20));
        let Poll::Pulse {
            host_ns: Some(host_ns),
            missed: 0,
            ..
        } = source.poll().unwrap()
        else {
            panic!("no pulse");
        };
        let between = before_ns.saturating_sub(1_000_000)..after_ns + 1_000_000;
        assert!(between.contains(&host_ns), "{host_ns} not in {between:?}");
        assert_eq!(source.poll().unwrap(), Poll::Nothing);
        // The kernel's number wraps.
        put(&path, now(), 3);
        assert!(matches!(
            source.poll().unwrap(),
            Poll::Pulse { missed: 3, .. }
        ));
        // A driver that was loaded again counts again.
        put(&path, now(), 1);
        assert!(matches!(
            source.poll().unwrap(),
            Poll::Pulse { missed: 0, .. }
        ));
        // A stamp of the future: the calendar clock was set back.
        put(&path, now() + Duration::from_secs(5), 2);
        assert!(matches!(
            source.poll().unwrap(),
            Poll::Pulse { host_ns: None, .. }
        ));
    }

    #[test]
    fn an_inverted_wire_is_seen_where_both_edges_are_stamped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("assert");
        let stamp = |unix_ms| PulseStamp {
            unix: Duration::from_millis(unix_ms),
            sequence: 9,
        };
        put(&path, stamp(20_950).unix, 9);
        let source = PpsSource::open(&path, HostClock::start()).unwrap();
        assert_eq!(source.inverted(stamp(20_950)), None, "one edge");
        let clear = folder.path().join("clear");
        // Pulses of 100 ms: the one before, then this one.
        for unix_ms in [20_050, 21_050] {
            put(&clear, stamp(unix_ms).unix, 9);
            assert_eq!(source.inverted(stamp(20_950)), None);
        }
        // The wire falls at the second and rises at the pulse's end.
        for unix_ms in [20_850, 21_850] {
            put(&clear, stamp(unix_ms).unix, 9);
            let high = source.inverted(stamp(20_950));
            assert_eq!(high, Some(Duration::from_millis(900)));
        }
        std::fs::write(&clear, "").unwrap();
        assert_eq!(source.inverted(stamp(20_950)), None);
        put(&clear, Duration::ZERO, 0);
        assert_eq!(source.inverted(stamp(20_950)), None, "never stamped");
    }

    #[test]
    fn what_is_no_device_is_refused_by_name() {
        let clock = HostClock::start();
        let error_of = |path: &Path| PpsSource::open(path, clock).unwrap_err().to_string();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("assert");
        assert!(error_of(&path).starts_with(&format!("PPS at {}: ", path.display())));
        assert!(error_of(folder.path()).contains("expected /dev/ppsN"));
        std::fs::write(&path, "\0\u{1}").unwrap();
        assert!(error_of(&path).contains("byte 0: expected seconds"));
        std::fs::write(&path, vec![b'1'; 1 << 16]).unwrap();
        assert!(error_of(&path).contains("64 bytes at most"));
        assert!(error_of(Path::new("/dev/pps4711")).contains("/sys/class/pps/pps4711/assert"));
        assert_eq!(text_of(Path::new("/dev/ppsx")), Path::new("/dev/ppsx"));
    }
}
