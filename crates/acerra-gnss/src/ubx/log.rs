//! A whole UBX log.

use std::collections::{BTreeMap, HashMap};

use acerra_geo::time::GpsTime;

use super::d1::D1Collector;
use super::decoded::Decoded;
use super::frame::{Frame, Piece, pieces};
use super::glonass::GlonassCollector;
use super::inav::InavCollector;
use super::lnav::LnavCollector;
use super::measurement::{Measurements, bytes, satellite, time_mark};
use super::{d1, lnav};
use crate::input::{DropReason, Place, ReadReport};
use crate::observations::observation::EventRecord;
use crate::observations::recorded::RecordedEpoch;
use crate::observations::satellite::{SatelliteId, System};
use crate::orbits::navigation::{Ephemeris, Klobuchar, Navigation};

/// Content of a UBX log, with all signals.
#[derive(Debug, Clone, Default)]
pub struct UbxLog {
    /// Measurement epochs with the byte offset of their message, in the order of the log.
    pub epochs: Vec<(u64, RecordedEpoch)>,
    /// Time marks in the order of the log.
    pub events: Vec<EventRecord>,
    /// Ephemerides and ionosphere coefficients decoded from subframes.
    pub navigation: Navigation,
    /// GLONASS channels by satellite number.
    pub glonass_channels: BTreeMap<u8, i8>,
    /// Dropped data.
    pub report: ReadReport,
}

/// Reads a UBX log: RXM-RAWX, RXM-RAW, RXM-SFRBX, RXM-SFRB and TIM-TM2; other messages are
/// counted.
///
/// Navigation frames carry ten bits of the week at most; the full week comes from the measurements of the
/// log, never from the computer's clock. Without measurements the frames are not used.
pub fn read_ubx(log: &[u8]) -> UbxLog {
    let mut reader = Reader {
        near: first_time(log),
        ..Reader::default()
    };
    for piece in pieces(log) {
        match piece {
            Piece::Frame(frame) => reader.frame(frame),
            Piece::Outside { offset, bytes } => {
                let count = bytes as u64;
                reader
                    .out
                    .report
                    .drop_many(DropReason::OutsideFrames, byte(offset), count);
            }
            Piece::BadChecksum { offset } => reader.drop(DropReason::Checksum, offset),
            Piece::CutOff { offset } => reader.drop(DropReason::CutOff, offset),
        }
    }
    let mut out = reader.out;
    out.glonass_channels = reader.measurements.glonass_channels;
    out.report.format = "UBX".to_owned();
    out.navigation.normalise();
    out
}

fn byte(offset: usize) -> Place {
    Place::Byte(offset as u64)
}

fn first_time(log: &[u8]) -> Option<GpsTime> {
    pieces(log).find_map(|piece| match piece {
        Piece::Frame(Frame {
            class: 0x02,
            id,
            payload,
            ..
        }) => Measurements::time_tag(id, payload),
        _ => None,
    })
}

#[derive(Debug, Default)]
struct Reader {
    out: UbxLog,
    measurements: Measurements,
    /// Time of the latest measurements (before any: of the first).
    near: Option<GpsTime>,
    lnav: HashMap<SatelliteId, LnavCollector>,
    glonass: HashMap<SatelliteId, GlonassCollector>,
    inav: HashMap<SatelliteId, InavCollector>,
    d1: HashMap<SatelliteId, D1Collector>,
    latest: HashMap<SatelliteId, Ephemeris>,
}

impl Reader {
    fn drop(&mut self, reason: DropReason, offset: usize) {
        self.out.report.drop_one(reason, byte(offset));
    }

    fn frame(&mut self, frame: Frame<'_>) {
        let place = byte(frame.offset);
        let report = &mut self.out.report;
        let epoch = match (frame.class, frame.id) {
            (0x02, 0x15) => self.measurements.rawx(frame.payload, place, report),
            (0x02, 0x10) => self.measurements.raw(frame.payload, place, report),
            (0x02, 0x13) => return self.sfrbx(frame),
            (0x02, 0x11) => return self.sfrb(frame),
            (0x0D, 0x03) => {
                match time_mark(frame.payload) {
                    Ok(events) => self.out.events.extend(events),
                    Err(reason) => self.drop(reason, frame.offset),
                }
                return;
            }
            (class, id) => Err(DropReason::UnusedMessage { class, id }),
        };
        match epoch {
            Ok(mut epoch) => {
                epoch.satellites.shrink_to_fit();
                self.near = Some(epoch.time);
                self.out.epochs.push((frame.offset as u64, epoch));
            }
            Err(reason) => self.drop(reason, frame.offset),
        }
    }

    fn sfrb(&mut self, frame: Frame<'_>) {
        let words: Option<[u32; lnav::WORDS]> = words(frame.payload, 2);
        let (Some(words), Some(&number)) = (words, frame.payload.get(1)) else {
            return self.drop(
                DropReason::MalformedMessage {
                    class: frame.class,
                    id: frame.id,
                },
                frame.offset,
            );
        };
        match SatelliteId::new(System::Gps, number) {
            Some(satellite) => self.lnav(satellite, &words.map(|w| w & 0xFF_FFFF), frame.offset),
            // SBAS messages.
            None => self.drop(
                DropReason::UnusedNavigationMessage("SBAS".to_owned()),
                frame.offset,
            ),
        }
    }

