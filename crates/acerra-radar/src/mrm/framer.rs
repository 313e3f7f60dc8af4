//! Cutting a byte stream into messages, and resynchronising after damage.

use std::io::{self, Read};

use super::config::{CONFIG_BYTES, RadarConfig};
use super::header::{HEADER_BYTES, HeaderFault, SCAN_MESSAGE_BYTES, ScanHeader, samples_in};
use super::message::{MessageType, SERIAL_PREFIX};
use crate::report::{BlemishKind, Place, ReadReport};

const PREFIX_BYTES: usize = 4;
/// Enough for a whole message and the beginning of the next.
const LOOKAHEAD: usize = PREFIX_BYTES + SCAN_MESSAGE_BYTES + PREFIX_BYTES + HEADER_BYTES;

/// Largest modulus of a sample that the radio can send: 2¹⁵ pulses (PII 15) of 16-bit values. Foreign bytes
/// read as samples exceed this modulus half of the time.
const LARGEST_SAMPLE: u32 = 1 << 30;

/// One message cut out of the stream.
pub(super) enum Message {
    Scan {
        header: ScanHeader,
        samples: Vec<i32>,
        offset: u64,
    },
    Config {
        config: RadarConfig,
        offset: u64,
    },
    Control {
        interval_us: u32,
    },
    Other(MessageType),
}

/// Kind of record at a place in the stream.
#[derive(Clone, Copy)]
enum Start {
    Scan {
        prefix: usize,
        header: ScanHeader,
    },
    Other {
        prefix: usize,
        kind: MessageType,
        bytes: usize,
    },
    BadScan(HeaderFault),
    Nothing,
}

/// Kind of stream by its first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Recognised {
    /// MRM messages, possibly after a configuration or some damage.
    Mrm,
    /// MRM messages with the bytes of every field swapped; the place of the first such message.
    Swapped(u64),
    /// An inconsistent SCAN_INFO message without a valid one nearby.
    Broken(u64, HeaderFault),
    /// Something else.
    No,
}

/// Searches a file's first bytes for MRM messages.
///
/// A valid SCAN_INFO header is evidence anywhere. An inconsistent one is evidence only where a capture would
/// have its first message, or where another message follows: the two bytes of a message type occur by chance
/// in any file of some size.
pub(crate) fn recognise(head: &[u8]) -> Recognised {
    let mut broken = None;
    let mut swapped = None;
    for at in 0..head.len() {
        let is_first = at == 0 || at == CONFIG_BYTES;
        match start_at(&head[at..]) {
            Start::Scan { .. } => return Recognised::Mrm,
            // A short message is weak evidence, except at a file's beginning.
            Start::Other { prefix, bytes, .. } if is_first => {
                let end = at + prefix + bytes;
                if end == head.len() || head.get(end..).is_some_and(looks_like_start) {
                    return Recognised::Mrm;
                }
            }
            Start::BadScan(fault) if is_first || followed_by_scan(&head[at..]) => {
                broken = broken.or(Some((at as u64, fault)));
            }
            _ => {}
        }
        if swapped.is_none() && ScanHeader::is_swapped(&head[at..]) {
            swapped = Some(at as u64);
        }
    }
    match (swapped, broken) {
        (Some(at), _) => Recognised::Swapped(at),
        (None, Some((at, fault))) => Recognised::Broken(at, fault),
        (None, None) => match head.first_chunk::<CONFIG_BYTES>() {
            // Only the configuration: the radio was never started.
            Some(b)
                if head.len() < CONFIG_BYTES + 8 && RadarConfig::from_bytes(b).is_plausible() =>
            {
                Recognised::Mrm
            }
            _ => Recognised::No,
        },
    }
}

/// Whether a valid SCAN_INFO header is at one of the two places where a capture has its first message.
pub(crate) fn begins_with_scan(head: &[u8]) -> bool {
    [0, CONFIG_BYTES].into_iter().any(|at| {
        head.get(at..)
            .is_some_and(|rest| matches!(start_at(rest), Start::Scan { .. }))
    })
}

/// Whether another SCAN_INFO message type follows at one message length.
fn followed_by_scan(b: &[u8]) -> bool {
    b.get(SCAN_MESSAGE_BYTES..SCAN_MESSAGE_BYTES + 2)
        .is_some_and(|code| code == MessageType::ScanInfo.code().to_be_bytes())
}

