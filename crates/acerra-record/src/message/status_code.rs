//! The radio's answer to a request.

use std::fmt;

/// Status word of a confirm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StatusCode {
    /// The request was carried out (0).
    Success,
    /// Refused without a reason (1).
    Failure,
    /// The radio is in another operating mode (2).
    WrongMode,
    /// A value that the radio does not support (3).
    UnsupportedValue,
    /// Any other code.
    Other(u32),
}

impl StatusCode {
    /// From the status word.
    #[must_use]
    pub fn from_code(code: u32) -> Self {
        match code {
            0 => Self::Success,
            1 => Self::Failure,
            2 => Self::WrongMode,
            3 => Self::UnsupportedValue,
            other => Self::Other(other),
        }
    }

    /// The status word.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Self::Success => 0,
            Self::Failure => 1,
            Self::WrongMode => 2,
            Self::UnsupportedValue => 3,
            Self::Other(code) => code,
        }
    }
}

impl fmt::Display for StatusCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Success => f.write_str("success"),
            Self::Failure => f.write_str("failure without a reason (status 1)"),
            Self::WrongMode => f.write_str("wrong operating mode (status 2)"),
            Self::UnsupportedValue => f.write_str("unsupported value (status 3)"),
            Self::Other(code) => write!(f, "status {code}"),
        }
    }
}
