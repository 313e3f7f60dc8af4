//! MAVLink telemetry as ground stations record it, `.tlog`.

mod component;
mod frame;
mod messages;

use std::collections::BTreeSet;
use std::io::Read;

use crate::bytes::LogBytes;
use crate::collect::{ClockSource, Collector, Origin};
use crate::error::LogError;
use crate::format::LogFormat;
use crate::sample::{GimbalSample, PairKind, Recording, SourceKind, Stamp, Teller};

use component::ComponentClocks;
use frame::{HEADER, LONGEST, Packet, length};
use messages::{Kind, Payload};

/// The part of a vehicle that is its autopilot.
const AUTOPILOT: u8 = 1;

/// Whether a log begins with these bytes: stamped packets one after the other, or packets of right checksums
/// that fill more than half of them.
pub fn begins(start: &[u8]) -> bool {
    let mut at = 0;
    let (mut whole, mut stray, mut checked) = (0, 0, 0);
    while start.len() - at >= HEADER {
        let rest = &start[at..];
        let Some(length) = length(rest).filter(|length| is_packet(rest, *length)) else {
            stray += 1;
            at += 1;
            continue;
        };
        let packet = rest.get(..length).and_then(Packet::of);
        checked += usize::from(packet.is_some_and(|p| Kind::of(p.message).is_some()));
        whole += length;
        at = start.len().min(at + length);
    }
    // A log whose remainder is shorter than a packet's header was cut off, and is accepted.
    whole > 0 && (stray == 0 || (checked > 1 && whole > stray))
}

/// Reads a log.
///
/// # Errors
/// A log that is cut off within a packet, damaged beyond use, or beyond the limit.
pub fn read<R: Read>(bytes: &mut LogBytes<R>, limit: usize) -> Result<Recording, LogError> {
    let mut log = Reader {
        found: Collector::new(LogFormat::Mavlink, limit),
        system: None,
        others: BTreeSet::new(),
        clocks: ComponentClocks::default(),
    };
    while !bytes.is_at_end()? {
        let offset = bytes.offset();
        if bytes.peek(HEADER)?.len() < HEADER {
            bytes.whole(HEADER, "packet's header")?;
        }
        let start = bytes.peek(LONGEST + HEADER)?;
        let Some(length) = length(start).filter(|length| is_packet(start, *length)) else {
            let (passed, is_blank) = bytes.seek(HEADER, |start| length(start).is_some())?;
            if !(is_blank && bytes.is_at_end()?) {
                log.found.damage.add(offset, passed);
            }
            continue;
        };
        let packet = bytes.whole(length, "packet")?;
        if let Some(packet) = Packet::of(packet) {
            log.take(&packet, offset)?;
        }
        bytes.advance(length);
    }
    std::mem::take(&mut log.clocks).settle(&mut log.found);
    if !log.others.is_empty() {
        let others: Vec<String> = log.others.iter().map(u8::to_string).collect();
        log.found.remarks.push(format!(
            "messages of the vehicles {} were left out: the log holds several, and the positions are \
             those of the first, {}",
            others.join(", "),
            log.system.unwrap_or_default()
        ));
    }
    let clock = ClockSource {
        kind: PairKind::Simultaneous,
        name: "a message SYSTEM_TIME with UTC",
        allows_own: false,
    };
    log.found.finish(clock, bytes.offset())
}

/// Whether the bytes begin with a whole packet: by its checksum where its message is known, else by the bytes
/// after it.
fn is_packet(start: &[u8], length: usize) -> bool {
    let Some(packet) = start.get(..length).and_then(Packet::of) else {
        // Cut off, which the caller finds out.
        return true;
    };
    match Kind::of(packet.message) {
        Some((_, crc_extra)) => packet.is_whole(crc_extra),
        None => {
            let rest = &start[length..];
            rest.len() < HEADER || frame::length(rest).is_some()
        }
    }
}

struct Reader {
    found: Collector,
    /// The vehicle: the first one with a useful message.
    system: Option<u8>,
    /// Other vehicles in the log.
    others: BTreeSet<u8>,
    /// Clocks of the vehicle's parts.
    clocks: ComponentClocks,
}

impl Reader {
    fn take(&mut self, packet: &Packet<'_>, offset: u64) -> Result<(), LogError> {
        let Some((kind, _)) = Kind::of(packet.message) else {
            return Ok(());
        };
        let payload = Payload::new(packet.payload);
        if matches!(kind, Kind::MountOrientation | Kind::GimbalDeviceStatus) {
            return self.take_gimbal(kind, packet, &payload, offset);
        }
        // Gimbals, cameras and the ground station have separate clocks and attitudes.
        if packet.component != AUTOPILOT {
            return Ok(());
        }
        if *self.system.get_or_insert(packet.system) != packet.system {
            self.others.insert(packet.system);
            return Ok(());
        }
        match kind {
            Kind::SystemTime => match payload.clock_pair() {
                Some(pair) => {
                    self.clocks.autopilot(pair.boot_s, packet.arrival);
                    self.found.pair(pair, offset)
                }
                None => Ok(()),
            },
            Kind::Attitude => match payload.attitude() {
                Some(attitude) => {
                    if let Stamp::Boot(boot_s) = attitude.stamp {
                        self.clocks.autopilot(boot_s, packet.arrival);
                    }
                    self.found.attitude(kind.name(), attitude, offset)
                }
                None => Ok(()),
            },
            Kind::GlobalPosition => {
                let origin = Origin::first(kind.name(), SourceKind::Filter);
                self.found
                    .position(origin, payload.filter_position(), offset)
            }
            Kind::GpsRaw | Kind::Gps2Raw => {
                let origin = Origin::first(kind.name(), SourceKind::Gnss);
                self.found
                    .position(origin, payload.gnss_position(kind), offset)
            }
            Kind::MountOrientation | Kind::GimbalDeviceStatus => Ok(()),
        }
    }

    /// Adds the attitude of a gimbal of the vehicle: sent by the autopilot on its behalf, or by a separate
    /// component.
    fn take_gimbal(
        &mut self,
        kind: Kind,
        packet: &Packet<'_>,
        payload: &Payload,
        offset: u64,
    ) -> Result<(), LogError> {
        if self.system != Some(packet.system) {
            return Ok(());
        }
        let (sample, device, rank) = match kind {
            Kind::GimbalDeviceStatus => (payload.gimbal_status(), payload.gimbal_device(), 0),
            _ => (payload.mount_orientation(), 0, 1),
        };
        let number = match device {
            0 => packet.component,
            device => device,
        };
        let name = format!("{}[{number}]", kind.name());
        let sample = if packet.component == AUTOPILOT {
            sample.map(|sample| GimbalSample {
                teller: Teller::Autopilot,
                ..sample
            })
        } else {
            if let Some(sample) = sample {
                self.clocks.gimbal(&name, sample.stamp, packet.arrival);
            }
            sample
        };
        self.found.gimbal(&name, rank, sample, offset)
    }
}