fn start_at(b: &[u8]) -> Start {
    let Some(first) = b.first_chunk::<2>() else {
        return Start::Nothing;
    };
    let (prefix, length) = if *first == SERIAL_PREFIX {
        match b.get(2..4) {
            Some(l) => (
                PREFIX_BYTES,
                Some(usize::from(u16::from_be_bytes([l[0], l[1]]))),
            ),
            None => return Start::Nothing,
        }
    } else {
        (0, None)
    };
    let body = &b[prefix..];
    let Some(code) = body.first_chunk::<2>().map(|c| u16::from_be_bytes(*c)) else {
        return Start::Nothing;
    };
    let Some(kind) = MessageType::from_code(code) else {
        return Start::Nothing;
    };
    if length.is_some_and(|l| l != kind.bytes()) {
        return Start::Nothing;
    }
    if kind != MessageType::ScanInfo {
        return Start::Other {
            prefix,
            kind,
            bytes: kind.bytes(),
        };
    }
    match ScanHeader::parse(body) {
        Ok(header) => Start::Scan { prefix, header },
        Err(fault) => Start::BadScan(fault),
    }
}

/// Whether a message may begin here (a weak test, for bytes after a whole message).
fn looks_like_start(b: &[u8]) -> bool {
    match start_at(b) {
        Start::Scan { .. } | Start::Other { .. } => true,
        Start::BadScan(HeaderFault::Short) => true,
        // Too few bytes left to decide.
        Start::Nothing => b.len() < 2 || (b.len() < 6 && b[..2] == SERIAL_PREFIX),
        Start::BadScan(_) => false,
    }
}

/// Streams messages out of a reader, holding no more than a few kilobytes.
pub(super) struct Framer<R> {
    reader: R,
    buffer: Vec<u8>,
    at: usize,
    /// Offset in the file of `buffer[at]`.
    offset: u64,
    ended: bool,
    first: bool,
    /// Largest modulus among the samples of messages with a message after them.
    largest_sound: Option<u32>,
}

impl<R: Read> Framer<R> {
    pub(super) fn new(reader: R) -> Self {
        Self {
            reader,
            buffer: Vec::new(),
            at: 0,
            offset: 0,
            ended: false,
            first: true,
            largest_sound: None,
        }
    }

    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    fn rest(&self) -> &[u8] {
        &self.buffer[self.at..]
    }

    fn advance(&mut self, bytes: usize) {
        self.at += bytes;
        self.offset += bytes as u64;
    }

