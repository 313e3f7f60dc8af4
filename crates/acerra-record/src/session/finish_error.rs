//! Reasons why a session cannot be finished.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use super::settings::SettingsError;
use crate::log::LogReadError;

/// Reason why a session cannot be finished.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FinishError {
    /// A file of the directory.
    #[error("{}: {cause}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
    /// The log.
    #[error("{}: {cause}", path.display())]
    Log {
        /// The file.
        path: PathBuf,
        /// Reason why it cannot be read.
        cause: LogReadError,
    },
    /// The log holds no session, or an invalid one.
    #[error("{}: the settings in the log: {cause}", path.display())]
    Settings {
        /// The log.
        path: PathBuf,
        /// Defect found.
        cause: SettingsError,
    },
}
