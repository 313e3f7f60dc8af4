//! A whole RTCM 3 log.

use std::collections::{BTreeMap, HashMap};

use acerra_geo::time::GpsTime;

use super::ephemeris::Refused;
use super::frame::{Frame, Piece, pieces};
use super::lock::LockTracker;
use super::measurement::{Measured, MeasuredSignal, PhaseRange};
use super::station::StationMessage;
use super::time::{DateSource, date_of, resolve};
use super::{ephemeris, legacy, msm, station};
use crate::input::{DropReason, Place, ReadReport};
use crate::observations::observation::{LossOfLock, SignalObservation, StationInfo};
use crate::observations::recorded::{RecordedEpoch, add_signal};
use crate::observations::satellite::SatelliteId;
use crate::observations::signal::{SPEED_OF_LIGHT_M_S, SignalCode};
use crate::orbits::navigation::{Ephemeris, Navigation};

/// Messages whose times differ by less than this (s) belong to one epoch.
const SAME_EPOCH_S: f64 = 1e-3;
/// A station whose position changes by more than this (m) is another station.
const SAME_PLACE_M: f64 = 0.01;
/// Largest distance of a stated time from the log's own date (s).
const MAX_DATE_ERROR_S: f64 = 4.0 * 86_400.0;
/// Modulus of phases of the first generation (cycles).
const PHASE_MODULUS_CYCLES: f64 = 1500.0;

/// Data that a log may lack.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RtcmHints {
    /// Any time within half a week of the log's beginning.
    pub near: Option<GpsTime>,
    /// A time before which the log was recorded, such as the date of its file: resolves the ambiguity of 1024
    /// weeks in a ten-bit week number.
    pub not_after: Option<GpsTime>,
    /// GLONASS frequency channels by satellite number. Channels in the log take precedence.
    pub glonass_channels: BTreeMap<u8, i8>,
}

/// Content of an RTCM 3 log, with all signals.
#[derive(Debug, Clone, Default)]
pub struct RtcmLog {
    /// Epochs with the byte offset of their first message, in the order of the log.
    pub epochs: Vec<(u64, RecordedEpoch)>,
    /// The reference station, whose position is that of the antenna reference point, so that the offset is
    /// zero.
    pub station: StationInfo,
    /// Ephemerides.
    pub navigation: Navigation,
    /// GLONASS channels by satellite number.
    pub glonass_channels: BTreeMap<u8, i8>,
    /// Source of the date; `None` where the log has no date and therefore no epochs.
    pub date: Option<DateSource>,
    /// Dropped data.
    pub report: ReadReport,
}

/// Reads an RTCM 3 log. The date is never taken from the computer's clock: a log without a date and without a
/// hint yields no epochs, and [`RtcmLog::date`] is `None`.
pub fn read_rtcm(log: &[u8], hints: &RtcmHints) -> RtcmLog {
    let date = date_of(log, hints.near, hints.not_after);
    let mut out = RtcmLog {
        date: date.map(|(_, source)| source),
        glonass_channels: hints.glonass_channels.clone(),
        ..RtcmLog::default()
    };
    out.report.format = "RTCM 3".to_owned();
    if let (Some((found, _)), Some(stated)) = (date, hints.near)
        && found.seconds_since(stated).abs() > MAX_DATE_ERROR_S
    {
        out.report.remarks.push(format!(
            "the log's own date is {}, not {} as stated: the log's own date is used",
            found.format_calendar(0),
            stated.format_calendar(0)
        ));
    }
    let frames = pieces(log).filter_map(|piece| match piece {
        Piece::Frame(frame) => Some(frame),
        _ => None,
    });
    // Channels stated anywhere hold for the whole log.
    for frame in frames {
        if let Some(measured) = observations(&frame) {
            out.glonass_channels.extend(measured.channels);
        } else if let (1020, Some((near, _))) = (frame.number, date)
            && let Ok(Ephemeris::Glonass(e)) = ephemeris::read(1020, frame.payload, near)
        {
            out.glonass_channels.insert(e.satellite.number(), e.channel);
        }
    }
    let mut reader = Reader::new(out, date.map(|(near, _)| near));
    for piece in pieces(log) {
        reader.piece(piece);
    }
    reader.finish()
}

