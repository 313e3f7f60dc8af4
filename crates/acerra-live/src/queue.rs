//! Scans that wait for their time and place, oldest first.

use std::collections::VecDeque;
use std::time::Instant;

use acerra_geo::time::GpsTime;
use acerra_radar::Scan;

use crate::canvas::MOST_PULSES;
use crate::clean::PlacedTrace;
use crate::clock::Settled;
use crate::place::{Placed, RadarPlace};
use crate::positions::Positions;
use crate::settings::LiveSettings;
use crate::status::PulseCounts;

/// Scans that wait at most: 80 s at 50 a second, 30 MB.
const MOST_WAITING: usize = 4096;

/// A scan that waits for its time and place.
struct Waiting {
    scan: Scan,
    number: u64,
    time: Option<GpsTime>,
    came: Instant,
    /// Whether it waited for the heading or a better clock: that time is no delay of the imaging.
    was_held: bool,
}

/// A scan that has its place, and its trace.
#[derive(Clone, Debug)]
pub(crate) struct PlacedScan {
    /// When its last message came.
    pub came: Instant,
    /// Position of the radar.
    pub place: RadarPlace,
    /// Whether it waited for the heading or a better clock: the pulse's delay is then no measure of the imaging
    /// speed.
    pub was_held: bool,
}

/// Scans of one window, with their traces.
pub(crate) type Batch = (Vec<PlacedTrace>, Vec<PlacedScan>);

/// Scans that wait.
#[derive(Default)]
pub(crate) struct Queue {
    waiting: VecDeque<Waiting>,
    /// Scans that waited together for the heading or a better clock and do not count as late.
    backlog: usize,
    without_heading: bool,
    without_clock: bool,
}

impl Queue {
    /// Takes a scan by its number in order of arrival.
    pub fn push(&mut self, scan: Scan, number: u64, came: Instant, counts: &mut PulseCounts) {
        self.waiting.push_back(Waiting {
            scan,
            number,
            time: None,
            came,
            was_held: false,
        });
        if self.waiting.len() > MOST_WAITING {
            self.pop();
            let missing = match self.without_heading {
                true => &mut counts.without_heading,
                false => &mut counts.without_position,
            };
            *missing += 1;
        }
    }

    fn pop(&mut self) -> Option<Waiting> {
        self.backlog = self.backlog.saturating_sub(1);
        self.waiting.pop_front()
    }

    /// Scans that wait.
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Whether so many scans wait that the oldest are about to be given up.
    pub fn is_half_full(&self) -> bool {
        self.waiting.len() >= MOST_WAITING / 2
    }

    /// Lets all wait for a better clock.
    pub fn hold(&mut self) {
        self.without_clock = true;
        for waiting in &mut self.waiting {
            waiting.was_held = true;
        }
    }

    /// Whether they wait for the heading.
    pub fn is_without_heading(&self) -> bool {
        self.without_heading
    }

    /// The time of the oldest, where it is known.
    pub fn oldest(&self) -> Option<GpsTime> {
        self.waiting.front()?.time
    }

    /// Whether a scan has no time yet.
    pub fn needs_times(&self) -> bool {
        self.waiting.iter().any(|waiting| waiting.time.is_none())
    }

    /// Gives scans their times: until they are placed, later stamps make these better.
    pub fn settle_times(&mut self, settled: &Settled) {
        for waiting in &mut self.waiting {
            let before = || Some(waiting.time? + settled.change_s.unwrap_or(0.0));
            waiting.time = settled.time(waiting.number).or_else(before);
        }
    }

    /// Scans that will never have a time are dropped; returns their number.
    pub fn forget_untimed(&mut self) -> u64 {
        let before = self.waiting.len();
        self.waiting.retain(|waiting| waiting.time.is_some());
        (before - self.waiting.len()) as u64
    }

    /// Takes scans whose places are known, at most a batch.
    pub fn take_placed(
        &mut self,
        positions: &mut Positions,
        settings: &LiveSettings,
        counts: &mut PulseCounts,
    ) -> Batch {
        let (mut traces, mut placed) = Batch::default();
        (self.without_heading, self.without_clock) = (false, false);
        while let Some(front) = self.waiting.front() {
            let Some(time) = front.time else { break };
            let is_other = |trace: &PlacedTrace| trace.window != front.scan.window;
            // Another window begins a new batch.
            if traces.len() == MOST_PULSES || traces.last().is_some_and(is_other) {
                break;
            }
            let at = positions.at(time);
            let too_low = |up_m: f64| up_m - settings.z_m < settings.least_height_m;
            match at {
                Placed::Waiting => break,
                Placed::WithoutHeading { up_m } if !too_low(up_m) => {
                    self.without_heading = true;
                    for waiting in &mut self.waiting {
                        waiting.was_held = true;
                    }
                    break;
                }
                _ => {}
            }
            let Some(waiting) = self.pop() else { break };
            match at {
                Placed::At(place) if !too_low(place.position_m[2]) => {
                    traces.push(trace(&waiting.scan, &place, settings));
                    placed.push(PlacedScan {
                        came: waiting.came,
                        place,
                        was_held: waiting.was_held,
                    });
                }
                Placed::At(_) | Placed::WithoutHeading { .. } => counts.too_low += 1,
                Placed::Nowhere(_) | Placed::Waiting => counts.without_position += 1,
            }
        }
        (traces, placed)
    }

    /// Drops the oldest scans up to a time, for lack of time, all but `keep`, and returns their number. Scans
    /// that waited for the heading or a better clock are no delay of the imaging.
    pub fn drop_behind(&mut self, until: GpsTime, keep: usize) -> u64 {
        let is_ready = |waiting: &&Waiting| waiting.time.is_some_and(|time| time <= until);
        let ready = self.waiting.iter().take_while(is_ready).count();
        if self.without_heading || self.without_clock {
            self.backlog = ready;
            return 0;
        }
        let dropped = ready.saturating_sub(keep + self.backlog);
        for _ in 0..dropped {
            self.pop();
        }
        dropped as u64
    }
}

fn trace(scan: &Scan, place: &RadarPlace, settings: &LiveSettings) -> PlacedTrace {
    PlacedTrace {
        samples: scan.samples.iter().map(|&sample| sample as f32).collect(),
        window: scan.window,
        position_m: place.position_m,
        height_m: place.position_m[2] - settings.z_m,
    }
}
