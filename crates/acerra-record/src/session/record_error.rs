//! Reasons why a recording cannot begin, or ends.

use std::path::PathBuf;

use thiserror::Error;

use super::settings::SettingsError;
use crate::driver::DriverError;
use crate::gnss::{ConfigureError, SourceFault};
use crate::link::LinkError;
use crate::log::LogWriteError;
use crate::pps::PpsError;

/// Reason why a recording cannot begin, or ends.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The radio.
    #[error(transparent)]
    Radio(#[from] DriverError),
    /// The way to the radio.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The way to the receiver.
    #[error(transparent)]
    Gnss(#[from] SourceFault),
    /// The receiver's settings.
    #[error(transparent)]
    Configure(#[from] ConfigureError),
    /// The pulses per second.
    #[error(transparent)]
    Pps(#[from] PpsError),
    /// The session does not state the address of an instrument.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The log.
    #[error(transparent)]
    Log(#[from] LogWriteError),
    /// The directory.
    #[error("{}: {cause}", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
        /// Error of the system.
        cause: std::io::Error,
    },
    /// The system gives no thread.
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
}
