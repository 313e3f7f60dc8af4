//! The radio's scans on GPS time during a recording: the session's own fit, over the latest stamps.

use std::collections::VecDeque;

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::frame::Frame;
use acerra_radar::{LoggedClock, recover_clock};
use acerra_record::timing::{Latency, Pair, Stamps, TimingError, logged_clock};

use crate::hardware_clock::{ClockKind, HardwareClock, Wiring};

/// Scans and epochs that a fit rests on: at 50 scans/s the latest 20 s.
const MOST_SCANS: usize = 1024;
const MOST_EPOCHS: usize = 600;

/// A scan's number in order of arrival, the radio's own number and stamp, and the time of arrival of its
/// first message.
#[derive(Clone, Copy, Debug)]
struct Stamped {
    number: u64,
    id: u16,
    stamp_ms: u32,
    host_s: f64,
}

/// Radio time on GPS time, by the latest stamps.
#[derive(Debug)]
pub struct RunningClock {
    latency: [Latency; 2],
    scans: VecDeque<Stamped>,
    epochs: VecDeque<(GpsTime, f64)>,
    /// Epochs by solutions, for receivers that send no measurements.
    solutions: VecDeque<(GpsTime, f64)>,
    settled: Option<Settled>,
    wiring: Wiring,
    hardware: HardwareClock,
    /// The best clock so far, and the offset of its times from those by times of arrival (s).
    held: (ClockKind, f64),
}

/// A fit.
#[derive(Clone, Debug)]
pub struct Settled {
    first_number: u64,
    radar_s: Vec<f64>,
    numbers: Vec<u64>,
    start: GpsTime,
    rate: f64,
    /// Standard deviation of a scan's time, by the stamps alone (s).
    pub sigma_s: f64,
    /// Source of the times.
    pub kind: ClockKind,
    /// Offset of times from the fit before, where a better clock has just taken over (s).
    pub change_s: Option<f64>,
}

impl Settled {
    /// The GPS time of a scan; none for a scan outside the fit.
    #[must_use]
    pub fn time(&self, number: u64) -> Option<GpsTime> {
        if number < self.first_number {
            return None;
        }
        let place = self.numbers.binary_search(&number).ok()?;
        Some(self.start + self.rate * self.radar_s[place])
    }
}

impl RunningClock {
    /// A clock without stamps; `latency` is common to all messages of the radio, and to all epochs, and
    /// `wiring` lists the hardware signals of the session.
    #[must_use]
    pub fn new(latency: [Latency; 2], wiring: Wiring) -> Self {
        Self {
            latency,
            wiring,
            hardware: HardwareClock::new(wiring),
            held: (ClockKind::Arrivals, 0.0),
            scans: VecDeque::new(),
            epochs: VecDeque::new(),
            solutions: VecDeque::new(),
            settled: None,
        }
    }

    /// Takes a scan, by its number in order of arrival.
    pub fn scan(&mut self, number: u64, id: u16, stamp_ms: u32, host_s: f64) {
        self.scans.push_back(Stamped {
            number,
            id,
            stamp_ms,
            host_s,
        });
        if self.scans.len() > MOST_SCANS {
            self.scans.pop_front();
        }
    }

    /// Takes an epoch of measurements, with the host time of its first byte (s).
    pub fn epoch(&mut self, time: GpsTime, host_s: f64) {
        push_epoch(&mut self.epochs, time, host_s);
    }

    /// Takes the epoch of a solution.
    pub fn solution(&mut self, time: GpsTime, host_s: f64) {
        push_epoch(&mut self.solutions, time, host_s);
    }

    /// Takes a message of the receiver for its fix and its time marks.
    pub fn frame(&mut self, frame: &Frame<'_>, host_s: f64) {
        self.hardware.frame(frame, host_s);
    }

    /// Adds a pulse per second, with its number by the kernel.
    pub fn pulse(&mut self, sequence: u32, host_s: f64) {
        self.hardware.pulse(sequence, host_s);
    }

    /// Reason why a better clock that the session is wired for is not used; `None` where that clock is used.
    #[must_use]
    pub fn hardware_trouble(&self) -> Option<&str> {
        let is_best = self.held.0 >= self.hardware.expected();
        self.hardware.trouble.as_deref().filter(|_| !is_best)
    }

    /// The best clock that may be waited for.
    #[must_use]
    pub fn expected(&self) -> ClockKind {
        self.hardware.expected()
    }

    /// Restart of the radio's clock: the fit of the host's clock to GPS time remains valid.
    pub fn radio_restarted(&mut self) {
        self.scans.clear();
        self.settled = None;
    }