    fn sfrbx(&mut self, frame: Frame<'_>) {
        let payload = frame.payload;
        let malformed = DropReason::MalformedMessage {
            class: frame.class,
            id: frame.id,
        };
        let unused = |name: &str| DropReason::UnusedNavigationMessage(name.to_owned());
        let &[gnss, number, _, frequency, count, ..] = payload else {
            return self.drop(malformed, frame.offset);
        };
        if payload.len() < 8 + 4 * usize::from(count) {
            return self.drop(malformed, frame.offset);
        }
        let Some(satellite) = satellite(gnss, number) else {
            return self.drop(DropReason::UnknownSignal, frame.offset);
        };
        let Some(near) = self.near else {
            return self.drop(DropReason::NoWeek, frame.offset);
        };
        match satellite.system() {
            System::Gps | System::Qzss => {
                let Some(words) = words::<{ lnav::WORDS }>(payload, 8) else {
                    return self.drop(malformed, frame.offset);
                };
                if words[0] >> 24 == 0x8B {
                    return self.drop(unused("CNAV"), frame.offset);
                }
                self.lnav(satellite, &words.map(|w| w >> 6 & 0xFF_FFFF), frame.offset);
            }
            System::Glonass => {
                let channel = i8::try_from(i16::from(frequency) - 7).ok();
                let (Some(words), Some(channel @ -7..=6)) = (words(payload, 8), channel) else {
                    return self.drop(malformed, frame.offset);
                };
                let collector = self.glonass.entry(satellite).or_default();
                let decoded = collector.take(satellite, channel, &words, near);
                self.take(satellite, decoded, frame.offset);
            }
            System::Galileo => {
                let Some(words) = words(payload, 8) else {
                    return self.drop(unused("F/NAV"), frame.offset);
                };
                let collector = self.inav.entry(satellite).or_default();
                let decoded = collector.take(satellite, &words, near);
                self.take(satellite, decoded, frame.offset);
            }
            System::Beidou if matches!(satellite.number(), 1..=5 | 59..) => {
                self.drop(unused("D2"), frame.offset);
            }
            System::Beidou => {
                let Some(words) = words::<{ d1::WORDS }>(payload, 8) else {
                    return self.drop(malformed, frame.offset);
                };
                let collector = self.d1.entry(satellite).or_default();
                let decoded = collector.take(satellite, &words);
                self.take(satellite, decoded, frame.offset);
            }
            System::Sbas => self.drop(unused("SBAS"), frame.offset),
            System::Navic => self.drop(unused("NavIC"), frame.offset),
        }
    }

    fn lnav(&mut self, satellite: SatelliteId, words: &[u32; lnav::WORDS], offset: usize) {
        let Some(near) = self.near else {
            return self.drop(DropReason::NoWeek, offset);
        };
        let collector = self.lnav.entry(satellite).or_default();
        let decoded = collector.take(satellite, words, near);
        self.take(satellite, decoded, offset);
    }

    /// Keeps the result of a part of a navigation message.
    fn take(&mut self, satellite: SatelliteId, decoded: Decoded, offset: usize) {
        match decoded {
            Decoded::Pending => {}
            Decoded::Kepler(e) => self.ephemeris(Ephemeris::Kepler(*e)),
            Decoded::Glonass(e) => self.ephemeris(Ephemeris::Glonass(*e)),
            Decoded::Ionosphere(Klobuchar { alpha, beta }) => {
                if satellite.system() == System::Gps && alpha.iter().chain(&beta).any(|&x| x != 0.0)
                {
                    self.out.navigation.klobuchar = Some(Klobuchar { alpha, beta });
                }
            }
            Decoded::Invalid => self.drop(DropReason::InvalidNavigationFrame, offset),
        }
    }

    /// Keeps an ephemeris unless it repeats the satellite's last one.
    fn ephemeris(&mut self, ephemeris: Ephemeris) {
        let repeats = match (self.latest.get(&ephemeris.satellite()), &ephemeris) {
            (Some(Ephemeris::Kepler(a)), Ephemeris::Kepler(b)) => {
                (a.iode, a.toe, a.toc, a.health) == (b.iode, b.toe, b.toc, b.health)
            }
            (Some(Ephemeris::Glonass(a)), Ephemeris::Glonass(b)) => {
                (a.toe, a.health) == (b.toe, b.health) && a.position_ecef_m == b.position_ecef_m
            }
            _ => false,
        };
        if !repeats {
            self.latest.insert(ephemeris.satellite(), ephemeris);
            self.out.navigation.ephemerides.push(ephemeris);
        }
    }
}

fn words<const N: usize>(payload: &[u8], start: usize) -> Option<[u32; N]> {
    let mut out = [0; N];
    for (i, word) in out.iter_mut().enumerate() {
        *word = u32::from_le_bytes(bytes(payload, start + 4 * i)?);
    }
    Some(out)
}
