//! PX4's ULog files, `.ulg` (PX4 User Guide, "ULog File Format").

mod definitions;
mod framing;
mod messages;

use std::collections::HashMap;
use std::io::Read;

use crate::bytes::{LogBytes, array};
use crate::collect::{ClockSource, Collector, Origin};
use crate::error::LogError;
use crate::format::LogFormat;
use crate::sample::{PairKind, Recording, SourceKind};

use definitions::{Definitions, Fields};
use framing::{Framing, MESSAGE_HEADER, SHOWN};
use messages::Message;

/// The mark of a log, without its version.
const MAGIC: &[u8; 7] = b"ULog\x01\x12\x35";
/// Mark, version and time of the start (bytes).
const FILE_HEADER: usize = 16;
/// Number of equal bytes that may be unwritten memory instead of damage: the following ones decide.
const BLANK: usize = 64;

/// The topic of gimbals.
const GIMBAL: &str = "gimbal_device_attitude_status";

/// Whether a log begins like this.
pub fn begins(start: &[u8]) -> bool {
    start.starts_with(MAGIC)
}

/// Reads a log.
///
/// # Errors
/// A log that is cut off within its header, damaged beyond use, of a version that is not known, or
/// beyond the limit.
pub fn read<R: Read>(bytes: &mut LogBytes<R>, limit: usize) -> Result<Recording, LogError> {
    let header = bytes.whole(FILE_HEADER, "file header")?;
    if header[7] > 1 {
        return Err(LogError::Malformed {
            offset: 7,
            expected: "version 0 or 1 of the format".to_owned(),
            found: header[7].to_string(),
        });
    }
    bytes.advance(FILE_HEADER);
    let mut log = Reader {
        definitions: Definitions::default(),
        framing: Framing::default(),
        subscriptions: HashMap::new(),
        found: Collector::new(LogFormat::Px4, limit),
        clock_topic: None,
        appended_at: None,
        dropouts: 0,
        lost_ms: 0,
    };
    while !bytes.is_at_end()? {
        log.next(bytes)?;
    }
    if log.dropouts > 0 {
        log.found.remarks.push(format!(
            "the autopilot lost {} ms of its log in {} gaps",
            log.lost_ms, log.dropouts
        ));
    }
    let clock = ClockSource {
        kind: PairKind::Arrival,
        name: "a message vehicle_gps_position or sensor_gps with time_utc_usec",
        allows_own: false,
    };
    log.found.finish(clock, bytes.offset())
}

struct Subscription {
    topic: String,
    source: String,
    fields: Fields,
}

struct Reader {
    definitions: Definitions,
    /// Tests that distinguish messages from damage.
    framing: Framing,
    subscriptions: HashMap<u16, Subscription>,
    found: Collector,
    /// The topic that gives the time: the first with a fix.
    clock_topic: Option<String>,
    /// Where the part begins that was appended after a crash.
    appended_at: Option<u64>,
    /// Gaps in the log, and the time lost in them (ms).
    dropouts: u64,
    lost_ms: u64,
}

impl Reader {
    fn next<R: Read>(&mut self, bytes: &mut LogBytes<R>) -> Result<(), LogError> {
        let offset = bytes.offset();
        if bytes.peek(MESSAGE_HEADER)?.len() < MESSAGE_HEADER {
            return self.resynchronise(bytes, offset);
        }
        let header = bytes.whole(MESSAGE_HEADER, "message header")?;
        let length = MESSAGE_HEADER + usize::from(u16::from_le_bytes([header[0], header[1]]));
        let kind = header[2];
        let end = offset + length as u64;
        if let Some(appended) = self.appended_at.filter(|at| (offset + 1..end).contains(at)) {
            // The crash cut the last message before the appended part.
            self.appended_at = None;
            return bytes.skip(appended - offset, "message before the appended part");
        }
        let start = bytes.peek(MESSAGE_HEADER + 2)?;
        if !self.framing.may_begin(start) {
            return self.resynchronise(bytes, offset);
        }
        let start = bytes.peek(length + BLANK)?;
        let Some(message) = start.get(MESSAGE_HEADER..length).map(<[u8]>::to_vec) else {
            // The log is cut off within a message, or its length is damage.
            return self.resynchronise(bytes, offset);
        };
        let is_sound = match self.framing.checks(&start[..length], offset) {
            Some(is_sound) => is_sound,
            None => {
                let following = &bytes.peek(length + SHOWN)?[length..];
                following.is_empty() || self.framing.is_sound(following)
            }
        };
        if !is_sound {
            return self.resynchronise(bytes, offset);
        }
        let start = bytes.peek(length + BLANK)?;
        let following = start.get(length..).unwrap_or_default();
        let is_announced = kind == b'A' && following.get(3..5) == message.get(1..3);
        let is_cut = following.len() < MESSAGE_HEADER;
        let is_appended = self
            .appended_at
            .is_some_and(|at| (end..end + MESSAGE_HEADER as u64).contains(&at));
        if is_cut || is_appended || is_announced || self.framing.may_begin(following) {
            bytes.advance(length);
            return self.take(kind, &message, offset);
        }
        let first = following[0];
        if !(matches!(first, 0 | 255) && following.iter().all(|b| *b == first)) {
            // The damage begins in this message, or its length is damage and hides sound messages.
            return self.resynchronise(bytes, offset);
        }
        bytes.advance(length);
        let (passed, is_blank) = self.seek(bytes)?;
        if is_blank && bytes.is_at_end()? {
            return self.take(kind, &message, offset);
        }
        self.found.damage.add(offset, length as u64 + passed);
        Ok(())
    }