    /// Makes at least `wanted` bytes available, or all that remain.
    fn fill(&mut self, wanted: usize) -> io::Result<()> {
        if self.ended || self.rest().len() >= wanted {
            return Ok(());
        }
        self.buffer.drain(..self.at);
        self.at = 0;
        let mut chunk = [0u8; 1 << 14];
        while !self.ended && self.buffer.len() < wanted {
            match self.reader.read(&mut chunk) {
                Ok(0) => self.ended = true,
                Ok(n) => self.buffer.extend_from_slice(&chunk[..n]),
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }

    /// The next message, or `None` at the end.
    pub(super) fn next(&mut self, report: &mut ReadReport) -> io::Result<Option<Message>> {
        if std::mem::take(&mut self.first) {
            self.fill(LOOKAHEAD)?;
            if let Some(config) = self.leading_config() {
                let offset = self.offset;
                self.advance(CONFIG_BYTES);
                return Ok(Some(Message::Config { config, offset }));
            }
        }
        loop {
            self.fill(LOOKAHEAD)?;
            if self.rest().is_empty() {
                return Ok(None);
            }
            match start_at(self.rest()) {
                Start::Scan { prefix, header } => {
                    if let Some(message) = self.take_scan(prefix, header, report) {
                        return Ok(Some(message));
                    }
                }
                Start::Other {
                    prefix,
                    kind,
                    bytes,
                } => {
                    let end = prefix + bytes;
                    let follows = self.rest().get(end..);
                    if follows.is_some_and(|b| b.is_empty() || looks_like_start(b)) {
                        return Ok(Some(self.take_other(prefix, kind, bytes)));
                    }
                    self.skip_damage(report)?;
                }
                Start::BadScan(fault) => {
                    if fault != HeaderFault::Short {
                        report.add(Place::Byte(self.offset), BlemishKind::BadHeader(fault));
                    }
                    self.skip_damage(report)?;
                }
                Start::Nothing => self.skip_damage(report)?,
            }
        }
    }

    /// The 32-byte configuration at the beginning of a capture.
    fn leading_config(&self) -> Option<RadarConfig> {
        let rest = self.rest();
        if matches!(start_at(rest), Start::Scan { .. }) {
            return None;
        }
        let config = RadarConfig::from_bytes(rest.first_chunk::<CONFIG_BYTES>()?);
        let follows = &rest[CONFIG_BYTES..];
        (config.is_plausible() && (follows.is_empty() || looks_like_start(follows)))
            .then_some(config)
    }

    /// Reads a SCAN_INFO message. Where another message begins inside it, bytes are missing and the rest is
    /// skipped; likewise where its samples exceed the radio's range.
    fn take_scan(
        &mut self,
        prefix: usize,
        header: ScanHeader,
        report: &mut ReadReport,
    ) -> Option<Message> {
        let end = prefix + SCAN_MESSAGE_BYTES;
        let rest = self.rest();
        let sound = rest
            .get(end..)
            .is_some_and(|b| b.is_empty() || looks_like_start(b));
        if !sound {
            let inner = (prefix + HEADER_BYTES..end.min(rest.len()))
                .find(|&i| matches!(start_at(&rest[i..]), Start::Scan { .. }));
            let missing = rest.len() < end;
            if let Some(found) = inner.or(missing.then_some(rest.len())) {
                let kind = BlemishKind::CutOffMessage {
                    found: found as u64,
                };
                report.add(Place::Byte(self.offset), kind);
                self.advance(found);
                return None;
            }
        }
        let first = prefix + HEADER_BYTES;
        let samples: Vec<i32> = samples_in(&rest[first..])
            .take(usize::from(header.samples_in_message))
            .collect();
        let largest = samples.iter().map(|s| s.unsigned_abs()).max().unwrap_or(0);
        if largest > self.largest_plausible(sound) {
            let kind = BlemishKind::ImplausibleSamples {
                message_id: header.message_id,
                index: header.message_index,
                largest,
            };
            report.add(Place::Byte(self.offset), kind);
            // The bytes after the header do not belong to this message: search them for the next one.
            self.advance(first);
            return None;
        }
        if sound {
            self.largest_sound = self.largest_sound.max(Some(largest));
        }
        let offset = self.offset;
        self.advance(end);
        Some(Message::Scan {
            header,
            samples,
            offset,
        })
    }

    /// Largest modulus of a message's samples. Without a message after it, foreign bytes may be in its place:
    /// then the modulus must not exceed that of valid messages by orders of magnitude.
    fn largest_plausible(&self, sound: bool) -> u32 {
        match self.largest_sound {
            Some(largest) if !sound => largest.saturating_mul(16).min(LARGEST_SAMPLE),
            _ => LARGEST_SAMPLE,
        }
    }

    fn take_other(&mut self, prefix: usize, kind: MessageType, bytes: usize) -> Message {
        let offset = self.offset;
        let body = &self.rest()[prefix..prefix + bytes];
        let message = match kind {
            MessageType::SetConfigRequest | MessageType::GetConfigConfirm => body[4..]
                .first_chunk::<CONFIG_BYTES>()
                .map(RadarConfig::from_bytes)
                .filter(RadarConfig::is_plausible)
                .map_or(Message::Other(kind), |config| Message::Config {
                    config,
                    offset,
                }),
            MessageType::ControlRequest => {
                let interval_us = u32::from_be_bytes([body[8], body[9], body[10], body[11]]);
                Message::Control { interval_us }
            }
            _ => Message::Other(kind),
        };
        self.advance(prefix + bytes);
        message
    }

    /// Skips to the next valid SCAN_INFO header, or to a prefixed message, or to the end.
    fn skip_damage(&mut self, report: &mut ReadReport) -> io::Result<()> {
        let (place, mut count) = (Place::Byte(self.offset), 0u64);
        loop {
            self.fill(LOOKAHEAD)?;
            let rest = self.rest();
            if rest.is_empty() {
                break;
            }
            // Leave the last bytes for the next round: a header may straddle the boundary.
            let last = if self.ended {
                rest.len()
            } else {
                rest.len() - HEADER_BYTES - PREFIX_BYTES
            };
            let from = usize::from(count == 0);
            let hit = (from..last).find(|&i| match start_at(&rest[i..]) {
                Start::Scan { .. } => true,
                Start::Other { prefix, .. } => prefix > 0,
                _ => false,
            });
            let skipped = hit.unwrap_or(last);
            count += skipped as u64;
            self.advance(skipped);
            if hit.is_some() {
                break;
            }
        }
        report.add(place, BlemishKind::UnreadableBytes { count });
        Ok(())
    }
}
