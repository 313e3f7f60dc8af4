//! Why a file cannot be read.

use std::fmt;
use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// A place in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// A byte, counted from 0.
    Byte(u64),
    /// A line, counted from 1.
    Line(u64),
    /// A trace, counted from 1.
    Trace(u64),
    /// A named field of a header, a key or an array.
    Field(String),
    /// The file as a whole.
    Whole,
}

impl Place {
    /// A named field.
    pub(crate) fn field(name: impl Into<String>) -> Self {
        Self::Field(name.into())
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Byte(at) => write!(f, "byte {at}"),
            Self::Line(at) => write!(f, "line {at}"),
            Self::Trace(at) => write!(f, "trace {at}"),
            Self::Field(name) => write!(f, "{name}"),
            Self::Whole => f.write_str("the file"),
        }
    }
}

/// Why a file cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The content violates the format.
    #[error("{place}: expected {expected}, found {found}")]
    Content {
        /// Where.
        place: Place,
        /// What was expected there.
        expected: String,
        /// What was found.
        found: String,
    },
    /// The file, or the size in its header, exceeds the reader's limit.
    #[error("{place}: expected at most {limit} {what}, found {found}")]
    TooLarge {
        /// Where.
        place: Place,
        /// What is counted.
        what: &'static str,
        /// The limit.
        limit: u64,
        /// How many there are.
        found: u64,
    },
    /// The content is of no kind that is read.
    #[error(
        "expected a radar file (SEG-Y, DZT, DT1 with HD, rd3 or rd7 with rad, gprMax, HDF5, MATLAB, Touchstone, \
         analyser CSV, FMCW), found another kind"
    )]
    Unrecognised,
    /// A file without a header of its own lacks the file that describes it.
    #[error("expected {expected} next to it, found none")]
    NoCompanion {
        /// The companion.
        expected: String,
    },
    /// A file next to the named one.
    #[error("{}: {cause}", path.display())]
    Companion {
        /// The companion.
        path: PathBuf,
        /// What is wrong with it.
        cause: Box<FormatError>,
    },
    /// The operating system does not deliver the bytes.
    #[error(transparent)]
    Io(#[from] io::Error),
}

impl FormatError {
    pub(crate) fn content(
        place: Place,
        expected: impl Into<String>,
        found: impl fmt::Display,
    ) -> Self {
        Self::Content {
            place,
            expected: expected.into(),
            found: found.to_string(),
        }
    }
}