    /// Passes over damage, from the byte `offset` on which the reader is, to the next sound message.
    fn resynchronise<R: Read>(
        &mut self,
        bytes: &mut LogBytes<R>,
        offset: u64,
    ) -> Result<(), LogError> {
        let (passed, is_blank) = self.seek(bytes)?;
        if !(is_blank && bytes.is_at_end()?) {
            self.found.damage.add(offset, passed);
        }
        Ok(())
    }

    fn seek<R: Read>(&self, bytes: &mut LogBytes<R>) -> Result<(u64, bool), LogError> {
        Ok(bytes.seek(SHOWN, |start| self.framing.is_sound(start))?)
    }

    fn take(&mut self, kind: u8, message: &[u8], offset: u64) -> Result<(), LogError> {
        let malformed = |expected: &str, found: String| LogError::Malformed {
            offset,
            expected: expected.to_owned(),
            found,
        };
        match kind {
            b'B' => self.flags(message, offset),
            b'F' => {
                let text = String::from_utf8_lossy(message);
                let added = self.definitions.add(&text);
                added.map_err(|found| malformed("a message's definition", found))
            }
            b'A' => {
                let subscribed = self.subscribe(message);
                subscribed.map_err(|found| malformed("a message that is defined", found))
            }
            b'D' => self.data(message, offset),
            b'O' => {
                let lost_ms = array(message, 0).map_or(0, u16::from_le_bytes);
                self.dropped(lost_ms);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Flags of the format: bit 0 of the incompatible ones means that data were appended.
    fn flags(&mut self, message: &[u8], offset: u64) -> Result<(), LogError> {
        let incompatible: [u8; 8] = array(message, 8).unwrap_or_default();
        let [first, rest @ ..] = incompatible;
        if first & !1 != 0 || rest != [0; 7] {
            return Err(LogError::Malformed {
                offset,
                expected: "a log without flags that are not known".to_owned(),
                found: format!("{incompatible:02x?}"),
            });
        }
        let appended = array(message, 16).map(u64::from_le_bytes);
        self.appended_at = appended.filter(|at| first & 1 == 1 && *at > 0);
        Ok(())
    }

    fn dropped(&mut self, lost_ms: u16) {
        self.dropouts += 1;
        self.lost_ms += u64::from(lost_ms);
    }

    /// Notes a topic that matters here.
    fn subscribe(&mut self, message: &[u8]) -> Result<(), String> {
        let (Some(&instance), Some(id)) = (message.first(), array(message, 1)) else {
            return Err("a subscription of less than three bytes".to_owned());
        };
        let topic = String::from_utf8_lossy(message.get(3..).unwrap_or_default()).into_owned();
        let id = u16::from_le_bytes(id);
        self.framing
            .subscribe(id, self.definitions.lengths_of(&topic));
        let matters = matches!(
            topic.as_str(),
            "vehicle_gps_position"
                | "sensor_gps"
                | "vehicle_global_position"
                | "vehicle_attitude"
                | GIMBAL
        );
        if matters {
            let fields = self.definitions.fields_of(&topic)?;
            let source = format!("{topic}[{instance}]");
            let subscription = Subscription {
                topic,
                source,
                fields,
            };
            self.subscriptions.insert(id, subscription);
        }
        Ok(())
    }

    fn data(&mut self, message: &[u8], offset: u64) -> Result<(), LogError> {
        let id = array(message, 0).map(u16::from_le_bytes);
        let Some(topic) = id.and_then(|id| self.subscriptions.get(&id)) else {
            return Ok(());
        };
        let message = Message {
            fields: &topic.fields,
            bytes: message.get(2..).unwrap_or_default(),
        };
        let source = topic.source.as_str();
        match topic.topic.as_str() {
            "vehicle_attitude" => match message.attitude() {
                Some(attitude) => self.found.attitude(source, attitude, offset),
                None => Ok(()),
            },
            GIMBAL => {
                let name = match message.gimbal_device() {
                    0 => source.to_owned(),
                    device => format!("{source}.{device}"),
                };
                let sample = message.gimbal_attitude();
                self.found.gimbal(&name, 0, sample, offset)
            }
            "vehicle_global_position" => {
                let position = message.filter_position();
                self.found
                    .position(Origin::first(source, SourceKind::Filter), position, offset)
            }
            _ => {
                if let Some(pair) = message.clock_pair() {
                    let teller = self.clock_topic.get_or_insert_with(|| source.to_owned());
                    if teller == source {
                        self.found.pair(pair, offset)?;
                    }
                }
                // The estimate that the autopilot itself uses precedes the single receivers.
                let origin = match topic.topic.as_str() {
                    "vehicle_gps_position" => Origin::first(source, SourceKind::Gnss),
                    _ => Origin::second(source, SourceKind::Gnss),
                };
                self.found.position(origin, message.gnss_position(), offset)
            }
        }
    }
}
