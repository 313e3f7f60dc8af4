//! An emulated radio, to be held by who needs it.

use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use super::options::{EmulatorCounts, EmulatorOptions};
use super::server::{Orders, Server};
use super::source::ScanSource;

/// A radio emulated on the loopback interface by a separate thread, until it is dropped.
pub struct EmulatedRadio {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    reboot: Arc<AtomicBool>,
    counts: Arc<Mutex<EmulatorCounts>>,
    thread: Option<JoinHandle<()>>,
}

impl EmulatedRadio {
    /// Emulates a radio at `address`; port 0 takes any free one.
    ///
    /// # Errors
    /// If the port is taken, or the system gives no thread.
    pub fn start(
        address: SocketAddr,
        source: Box<dyn ScanSource>,
        options: EmulatorOptions,
    ) -> io::Result<Self> {
        let socket = UdpSocket::bind(address)?;
        let address = socket.local_addr()?;
        let stop = Arc::new(AtomicBool::new(false));
        let reboot = Arc::new(AtomicBool::new(false));
        let counts = Arc::new(Mutex::new(EmulatorCounts::default()));
        let mut server = Server::new(socket, source, options);
        server.orders = Orders {
            stop: Arc::clone(&stop),
            reboot: Arc::clone(&reboot),
            counts: Arc::clone(&counts),
        };
        let thread = std::thread::Builder::new()
            .name("emulated radio".to_owned())
            .spawn(move || server.run())?;
        Ok(Self {
            address,
            stop,
            reboot,
            counts,
            thread: Some(thread),
        })
    }

    /// Address at which the emulator listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Restarts the radio now.
    pub fn reboot(&self) {
        self.reboot.store(true, Ordering::SeqCst);
    }

    /// Actions so far.
    #[must_use]
    pub fn counts(&self) -> EmulatorCounts {
        *self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for EmulatedRadio {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has printed its message.
            let _ = thread.join();
        }
    }
}
