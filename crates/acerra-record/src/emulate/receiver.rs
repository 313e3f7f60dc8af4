//! A GNSS receiver emulated on a TCP port: a recorded UBX log sent epoch by epoch at its pace.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::epoch_time;
use acerra_gnss::ubx::frame::{self, Frame, Piece, pieces};

use super::marks::time_mark;
use super::no_fix::without_fix;
use super::pulse_line::PulseLine;
use super::world::World;

/// Behaviour of an emulated receiver.
#[derive(Debug, Clone)]
pub struct ReceiverOptions {
    /// The time it lives in.
    pub world: World,
    /// GPS time at the world's beginning; by default that of the first epoch.
    pub starts_at: Option<GpsTime>,
    /// Time from an epoch to its first byte (s).
    pub latency_s: f64,
    /// World times from and to which it has no fix (s).
    pub no_fix_s: Vec<[f64; 2]>,
    /// Pulses on its time-mark input.
    pub pulses: Option<PulseLine>,
}

impl ReceiverOptions {
    /// A receiver without latency whose first epoch is the world's beginning.
    #[must_use]
    pub fn new(world: World) -> Self {
        Self {
            world,
            starts_at: None,
            latency_s: 0.0,
            no_fix_s: Vec::new(),
            pulses: None,
        }
    }
}

/// A receiver emulated by a separate thread, until it is dropped.
pub struct EmulatedReceiver {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    finished: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl EmulatedReceiver {
    /// Emulates a receiver at `address` (port 0 takes any free one) that sends `log` to the first client,
    /// each byte once, at the world's times: bytes that are due before a client connects are sent at once.
    ///
    /// # Errors
    /// If the port is taken, or the system gives no thread.
    pub fn start(address: SocketAddr, log: Vec<u8>, options: ReceiverOptions) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let stop = Arc::new(AtomicBool::new(false));
        let finished = Arc::new(AtomicBool::new(false));
        let server = Server {
            listener,
            bursts: bursts(&log, &options),
            starts_at: options.starts_at.or_else(|| first_epoch(&log)),
            log,
            options,
            stop: Arc::clone(&stop),
            finished: Arc::clone(&finished),
        };
        let thread = std::thread::Builder::new()
            .name("emulated receiver".to_owned())
            .spawn(move || server.run())?;
        Ok(Self {
            address,
            stop,
            finished,
            thread: Some(thread),
        })
    }

    /// Address at which the emulator listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Whether every byte was sent.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.finished.load(Ordering::SeqCst)
    }
}

impl Drop for EmulatedReceiver {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has printed its message.
            let _ = thread.join();
        }
    }
}

/// Time that listening to a client may take (s): systems wake sleepers on sockets by their tick.
const LISTENING_S: f64 = 0.012;

/// Longest time between two reads of a client's messages, however much there is to send.
const LISTEN_EVERY: Duration = Duration::from_millis(200);

/// Bytes that are sent together.
struct Burst {
    /// World time (s).
    at_s: f64,
    /// Where they end in the log.
    end: usize,
}

/// A log cut before each epoch's first message, so that a burst begins with that message; bytes before the
/// first epoch belong to the first burst.
fn bursts(log: &[u8], options: &ReceiverOptions) -> Vec<Burst> {
    let epochs: Vec<(usize, GpsTime)> = pieces(log)
        .filter_map(|piece| match piece {
            Piece::Frame(frame) => Some((frame.offset, epoch_time(&frame)?)),
            _ => None,
        })
        .collect();
    let Some((_, first)) = epochs.first() else {
        return vec![Burst {
            at_s: 0.0,
            end: log.len(),
        }];
    };
    let start = options.starts_at.unwrap_or(*first);
    let ends = epochs.iter().skip(1).map(|(offset, _)| *offset);
    let ends = ends.chain([log.len()]);
    epochs
        .iter()
        .zip(ends)
        .map(|((_, time), end)| Burst {
            at_s: time.seconds_since(start) + options.latency_s,
            end,
        })
        .collect()
}

