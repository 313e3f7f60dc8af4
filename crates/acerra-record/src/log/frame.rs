//! Records of a session log: each record is self-contained, so that a truncated end loses only the last record.
//!
//! | bytes | field |
//! | --- | --- |
//! | 4 | mark, `AcRf` |
//! | 1 | kind |
//! | 3 | zero |
//! | 4 | length of the payload, little-endian |
//! | 8 | host clock, ns, little-endian |
//! | … | payload |
//! | 4 | CRC-32 (IEEE 802.3) of everything from the kind to the payload's end, little-endian |

use std::io::{self, Read};

/// First bytes of every log: name and version of the format.
pub const LOG_SIGNATURE: [u8; 8] = *b"ACERLOG\x01";

pub(super) const MARK: [u8; 4] = *b"AcRf";
pub(super) const HEAD_BYTES: usize = 20;
const CRC_BYTES: usize = 4;
/// Longest payload; a longer one is damage.
pub const MAX_PAYLOAD_BYTES: usize = 1 << 20;

/// Content of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RecordKind {
    /// The session's settings, TOML.
    Settings,
    /// A message of the radio as it came.
    Radio,
    /// The configuration that the radio reads back, 32 bytes.
    RadioConfig,
    /// Bytes of the GNSS receiver as they came.
    Gnss,
    /// Description of the event, UTF-8.
    Note,
    /// The session ended in order; counts, JSON.
    End,
    /// A pulse per second as the kernel stamped it ([`crate::pps::PulseStamp`]), at the host clock of its edge.
    Pulse,
    /// A kind of a later version.
    Other(u8),
}

impl RecordKind {
    /// From the code in the log.
    #[must_use]
    pub fn from_code(code: u8) -> Self {
        match code {
            1 => Self::Settings,
            2 => Self::Radio,
            3 => Self::RadioConfig,
            4 => Self::Gnss,
            5 => Self::Note,
            6 => Self::End,
            7 => Self::Pulse,
            other => Self::Other(other),
        }
    }

    /// The code in the log.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Settings => 1,
            Self::Radio => 2,
            Self::RadioConfig => 3,
            Self::Gnss => 4,
            Self::Note => 5,
            Self::End => 6,
            Self::Pulse => 7,
            Self::Other(code) => code,
        }
    }
}

/// One record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Record {
    /// Content.
    pub kind: RecordKind,
    /// Host clock when the payload came, ns.
    pub at_ns: u64,
    /// The payload.
    pub payload: Vec<u8>,
}

impl Record {
    /// Encodes the record. `None` for a payload too long for one.
    #[must_use]
    pub fn encode(&self) -> Option<Vec<u8>> {
        let length = u32::try_from(self.payload.len()).ok()?;
        if self.payload.len() > MAX_PAYLOAD_BYTES {
            return None;
        }
        let mut out = Vec::with_capacity(HEAD_BYTES + self.payload.len() + CRC_BYTES);
        out.extend_from_slice(&MARK);
        out.extend_from_slice(&[self.kind.code(), 0, 0, 0]);
        out.extend_from_slice(&length.to_le_bytes());
        out.extend_from_slice(&self.at_ns.to_le_bytes());
        out.extend_from_slice(&self.payload);
        let crc = crc32fast::hash(&out[MARK.len()..]);
        out.extend_from_slice(&crc.to_le_bytes());
        Some(out)
    }

    /// The record at the beginning of `bytes`, with its length there; `None` where no complete record with a
    /// valid checksum begins there.
    #[must_use]
    pub fn decode(bytes: &[u8]) -> Option<(Self, usize)> {
        let head = bytes.first_chunk::<HEAD_BYTES>()?;
        let (mark, fields) = head.split_first_chunk::<4>()?;
        let length = u32::from_le_bytes([fields[4], fields[5], fields[6], fields[7]]) as usize;
        if *mark != MARK || length > MAX_PAYLOAD_BYTES {
            return None;
        }
        let whole = bytes.get(..HEAD_BYTES + length + CRC_BYTES)?;
        let (covered, crc) = whole.split_last_chunk::<CRC_BYTES>()?;
        if crc32fast::hash(&covered[MARK.len()..]) != u32::from_le_bytes(*crc) {
            return None;
        }
        let at_ns = u64::from_le_bytes(*fields.last_chunk()?);
        let record = Self {
            kind: RecordKind::from_code(fields[0]),
            at_ns,
            payload: covered[HEAD_BYTES..].to_vec(),
        };
        Some((record, whole.len()))
    }
}

/// Number of bytes whose checksum [`Record::decode`] computes here: none where no record can begin.
pub(super) fn checked_bytes(bytes: &[u8]) -> usize {
    let Some(head) = bytes.first_chunk::<HEAD_BYTES>() else {
        return 0;
    };
    let length = u32::from_le_bytes([head[8], head[9], head[10], head[11]]) as usize;
    let whole = HEAD_BYTES + length + CRC_BYTES;
    let is_checked = head.starts_with(&MARK) && length <= MAX_PAYLOAD_BYTES && whole <= bytes.len();
    if is_checked { whole } else { 0 }
}

/// Reads up to `wanted` bytes more into `buffer`; fewer at the end.
pub(super) fn read_more(
    reader: &mut impl Read,
    buffer: &mut Vec<u8>,
    wanted: usize,
) -> io::Result<usize> {
    reader.by_ref().take(wanted as u64).read_to_end(buffer)
}
