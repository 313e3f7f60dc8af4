//! MCAP files with messages of ROS 2.

mod cdr;
mod mcap;
mod messages;

use std::collections::HashMap;
use std::io::Read;

use crate::bytes::LogBytes;
use crate::collect::{ClockSource, Collector, Origin};
use crate::error::LogError;
use crate::format::LogFormat;
use crate::sample::{GimbalSample, PairKind, Recording, SourceKind, YawFrom};

use mcap::{Fields, LARGEST_CHUNK, MAGIC, RECORD_HEADER, kind, unpacked};
use messages::{Kind, fix, imu, odometry, quaternion};

/// Whether a file begins like this.
pub fn begins(start: &[u8]) -> bool {
    start.starts_with(&MAGIC)
}

/// Reads a file.
///
/// # Errors
/// A file that is cut off within a record, with a record that cannot be read, or beyond the limit.
pub fn read<R: Read>(bytes: &mut LogBytes<R>, limit: usize) -> Result<Recording, LogError> {
    bytes.whole(MAGIC.len(), "file header")?;
    bytes.advance(MAGIC.len());
    let mut log = Reader {
        found: Collector::new(LogFormat::Mcap, limit),
        schemas: HashMap::new(),
        topics: HashMap::new(),
    };
    let mut is_closed = false;
    while !is_closed && !bytes.is_at_end()? {
        let offset = bytes.offset();
        let record = Record::next(bytes)?;
        match record.kind {
            kind::DATA_END | kind::FOOTER => is_closed = true,
            kind::CHUNK => {
                let records = unpacked(&record.content).map_err(|found| LogError::Malformed {
                    offset,
                    expected: "a chunk of records".to_owned(),
                    found,
                })?;
                log.take_chunk(&records, offset)?;
            }
            _ => log.take(record.kind, &record.content, offset)?,
        }
    }
    if !is_closed {
        let remark = "the file was not closed: its end is missing, and so may be messages";
        log.found.remarks.push(remark.to_owned());
    }
    log.found.remarks.push(
        "times are the stamps of the messages' headers, UTC by the clock of the robot's computer or of its \
         receiver: the file does not state the clock's accuracy ([trajectory] time_offset_s)"
            .to_owned(),
    );
    let clock = ClockSource {
        kind: PairKind::Simultaneous,
        name: "stamps that count from 1970",
        allows_own: true,
    };
    log.found.finish(clock, bytes.offset())
}

/// A record with its content.
struct Record {
    kind: u8,
    content: Vec<u8>,
}

impl Record {
    fn next<R: Read>(bytes: &mut LogBytes<R>) -> Result<Self, LogError> {
        let offset = bytes.offset();
        let header = bytes.whole(RECORD_HEADER, "record's header")?;
        let kind = header[0];
        let length = Fields::new(&header[1..]).u64().unwrap_or_default();
        if length > LARGEST_CHUNK {
            return Err(LogError::Limit {
                offset,
                what: "bytes of a record",
                limit: LARGEST_CHUNK,
            });
        }
        bytes.advance(RECORD_HEADER);
        let what = format!("record of kind {kind:#04x}");
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        let content = bytes.whole(length, &what).map_err(|error| match error {
            LogError::CutOff {
                what,
                expected,
                found,
                ..
            } => LogError::CutOff {
                offset,
                what,
                expected: expected + RECORD_HEADER as u64,
                found: found + RECORD_HEADER as u64,
            },
            other => other,
        });
        let content = content?.to_vec();
        bytes.advance(length);
        Ok(Self { kind, content })
    }
}

struct Topic {
    name: String,
    kind: Kind,
}

struct Reader {
    found: Collector,
    schemas: HashMap<u16, String>,
    /// The topics that matter here.
    topics: HashMap<u16, Topic>,
}