/// Time of a log's first epoch.
fn first_epoch(log: &[u8]) -> Option<GpsTime> {
    pieces(log).find_map(|piece| match piece {
        Piece::Frame(frame) => epoch_time(&frame),
        _ => None,
    })
}

struct Server {
    listener: TcpListener,
    log: Vec<u8>,
    bursts: Vec<Burst>,
    options: ReceiverOptions,
    /// GPS time at the world's beginning, where the log contains a GPS time.
    starts_at: Option<GpsTime>,
    stop: Arc<AtomicBool>,
    finished: Arc<AtomicBool>,
}

impl Server {
    fn run(self) {
        let mut sent = 0;
        let mut next = 0;
        while !self.stop.load(Ordering::SeqCst) {
            let Ok((client, _)) = self.listener.accept() else {
                std::thread::sleep(Duration::from_millis(5));
                continue;
            };
            // A client that goes away leaves the rest to the next one.
            let _ = self.serve(client, &mut sent, &mut next);
        }
    }

    fn serve(&self, mut client: TcpStream, sent: &mut usize, next: &mut usize) -> io::Result<()> {
        client.set_nonblocking(false)?;
        client.set_nodelay(true)?;
        client.set_read_timeout(Some(Duration::from_millis(1)))?;
        let mut heard = Vec::new();
        let mut listened = Instant::now();
        while !self.stop.load(Ordering::SeqCst) {
            let Some(burst) = self.bursts.get(*next) else {
                self.finished.store(true, Ordering::SeqCst);
                answer(&mut client, &mut heard)?;
                continue;
            };
            let world = &self.options.world;
            let left_s = world
                .now_s()
                .map_or(1.0, |now_s| (burst.at_s - now_s) / world.speed());
            if left_s > LISTENING_S || listened.elapsed() > LISTEN_EVERY {
                answer(&mut client, &mut heard)?;
                listened = Instant::now();
                continue;
            }
            if left_s > 0.0 {
                std::thread::sleep(Duration::from_secs_f64(left_s));
                continue;
            }
            client.write_all(&self.message(*sent, burst))?;
            *sent = burst.end;
            *next += 1;
        }
        Ok(())
    }
}

impl Server {
    /// Bytes sent of the log from `begin` on: the burst, and the latest pulse before it.
    fn message(&self, begin: usize, burst: &Burst) -> Vec<u8> {
        let epoch_s = burst.at_s - self.options.latency_s;
        let bytes = &self.log[begin..burst.end];
        let pulses = self.options.pulses.as_ref();
        let edge = pulses.and_then(|pulses| pulses.latest(epoch_s));
        let mut no_fix_s = self.options.no_fix_s.iter();
        if no_fix_s.any(|[from, to]| (*from..*to).contains(&epoch_s)) {
            return without_fix(bytes);
        }
        let mut message = bytes.to_vec();
        if let (Some(edge), Some(starts_at)) = (edge, self.starts_at) {
            message.extend(time_mark(starts_at + edge.at_s, edge.count));
        }
        message
    }
}

/// Acknowledges each configuration message.
fn answer(client: &mut TcpStream, heard: &mut Vec<u8>) -> io::Result<()> {
    const CFG: u8 = 0x06;
    const ACK: u8 = 0x05;
    let mut buffer = [0; 1024];
    match client.read(&mut buffer) {
        Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
        Ok(bytes) => heard.extend_from_slice(&buffer[..bytes]),
        Err(error) if crate::link::is_timeout(&error) => return Ok(()),
        Err(error) => return Err(error),
    }
    let mut through = 0;
    let mut answers = Vec::new();
    for piece in pieces(heard) {
        if let Piece::Frame(Frame {
            class,
            id,
            payload,
            offset,
        }) = piece
        {
            through = offset + payload.len() + 8;
            if class == CFG {
                answers.extend(frame::encode(ACK, 1, &[class, id]).unwrap_or_default());
            }
        }
    }
    heard.drain(..through.min(heard.len()));
    client.write_all(&answers)
}
