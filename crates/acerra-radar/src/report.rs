//! Report of a reader: every record read, kept or skipped.

use std::collections::BTreeMap;
use std::fmt;

use crate::mrm::HeaderFault;
use crate::scan::ScanWindow;

/// Largest number of blemishes listed; further ones are only counted.
const LISTED: usize = 1000;

/// Place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Byte offset from the file's start.
    Byte(u64),
    /// Line number, from 1.
    Line(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Byte(offset) => write!(f, "byte {offset}"),
            Self::Line(number) => write!(f, "line {number}"),
        }
    }
}

/// One defect of a log, after which reading continued.
#[derive(Debug, Clone, PartialEq)]
pub struct Blemish {
    /// Where it is.
    pub place: Place,
    /// What it is.
    pub kind: BlemishKind,
}

impl Blemish {
    /// Whether the defect is only that the recording ends within a scan: no other data are missing.
    #[must_use]
    pub fn is_end_of_recording(&self) -> bool {
        matches!(
            self.kind,
            BlemishKind::IncompleteScan { at_end: true, .. }
                | BlemishKind::CutOffMessage { .. }
                | BlemishKind::CutOffLine
        )
    }
}

impl fmt::Display for Blemish {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.kind)
    }
}

/// Kinds of [`Blemish`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum BlemishKind {
    /// A scan with missing messages; its samples are not used.
    IncompleteScan {
        /// The scan's number.
        message_id: u16,
        /// Messages that came.
        found: usize,
        /// Messages that belong to it.
        expected: usize,
        /// Whether the file ended before the rest.
        at_end: bool,
    },
    /// A scan whose messages together do not hold the declared number of samples.
    SampleCount {
        /// The scan's number.
        message_id: u16,
        /// Samples declared.
        expected: usize,
        /// Samples in its messages.
        found: usize,
    },
    /// A message whose scan and index came before; the first one counts.
    RepeatedMessage {
        /// The scan's number.
        message_id: u16,
        /// The message's index in the scan.
        index: u16,
        /// Whether both held the same samples; unknown once the scan has been returned.
        identical: Option<bool>,
    },
    /// A message out of order, sorted into its place.
    OutOfOrder {
        /// The scan's number.
        message_id: u16,
        /// The message's index in the scan.
        index: u16,
    },
    /// Bytes that belong to no message.
    UnreadableBytes {
        /// Count.
        count: u64,
    },
    /// A message that stops before its end, followed by the next message or the file's end.
    CutOffMessage {
        /// Number of its bytes.
        found: u64,
    },
    /// A SCAN_INFO message with samples beyond the radio's range, or far beyond those of its neighbours where
    /// no message follows: foreign bytes. The message is not used.
    ImplausibleSamples {
        /// The scan's number.
        message_id: u16,
        /// The message's index in the scan.
        index: u16,
        /// Largest modulus among the samples.
        largest: u32,
    },
    /// An inconsistent SCAN_INFO message.
    BadHeader(HeaderFault),
    /// The fast-time window changes between scans.
    WindowChanged {
        /// Window before.
        from: ScanWindow,
        /// Window from here on.
        to: ScanWindow,
    },
    /// The radio is configured again.
    Reconfigured,
    /// The last line has no line end; its scan is complete by its sample count and kept.
    UnterminatedLine,
    /// The last line is cut off.
    CutOffLine,
    /// A line that cannot be read.
    MalformedLine {
        /// Field number, from 1.
        field: usize,
        /// Expected content at that place.
        expected: &'static str,
    },
    /// A scan line with another number of samples than it declares.
    LineSamples {
        /// Samples declared.
        expected: usize,
        /// Samples there.
        found: usize,
    },
    /// A line longer than the limit.
    LongLine {
        /// The limit, bytes.
        limit: usize,
    },
}

