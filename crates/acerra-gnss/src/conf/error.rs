//! Errors of configuration files.

use std::path::PathBuf;

use crate::input::ReadError;

/// Reason for which a configuration cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConfError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A line is neither empty, a comment, nor `key = value`.
    #[error("line {line}: expected key = value, found {found:?}")]
    Line {
        /// Line number, from 1.
        line: u64,
        /// The line, shortened.
        found: String,
    },
    /// A value is invalid for its key.
    #[error("line {line}: {key}: expected {expected}, found {found:?}")]
    Value {
        /// Line number, from 1.
        line: u64,
        /// The key.
        key: String,
        /// The values accepted.
        expected: String,
        /// The value given.
        found: String,
    },
    /// A file that the configuration names and needs is not there.
    #[error("line {line}: {key} = {name}: no such file: neither {} nor {name} in the current folder", tried.display())]
    MissingFile {
        /// Line number, from 1.
        line: u64,
        /// The key.
        key: String,
        /// The name given.
        name: String,
        /// The path searched first.
        tried: PathBuf,
    },
    /// The file asks for a kind of processing that is not offered.
    #[error("line {line}: {key} = {value} is not supported")]
    Unsupported {
        /// Line number, from 1.
        line: u64,
        /// The key.
        key: String,
        /// The value given.
        value: String,
    },
}
