//! Connections: a few at a time without the token, and a bounded number with it, so that no program uses up
//! the descriptors that a recording in the same process needs.

use std::collections::{HashSet, VecDeque};
use std::future::Future;
use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};

use axum::extract::connect_info::Connected;
use axum::serve::{IncomingStream, Listener};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot::{Receiver, Sender, channel};

/// Most connections at a time that have not shown the token; a browser opens six.
pub const MOST_STRANGERS: usize = 16;

/// Most connections at a time with the token and without a time limit; further ones count as those without
/// the token.
pub const MOST_KNOWN: usize = 64;

/// Fewest connections with the token, however few descriptors the process may open: a page takes two.
const FEWEST_KNOWN: usize = 8;

/// Descriptors that are reserved for a recording in the same process and for the products made of it.
const RESERVED_DESCRIPTORS: usize = 128;

/// Most connections with the token for a process that may open so many descriptors.
fn most_known(descriptors: usize) -> usize {
    descriptors
        .saturating_sub(RESERVED_DESCRIPTORS + MOST_STRANGERS)
        .clamp(FEWEST_KNOWN, MOST_KNOWN)
}

/// Descriptors that this process may open.
fn descriptor_limit() -> usize {
    #[cfg(unix)]
    let limit = rustix::process::getrlimit(rustix::process::Resource::Nofile).current;
    #[cfg(not(unix))]
    let limit: Option<u64> = None;
    limit.map_or(usize::MAX, |limit| {
        usize::try_from(limit).unwrap_or(usize::MAX)
    })
}

/// Numbers of the connections that have shown the token.
type Known = Arc<Mutex<HashSet<u64>>>;

/// Handle that closes each connection without the token, the oldest first, with its number.
type Strangers = Arc<Mutex<VecDeque<(u64, Sender<()>)>>>;

/// A listener that closes the oldest connection without the token where there are too many.
pub struct Connections {
    listener: TcpListener,
    strangers: Strangers,
    known: Known,
    most_known: usize,
    accepted: u64,
}

impl Connections {
    /// Those that `listener` accepts.
    pub fn new(listener: TcpListener) -> Self {
        Self {
            listener,
            strangers: Strangers::default(),
            known: Known::default(),
            most_known: most_known(descriptor_limit()),
            accepted: 0,
        }
    }
}

/// A connection of one caller.
#[derive(Clone)]
pub struct Caller {
    number: u64,
    strangers: Strangers,
    known: Known,
    most_known: usize,
}

impl Caller {
    /// Notes that the caller has shown the token: its connection stays as long as it likes, where not too many do.
    pub fn is_known(&self) {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() < self.most_known && known.insert(self.number) {
            forget(&self.strangers, self.number);
        }
    }
}

/// Drops the handle that would close a connection.
fn forget(strangers: &Strangers, number: u64) {
    let mut strangers = strangers.lock().unwrap_or_else(PoisonError::into_inner);
    strangers.retain(|(other, _)| *other != number);
}

impl Connected<IncomingStream<'_, Connections>> for Caller {
    fn connect_info(stream: IncomingStream<'_, Connections>) -> Self {
        stream.io().caller.clone()
    }
}

impl Listener for Connections {
    type Io = Connection;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Connection, SocketAddr) {
        let (stream, address) = Listener::accept(&mut self.listener).await;
        self.accepted += 1;
        let (close, closed) = channel();
        let caller = Caller {
            number: self.accepted,
            strangers: Arc::clone(&self.strangers),
            known: Arc::clone(&self.known),
            most_known: self.most_known,
        };
        let mut strangers = self
            .strangers
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if strangers.len() >= MOST_STRANGERS
            && let Some((_, close)) = strangers.pop_front()
        {
            // A connection that has ended needs no closing.
            let _ = close.send(());
        }
        strangers.push_back((caller.number, close));
        drop(strangers);
        let connection = Connection {
            stream,
            closed: Some(closed),
            caller,
        };
        (connection, address)
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        TcpListener::local_addr(&self.listener)
    }
}

/// An accepted connection.
pub struct Connection {
    stream: TcpStream,
    /// Notified when the connection is to be closed; none once it cannot be notified any more.
    closed: Option<Receiver<()>>,
    caller: Caller,
}

impl Drop for Connection {
    fn drop(&mut self) {
        let Caller {
            number,
            strangers,
            known,
            ..
        } = &self.caller;
        forget(strangers, *number);
        let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
        known.remove(number);
    }
}

impl Connection {
    /// Fails where the connection is to be closed.
    fn check(&mut self, context: &mut Context<'_>) -> io::Result<()> {
        let Some(closed) = &mut self.closed else {
            return Ok(());
        };
        match Pin::new(closed).poll(context) {
            Poll::Ready(Ok(())) => Err(io::ErrorKind::ConnectionAborted.into()),
            Poll::Ready(Err(_)) => {
                self.closed = None;
                Ok(())
            }
            Poll::Pending => Ok(()),
        }
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        self.check(context)?;
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        self.check(context)?;
        Pin::new(&mut self.stream).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptors_are_left_to_a_recording() {
        assert_eq!([1024, 180, 64].map(most_known), [64, 36, 8]);
        assert_eq!(most_known(usize::MAX), MOST_KNOWN);
    }
}
