//! The emulated radio's thread on a UDP port.

use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use acerra_radar::mrm::{RadarConfig, ScanHeader};

use super::channel::Channel;
use super::numbering::{Numbering, Renumber};
use super::options::{EmulatorCounts, EmulatorOptions};
use super::radio::{Effect, RadioState};
use super::source::{ScanSource, SourceScan};
use crate::message::{MAX_MESSAGE_BYTES, Packet};

/// Largest delay of a system in waking a thread that waits on a socket.
const TICK: Duration = Duration::from_millis(8);

/// Commands to an emulated radio from its owner, and counts reported to the owner.
#[derive(Default)]
pub(super) struct Orders {
    /// The radio is to end.
    pub stop: Arc<AtomicBool>,
    /// It is to restart.
    pub reboot: Arc<AtomicBool>,
    /// Actions so far.
    pub counts: Arc<Mutex<EmulatorCounts>>,
}

/// An outgoing message with its destination.
type Outgoing = (SocketAddr, Vec<u8>);

pub(super) struct Server {
    socket: UdpSocket,
    source: Box<dyn ScanSource>,
    options: EmulatorOptions,
    state: RadioState,
    channel: Channel<Outgoing>,
    /// Commands from the radio's owner, and counts reported to the owner.
    pub orders: Orders,
    began: Instant,
    /// Who asked for scans.
    client: Option<SocketAddr>,
    /// The next scan, not yet made.
    next: Option<SourceScan>,
    /// Emulator time (µs) at which scan time `radio_us` = `source_us` is sent.
    anchor: Option<Anchor>,
    /// Numbers and stamps of the scans to come.
    numbering: Numbering,
    /// Added to the source's numbers and stamps.
    renumber: Renumber,
    /// Source time of the first scan of all, µs.
    first_us: Option<u64>,
    /// Emulator time at which the client last asked for scans.
    started_us: u64,
    /// Emulator time of the last power-on, and the radio clock then.
    booted_us: u64,
    boot_clock_us: u64,
    deaf_until_us: u64,
    own: EmulatorCounts,
}

#[derive(Clone, Copy)]
struct Anchor {
    emulator_us: u64,
    source_us: u64,
}

impl Server {
    /// A radio at a socket.
    pub fn new(socket: UdpSocket, source: Box<dyn ScanSource>, options: EmulatorOptions) -> Self {
        let mut options = options;
        if let Some((world, _)) = &options.world {
            options.speed = world.speed();
        }
        options.reboot_at_s.sort_by(|a, b| b.total_cmp(a));
        Self {
            socket,
            source,
            state: RadioState::new(RadarConfig::default()),
            channel: Channel::new(options.impairments),
            options,
            orders: Orders::default(),
            began: Instant::now(),
            client: None,
            next: None,
            anchor: None,
            numbering: Numbering::AsSource,
            renumber: Renumber::default(),
            first_us: None,
            started_us: 0,
            booted_us: 0,
            boot_clock_us: 60_000_000,
            deaf_until_us: 0,
            own: EmulatorCounts::default(),
        }
    }

    /// Answers, scans and sends until it is stopped.
    pub fn run(&mut self) {
        let mut buffer = [0; MAX_MESSAGE_BYTES + 1];
        while !self.orders.stop.load(Ordering::SeqCst) {
            let now_us = self.now_us();
            self.restart_if_due(now_us);
            self.make_scans(now_us);
            self.send_due(now_us);
            self.publish();
            let wait_us = self.wait_us(now_us);
            if wait_us > 0 {
                self.hear(&mut buffer, Duration::from_micros(wait_us));
            }
        }
    }

    /// Emulator time: radio seconds as the world's clock counts them, µs.
    fn now_us(&self) -> u64 {
        (self.began.elapsed().as_secs_f64() * self.options.speed * 1e6) as u64
    }