/// Whole messages of a log, and those that hold observations.
pub(crate) fn counts(log: &[u8]) -> (usize, usize) {
    let numbers = pieces(log).filter_map(|piece| match piece {
        Piece::Frame(frame) => Some(frame.number),
        _ => None,
    });
    numbers.fold((0, 0), |(all, observing), number| {
        (all + 1, observing + usize::from(holds_observations(number)))
    })
}

/// The observations of a message of a supported kind.
fn observations(frame: &Frame<'_>) -> Option<Measured> {
    match frame.number {
        1002 | 1004 => legacy::gps(frame.payload, frame.number == 1004),
        1010 | 1012 => legacy::glonass(frame.payload, frame.number == 1012),
        number => {
            let (system, kind) = msm::kind(number)?;
            msm::read(frame.payload, system, kind)
        }
    }
}

fn holds_observations(number: u16) -> bool {
    matches!(number, 1002 | 1004 | 1010 | 1012) || msm::kind(number).is_some()
}

/// An epoch whose messages are being read.
#[derive(Debug)]
struct Open {
    offset: u64,
    more_follow: bool,
    epoch: RecordedEpoch,
}

#[derive(Debug)]
struct Reader {
    out: RtcmLog,
    /// Time of the latest message (before any: the log's date).
    near: Option<GpsTime>,
    open: Option<Open>,
    station: Option<u16>,
    /// Largest distance of a position from the station's first position (m), and the offset of its first
    /// occurrence.
    moved: Option<(f64, usize)>,
    locks: LockTracker,
    /// Phase minus pseudorange (cycles) of phases known modulo 1500 cycles, when last seen.
    excess_cycles: HashMap<(SatelliteId, SignalCode), f64>,
    latest: HashMap<SatelliteId, Ephemeris>,
}

impl Reader {
    fn new(out: RtcmLog, near: Option<GpsTime>) -> Self {
        Self {
            out,
            near,
            open: None,
            station: None,
            moved: None,
            locks: LockTracker::default(),
            excess_cycles: HashMap::new(),
            latest: HashMap::new(),
        }
    }

    fn drop(&mut self, reason: DropReason, offset: usize, count: u64) {
        let place = Place::Byte(offset as u64);
        self.out.report.drop_many(reason, place, count);
    }

    fn piece(&mut self, piece: Piece<'_>) {
        match piece {
            Piece::Frame(frame) if holds_observations(frame.number) => match observations(&frame) {
                Some(measured) => self.measured(&measured, frame.offset),
                None => self.malformed(&frame),
            },
            Piece::Frame(frame) if ephemeris::is_ephemeris(frame.number) => self.ephemeris(&frame),
            Piece::Frame(frame) => match frame.number {
                1005..=1008 | 1033 => match station::read(frame.number, frame.payload) {
                    Some((id, message)) => self.station(id, message, frame.offset),
                    None => self.malformed(&frame),
                },
                1013 if station::date(frame.payload).is_some() => {}
                1013 => self.malformed(&frame),
                number => self.drop(DropReason::UnusedRtcmMessage { number }, frame.offset, 1),
            },
            Piece::Outside { offset, bytes } => {
                self.drop(DropReason::OutsideMessages, offset, bytes as u64);
            }
            Piece::Damaged { offset, .. } => self.drop(DropReason::Checksum, offset, 1),
            Piece::CutOff { offset } => self.drop(DropReason::CutOff, offset, 1),
        }
    }

    fn malformed(&mut self, frame: &Frame<'_>) {
        let number = frame.number;
        self.drop(DropReason::MalformedRtcmMessage { number }, frame.offset, 1);
    }

    fn ephemeris(&mut self, frame: &Frame<'_>) {
        let Some(near) = self.near else {
            return self.drop(DropReason::NoWeek, frame.offset, 1);
        };
        match ephemeris::read(frame.number, frame.payload, near) {
            Ok(ephemeris) => self.keep(ephemeris),
            Err(Refused::Short) => self.malformed(frame),
            Err(Refused::Impossible) => {
                self.drop(DropReason::InvalidNavigationFrame, frame.offset, 1);
            }
        }
    }