impl Reader {
    /// The records of a chunk at `offset` of the file.
    fn take_chunk(&mut self, mut records: &[u8], offset: u64) -> Result<(), LogError> {
        while !records.is_empty() {
            let mut fields = Fields::new(records.get(1..).unwrap_or_default());
            let length = fields.u64().and_then(|length| usize::try_from(length).ok());
            let content = length.and_then(|length| {
                let end = RECORD_HEADER.checked_add(length)?;
                records.get(RECORD_HEADER..end)
            });
            let Some(content) = content else {
                return Err(malformed(offset, "a chunk of whole records", "part of one"));
            };
            self.take(records[0], content, offset)?;
            records = &records[RECORD_HEADER + content.len()..];
        }
        Ok(())
    }

    fn take(&mut self, record: u8, content: &[u8], offset: u64) -> Result<(), LogError> {
        let mut fields = Fields::new(content);
        match record {
            kind::SCHEMA => {
                let schema = fields.u16().zip(fields.text());
                let (id, name) =
                    schema.ok_or_else(|| malformed(offset, "a schema", "part of one"))?;
                self.schemas.insert(id, name.to_owned());
                Ok(())
            }
            kind::CHANNEL => self.topic(fields, offset),
            kind::MESSAGE => {
                let head = fields.u16().zip(fields.u32()).zip(fields.u64());
                let id = head.zip(fields.u64()).map(|(((id, _), _), _)| id);
                let id = id.ok_or_else(|| malformed(offset, "a message", "part of one"))?;
                self.message(id, fields.rest(), offset)
            }
            _ => Ok(()),
        }
    }

    fn topic(&mut self, mut fields: Fields<'_>, offset: u64) -> Result<(), LogError> {
        let id = fields.u16().zip(fields.u16());
        let texts = id.and_then(|_| fields.text().zip(fields.text()));
        let (Some((id, schema)), Some((name, encoding))) = (id, texts) else {
            return Err(malformed(offset, "a channel", "part of one"));
        };
        let schema = self.schemas.get(&schema).map_or("", String::as_str);
        let Some(kind) = Kind::named(schema) else {
            return Ok(());
        };
        if encoding != "cdr" {
            let found = format!("'{}'", encoding.escape_debug());
            let expected = format!("messages of {name} in the encoding cdr of ROS 2");
            return Err(malformed(offset, &expected, &found));
        }
        let name = name.to_owned();
        self.topics.insert(id, Topic { name, kind });
        Ok(())
    }

    fn message(&mut self, topic: u16, message: &[u8], offset: u64) -> Result<(), LogError> {
        let Some(Topic { name, kind }) = self.topics.get(&topic) else {
            return Ok(());
        };
        let broken = || {
            let expected = format!("a whole message of {name} in the encoding CDR, version 1");
            malformed(offset, &expected, &format!("{} bytes", message.len()))
        };
        match kind {
            Kind::NavSatFix => {
                let position = fix(message).ok_or_else(broken)?;
                let origin = Origin::first(name, SourceKind::Gnss);
                self.found.position(origin, position, offset)
            }
            Kind::Odometry => {
                let found = odometry(message).ok_or_else(broken)?;
                let origin = Origin::first(name, SourceKind::Filter);
                self.found
                    .position(origin, found.map(|(position, _)| position), offset)?;
                match found.and_then(|(_, attitude)| attitude) {
                    Some(attitude) => self.found.ranked_attitude(name, 1, attitude, offset),
                    None => Ok(()),
                }
            }
            // Whose attitude it is the message does not say: it is taken where its topic is named.
            Kind::Quaternion => {
                let sample = quaternion(message).ok_or_else(broken)?;
                let sample = sample.map(|s| GimbalSample::new(s.stamp, s.attitude, YawFrom::North));
                self.found.gimbal(name, 0, sample, offset)
            }
            Kind::Imu => match imu(message).ok_or_else(broken)? {
                Some(attitude) => self.found.attitude(name, attitude, offset),
                None => Ok(()),
            },
        }
    }
}

fn malformed(offset: u64, expected: &str, found: &str) -> LogError {
    LogError::Malformed {
        offset,
        expected: expected.to_owned(),
        found: found.to_owned(),
    }
}