    /// Time until the next message is due, in microseconds of the world's clock.
    fn wait_us(&self, now_us: u64) -> u64 {
        let scan = self
            .next
            .as_ref()
            .filter(|_| self.state.scan_interval_us().is_some())
            .and_then(|scan| self.due_us(scan));
        let next = [scan, self.channel.next_due_us()]
            .into_iter()
            .flatten()
            .min();
        let ahead = next.map_or(20_000, |due| due.saturating_sub(now_us));
        ((ahead as f64 / self.options.speed) as u64).min(20_000)
    }

    fn due_us(&self, scan: &SourceScan) -> Option<u64> {
        let anchor = self.anchor?;
        let radio_us = scan.radio_us.saturating_sub(anchor.source_us) as f64;
        if self.options.world.is_some() {
            return Some(anchor.emulator_us + radio_us as u64);
        }
        // A fast clock counts more than a second a second.
        Some(anchor.emulator_us + (radio_us / (1.0 + 1e-6 * self.options.drift_ppm)) as u64)
    }

    fn clock_ms(&self, now_us: u64) -> u32 {
        let since_boot_us = now_us.saturating_sub(self.booted_us) as f64;
        let drifted_us = since_boot_us * (1.0 + 1e-6 * self.options.drift_ppm);
        ((self.boot_clock_us + drifted_us as u64) / 1000) as u32
    }

    fn restart_if_due(&mut self, now_us: u64) {
        let planned = self
            .options
            .reboot_at_s
            .last()
            .is_some_and(|at_s| now_us as f64 >= 1e6 * at_s);
        if planned {
            self.options.reboot_at_s.pop();
        }
        if planned || self.orders.reboot.swap(false, Ordering::SeqCst) {
            self.restart(now_us);
        }
    }

    fn restart(&mut self, now_us: u64) {
        self.own.reboots += 1;
        self.state.restart();
        self.channel.clear();
        self.client = None;
        self.anchor = None;
        self.deaf_until_us = now_us + (1e6 * self.options.reboot_takes_s) as u64;
        self.booted_us = self.deaf_until_us;
        self.boot_clock_us = 0;
        self.numbering = Numbering::FromZero;
    }

    fn make_scans(&mut self, now_us: u64) {
        while let Some(interval_us) = self.state.scan_interval_us() {
            if self.next.is_none() {
                self.next = self.source.next_scan(self.state.config(), interval_us);
                self.own.exhausted = self.next.is_none();
            }
            let Some(scan) = &self.next else { return };
            if self.anchor.is_none() {
                self.anchor = Some(self.anchor_at(now_us, scan.radio_us));
                self.settle_numbers(now_us);
            }
            let Some(scan) = self.next.take() else { return };
            match self.due_us(&scan) {
                // Over before the client started scans.
                Some(due) if due + 1_000 < self.started_us => {}
                Some(due) if due <= now_us => self.make(scan, due),
                _ => {
                    self.next = Some(scan);
                    return;
                }
            }
        }
    }

    /// Time anchor of the next scans: the next scan is due now, or in a world each scan at its own time.
    fn anchor_at(&mut self, now_us: u64, next_us: u64) -> Anchor {
        let first_us = *self.first_us.get_or_insert(next_us);
        let Some((world, first_s)) = &self.options.world else {
            return Anchor {
                emulator_us: now_us,
                source_us: next_us,
            };
        };
        world.begin();
        let world_us = 1e6 * world.now_s().unwrap_or(0.0);
        let begun_us = now_us.saturating_sub(world_us as u64);
        Anchor {
            emulator_us: begun_us + (1e6 * first_s) as u64,
            source_us: first_us,
        }
    }

    /// Settles numbers and stamps of the scans to come by the next one.
    fn settle_numbers(&mut self, now_us: u64) {
        let Some(scan) = &self.next else { return };
        let Some(header) = scan
            .messages
            .first()
            .and_then(|m| ScanHeader::parse(m).ok())
        else {
            return;
        };
        if self.numbering == Numbering::AsSource {
            self.boot_clock_us = scan.radio_us;
            self.booted_us = self.due_us(scan).unwrap_or(now_us);
        } else if self.options.world.is_some() && self.numbering == Numbering::GoOn {
            // In a world a scan's stamp is its time, and numbers go on.
        } else {
            let clock_ms = self.clock_ms(now_us);
            self.renumber.stamp_ms = clock_ms.wrapping_sub(header.timestamp_ms);
        }
        if self.numbering == Numbering::FromZero {
            self.renumber.id = 0_u16.wrapping_sub(header.message_id);
        }
        self.numbering = Numbering::GoOn;
    }

