//! Radio and receiver on serial lines: pseudo-terminals with the emulators at their other ends.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures

use std::fs;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::os::unix::ffi::OsStrExt as _;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use acerra_gnss::ubx::frame::encode;
use acerra_record::driver::{RequestOptions, WatchOptions};
use acerra_record::emulate::{
    EmulatedRadio, EmulatedReceiver, EmulatorOptions, Pattern, ReceiverOptions, World,
};
use acerra_record::link::{Deframer, frame_body};
use acerra_record::session::{Progress, ROVER_NAME, Recorder, Session, finish};

const LOOPBACK: ([u8; 4], u16) = ([127, 0, 0, 1], 0);

/// The device end of a serial line.
trait Device: Send {
    /// Takes bytes that the computer wrote.
    fn take(&mut self, bytes: &[u8]);
    /// Bytes for the computer, where there are any by now.
    fn give(&mut self) -> Vec<u8>;
}

/// An emulated radio, its messages framed for a serial line.
struct RadioPort {
    socket: UdpSocket,
    deframer: Deframer,
}

impl RadioPort {
    fn new(radio: SocketAddr) -> Self {
        let socket = UdpSocket::bind(SocketAddr::from(LOOPBACK)).unwrap();
        socket.connect(radio).unwrap();
        socket.set_nonblocking(true).unwrap();
        Self {
            socket,
            deframer: Deframer::default(),
        }
    }
}

impl Device for RadioPort {
    fn take(&mut self, bytes: &[u8]) {
        self.deframer.push(bytes);
        while let Some(body) = self.deframer.next_body() {
            self.socket.send(&body).unwrap();
        }
    }

    fn give(&mut self) -> Vec<u8> {
        let mut body = [0; 2048];
        match self.socket.recv(&mut body) {
            Ok(bytes) => frame_body(&body[..bytes]).unwrap(),
            Err(_) => Vec::new(),
        }
    }
}

/// An emulated receiver.
struct ReceiverPort(TcpStream);

impl Device for ReceiverPort {
    fn take(&mut self, bytes: &[u8]) {
        self.0.write_all(bytes).unwrap();
    }

    fn give(&mut self) -> Vec<u8> {
        let mut buffer = [0; 4096];
        match self.0.read(&mut buffer) {
            Ok(bytes) => buffer[..bytes].to_vec(),
            Err(_) => Vec::new(),
        }
    }
}

/// A cable from a device to a port of this computer; dropped, it is pulled.
struct Cable {
    pulled: Arc<AtomicBool>,
    thread: Option<JoinHandle<Box<dyn Device>>>,
}

impl Cable {
    /// Plugs a device in: `port` names the computer's end from now on.
    fn plug(port: &Path, mut device: Box<dyn Device>) -> Self {
        let flags = rustix::pty::OpenptFlags::RDWR | rustix::pty::OpenptFlags::NOCTTY;
        let end = rustix::pty::openpt(flags).unwrap();
        rustix::pty::grantpt(&end).unwrap();
        rustix::pty::unlockpt(&end).unwrap();
        let name = rustix::pty::ptsname(&end, Vec::new()).unwrap();
        rustix::io::ioctl_fionbio(&end, true).unwrap();
        // Bytes that come before the computer opens its end are not edited as a keyboard's.
        let mut raw = rustix::termios::tcgetattr(&end).unwrap();
        raw.make_raw();
        rustix::termios::tcsetattr(&end, rustix::termios::OptionalActions::Now, &raw).unwrap();
        // A port that comes back has its old name.
        let aside = port.with_extension("new");
        std::os::unix::fs::symlink(std::ffi::OsStr::from_bytes(name.as_bytes()), &aside).unwrap();
        fs::rename(&aside, port).unwrap();
        let pulled = Arc::new(AtomicBool::new(false));
        let is_pulled = Arc::clone(&pulled);
        let thread = std::thread::spawn(move || {
            carry(fs::File::from(end), &mut *device, &is_pulled);
            device
        });
        Self {
            pulled,
            thread: Some(thread),
        }
    }

    /// Pulls it; the device is left.
    fn pull(mut self) -> Box<dyn Device> {
        self.pulled.store(true, Ordering::SeqCst);
        self.thread.take().unwrap().join().unwrap()
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        self.pulled.store(true, Ordering::SeqCst);
    }
}

fn carry(mut end: fs::File, device: &mut dyn Device, is_pulled: &AtomicBool) {
    let mut buffer = [0; 4096];
    let mut waiting = Vec::new();
    while !is_pulled.load(Ordering::SeqCst) {
        // Until the computer opens its end, and while nothing comes, reading fails.
        if let Ok(bytes) = end.read(&mut buffer) {
            device.take(&buffer[..bytes]);
        }
        if waiting.is_empty() {
            waiting = device.give();
        }
        match end.write(&waiting) {
            Ok(0) => std::thread::sleep(Duration::from_millis(1)),
            Ok(bytes) => drop(waiting.drain(..bytes)),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                std::thread::sleep(Duration::from_millis(1));
            }
            Err(error) => panic!("{error}"),
        }
    }
}

