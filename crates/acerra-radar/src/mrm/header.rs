//! The fixed part of a SCAN_INFO message.

use std::fmt;

use crate::scan::{Filtering, ScanWindow};

/// Samples that every SCAN_INFO message has room for.
pub const SAMPLES_PER_MESSAGE: usize = 350;
/// Bytes of a SCAN_INFO message before its samples.
pub const HEADER_BYTES: usize = 52;
/// Bytes of a whole SCAN_INFO message.
pub const SCAN_MESSAGE_BYTES: usize = HEADER_BYTES + 4 * SAMPLES_PER_MESSAGE;

const SCAN_INFO: u16 = 0xF201;

/// Fields of a SCAN_INFO message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ScanHeader {
    /// Running number of the scan.
    pub message_id: u16,
    /// Identity of the radio.
    pub source_id: u32,
    /// Radio clock, ms since boot, at the end of the scan.
    pub timestamp_ms: u32,
    /// Reserved words, kept as they are.
    pub reserved: [u32; 4],
    /// Fast time of the first sample, ps.
    pub scan_start_ps: i32,
    /// End of the window, ps.
    pub scan_stop_ps: i32,
    /// Spacing of samples, bins.
    pub scan_step_bins: u16,
    /// Filtering by the radio.
    pub filtering: Filtering,
    /// Reserved byte, kept as it is.
    pub reserved_byte: u8,
    /// Antenna the scan was received on.
    pub antenna_id: u8,
    /// Operation mode (1 = MRM).
    pub operation_mode: u8,
    /// Valid samples in this message, at most 350.
    pub samples_in_message: u16,
    /// Samples of the whole scan.
    pub samples_total: u32,
    /// Index of this message in the scan, from 0.
    pub message_index: u16,
    /// Messages of the scan.
    pub messages_total: u16,
}

/// Inconsistencies of a SCAN_INFO header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum HeaderFault {
    /// Fewer than 52 bytes.
    Short,
    /// The message type is not SCAN_INFO.
    Type,
    /// The window ends before it starts.
    Window {
        /// Start, ps.
        start_ps: i32,
        /// End, ps.
        stop_ps: i32,
    },
    /// The step is zero or larger than the radio's largest.
    Step {
        /// Step found, bins.
        bins: u16,
    },
    /// A message without samples, or with more than fit.
    SamplesInMessage {
        /// Number found.
        found: u16,
    },
    /// Total samples do not fit the number of messages.
    SamplesTotal {
        /// Number found.
        found: u32,
        /// Messages of the scan.
        messages: u16,
    },
    /// The message's index is not below the number of messages.
    MessageIndex {
        /// Index found.
        index: u16,
        /// Messages of the scan.
        messages: u16,
    },
    /// The scan is longer than the limit.
    Limit {
        /// Samples declared.
        samples: u32,
        /// The limit.
        limit: usize,
    },
}

impl fmt::Display for HeaderFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Short => write!(f, "fewer than {HEADER_BYTES} bytes"),
            Self::Type => f.write_str("not a SCAN_INFO message"),
            Self::Window { start_ps, stop_ps } => {
                write!(
                    f,
                    "window ends at {stop_ps} ps, not after its start at {start_ps} ps"
                )
            }
            Self::Step { bins } => write!(f, "step of {bins} bins, expected 1 to 1024"),
            Self::SamplesInMessage { found } => {
                write!(
                    f,
                    "{found} samples in a message, expected 1 to {SAMPLES_PER_MESSAGE}"
                )
            }
            Self::SamplesTotal { found, messages } => {
                write!(
                    f,
                    "{found} samples in {messages} messages of at most {SAMPLES_PER_MESSAGE}"
                )
            }
            Self::MessageIndex { index, messages } => {
                write!(f, "message {index} of {messages}")
            }
            Self::Limit { samples, limit } => {
                write!(f, "scan of {samples} samples, at most {limit} are read")
            }
        }
    }
}

/// Samples after a SCAN_INFO header.
pub fn samples_in(b: &[u8]) -> impl Iterator<Item = i32> {
    b.chunks_exact(4)
        .map(|c| i32::from_be_bytes([c[0], c[1], c[2], c[3]]))
}

impl ScanHeader {
    /// Decodes and checks a header.
    ///
    /// # Errors
    /// The first [`HeaderFault`] found; the limit on a scan's length is not checked here.
    pub fn parse(b: &[u8]) -> Result<Self, HeaderFault> {
        let bytes = b.first_chunk::<HEADER_BYTES>().ok_or(HeaderFault::Short)?;
        Self::decode(bytes, false)
    }