    /// The host's clock starts again.
    pub fn restarted(&mut self) {
        *self = Self::new(self.latency, self.wiring);
    }

    /// Fits the clock to time marks and pulses where these determine the clock, else to times of arrival. Once
    /// marks or pulses have ended, times of arrival are shifted by their last difference from the marks or
    /// pulses, so that the clock does not jump.
    ///
    /// # Errors
    /// Too few stamps, or clocks that differ by more than clocks do, as they seem to while the stamps span
    /// little time.
    pub fn settle(&mut self) -> Result<&Settled, TimingError> {
        let ids: Vec<u16> = self.scans.iter().map(|s| s.id).collect();
        let stamps_ms: Vec<u32> = self.scans.iter().map(|s| s.stamp_ms).collect();
        let radar_s = recover_clock(&ids, &stamps_ms).time_s;
        let pair = |(scan, sent_s): (&Stamped, &f64)| Pair {
            sent_s: *sent_s,
            arrived_s: scan.host_s,
        };
        let epochs = if self.epochs.is_empty() {
            &self.solutions
        } else {
            &self.epochs
        };
        let first = self.scans.front();
        let stamps = Stamps {
            radio: self.scans.iter().zip(&radar_s).map(pair).collect(),
            gps: epochs.iter().copied().collect(),
            first: first.map_or((0, 0), |scan| (scan.id, scan.stamp_ms)),
            latency: self.latency,
        };
        let arrivals = logged_clock(&stamps)?;
        let (mut clock, mut kind) = self.hardware.best(&stamps, &radar_s, &arrivals);
        let latest_s = radar_s.last().copied().unwrap_or(0.0);
        let start_of =
            |clock: &LoggedClock| GpsTime::from_week_tow(clock.gps_week, clock.time_offset_s);
        let at_latest = |clock: &LoggedClock| start_of(clock) + clock.rate * latest_s;
        let later_s = at_latest(&clock).seconds_since(at_latest(&arrivals));
        let (held, held_later_s) = self.held;
        let mut start = start_of(&clock);
        let mut change_s = None;
        if kind < held {
            (clock, kind) = (arrivals, held);
            start = start_of(&clock) + held_later_s;
        } else {
            change_s = (kind > held).then_some(later_s - held_later_s);
            self.held = (kind, later_s);
        }
        Ok(self.settled.insert(Settled {
            first_number: first.map_or(0, |scan| scan.number),
            radar_s,
            numbers: self.scans.iter().map(|scan| scan.number).collect(),
            start,
            rate: clock.rate,
            sigma_s: clock.sigma_stamps_s,
            kind,
            change_s,
        }))
    }
}

fn push_epoch(epochs: &mut VecDeque<(GpsTime, f64)>, time: GpsTime, host_s: f64) {
    // A receiver that sets its time starts again.
    if let Some((latest, _)) = epochs.back()
        && !(0.0..3600.0).contains(&time.seconds_since(*latest))
    {
        epochs.clear();
    }
    if epochs.back().is_none_or(|(latest, _)| *latest != time) {
        epochs.push_back((time, host_s));
    }
    if epochs.len() > MOST_EPOCHS {
        epochs.pop_front();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scans_stand_on_gps_time_though_stamps_are_late_and_coarse() {
        let start = GpsTime::from_week_tow(2075, 207_000.0);
        let mut clock = RunningClock::new([Latency::default(); 2], Wiring::NONE);
        assert!(clock.settle().is_err());
        // The host began 3 s before; both sources are late by up to 3 ms, the radio 20 ppm fast.
        let late_s = |k: u64| 1e-3 * (k * 7919 % 97) as f64 / 32.0;
        for k in 0..100_u64 {
            let at_s = 0.2 * k as f64;
            clock.epoch(start + at_s, 3.0 + at_s + late_s(k));
        }
        let scan_s = |n: u64| 0.5 + 0.021_573 * n as f64;
        for n in 0..900_u64 {
            let stamp_ms = 60_000.0 + 1e3 * scan_s(n) * (1.0 + 20e-6);
            clock.scan(
                n + 7,
                n as u16,
                stamp_ms as u32,
                3.0 + scan_s(n) + late_s(n),
            );
        }
        let settled = clock.settle().unwrap();
        for n in [0, 450, 899] {
            let off_s = settled.time(n + 7).unwrap().seconds_since(start) - scan_s(n);
            assert!(off_s.abs() < 4e-4, "{n}: {off_s}");
        }
        assert_eq!(settled.time(6), None);
        assert_eq!(settled.time(907), None);
        clock.radio_restarted();
        assert!(clock.settle().is_err());
    }
}
