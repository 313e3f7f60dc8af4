//! Errors of requests to a radio.

use std::time::Duration;

use thiserror::Error;

use super::setup::Mismatch;
use crate::link::LinkError;
use crate::message::StatusCode;

/// Reason why a request failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DriverError {
    /// The link does not carry messages.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// No confirm came.
    #[error(
        "{peer}: no answer to {request} in {attempts} attempts of {:.1} s; is the radio on, the cable in, the \
         address right, and this computer in its network?",
        timeout.as_secs_f64()
    )]
    Silent {
        /// The other end.
        peer: String,
        /// Name of the request.
        request: &'static str,
        /// Times it was sent.
        attempts: u32,
        /// Time waited each time.
        timeout: Duration,
    },
    /// The radio refuses.
    #[error("{peer}: the radio refuses {request}: {status}")]
    Refused {
        /// The other end.
        peer: String,
        /// Name of the request.
        request: &'static str,
        /// Answer.
        status: StatusCode,
    },
    /// The radio confirms a configuration and has another.
    #[error(
        "{peer}: the radio took {} = {}, and reads back {}",
        mismatch.field, mismatch.wanted, mismatch.found
    )]
    ReadBack {
        /// The other end.
        peer: String,
        /// Difference.
        mismatch: Mismatch,
    },
}