    /// Whether the bytes are a valid header when read little-endian: a byte-swapped capture.
    pub(super) fn is_swapped(b: &[u8]) -> bool {
        b.first_chunk::<HEADER_BYTES>()
            .is_some_and(|b| Self::decode(b, true).is_ok())
    }

    fn decode(b: &[u8; HEADER_BYTES], little: bool) -> Result<Self, HeaderFault> {
        let u16_at = |i: usize| {
            let raw = [b[i], b[i + 1]];
            if little {
                u16::from_le_bytes(raw)
            } else {
                u16::from_be_bytes(raw)
            }
        };
        let u32_at = |i: usize| {
            let raw = [b[i], b[i + 1], b[i + 2], b[i + 3]];
            if little {
                u32::from_le_bytes(raw)
            } else {
                u32::from_be_bytes(raw)
            }
        };
        if u16_at(0) != SCAN_INFO {
            return Err(HeaderFault::Type);
        }
        let header = Self {
            message_id: u16_at(2),
            source_id: u32_at(4),
            timestamp_ms: u32_at(8),
            reserved: [u32_at(12), u32_at(16), u32_at(20), u32_at(24)],
            scan_start_ps: u32_at(28) as i32,
            scan_stop_ps: u32_at(32) as i32,
            scan_step_bins: u16_at(36),
            filtering: Filtering::from_code(b[38]),
            reserved_byte: b[39],
            antenna_id: b[40],
            operation_mode: b[41],
            samples_in_message: u16_at(42),
            samples_total: u32_at(44),
            message_index: u16_at(48),
            messages_total: u16_at(50),
        };
        header.check()?;
        Ok(header)
    }

    fn check(&self) -> Result<(), HeaderFault> {
        if self.scan_stop_ps <= self.scan_start_ps {
            return Err(HeaderFault::Window {
                start_ps: self.scan_start_ps,
                stop_ps: self.scan_stop_ps,
            });
        }
        if !(1..=1024).contains(&self.scan_step_bins) {
            return Err(HeaderFault::Step {
                bins: self.scan_step_bins,
            });
        }
        if !(1..=SAMPLES_PER_MESSAGE).contains(&usize::from(self.samples_in_message)) {
            return Err(HeaderFault::SamplesInMessage {
                found: self.samples_in_message,
            });
        }
        if self.message_index >= self.messages_total {
            return Err(HeaderFault::MessageIndex {
                index: self.message_index,
                messages: self.messages_total,
            });
        }
        let others = u32::from(self.messages_total) - 1;
        let room = u32::from(self.samples_in_message) + others * SAMPLES_PER_MESSAGE as u32;
        let least = u32::from(self.samples_in_message) + others;
        if !(least..=room).contains(&self.samples_total) {
            return Err(HeaderFault::SamplesTotal {
                found: self.samples_total,
                messages: self.messages_total,
            });
        }
        Ok(())
    }

    /// Encodes the header, big-endian.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; HEADER_BYTES] {
        let mut b = [0; HEADER_BYTES];
        let mut put = |at: usize, bytes: &[u8]| b[at..at + bytes.len()].copy_from_slice(bytes);
        put(0, &SCAN_INFO.to_be_bytes());
        put(2, &self.message_id.to_be_bytes());
        put(4, &self.source_id.to_be_bytes());
        put(8, &self.timestamp_ms.to_be_bytes());
        for (i, word) in self.reserved.iter().enumerate() {
            put(12 + 4 * i, &word.to_be_bytes());
        }
        put(28, &self.scan_start_ps.to_be_bytes());
        put(32, &self.scan_stop_ps.to_be_bytes());
        put(36, &self.scan_step_bins.to_be_bytes());
        put(38, &[self.filtering.code(), self.reserved_byte]);
        put(40, &[self.antenna_id, self.operation_mode]);
        put(42, &self.samples_in_message.to_be_bytes());
        put(44, &self.samples_total.to_be_bytes());
        put(48, &self.message_index.to_be_bytes());
        put(50, &self.messages_total.to_be_bytes());
        b
    }

    /// The scan's window.
    #[must_use]
    pub fn window(&self) -> ScanWindow {
        ScanWindow {
            start_ps: self.scan_start_ps,
            stop_ps: self.scan_stop_ps,
            step_bins: self.scan_step_bins,
            samples: self.samples_total as usize,
        }
    }
}