/// RXM-RAWX without satellites, five times a second for so many seconds.
fn receiver_log(seconds: u32) -> Vec<u8> {
    let mut log = Vec::new();
    for epoch in 0..5 * seconds {
        let mut payload = vec![0; 16];
        payload[..8].copy_from_slice(&(1000.0 + 0.2 * f64::from(epoch)).to_le_bytes());
        payload[8..10].copy_from_slice(&2345_u16.to_le_bytes());
        log.extend(encode(0x02, 0x15, &payload).unwrap());
    }
    log
}

fn at(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

/// A whole session over serial lines; the radio's cable is pulled for a while.
#[test]
fn a_session_over_serial_lines_survives_a_pulled_cable() {
    let world = World::new(1.0);
    let options = EmulatorOptions {
        world: Some((world.clone(), 0.0)),
        ..EmulatorOptions::default()
    };
    let source = Box::new(Pattern::new(1_000));
    let radio = EmulatedRadio::start(LOOPBACK.into(), source, options).unwrap();
    let log = receiver_log(8);
    let receiver =
        EmulatedReceiver::start(LOOPBACK.into(), log.clone(), ReceiverOptions::new(world)).unwrap();
    let stream = TcpStream::connect(receiver.address()).unwrap();
    stream.set_nonblocking(true).unwrap();

    let folder = tempfile::tempdir().unwrap();
    let [radio_port, receiver_port] = ["radio", "receiver"].map(|name| folder.path().join(name));
    let mut cable = Some(Cable::plug(
        &radio_port,
        Box::new(RadioPort::new(radio.address())),
    ));
    let mut unplugged: Option<Box<dyn Device>> = None;
    let _receiver_cable = Cable::plug(&receiver_port, Box::new(ReceiverPort(stream)));
    let text = format!(
        "[radio]\nserial = {:?}\nwindow_ps = [0, 11000]\nscan_interval_ms = 50.0\n[gnss]\nserial = {:?}\n\
         receiver = \"m8t\"\n",
        at(folder.path(), "radio"),
        at(folder.path(), "receiver")
    );
    let session = Session::parse(&text).unwrap();
    let stop = AtomicBool::new(false);
    let directory = folder.path().join("flight");
    let recorder = Recorder {
        session: &session,
        text: &text,
        directory: &directory,
        stop: &stop,
        requests: RequestOptions {
            timeout: Duration::from_millis(300),
            attempts: 5,
        },
        watch: WatchOptions {
            silence: Duration::from_millis(500),
            retry: Duration::from_millis(50),
            status_every: Duration::ZERO,
        },
        tap: None,
    };
    let began = Instant::now();
    let mut told = Vec::new();
    let health = recorder
        .run(&mut |progress| {
            assert!(
                began.elapsed() < Duration::from_secs(60),
                "stalled: {told:?}"
            );
            match progress {
                Progress::Note(text) | Progress::Warning(text) => {
                    if text.starts_with("no scan for") {
                        // Plugged in again once it is missed.
                        let device = unplugged.take().unwrap();
                        cable = Some(Cable::plug(&radio_port, device));
                    }
                    told.push(text);
                }
                Progress::Health(health) => {
                    if health.radio.whole_scans > 30
                        && health.radio.silences == 0
                        && unplugged.is_none()
                        && let Some(cable) = cable.take()
                    {
                        unplugged = Some(cable.pull());
                    }
                    stop.store(receiver.is_finished(), Ordering::SeqCst);
                }
            }
        })
        .unwrap();
    println!("{}\n{told:#?}", health.radio);
    let says = |what: &str| told.iter().any(|text| text.contains(what));
    assert!(says("its messages are stamped by this program"), "{told:?}");
    assert!(says("radio: the link is interrupted"), "{told:?}");
    assert!(says("the radio scans again after"), "{told:?}");
    let counts = health.radio;
    assert_eq!((counts.silences, counts.undecodable), (1, 0));
    assert!(counts.whole_scans > 60, "{counts}");
    assert_eq!(health.kernel_stamped, 0);

    let finished = finish(&directory).unwrap();
    assert_eq!(finished.scans, counts.whole_scans);
    // Every byte of the receiver, acknowledgements of its configuration among them.
    let rover = fs::read(directory.join(ROVER_NAME)).unwrap();
    let acknowledged = 5 * encode(5, 1, &[6, 1]).unwrap().len();
    assert_eq!(rover.len(), log.len() + acknowledged);
    assert!(rover.ends_with(&log[log.len() - 100..]));
    let clock = finished.clock.unwrap();
    assert_eq!((clock.gps_week, clock.marks), (2345, 0));
}