    /// Lead of a world's radio since its first scan, ms.
    fn drift_ms(&self, radio_us: u64) -> u32 {
        match (&self.options.world, self.first_us) {
            (Some(_), Some(first_us)) => {
                let elapsed_ms = 1e-3 * radio_us.saturating_sub(first_us) as f64;
                // A clock that is slow counts back from 2³².
                (1e-6 * self.options.drift_ppm * elapsed_ms).round() as i64 as u32
            }
            _ => 0,
        }
    }

    /// The scan's pulse, at its world time.
    fn pulse(&self, radio_us: u64) {
        if let (Some(pulses), Some((_, first_s)), Some(first_us)) =
            (&self.options.pulses, &self.options.world, self.first_us)
        {
            pulses.pulse(first_s + 1e-6 * radio_us.saturating_sub(first_us) as f64);
        }
    }

    fn make(&mut self, scan: SourceScan, due_us: u64) {
        let Some(client) = self.client else { return };
        self.own.scans += 1;
        let lost = self.channel.counts().lost;
        let drift_ms = self.drift_ms(scan.radio_us);
        self.pulse(scan.radio_us);
        for mut message in scan.messages {
            let mut renumber = self.renumber;
            renumber.stamp_ms = renumber.stamp_ms.wrapping_add(drift_ms);
            renumber.apply(&mut message);
            self.channel.send(due_us, (client, message));
        }
        self.own.scans_sent_whole += u64::from(self.channel.counts().lost == lost);
        self.state.count_scan();
    }

    fn send_due(&mut self, now_us: u64) {
        while let Some((client, message)) = self.channel.take_due(now_us) {
            // A client that is gone receives no messages; a full buffer loses a message, as a link does.
            if self.socket.send_to(&message, client).is_ok() {
                self.own.datagrams += 1;
            }
        }
    }

    /// Waits for a datagram, and not longer: systems wake sleepers on sockets by their tick, others at once.
    fn receive(&self, buffer: &mut [u8], wait: Duration) -> io::Result<(usize, SocketAddr)> {
        let by_tick = wait.saturating_sub(TICK);
        if by_tick.is_zero() {
            std::thread::sleep(wait);
            self.socket.set_nonblocking(true)?;
            let received = self.socket.recv_from(buffer);
            self.socket.set_nonblocking(false)?;
            return received;
        }
        self.socket.set_read_timeout(Some(by_tick))?;
        self.socket.recv_from(buffer)
    }

    fn hear(&mut self, buffer: &mut [u8], wait: Duration) {
        let Ok((bytes, client)) = self.receive(buffer, wait) else {
            return;
        };
        let now_us = self.now_us();
        if now_us < self.deaf_until_us {
            return;
        }
        let Ok(packet) = Packet::decode(&buffer[..bytes]) else {
            return;
        };
        let clock_ms = self.clock_ms(now_us);
        let source = &self.source;
        let accepts = |config: &RadarConfig| source.accepts(config);
        let Some((answer, effect)) = self.state.answer(&packet, clock_ms, accepts) else {
            return;
        };
        self.channel.send(now_us, (client, answer.encode()));
        match effect {
            Effect::Start => {
                self.client = Some(client);
                self.anchor = None;
                self.started_us = now_us;
            }
            Effect::Stop => self.anchor = None,
            Effect::Reboot => {
                self.send_due(u64::MAX);
                self.restart(now_us);
            }
            Effect::None => {}
        }
    }

    fn publish(&mut self) {
        self.own.channel = self.channel.counts();
        *self
            .orders
            .counts
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = self.own;
    }
}
