//! The radio over USB or a serial line: messages behind a prefix on a stream of bytes.

use std::io;
use std::time::Duration;

use serialport::SerialPort;

use super::framing::{Deframer, frame_body};
use super::udp::is_timeout;
use super::{Arrival, Link, LinkError, StampedBy};
use crate::host::HostClock;
use crate::message::MAX_MESSAGE_BYTES;

/// A serial port with the radio at its other end.
pub struct SerialLink {
    path: String,
    baud: u32,
    port: Box<dyn SerialPort>,
    clock: HostClock,
    deframer: Deframer,
    /// When the bytes now in the deframer came.
    latest_ns: u64,
}

impl SerialLink {
    /// Opens the port `path` (`/dev/ttyACM0`, `COM3`). USB ports take any rate.
    ///
    /// # Errors
    /// If there is no such port, or this user may not open it.
    pub fn open(path: &str, baud: u32, clock: HostClock) -> Result<Self, LinkError> {
        Ok(Self {
            path: path.to_owned(),
            baud,
            port: open_port(path, baud)?,
            clock,
            deframer: Deframer::default(),
            latest_ns: 0,
        })
    }

    /// Bytes so far that belong to no message.
    #[must_use]
    pub fn skipped_bytes(&self) -> u64 {
        self.deframer.skipped_bytes()
    }

    fn failed(&self, cause: io::Error) -> LinkError {
        LinkError::Interrupted {
            peer: self.peer(),
            cause,
        }
    }
}

/// Opens a serial port: 8 data bits, no parity, 1 stop bit, no flow control.
///
/// # Errors
/// If there is no such port, or this user may not open it.
pub fn open_port(path: &str, baud: u32) -> Result<Box<dyn SerialPort>, LinkError> {
    serialport::new(path, baud)
        .timeout(Duration::from_millis(10))
        .open()
        .map_err(|cause| LinkError::Open {
            peer: path.to_owned(),
            cause: cause.into(),
        })
}

impl Link for SerialLink {
    fn send(&mut self, body: &[u8]) -> Result<(), LinkError> {
        let framed = frame_body(body).ok_or(LinkError::TooLong {
            found: body.len(),
            limit: MAX_MESSAGE_BYTES,
        })?;
        io::Write::write_all(&mut self.port, &framed).map_err(|cause| self.failed(cause))
    }

    fn receive(&mut self, wait: Duration) -> Result<Option<Arrival>, LinkError> {
        let until_ns = self.clock.now_ns() + wait.as_nanos() as u64;
        let mut buffer = [0; 4096];
        loop {
            if let Some(body) = self.deframer.next_body() {
                return Ok(Some(Arrival {
                    at_ns: self.latest_ns,
                    stamped_by: StampedBy::Program,
                    body,
                }));
            }
            let left_ns = until_ns.saturating_sub(self.clock.now_ns());
            if left_ns == 0 {
                return Ok(None);
            }
            let read = self
                .port
                .set_timeout(Duration::from_nanos(left_ns).max(Duration::from_millis(1)))
                .map_err(io::Error::from)
                .and_then(|()| io::Read::read(&mut self.port, &mut buffer));
            match read {
                Ok(0) => return Err(self.failed(io::ErrorKind::UnexpectedEof.into())),
                Ok(bytes) => {
                    self.latest_ns = self.clock.now_ns();
                    self.deframer.push(&buffer[..bytes]);
                }
                Err(error) if is_timeout(&error) => {}
                Err(cause) => return Err(self.failed(cause)),
            }
        }
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        self.port = open_port(&self.path, self.baud)?;
        self.deframer = Deframer::default();
        Ok(())
    }

    fn peer(&self) -> String {
        self.path.clone()
    }
}
