//! From a recording's records to an image: scans put together, timed, placed, cleaned, imaged.

use std::collections::VecDeque;
use std::time::Instant;

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::epoch_time;
use acerra_imaging::{Control, LiveImage, PlanOptions, PlaneGrid, PulseArrays, Pulses};
use acerra_radar::{Filtering, Scan};
use acerra_record::driver::{Intake, Standing, Taken};
use acerra_record::gnss::FrameFinder;
use acerra_record::log::{Record, RecordKind};
use acerra_record::message::{Message, Packet};

use crate::clean::{Clean, Cleaner, PlacedTrace};
use crate::clock::RunningClock;
use crate::error::LiveError;
use crate::positions::{Latest, Missing, Placed, Positions, RadarPlace};
use crate::settings::LiveSettings;
use crate::status::{ByKind, PulseCounts, Status};

/// Pulses imaged together at most: what a batch adds to the latency is bounded.
const MOST_PULSES: usize = 32;
/// Scans that wait at most: 80 s at 50 a second, 30 MB.
const MOST_WAITING: usize = 4096;
/// Scans whose arrival is remembered until they are whole.
const MOST_ARRIVALS: usize = 64;

/// A scan that waits for its time and place.
struct Waiting {
    scan: Scan,
    number: u64,
    time: Option<GpsTime>,
    came: Instant,
}

/// When the first message of a scan came.
struct Arrival {
    key: (u16, u32),
    host_s: f64,
}

/// Pulses that were added to the image.
#[derive(Debug)]
pub struct Step {
    /// When the last message of each came.
    pub came: Vec<Instant>,
    /// When their imaging began.
    pub begun: Instant,
    /// The clean traces.
    pub clean: Clean,
    /// How their places are known.
    pub places: Vec<RadarPlace>,
}

/// From records to an image.
pub struct Pipeline {
    settings: LiveSettings,
    clock: RunningClock,
    positions: Positions,
    frames: FrameFinder,
    intake: Intake,
    arrivals: VecDeque<Arrival>,
    waiting: VecDeque<Waiting>,
    /// Scans whose places are known and that wait for the first ones to be enough.
    held: VecDeque<(Instant, RadarPlace)>,
    cleaner: Cleaner,
    image: Option<(PlaneGrid, LiveImage)>,
    numbers: u64,
    counts: PulseCounts,
    by_kind: ByKind,
    clock_sigma_s: Option<f64>,
    clock_trouble: Option<String>,
}

impl Pipeline {
    /// A pipeline that has seen nothing.
    #[must_use]
    pub fn new(settings: LiveSettings) -> Self {
        Self {
            clock: RunningClock::new(settings.latency),
            positions: Positions::new(settings.origin, settings.lever_arm_m),
            frames: FrameFinder::default(),
            intake: Intake::default(),
            arrivals: VecDeque::new(),
            waiting: VecDeque::new(),
            held: VecDeque::new(),
            cleaner: Cleaner::new(&settings),
            image: None,
            numbers: 0,
            counts: PulseCounts::default(),
            by_kind: ByKind::default(),
            clock_sigma_s: None,
            clock_trouble: None,
            settings,
        }
    }

    /// Takes a record that came at an instant.
    pub fn take(&mut self, record: &Record, came: Instant) {
        let host_s = 1e-9 * record.at_ns as f64;
        match record.kind {
            RecordKind::Settings => {
                // Another start of the recording: the host's clock begins anew, scans without a time are lost.
                self.clock.restarted();
                self.forget_untimed();
            }
            RecordKind::Radio => self.message(&record.payload, host_s, came),
            RecordKind::Gnss => self.gnss(&record.payload, host_s),
            _ => {}
        }
    }

    fn message(&mut self, body: &[u8], host_s: f64, came: Instant) {
        if let Ok(Packet {
            message: Message::ScanInfo(message),
            ..
        }) = Packet::decode(body)
        {
            let key = (message.header.message_id, message.header.timestamp_ms);
            if self.arrivals.iter().all(|arrival| arrival.key != key) {
                self.arrivals.push_back(Arrival { key, host_s });
                if self.arrivals.len() > MOST_ARRIVALS {
                    self.arrivals.pop_front();
                }
            }
        }
        if self.intake.take(body) == Taken::Scan(Standing::Restarted) {
            self.clock.radio_restarted();
            self.forget_untimed();
        }
        while let Some(scan) = self.intake.next_scan() {
            if scan.filtering != Filtering::Raw {
                continue;
            }
            let key = (scan.message_id, scan.timestamp_ms);
            let arrival = self.arrivals.iter().find(|arrival| arrival.key == key);
            let scan_host_s = arrival.map_or(host_s, |arrival| arrival.host_s);
            let number = self.numbers;
            self.numbers += 1;
            self.counts.came += 1;
            self.clock
                .scan(number, scan.message_id, scan.timestamp_ms, scan_host_s);
            self.waiting.push_back(Waiting {
                scan,
                number,
                time: None,
                came,
            });
            if self.waiting.len() > MOST_WAITING {
                self.waiting.pop_front();
                self.counts.without_position += 1;
            }
        }
    }

