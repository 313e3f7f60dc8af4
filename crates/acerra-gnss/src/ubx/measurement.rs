//! RXM-RAWX, RXM-RAW and TIM-TM2.

use std::collections::HashMap;

use acerra_geo::time::GpsTime;

use crate::input::{DropReason, Place, ReadReport};
use crate::observations::observation::{EventKind, EventRecord, LossOfLock, SignalObservation};
use crate::observations::recorded::{RecordedEpoch, add_signal};
use crate::observations::satellite::{SatelliteId, System};
use crate::observations::signal::SignalCode;
use crate::rinex::utc_to_gps;

/// Worst carrier-phase standard deviation (in steps of 0.004 cycle) of a usable phase.
const WORST_PHASE_DEVIATION: u8 = 5;

/// Ceiling of the lock-time counter (s).
const LOCK_TIME_CEILING_S: f64 = 64.5;

/// A little-endian field.
pub(super) fn bytes<const N: usize>(payload: &[u8], at: usize) -> Option<[u8; N]> {
    payload.get(at..at + N)?.try_into().ok()
}

/// History of a signal from epoch to epoch.
#[derive(Debug, Clone, Copy)]
struct Tracking {
    time: GpsTime,
    lock_time_s: f64,
    half_cycle_subtracted: bool,
    /// Whether a slip occurred while there was no usable phase to mark.
    slip_pending: bool,
}

/// Turns measurement messages into epochs.
#[derive(Debug, Default)]
pub(super) struct Measurements {
    tracking: HashMap<(SatelliteId, SignalCode), Tracking>,
    /// GLONASS channels seen in RXM-RAWX, by satellite number.
    pub(super) glonass_channels: std::collections::BTreeMap<u8, i8>,
}

impl Measurements {
    /// The time tag of a measurement message of either kind, if it has one.
    pub(super) fn time_tag(id: u8, payload: &[u8]) -> Option<GpsTime> {
        let (week, tow_s) = match id {
            0x15 => (
                u16::from_le_bytes(bytes(payload, 8)?),
                f64::from_le_bytes(bytes(payload, 0)?),
            ),
            0x10 => (
                u16::from_le_bytes(bytes(payload, 4)?),
                f64::from(i32::from_le_bytes(bytes(payload, 0)?)) * 1e-3,
            ),
            _ => return None,
        };
        let plausible = (1..8192).contains(&week) && (0.0..604_801.0).contains(&tow_s);
        plausible.then(|| GpsTime::from_week_tow(i64::from(week), tow_s))
    }

    /// RXM-RAWX (02 15). `Err` gives the reason why no epoch results.
    pub(super) fn rawx(
        &mut self,
        payload: &[u8],
        place: Place,
        report: &mut ReadReport,
    ) -> Result<RecordedEpoch, DropReason> {
        let malformed = DropReason::MalformedMessage {
            class: 0x02,
            id: 0x15,
        };
        let (count, version) = match (payload.get(11), payload.get(13)) {
            (Some(&count), Some(&version)) => (usize::from(count), version),
            _ => return Err(malformed),
        };
        if payload.len() < 16 + 32 * count {
            return Err(malformed);
        }
        let time = Self::time_tag(0x15, payload).ok_or(DropReason::NoWeek)?;
        let mut satellites = Vec::new();
        for block in payload[16..].chunks_exact(32).take(count) {
            match self.rawx_block(block, version, time, place, report) {
                Some((satellite, signal)) => add_signal(&mut satellites, satellite, signal),
                None => report.drop_one(DropReason::UnknownSignal, place),
            }
        }
        Ok(RecordedEpoch {
            time,
            receiver_clock_s: None,
            satellites,
        })
    }