    /// Keeps an ephemeris unless it repeats the satellite's last one.
    fn keep(&mut self, ephemeris: Ephemeris) {
        let repeats = match (self.latest.get(&ephemeris.satellite()), &ephemeris) {
            (Some(Ephemeris::Kepler(a)), Ephemeris::Kepler(b)) => {
                (a.iode, a.toe, a.toc, a.health, a.data_source)
                    == (b.iode, b.toe, b.toc, b.health, b.data_source)
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

    fn station(&mut self, id: u16, message: StationMessage, offset: usize) {
        if *self.station.get_or_insert(id) != id {
            return;
        }
        let station = &mut self.out.station;
        if station.marker.is_empty() {
            station.marker = format!("{id:04}");
        }
        match message {
            StationMessage::Position(position) if position.iter().all(|&x| x == 0.0) => {}
            StationMessage::Position(position) => match station.position_ecef_m {
                None => station.position_ecef_m = Some(position),
                Some(first) => self.position(first, position, offset),
            },
            StationMessage::Antenna(antenna) => station.antenna = antenna,
            StationMessage::AntennaAndReceiver(antenna, receiver) => {
                station.antenna = antenna;
                station.receiver = receiver;
            }
        }
    }

    /// Compares a position with the station's first one.
    fn position(&mut self, first: [f64; 3], now: [f64; 3], offset: usize) {
        let distance_m = (0..3)
            .map(|k| (now[k] - first[k]).powi(2))
            .sum::<f64>()
            .sqrt();
        if distance_m > SAME_PLACE_M {
            let (farthest_m, place) = self.moved.unwrap_or((0.0, offset));
            self.moved = Some((distance_m.max(farthest_m), place));
        }
    }

    fn measured(&mut self, measured: &Measured, offset: usize) {
        let Some(near) = self.near else {
            return self.drop(DropReason::NoWeek, offset, 1);
        };
        if *self.station.get_or_insert(measured.station) != measured.station {
            return self.drop(DropReason::OtherStation, offset, 1);
        }
        let Some(time) = resolve(measured.tag, near) else {
            return self.drop(DropReason::UnreadableEpoch, offset, 1);
        };
        self.near = Some(time);
        self.drop(DropReason::UnknownSignal, offset, measured.unknown);
        let continues = self
            .open
            .as_ref()
            .is_some_and(|open| time.seconds_since(open.epoch.time).abs() < SAME_EPOCH_S);
        if !continues {
            self.close();
            self.open = Some(Open {
                offset: offset as u64,
                more_follow: false,
                epoch: RecordedEpoch {
                    time,
                    receiver_clock_s: None,
                    satellites: Vec::new(),
                },
            });
        }
        let signals: Vec<(SatelliteId, SignalObservation)> = measured
            .signals
            .iter()
            .map(|signal| (signal.satellite, self.observation(signal, time, offset)))
            .collect();
        if let Some(open) = &mut self.open {
            open.more_follow = measured.more_follow;
            for (satellite, signal) in signals {
                add_signal(&mut open.epoch.satellites, satellite, signal);
            }
        }
    }

    fn observation(
        &mut self,
        measured: &MeasuredSignal,
        time: GpsTime,
        offset: usize,
    ) -> SignalObservation {
        let (satellite, code) = (measured.satellite, measured.code);
        let channel = self.out.glonass_channels.get(&satellite.number()).copied();
        let frequency_hz = code.carrier_frequency_hz(satellite.system(), channel);
        let mut signal = SignalObservation::empty(code);
        signal.pseudorange_m = measured.range_m.filter(|&range| range > 0.0);
        signal.cn0_db_hz = measured.cn0_db_hz;
        let Some(frequency_hz) = frequency_hz else {
            if measured.phase.is_some() {
                self.drop(DropReason::UnknownChannel, offset, 1);
            }
            return signal;
        };
        let cycles_per_m = frequency_hz / SPEED_OF_LIGHT_M_S;
        // Zero means "none" in the rest of the processing.
        let doppler_hz = measured.rate_m_s.map(|rate| -rate * cycles_per_m);
        signal.doppler_hz = doppler_hz.filter(|&doppler| doppler != 0.0);
        let Some(phase) = measured.phase.filter(PhaseRange::is_positive) else {
            return signal;
        };
        let lost = self
            .locks
            .lost((satellite, code), time, measured.least_lock_ms);
        signal.phase_cycles = Some(match phase {
            PhaseRange::Whole(metres) => metres * cycles_per_m,
            PhaseRange::Modulo1500 { range_m, excess_m } => {
                let excess = excess_m * cycles_per_m;
                range_m * cycles_per_m + self.unwrapped((satellite, code), excess, lost)
            }
        });
        if lost {
            signal.loss_of_lock.0 |= LossOfLock::SLIP;
        }
        if measured.half_cycle_unknown {
            signal.loss_of_lock.0 |= LossOfLock::HALF_CYCLE;
        }
        signal
    }

    /// Phase minus pseudorange, continued from the epoch before: ionosphere drives the two apart, and beyond
    /// 750 cycles a sender wraps around.
    fn unwrapped(&mut self, signal: (SatelliteId, SignalCode), excess: f64, lost: bool) -> f64 {
        let before = self.excess_cycles.get(&signal).filter(|_| !lost);
        let turns = before.map_or(0.0, |b| ((b - excess) / PHASE_MODULUS_CYCLES).round());
        let excess = excess + turns * PHASE_MODULUS_CYCLES;
        self.excess_cycles.insert(signal, excess);
        excess
    }

    fn close(&mut self) {
        let Some(mut open) = self.open.take() else {
            return;
        };
        open.epoch.satellites.shrink_to_fit();
        if open.more_follow {
            let place = Place::Byte(open.offset);
            self.out.report.drop_one(DropReason::IncompleteEpoch, place);
        }
        self.out.epochs.push((open.offset, open.epoch));
    }

    fn finish(mut self) -> RtcmLog {
        self.close();
        let mut out = self.out;
        if let Some((farthest_m, offset)) = self.moved {
            out.report.remarks.push(format!(
                "the station's position changes by up to {farthest_m:.3} m, first at byte \
                 {offset}: the first position is taken"
            ));
        }
        out.navigation.normalise();
        if matches!(
            out.date,
            Some(DateSource::TenBits | DateSource::TenBitsAndFile)
        ) && let Some((_, first)) = out.epochs.first()
        {
            out.report.remarks.push(format!(
                "the log gives ten bits of the week only: taken as week {} ({}), {}",
                first.time.week(),
                first.time.format_calendar(0),
                match out.date {
                    Some(DateSource::TenBitsAndFile) => "the last one before the file was written",
                    _ => "one since April 2019",
                }
            ));
        }
        out.report.remarks.extend(missing_epochs(&out.epochs));
        out
    }
}

/// A remark on epochs that are missing by the log's usual interval.
fn missing_epochs(epochs: &[(u64, RecordedEpoch)]) -> Option<String> {
    let mut steps_s: Vec<f64> = epochs
        .windows(2)
        .map(|pair| pair[1].1.time.seconds_since(pair[0].1.time))
        .filter(|&step| step > SAME_EPOCH_S)
        .collect();
    let in_order = steps_s.clone();
    steps_s.sort_by(f64::total_cmp);
    let usual_s = *steps_s.get(steps_s.len() / 2)?;
    let missing = |step: f64| ((step / usual_s).round() - 1.0).max(0.0);
    let gaps = in_order.iter().filter(|&&step| missing(step) >= 1.0);
    let (count, lost) = gaps.fold((0_u64, 0.0), |(n, sum), &step| (n + 1, sum + missing(step)));
    let longest_s = steps_s.last().copied().unwrap_or(0.0);
    (count > 0).then(|| {
        format!(
            "{lost:.0} epochs of {usual_s:.3} s are missing in {count} gaps, the longest of \
             {longest_s:.1} s"
        )
    })
}
