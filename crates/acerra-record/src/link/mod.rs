//! How messages travel between the radio and this computer.

mod framing;
mod kernel_stamp;
mod serial;
mod udp;

use std::io;
use std::time::Duration;

use thiserror::Error;

pub use framing::{Deframer, frame_body};
pub(crate) use kernel_stamp::StampPairing;
pub use serial::{SerialLink, open_port};
pub(crate) use udp::is_timeout;
pub use udp::{RADIO_PORT, UdpLink};

/// A message body as it came, with the time of its arrival.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arrival {
    /// Host clock at its arrival, ns.
    pub at_ns: u64,
    /// What that time is of.
    pub stamped_by: StampedBy,
    /// The body, without a link's prefix.
    pub body: Vec<u8>,
}

/// Where the time of an arrival comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StampedBy {
    /// The kernel, when the network interface handed the datagram over (`SO_TIMESTAMPNS`).
    Kernel,
    /// This program, just after the system handed the bytes over.
    Program,
}

/// `by the kernel at reception`.
impl std::fmt::Display for StampedBy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Kernel => "by the kernel at reception",
            Self::Program => "by this program when it reads them",
        })
    }
}

/// A way to one radio.
pub trait Link {
    /// Sends one message body.
    ///
    /// # Errors
    /// The system's error on the link.
    fn send(&mut self, body: &[u8]) -> Result<(), LinkError>;

    /// The next message body; `None` where none came within `wait`.
    ///
    /// # Errors
    /// The system's error on the link.
    fn receive(&mut self, wait: Duration) -> Result<Option<Arrival>, LinkError>;

    /// Opens the link again after it failed, as after a cable was pulled.
    ///
    /// # Errors
    /// If it cannot be opened yet.
    fn reopen(&mut self) -> Result<(), LinkError>;

    /// The other end, for messages.
    fn peer(&self) -> String;

    /// Where the times of arrivals come from as a rule.
    fn stamped_by(&self) -> StampedBy {
        StampedBy::Program
    }
}

/// Reason why a link does not carry messages.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LinkError {
    /// The address is none, or has no route.
    #[error("{peer}: {cause}")]
    Open {
        /// The other end.
        peer: String,
        /// Error of the system.
        cause: io::Error,
    },
    /// The other computer reports that no program listens at that port.
    #[error(
        "{peer}: no program listens there; expected a radio, whose port is {RADIO_PORT} (check address and \
         port)"
    )]
    NothingListens {
        /// The other end.
        peer: String,
    },
    /// The link is interrupted: a cable pulled, an interface down.
    #[error("{peer}: the link is interrupted: {cause}")]
    Interrupted {
        /// The other end.
        peer: String,
        /// Error of the system.
        cause: io::Error,
    },
    /// A message too long for the link.
    #[error("message of {found} bytes; expected {limit} at most")]
    TooLong {
        /// Length.
        found: usize,
        /// The longest.
        limit: usize,
    },
}

impl<L: Link + ?Sized> Link for Box<L> {
    fn send(&mut self, body: &[u8]) -> Result<(), LinkError> {
        (**self).send(body)
    }

    fn receive(&mut self, wait: Duration) -> Result<Option<Arrival>, LinkError> {
        (**self).receive(wait)
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        (**self).reopen()
    }

    fn peer(&self) -> String {
        (**self).peer()
    }

    fn stamped_by(&self) -> StampedBy {
        (**self).stamped_by()
    }
}