impl fmt::Display for BlemishKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IncompleteScan {
                message_id,
                found,
                expected,
                at_end,
            } => {
                let why = if *at_end {
                    "the file ends"
                } else {
                    "the others are missing"
                };
                write!(
                    f,
                    "scan {message_id}: {found} of {expected} messages, {why}; not used"
                )
            }
            Self::SampleCount {
                message_id,
                expected,
                found,
            } => {
                write!(
                    f,
                    "scan {message_id}: {expected} samples declared, {found} there; not used"
                )
            }
            Self::RepeatedMessage {
                message_id,
                index,
                identical,
            } => {
                let how = match identical {
                    Some(true) => ", identical",
                    Some(false) => " with other samples",
                    None => "",
                };
                write!(
                    f,
                    "scan {message_id}: message {index} repeated{how}; the first one is used"
                )
            }
            Self::OutOfOrder { message_id, index } => {
                write!(
                    f,
                    "scan {message_id}: message {index} out of order; put in its place"
                )
            }
            Self::UnreadableBytes { count } => write!(f, "{count} bytes belong to no message"),
            Self::CutOffMessage { found } => write!(f, "message cut off after {found} bytes"),
            Self::ImplausibleSamples {
                message_id,
                index,
                largest,
            } => write!(
                f,
                "scan {message_id}: message {index} holds foreign bytes (a sample of {largest}); \
                 not used"
            ),
            Self::BadHeader(fault) => write!(f, "SCAN_INFO header: {fault}"),
            Self::WindowChanged { from, to } => write!(f, "window changes from {from} to {to}"),
            Self::Reconfigured => f.write_str("the radio is configured again"),
            Self::UnterminatedLine => f.write_str("last line has no end; its scan is kept"),
            Self::CutOffLine => f.write_str("last line is cut off; not used"),
            Self::MalformedLine { field, expected } => {
                write!(f, "field {field}: {expected} expected; line not used")
            }
            Self::LineSamples { expected, found } => {
                write!(
                    f,
                    "{expected} samples declared, {found} there; line not used"
                )
            }
            Self::LongLine { limit } => write!(f, "longer than {limit} bytes; not used"),
        }
    }
}

/// Account of one reading.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct ReadReport {
    /// Bytes read.
    pub bytes: u64,
    /// Messages (or lines) that carry scan samples.
    pub scan_messages: u64,
    /// Scans that are whole.
    pub whole_scans: u64,
    /// Scans with missing messages or samples.
    pub incomplete_scans: u64,
    /// Messages repeated.
    pub repeated_messages: u64,
    /// Messages out of order.
    pub out_of_order_messages: u64,
    /// Bytes that belong to no message, cut-off messages included.
    pub unreadable_bytes: u64,
    /// Messages whose samples were foreign bytes.
    pub implausible_messages: u64,
    /// Other messages or events, by name.
    pub other_events: BTreeMap<String, u64>,
    /// The first thousand blemishes.
    pub blemishes: Vec<Blemish>,
    /// All blemishes, listed or not.
    pub blemish_count: u64,
}

impl ReadReport {
    /// Whether the file was read without a blemish.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.blemish_count == 0
    }

    /// Records a blemish and updates the counts.
    pub(crate) fn add(&mut self, place: Place, kind: BlemishKind) {
        match &kind {
            BlemishKind::IncompleteScan { .. } | BlemishKind::SampleCount { .. } => {
                self.incomplete_scans += 1;
            }
            BlemishKind::RepeatedMessage { .. } => self.repeated_messages += 1,
            BlemishKind::OutOfOrder { .. } => self.out_of_order_messages += 1,
            BlemishKind::ImplausibleSamples { .. } => self.implausible_messages += 1,
            BlemishKind::UnreadableBytes { count } => self.unreadable_bytes += count,
            BlemishKind::CutOffMessage { found } => self.unreadable_bytes += found,
            BlemishKind::CutOffLine | BlemishKind::LineSamples { .. } => self.incomplete_scans += 1,
            _ => {}
        }
        self.blemish_count += 1;
        if self.blemishes.len() < LISTED {
            self.blemishes.push(Blemish { place, kind });
        }
    }

    /// Counts an event that carries no samples. Names beyond the first hundred share one entry.
    pub(crate) fn count_other(&mut self, name: &str) {
        let known = self.other_events.contains_key(name);
        let name = if known || self.other_events.len() < 100 {
            name
        } else {
            "(others)"
        };
        *self.other_events.entry(name.to_owned()).or_default() += 1;
    }
}

/// `799 whole scans of 3196 messages; 1 incomplete`.
impl fmt::Display for ReadReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} whole scans of {} messages",
            self.whole_scans, self.scan_messages
        )?;
        let mut sign = ';';
        for (count, what) in [
            (self.incomplete_scans, "incomplete"),
            (self.repeated_messages, "messages repeated"),
            (self.out_of_order_messages, "messages out of order"),
            (self.implausible_messages, "messages of foreign bytes"),
            (self.unreadable_bytes, "bytes that belong to no message"),
        ] {
            if count > 0 {
                write!(f, "{sign} {count} {what}")?;
                sign = ',';
            }
        }
        Ok(())
    }
}
