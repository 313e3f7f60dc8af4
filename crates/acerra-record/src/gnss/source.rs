//! Bytes of a receiver, from TCP or a serial port.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use thiserror::Error;

use crate::link::{LinkError, is_timeout, open_port};

/// Time to wait for a connection.
const CONNECT: Duration = Duration::from_secs(3);

/// Reason why no bytes come.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SourceFault {
    /// No connection.
    #[error("GNSS receiver at {place}: {cause}")]
    Open {
        /// Address or port.
        place: String,
        /// Error of the system.
        cause: io::Error,
    },
    /// The connection ended.
    #[error("GNSS receiver at {place}: the connection ended: {cause}")]
    Ended {
        /// Address or port.
        place: String,
        /// Error of the system.
        cause: io::Error,
    },
}

/// A stream of a receiver's bytes that can be written to and opened again.
pub trait ByteSource: Send {
    /// Reads the available bytes into `buffer`, waiting a tenth of a second at most; 0 where none arrived.
    ///
    /// # Errors
    /// If the connection ended.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, SourceFault>;

    /// Sends bytes to the receiver.
    ///
    /// # Errors
    /// If the connection ended.
    fn write(&mut self, bytes: &[u8]) -> Result<(), SourceFault>;

    /// Opens the connection again.
    ///
    /// # Errors
    /// If that is not possible yet.
    fn reopen(&mut self) -> Result<(), SourceFault>;
}

/// Common operations of the two kinds of connection.
fn read_some(
    place: &dyn Fn() -> String,
    stream: &mut impl Read,
    buffer: &mut [u8],
) -> Result<usize, SourceFault> {
    let ended = |cause| SourceFault::Ended {
        place: place(),
        cause,
    };
    match stream.read(buffer) {
        Ok(0) => Err(ended(io::ErrorKind::UnexpectedEof.into())),
        Ok(bytes) => Ok(bytes),
        Err(e) if is_timeout(&e) => Ok(0),
        Err(cause) => Err(ended(cause)),
    }
}

/// A receiver behind a TCP server, such as `str2str`, `ser2net` or the receiver itself.
#[derive(Debug)]
pub struct TcpSource {
    address: SocketAddr,
    stream: TcpStream,
}

impl TcpSource {
    /// Connects.
    ///
    /// # Errors
    /// If nothing listens there.
    pub fn open(address: SocketAddr) -> Result<Self, SourceFault> {
        Ok(Self {
            address,
            stream: connect(address)?,
        })
    }
}

fn connect(address: SocketAddr) -> Result<TcpStream, SourceFault> {
    let open = || {
        let stream = TcpStream::connect_timeout(&address, CONNECT)?;
        stream.set_read_timeout(Some(Duration::from_millis(100)))?;
        stream.set_nodelay(true)?;
        Ok(stream)
    };
    open().map_err(|cause| SourceFault::Open {
        place: address.to_string(),
        cause,
    })
}

impl ByteSource for TcpSource {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, SourceFault> {
        let address = self.address;
        read_some(&|| address.to_string(), &mut self.stream, buffer)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), SourceFault> {
        self.stream
            .write_all(bytes)
            .map_err(|cause| SourceFault::Ended {
                place: self.address.to_string(),
                cause,
            })
    }

    fn reopen(&mut self) -> Result<(), SourceFault> {
        self.stream = connect(self.address)?;
        Ok(())
    }
}

/// A receiver on a serial or USB port.
pub struct SerialSource {
    path: String,
    baud: u32,
    port: Box<dyn serialport::SerialPort>,
}

impl SerialSource {
    /// Opens the port.
    ///
    /// # Errors
    /// If there is no such port, or this user may not open it.
    pub fn open(path: &str, baud: u32) -> Result<Self, SourceFault> {
        Ok(Self {
            path: path.to_owned(),
            baud,
            port: open_serial(path, baud)?,
        })
    }
}

fn open_serial(path: &str, baud: u32) -> Result<Box<dyn serialport::SerialPort>, SourceFault> {
    let fault = |cause| SourceFault::Open {
        place: path.to_owned(),
        cause,
    };
    let mut port = open_port(path, baud).map_err(|error| match error {
        LinkError::Open { cause, .. } => fault(cause),
        other => fault(io::Error::other(other)),
    })?;
    port.set_timeout(Duration::from_millis(100))
        .map_err(|e| fault(e.into()))?;
    Ok(port)
}

impl ByteSource for SerialSource {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, SourceFault> {
        let path = &self.path;
        read_some(&|| path.clone(), &mut self.port, buffer)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), SourceFault> {
        self.port
            .write_all(bytes)
            .map_err(|cause| SourceFault::Ended {
                place: self.path.clone(),
                cause,
            })
    }

    fn reopen(&mut self) -> Result<(), SourceFault> {
        self.port = open_serial(&self.path, self.baud)?;
        Ok(())
    }
}