    fn gnss(&mut self, bytes: &[u8], host_s: f64) {
        let (clock, positions) = (&mut self.clock, &mut self.positions);
        self.frames.take(bytes, host_s, |frame, host_s| {
            if let Some(time) = epoch_time(frame) {
                clock.epoch(time, host_s);
            }
            if let Some(time) = positions.ubx(frame) {
                clock.solution(time, host_s);
            }
        });
        if let Some(time) = self.positions.nmea(bytes) {
            self.clock.solution(time, host_s);
        }
    }

    /// Scans without a time will never have one.
    fn forget_untimed(&mut self) {
        let before = self.waiting.len();
        self.waiting.retain(|waiting| waiting.time.is_some());
        self.counts.without_position += (before - self.waiting.len()) as u64;
    }

    /// Images the pulses that can be imaged by now, a batch of them at most; none where there are none.
    ///
    /// # Errors
    /// Traces that cannot be cleaned, pulses that cannot be imaged, cancellation.
    pub fn step(&mut self, control: Control<'_>) -> Result<Option<Step>, LiveError> {
        let begun = Instant::now();
        self.settle_times();
        let (traces, placed) = self.place();
        if traces.is_empty() {
            return Ok(None);
        }
        self.held.extend(placed);
        let (clean, given_up) = self.cleaner.take(traces)?;
        self.counts.not_cleaned += given_up;
        // Those that were given up are the oldest ones.
        for _ in 0..given_up {
            self.held.pop_front();
        }
        let Some(clean) = clean else {
            return Ok(None);
        };
        let held: Vec<(Instant, RadarPlace)> = self.held.drain(..).collect();
        self.add(&clean, control)?;
        self.counts.imaged += held.len() as u64;
        for (_, place) in &held {
            self.by_kind.count(place.status);
        }
        Ok(Some(Step {
            came: held.iter().map(|(came, _)| *came).collect(),
            begun,
            clean,
            places: held.into_iter().map(|(_, place)| place).collect(),
        }))
    }

    fn settle_times(&mut self) {
        if self.waiting.iter().all(|waiting| waiting.time.is_some()) {
            return;
        }
        match self.clock.settle() {
            Ok(settled) => {
                self.clock_sigma_s = Some(settled.sigma_s);
                self.clock_trouble = None;
                // Until they are placed, later stamps make their times better.
                for waiting in &mut self.waiting {
                    waiting.time = settled.time(waiting.number).or(waiting.time);
                }
            }
            Err(error) => self.clock_trouble = Some(error.to_string()),
        }
    }

    /// Scans from the front whose places are known, a batch of them at most.
    fn place(&mut self) -> (Vec<PlacedTrace>, Vec<(Instant, RadarPlace)>) {
        let (mut traces, mut placed) = (Vec::new(), Vec::new());
        while let Some(time) = self.waiting.front().and_then(|waiting| waiting.time) {
            let at = self.positions.at(time);
            if at == Placed::Waiting || traces.len() == MOST_PULSES {
                break;
            }
            let window = self.waiting.front().map(|waiting| waiting.scan.window);
            let is_other = |trace: &PlacedTrace| window.is_some_and(|w| w != trace.window);
            if traces.last().is_some_and(is_other) {
                // Another window is a batch of its own.
                break;
            }
            let Some(waiting) = self.waiting.pop_front() else {
                break;
            };
            let place = match at {
                Placed::At(place) => place,
                Placed::Nowhere(Missing::Heading) => {
                    self.counts.without_heading += 1;
                    continue;
                }
                Placed::Nowhere(_) | Placed::Waiting => {
                    self.counts.without_position += 1;
                    continue;
                }
            };
            let height_m = place.position_m[2] - self.settings.z_m;
            if height_m < self.settings.least_height_m {
                self.counts.too_low += 1;
                continue;
            }
            let samples = waiting.scan.samples.iter().map(|&sample| sample as f32);
            traces.push(PlacedTrace {
                samples: samples.collect(),
                window: waiting.scan.window,
                position_m: place.position_m,
                height_m,
            });
            placed.push((waiting.came, place));
        }
        (traces, placed)
    }