    fn rawx_block(
        &mut self,
        block: &[u8],
        version: u8,
        time: GpsTime,
        place: Place,
        report: &mut ReadReport,
    ) -> Option<(SatelliteId, SignalObservation)> {
        let real = |at| {
            bytes(block, at)
                .map(f64::from_le_bytes)
                .filter(|v| v.is_finite())
        };
        let (gnss, number, signal_id) = (block[20], block[21], block[22]);
        let satellite = satellite(gnss, number)?;
        let code = signal_code(
            satellite.system(),
            if version >= 1 { Some(signal_id) } else { None },
        )?;
        if satellite.system() == System::Glonass {
            let channel = i16::from(block[23]) - 7;
            if let (-7..=6, Ok(channel)) = (channel, i8::try_from(channel)) {
                self.glonass_channels.insert(satellite.number(), channel);
            }
        }
        let lock_time_s = f64::from(u16::from_le_bytes(bytes(block, 24)?)) * 1e-3;
        let (phase_deviation, status) = (block[28] & 15, block[30]);
        let [code_valid, phase_valid, half_resolved, half_subtracted] =
            [1, 2, 4, 8].map(|bit| status & bit != 0);

        let mut signal = SignalObservation::empty(code);
        signal.pseudorange_m = real(0).filter(|&p| code_valid && (1e6..1e9).contains(&p));
        let doppler = f64::from(f32::from_le_bytes(bytes(block, 16)?));
        signal.doppler_hz = Some(doppler).filter(|d| d.is_finite() && *d != 0.0);
        signal.cn0_db_hz = Some(f64::from(block[26])).filter(|&c| c > 0.0);

        let phase = real(8).filter(|&l| l != 0.0);
        let usable = phase_valid && phase != Some(-0.5) && phase_deviation <= WORST_PHASE_DEVIATION;
        let previous = self.tracking.get(&(satellite, code)).copied();
        let slip = lock_time_s == 0.0
            || previous.is_some_and(|p| {
                lock_time_s < p.lock_time_s
                    || half_subtracted != p.half_cycle_subtracted
                    || lost_in_between(time - p.time, lock_time_s)
                    || p.slip_pending
            });
        if usable {
            // BeiDou's geostationary satellites come with half a cycle of offset.
            let offset = if is_beidou_geo(satellite) { 0.5 } else { 0.0 };
            signal.phase_cycles = phase.map(|l| l + offset);
        } else if phase_valid && phase.is_some() {
            report.drop_one(DropReason::PhaseNotUsable, place);
        }
        let half = if half_resolved {
            0
        } else {
            LossOfLock::HALF_CYCLE
        };
        let marked = usable && slip;
        signal.loss_of_lock = LossOfLock(if usable { half } else { 0 } | u8::from(marked));
        self.tracking.insert(
            (satellite, code),
            Tracking {
                time,
                lock_time_s,
                half_cycle_subtracted: half_subtracted,
                slip_pending: slip && !marked,
            },
        );
        Some((satellite, signal))
    }

    /// RXM-RAW (02 10) of the sixth generation.
    pub(super) fn raw(
        &mut self,
        payload: &[u8],
        place: Place,
        report: &mut ReadReport,
    ) -> Result<RecordedEpoch, DropReason> {
        let malformed = DropReason::MalformedMessage {
            class: 0x02,
            id: 0x10,
        };
        let count = usize::from(*payload.get(6).ok_or(malformed.clone())?);
        if payload.len() < 8 + 24 * count {
            return Err(malformed);
        }
        let time = Self::time_tag(0x10, payload).ok_or(DropReason::NoWeek)?;
        let mut satellites = Vec::new();
        for block in payload[8..].chunks_exact(24).take(count) {
            match raw_block(block, place, report) {
                Some((satellite, signal)) => add_signal(&mut satellites, satellite, signal),
                None => report.drop_one(DropReason::UnknownSignal, place),
            }
        }
        Ok(RecordedEpoch {
            time,
            receiver_clock_s: None,
            satellites,
        })
    }
}

fn raw_block(
    block: &[u8],
    place: Place,
    report: &mut ReadReport,
) -> Option<(SatelliteId, SignalObservation)> {
    let real = |at| {
        bytes(block, at)
            .map(f64::from_le_bytes)
            .filter(|v| v.is_finite())
    };
    let (number, quality, lock) = (block[20], block[21].cast_signed(), block[23]);
    let satellite = match number {
        120.. => SatelliteId::new(System::Sbas, number - 100),
        _ => SatelliteId::new(System::Gps, number),
    }?;
    let mut signal = SignalObservation::empty(SignalCode::new(1, 'C'));
    signal.pseudorange_m = real(8).filter(|p| quality >= 4 && (1e6..1e9).contains(p));
    let doppler = f64::from(f32::from_le_bytes(bytes(block, 16)?));
    signal.doppler_hz = Some(doppler).filter(|d| d.is_finite() && *d != 0.0);
    signal.cn0_db_hz = Some(f64::from(block[22].cast_signed())).filter(|&c| c > 0.0);
    let phase = real(0).filter(|&l| l != 0.0);
    if quality >= 5 {
        signal.phase_cycles = phase;
    } else if phase.is_some() {
        report.drop_one(DropReason::PhaseNotUsable, place);
    }
    // Below quality 6 lock was probably lost since the epoch before.
    let slipped = u8::from(quality < 6);
    signal.loss_of_lock = LossOfLock((lock & 3) | slipped);
    Some((satellite, signal))
}

/// Whether a signal's lock is younger than its previous observation. Lock times are cut to whole milliseconds
/// and stop at a ceiling, beyond which slips are not visible.
fn lost_in_between(since_previous_s: f64, lock_time_s: f64) -> bool {
    since_previous_s > 0.0 && lock_time_s + 2e-3 < since_previous_s.min(LOCK_TIME_CEILING_S - 2e-3)
        || since_previous_s > LOCK_TIME_CEILING_S
}

