//! The radio over Ethernet: one message a datagram.

use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use super::kernel_stamp::{self, StampPairing};
use super::{Arrival, Link, LinkError, StampedBy};
use crate::host::HostClock;

/// UDP port that the radio listens on.
pub const RADIO_PORT: u16 = 21_210;

/// Datagrams longer than this are of no radio; they are cut off and refused by their length.
const DATAGRAM_BYTES: usize = 2_048;
/// Receive buffer requested of the system, bytes: a few seconds of scans. The system may grant less.
const RECEIVE_BUFFER_BYTES: usize = 4 << 20;

/// A radio's UDP port.
#[derive(Debug)]
pub struct UdpLink {
    peer: SocketAddr,
    socket: UdpSocket,
    clock: HostClock,
    /// How stamps of the kernel are put on the host clock, where it stamps datagrams.
    pairing: Option<StampPairing>,
    buffer: Vec<u8>,
}

impl UdpLink {
    /// Opens a port of the system's choice towards `peer`; datagrams from elsewhere are ignored.
    ///
    /// # Errors
    /// If there is no route to that address.
    pub fn open(peer: SocketAddr, clock: HostClock) -> Result<Self, LinkError> {
        let socket = connect(peer).map_err(|cause| LinkError::Open {
            peer: peer.to_string(),
            cause,
        })?;
        Ok(Self {
            pairing: kernel_stamp::enable(&socket).then(StampPairing::default),
            peer,
            socket,
            clock,
            buffer: vec![0; DATAGRAM_BYTES],
        })
    }

    fn failed(&self, cause: io::Error) -> LinkError {
        let peer = self.peer();
        match cause.kind() {
            io::ErrorKind::ConnectionRefused => LinkError::NothingListens { peer },
            _ => LinkError::Interrupted { peer, cause },
        }
    }
}

fn connect(peer: SocketAddr) -> io::Result<UdpSocket> {
    let local: SocketAddr = match peer {
        SocketAddr::V4(_) => ([0, 0, 0, 0], 0).into(),
        SocketAddr::V6(_) => ([0u16; 8], 0).into(),
    };
    let socket = UdpSocket::bind(local)?;
    enlarge_receive_buffer(&socket);
    socket.connect(peer)?;
    Ok(socket)
}

/// A small buffer loses scans while a disk is slow; a refusal of the system shows in the counts of lost
/// messages.
pub(crate) fn enlarge_receive_buffer(socket: &UdpSocket) {
    #[cfg(unix)]
    let _ = rustix::net::sockopt::set_socket_recv_buffer_size(socket, RECEIVE_BUFFER_BYTES);
    #[cfg(not(unix))]
    let _ = (socket, RECEIVE_BUFFER_BYTES);
}

/// The system's error for "no data arrived in time".
pub(crate) fn is_timeout(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted
    )
}

impl Link for UdpLink {
    fn send(&mut self, body: &[u8]) -> Result<(), LinkError> {
        match self.socket.send(body) {
            Ok(_) => Ok(()),
            Err(cause) => Err(self.failed(cause)),
        }
    }

    fn receive(&mut self, wait: Duration) -> Result<Option<Arrival>, LinkError> {
        let wait = wait.max(Duration::from_millis(1));
        let received = self
            .socket
            .set_read_timeout(Some(wait))
            .and_then(|()| kernel_stamp::receive(&self.socket, &mut self.buffer));
        match received {
            Ok(datagram) => {
                let stamped_ns = self
                    .pairing
                    .as_mut()
                    .and_then(|pairing| pairing.host_ns(self.clock, datagram.stamp?));
                Ok(Some(Arrival {
                    at_ns: stamped_ns.unwrap_or_else(|| self.clock.now_ns()),
                    stamped_by: match stamped_ns {
                        Some(_) => StampedBy::Kernel,
                        None => StampedBy::Program,
                    },
                    body: self.buffer[..datagram.bytes].to_vec(),
                }))
            }
            Err(error) if is_timeout(&error) => Ok(None),
            Err(cause) => Err(self.failed(cause)),
        }
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        // The port stays: a radio continues to send to it.
        self.socket
            .connect(self.peer)
            .map_err(|cause| LinkError::Open {
                peer: self.peer(),
                cause,
            })
    }

    fn peer(&self) -> String {
        self.peer.to_string()
    }

    fn stamped_by(&self) -> StampedBy {
        match self.pairing {
            Some(_) => StampedBy::Kernel,
            None => StampedBy::Program,
        }
    }
}