    fn add(&mut self, clean: &Clean, control: Control<'_>) -> Result<(), LiveError> {
        let (_, image) = match &mut self.image {
            Some(image) => image,
            none => {
                let [x_m, y_m, _] = clean.position_m.first().copied().unwrap_or_default();
                let grid = self.settings.grid([x_m, y_m])?;
                let options = PlanOptions::default()
                    .with_accuracy(self.settings.accuracy)
                    .with_check_pixels(16);
                none.insert((grid, LiveImage::new(grid, options)))
            }
        };
        let count = clean.position_m.len();
        let frequencies = self.settings.frequency_hz.len();
        let mut done = 0;
        // All of the first traces come at once.
        while done < count {
            let range = done..count.min(done + MOST_PULSES);
            let weight = vec![1.0; range.len()];
            let pulses = Pulses::new(PulseArrays {
                position_m: &clean.position_m[range.clone()],
                frequency_hz: &self.settings.frequency_hz,
                spectrum: &clean.spectrum[range.start * frequencies..range.end * frequencies],
                weight: &weight,
                light_speed_m_s: self.settings.light_speed_m_s,
            })?;
            image.push(pulses, control)?;
            done = range.end;
        }
        Ok(())
    }

    /// Drops the oldest pulses whose positions are there and that imaging has no time for, all but `keep`.
    pub fn drop_behind(&mut self, keep: usize) {
        let latest = self.positions.latest();
        let is_ready = |waiting: &Waiting| {
            waiting
                .time
                .zip(latest)
                .is_some_and(|(time, latest)| time <= latest.time)
        };
        let ready = self.waiting.iter().take_while(|w| is_ready(w)).count();
        for _ in keep..ready {
            self.waiting.pop_front();
            self.counts.too_many += 1;
        }
    }

    /// The image so far, and where its pixels are.
    #[must_use]
    pub fn image(&self) -> Option<(&PlaneGrid, &LiveImage)> {
        self.image.as_ref().map(|(grid, image)| (grid, image))
    }

    /// The latest position of the antenna.
    #[must_use]
    pub fn latest_position(&self) -> Option<Latest> {
        self.positions.latest()
    }

    /// Origin of the local frame: latitude and longitude (degrees), height (m).
    #[must_use]
    pub fn origin_deg_m(&self) -> Option<[f64; 3]> {
        let origin = self.positions.frame()?.origin();
        Some([
            origin.latitude_deg(),
            origin.longitude_deg(),
            origin.height_m,
        ])
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &LiveSettings {
        &self.settings
    }

    /// The state, without what only the one who shows it knows.
    #[must_use]
    pub fn status(&self) -> Status {
        let latest = self.positions.latest();
        let mut pulses = self.counts;
        pulses.waiting = (self.waiting.len() + self.cleaner.waiting()) as u64;
        let has_no_fix = self.positions.is_without_fix();
        Status {
            pulses,
            by_kind: self.by_kind,
            position: latest
                .filter(|_| !has_no_fix)
                .map(|latest| latest.status.name()),
            sigma_m: latest
                .and_then(|latest| latest.sigma_m)
                .map(|sigma_m| sigma_m.into_iter().fold(0.0, f64::max)),
            quarter_wavelength_m: self.settings.quarter_wavelength_m(),
            positions: self.positions.taken(),
            clock_sigma_s: self.clock_sigma_s,
            waits_for: self.waits_for(),
            shift_ns: self.cleaner.shift_s().map(|s| 1e9 * s),
            link: self.intake.counts(),
            ..Status::default()
        }
    }

    /// What keeps pulses from being imaged.
    fn waits_for(&self) -> Option<String> {
        if self.counts.came == 0 {
            return Some("the first scan".to_owned());
        }
        if self.positions.latest().is_none() {
            let undated = self.positions.undated();
            return Some(match undated {
                0 => "the receiver's first position (NAV-PVT, GGA)".to_owned(),
                _ => format!("a date: {undated} GGA positions came without RMC or ZDA"),
            });
        }
        if let Some(trouble) = &self.clock_trouble {
            return Some(format!("the clocks: {trouble}"));
        }
        if let Some(trouble) = self.cleaner.trouble() {
            return Some(format!(
                "where range is zero ([flight] delay_ns states it): {trouble}"
            ));
        }
        if self.cleaner.shift_s().is_some() {
            return None;
        }
        if self.counts.without_heading > 0 && self.cleaner.waiting() == 0 {
            return Some("motion that tells the heading, by which the lever arm turns".to_owned());
        }
        if self.counts.too_low > 0 && self.cleaner.waiting() == 0 {
            return Some("take-off".to_owned());
        }
        Some("the first pulses in flight".to_owned())
    }
}