/// The satellite of u-blox's system and satellite numbers.
pub(super) fn satellite(gnss: u8, number: u8) -> Option<SatelliteId> {
    let (system, number) = match gnss {
        0 => (System::Gps, number),
        1 => (System::Sbas, number.checked_sub(100)?),
        2 => (System::Galileo, number),
        3 => (System::Beidou, number),
        5 => (
            System::Qzss,
            if number > 192 { number - 192 } else { number },
        ),
        6 => (System::Glonass, number),
        7 => (System::Navic, number),
        _ => return None,
    };
    SatelliteId::new(system, number)
}

fn is_beidou_geo(satellite: SatelliteId) -> bool {
    satellite.system() == System::Beidou && matches!(satellite.number(), 1..=5 | 59..=63)
}

/// The signal of a u-blox signal number; without a number (first message version) the only signal that the
/// receivers of that time tracked.
fn signal_code(system: System, signal: Option<u8>) -> Option<SignalCode> {
    let (band, attribute) = match (system, signal) {
        (System::Galileo, None) => (1, 'X'),
        (System::Beidou, None) => (2, 'I'),
        (_, None) => (1, 'C'),
        (System::Gps, Some(0)) => (1, 'C'),
        (System::Gps, Some(3)) => (2, 'L'),
        (System::Gps, Some(4)) => (2, 'S'),
        (System::Gps, Some(6)) => (5, 'I'),
        (System::Gps, Some(7)) => (5, 'Q'),
        (System::Glonass, Some(0)) => (1, 'C'),
        (System::Glonass, Some(2)) => (2, 'C'),
        (System::Galileo, Some(0)) => (1, 'C'),
        (System::Galileo, Some(1)) => (1, 'B'),
        (System::Galileo, Some(3)) => (5, 'I'),
        (System::Galileo, Some(4)) => (5, 'Q'),
        (System::Galileo, Some(5)) => (7, 'I'),
        (System::Galileo, Some(6)) => (7, 'Q'),
        (System::Beidou, Some(0 | 1)) => (2, 'I'),
        (System::Beidou, Some(2 | 3)) => (7, 'I'),
        (System::Beidou, Some(5)) => (1, 'P'),
        (System::Beidou, Some(6)) => (1, 'D'),
        (System::Beidou, Some(7)) => (5, 'P'),
        (System::Beidou, Some(8)) => (5, 'D'),
        (System::Qzss, Some(0)) => (1, 'C'),
        (System::Qzss, Some(4)) => (2, 'S'),
        (System::Qzss, Some(5)) => (2, 'L'),
        (System::Qzss, Some(8)) => (5, 'I'),
        (System::Qzss, Some(9)) => (5, 'Q'),
        (System::Sbas, Some(0)) => (1, 'C'),
        (System::Navic, Some(0)) => (5, 'A'),
        _ => return None,
    };
    Some(SignalCode::new(band, attribute))
}

/// TIM-TM2 (0D 03): the edges on the time-mark input since the last message.
pub(super) fn time_mark(payload: &[u8]) -> Result<Vec<EventRecord>, DropReason> {
    let malformed = || DropReason::MalformedMessage {
        class: 0x0D,
        id: 0x03,
    };
    if payload.len() < 28 {
        return Err(malformed());
    }
    let flags = payload[1];
    let u16_at = |at| bytes(payload, at).map_or(0, u16::from_le_bytes);
    let u32_at = |at| bytes(payload, at).map_or(0, u32::from_le_bytes);
    if flags & 0x40 == 0 {
        return Err(DropReason::TimeNotValid);
    }
    let (count, accuracy_ns) = (u32::from(u16_at(2)), u32_at(24));
    let mut events = Vec::new();
    let edges = [
        (
            0x80,
            EventKind::RisingEdge,
            u16_at(4),
            u32_at(8),
            u32_at(12),
        ),
        (
            0x04,
            EventKind::FallingEdge,
            u16_at(6),
            u32_at(16),
            u32_at(20),
        ),
    ];
    for (bit, kind, week, tow_ms, below_ms_ns) in edges {
        if flags & bit == 0 {
            continue;
        }
        if tow_ms >= 604_800_000 || below_ms_ns >= 1_000_000 || week >= 8192 {
            return Err(malformed());
        }
        // Whole seconds and the fraction are kept apart, so that nanoseconds are not lost to rounding.
        let fraction_s = f64::from(tow_ms % 1000) * 1e-3 + f64::from(below_ms_ns) * 1e-9;
        let seconds = i64::from(week) * 604_800 + i64::from(tow_ms / 1000);
        let time = GpsTime::new(seconds, fraction_s);
        let is_utc = flags >> 3 & 3 == 2;
        let time = if is_utc {
            utc_to_gps(time).ok_or_else(malformed)?
        } else {
            time
        };
        events.push(EventRecord {
            time,
            kind,
            count: Some(count),
            accuracy_s: Some(f64::from(accuracy_ns) * 1e-9),
        });
    }
    Ok(events)
}
