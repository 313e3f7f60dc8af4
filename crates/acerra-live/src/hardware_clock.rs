//! Pulses per second and time marks of a recording that goes on, and the better clock that they give.

use std::collections::VecDeque;

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::frame::Frame;
use acerra_gnss::ubx::rising_edge;
use acerra_radar::LoggedClock;
use acerra_record::session::{FixSource, Session};
use acerra_record::timing::{Latency, MarkedScans, Pulse, Stamps, marked_clock, pulsed_clock};

/// Pulses that a fit rests on: two minutes, over which a computer's clock is a line.
const MOST_PULSES: usize = 120;
/// Marks that a fit rests on.
const MOST_MARKS: usize = 1024;
/// Time that a receiver's pulses take to settle once it has a fix, and longest gap between two messages
/// reporting a fix across which the fix counts as held (s); both as in the session's own clock.
const SETTLES_S: f64 = 1.0;
const LONGEST_GAP_S: f64 = 3.0;

/// Source of the scans' times, rising with quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ClockKind {
    /// Times of arrival.
    Arrivals,
    /// The receiver's pulses per second.
    Pulses,
    /// Marks that the receiver stamps, one a scan.
    Marks,
}

impl ClockKind {
    /// Name of the clock.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Arrivals => "times of arrival",
            Self::Pulses => "pulses per second",
            Self::Marks => "time marks",
        }
    }
}

/// Hardware signals of a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wiring {
    /// Whether the kernel stamps pulses per second.
    pub has_pulses: bool,
    /// Whether the radio's pulse is on the receiver's EXTINT, inferred from a stated mark delay.
    pub has_marks: bool,
    /// From a mark to the middle of its scan.
    pub mark_delay: Latency,
}

impl Wiring {
    /// Settings of a session: `[gnss] pps`, `[radio] mark_delay_ms`.
    #[must_use]
    pub fn of(session: &Session) -> Self {
        Self {
            has_pulses: session.gnss.as_ref().is_some_and(|gnss| gnss.pps.is_some()),
            has_marks: session.radio.mark_delay_ms.is_some(),
            mark_delay: session.mark_delay(),
        }
    }

    /// No wires.
    pub const NONE: Self = Self {
        has_pulses: false,
        has_marks: false,
        mark_delay: Latency {
            delay_s: 0.0,
            sigma_s: 0.0,
        },
    };
}

/// Pulses and marks so far.
#[derive(Debug)]
pub(crate) struct HardwareClock {
    wiring: Wiring,
    pulses: VecDeque<Pulse>,
    marks: VecDeque<GpsTime>,
    source: FixSource,
    /// Host time since which the receiver has a fix, and time of its last report of a fix (s).
    fix_s: Option<[f64; 2]>,
    /// Reason why the hardware signals of the session are not used.
    pub trouble: Option<String>,
}

impl HardwareClock {
    pub fn new(wiring: Wiring) -> Self {
        Self {
            wiring,
            pulses: VecDeque::new(),
            marks: VecDeque::new(),
            source: FixSource::default(),
            fix_s: None,
            trouble: None,
        }
    }

    /// Adds the receiver's reports of its fix, and marks.
    pub fn frame(&mut self, frame: &Frame<'_>, host_s: f64) {
        if let Some(state) = self.source.take(frame, host_s) {
            self.fix_s = match (state.has_fix, self.fix_s) {
                (false, _) => None,
                (true, Some([since_s, told_s])) if host_s - told_s <= LONGEST_GAP_S => {
                    Some([since_s, host_s])
                }
                (true, _) => Some([host_s, host_s]),
            };
            if !state.has_fix {
                // The fix was lost at some time after the last message that reported it.
                let until_s = host_s - LONGEST_GAP_S;
                let late = self.pulses.iter_mut().rev();
                late.take_while(|pulse| pulse.host_s > until_s)
                    .for_each(|pulse| pulse.has_fix = false);
            }
        }
        if let Some(edge) = rising_edge(frame) {
            self.marks.push_back(edge.time);
            if self.marks.len() > MOST_MARKS {
                self.marks.pop_front();
            }
        }
    }

    /// Adds a pulse with its number by the kernel and the host time of its edge (s).
    pub fn pulse(&mut self, sequence: u32, host_s: f64) {
        let has_fix = self.fix_s.is_some_and(|[since_s, told_s]| {
            host_s >= since_s + SETTLES_S && host_s <= told_s + LONGEST_GAP_S
        });
        self.pulses.push_back(Pulse {
            sequence,
            host_s,
            has_fix,
        });
        if self.pulses.len() > MOST_PULSES {
            self.pulses.pop_front();
        }
    }

    /// The best clock that may be waited for: marks are once the first has come.
    pub fn expected(&self) -> ClockKind {
        match (
            self.wiring.has_pulses,
            self.wiring.has_marks && !self.marks.is_empty(),
        ) {
            (_, true) => ClockKind::Marks,
            (true, false) => ClockKind::Pulses,
            (false, false) => ClockKind::Arrivals,
        }
    }

    /// The best clock of these stamps, `arrivals` being the one by times of arrival and `radar_s` the radar times of the
    /// scans.
    pub fn best(
        &mut self,
        stamps: &Stamps,
        radar_s: &[f64],
        arrivals: &LoggedClock,
    ) -> (LoggedClock, ClockKind) {
        let mut best = (arrivals.clone(), ClockKind::Arrivals);
        let mut trouble = Vec::new();
        if self.wiring.has_pulses || !self.pulses.is_empty() {
            match self.by_pulses(stamps) {
                Ok(clock) => best = (clock, ClockKind::Pulses),
                Err(error) => trouble.push(format!("pulses per second: {error}")),
            }
        }
        if !self.marks.is_empty() {
            let marks: Vec<GpsTime> = self.marks.iter().copied().collect();
            let scans = MarkedScans {
                radar_s,
                marks: &marks,
                delay: self.wiring.mark_delay,
            };
            match marked_clock(&scans, &best.0) {
                Ok(clock) => best = (clock, ClockKind::Marks),
                Err(error) => trouble.push(format!("time marks: {error}")),
            }
        }
        self.trouble = (best.1 < self.expected()).then(|| trouble.join("; "));
        best
    }

    fn by_pulses(&self, stamps: &Stamps) -> Result<LoggedClock, String> {
        let pulses: Vec<Pulse> = self.pulses.iter().copied().collect();
        // Epochs before the pulses give no relation to them.
        let first_s = pulses.iter().find(|pulse| pulse.has_fix).map(|p| p.host_s);
        let is_since = |host_s: f64| first_s.is_some_and(|first_s| host_s >= first_s - 1.0);
        let of_pulses = Stamps {
            gps: (stamps.gps.iter().copied())
                .filter(|(_, host_s)| is_since(*host_s))
                .collect(),
            ..stamps.clone()
        };
        let stamps = match first_s {
            Some(_) => &of_pulses,
            None => stamps,
        };
        let found = pulsed_clock(stamps, &pulses);
        found.map(|found| found.clock).map_err(|e| e.to_string())
    }
}
