//! Errors of the readers.

use super::kind::FileKind;

/// Reason for which a file could not be read. The caller adds the path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system, or the gzip stream, failed.
    #[error("cannot read: {0}")]
    Io(#[from] std::io::Error),
    /// The file is empty.
    #[error("the file is empty")]
    Empty,
    /// A line violates its format.
    #[error("line {line}: expected {expected}, found {found:?}")]
    Format {
        /// Line number, from 1.
        line: u64,
        /// Requirement of the format at this place.
        expected: &'static str,
        /// The text found, shortened.
        found: String,
    },
    /// A well-formed file of a kind or version that this reader does not understand.
    #[error("line {line}: {what} is not supported")]
    Unsupported {
        /// Line number, from 1.
        line: u64,
        /// The feature or version.
        what: String,
    },
    /// The header ends without a record that the body needs.
    #[error("the header ends at line {line} without {missing}")]
    MissingHeader {
        /// Line number where the header (or the file) ended.
        line: u64,
        /// The label of the missing record.
        missing: &'static str,
    },
    /// The content is of another kind than requested.
    #[error("expected {expected}, but the content is {found}")]
    WrongKind {
        /// What the caller wanted.
        expected: &'static str,
        /// Apparent kind of the content.
        found: FileKind,
    },
    /// An RTCM 3 log whose messages give the time of the week only.
    #[error(
        "the messages give the time of the week only, and none gives the week: state the date on which the \
         log was recorded"
    )]
    NoDate,
    /// A UBX log without raw measurements.
    #[error(
        "UBX without raw measurements: the receiver must be configured to send UBX-RXM-RAWX (and \
         UBX-RXM-SFRBX for the ephemerides), which some modules cannot"
    )]
    NoMeasurements,
    /// A zip archive that cannot be used.
    #[error("zip archive: {problem}")]
    Archive {
        /// The defect.
        problem: String,
    },
    /// A limit was reached; see [`super::Limits`].
    #[error("{what} exceeds the limit of {limit} bytes")]
    Limit {
        /// What is too large.
        what: &'static str,
        /// The limit in bytes.
        limit: u64,
    },
}

impl ReadError {
    /// A [`ReadError::Format`] with the found text made printable and at most 60 characters long.
    pub(crate) fn format(line: u64, expected: &'static str, found: &[u8]) -> Self {
        let text = String::from_utf8_lossy(found);
        let mut short: String = text.chars().take(60).collect();
        if short.len() < text.len() {
            short.push('…');
        }
        Self::Format {
            line,
            expected,
            found: short,
        }
    }
}
