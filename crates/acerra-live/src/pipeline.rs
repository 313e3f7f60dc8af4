//! From a recording's records to an image: scans put together, timed, placed, cleaned, imaged.

use std::collections::VecDeque;
use std::time::Instant;

use acerra_gnss::ubx::epoch_time;
use acerra_imaging::{Control, LiveImage, PlaneGrid};
use acerra_record::gnss::FrameFinder;
use acerra_record::log::{Record, RecordKind};
use acerra_record::pps::PulseStamp;

use crate::canvas::Canvas;
use crate::clean::{Clean, Cleaner};
use crate::clock::RunningClock;
use crate::error::LiveError;
use crate::hardware_clock::ClockKind;
use crate::patience::{CLOCK_WAIT_S, Patience};
use crate::place::RadarPlace;
use crate::positions::Positions;
use crate::queue::{PlacedScan, Queue};
use crate::scans::Scans;
use crate::settings::LiveSettings;
use crate::status::{BegunAnew, ByKind, PulseCounts, Status};

/// Pulses that were added to the image.
#[derive(Debug)]
pub struct Step {
    /// When the last message came of each that did not wait for the heading or a better clock.
    pub came: Vec<Instant>,
    /// When their imaging began.
    pub begun: Instant,
    /// The clean traces.
    pub clean: Clean,
    /// Source of the pulses' places.
    pub places: Vec<RadarPlace>,
}

/// From records to an image.
pub struct Pipeline {
    settings: LiveSettings,
    clock: RunningClock,
    positions: Positions,
    frames: FrameFinder,
    scans: Scans,
    queue: Queue,
    /// Scans whose places are known and that wait for the first ones to be enough.
    held: VecDeque<PlacedScan>,
    cleaner: Cleaner,
    canvas: Option<Canvas>,
    numbers: u64,
    /// The latest record's host time (s).
    host_s: f64,
    counts: PulseCounts,
    by_kind: ByKind,
    clock_sigma_s: Option<f64>,
    clock_kind: Option<ClockKind>,
    /// Whether pulses were imaged by that clock.
    has_imaged_by_it: bool,
    clock_trouble: Option<String>,
    patience: Patience,
    /// Fastest that the platform was while pulses were imaged (m/s).
    most_speed_m_s: f64,
    begun_anew: Option<BegunAnew>,
}

/// Share of a quarter of the wavelength by which the pulses of a picture may be misplaced against one another.
const TEAR_SHARE: f64 = 0.5;

impl Pipeline {
    /// A pipeline without data.
    #[must_use]
    pub fn new(settings: LiveSettings) -> Self {
        Self {
            clock: RunningClock::new(settings.latency, settings.wiring),
            positions: Positions::new(settings.origin, settings.lever_arm_m),
            frames: FrameFinder::default(),
            scans: Scans::default(),
            queue: Queue::default(),
            held: VecDeque::new(),
            cleaner: Cleaner::new(&settings),
            canvas: None,
            numbers: 0,
            counts: PulseCounts::default(),
            by_kind: ByKind::default(),
            clock_sigma_s: None,
            clock_kind: None,
            has_imaged_by_it: false,
            clock_trouble: None,
            patience: Patience::default(),
            most_speed_m_s: 0.0,
            begun_anew: None,
            host_s: 0.0,
            settings,
        }
    }

    /// Takes a record that came at an instant.
    pub fn take(&mut self, record: &Record, came: Instant) {
        let host_s = 1e-9 * record.at_ns as f64;
        self.host_s = host_s;
        match record.kind {
            RecordKind::Settings => {
                // Another start of the recording: the host's clock starts again, scans without a time are lost.
                self.clock.restarted();
                (self.clock_kind, self.has_imaged_by_it) = (None, false);
                self.patience = Patience::Fresh;
                self.counts.without_position += self.queue.forget_untimed();
            }
            RecordKind::Radio => self.message(&record.payload, host_s, came),
            RecordKind::Gnss => self.gnss(&record.payload, host_s),
            RecordKind::Pulse => {
                // A record without a valid pulse is counted when the session's files are made.
                if let Ok(stamp) = PulseStamp::parse(&record.payload) {
                    self.clock.pulse(stamp.sequence, host_s);
                }
            }
            _ => {}
        }
    }

    fn message(&mut self, body: &[u8], host_s: f64, came: Instant) {
        if self.scans.take(body, host_s) {
            self.clock.radio_restarted();
            self.counts.without_position += self.queue.forget_untimed();
        }
        while let Some((scan, scan_host_s)) = self.scans.next(host_s) {
            let number = self.numbers;
            self.numbers += 1;
            self.counts.came += 1;
            self.clock
                .scan(number, scan.message_id, scan.timestamp_ms, scan_host_s);
            self.queue.push(scan, number, came, &mut self.counts);
        }
    }

    fn gnss(&mut self, bytes: &[u8], host_s: f64) {
        self.positions.need_from(self.queue.oldest());
        let (clock, positions) = (&mut self.clock, &mut self.positions);
        self.frames.take(bytes, host_s, |frame, host_s| {
            clock.frame(frame, host_s);
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

    /// Images the pulses that can be imaged by now, a batch at most; none where no pulse can.
    ///
    /// # Errors
    /// Traces that cannot be cleaned, pulses that cannot be imaged, cancellation.
    pub fn step(&mut self, control: Control<'_>) -> Result<Option<Step>, LiveError> {
        let begun = Instant::now();
        self.settle_times();
        if self.patience.is_waiting() {
            self.queue.hold();
            return Ok(None);
        }
        let (settings, counts) = (&self.settings, &mut self.counts);
        let (traces, placed) = self
            .queue
            .take_placed(&mut self.positions, settings, counts);
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
        let scans: Vec<PlacedScan> = self.held.drain(..).collect();
        self.add(&clean, control)?;
        self.counts.imaged += scans.len() as u64;
        self.has_imaged_by_it = true;
        self.most_speed_m_s = self.most_speed_m_s.max(self.positions.speed_m_s());
        for scan in &scans {
            self.by_kind.count(scan.place.status);
        }
        let in_time = scans.iter().filter(|scan| !scan.was_held);
        Ok(Some(Step {
            came: in_time.map(|scan| scan.came).collect(),
            begun,
            clean,
            places: scans.iter().map(|scan| scan.place).collect(),
        }))
    }

    fn add(&mut self, clean: &Clean, control: Control<'_>) -> Result<(), LiveError> {
        let canvas = match &mut self.canvas {
            Some(canvas) => canvas,
            none => {
                let [x_m, y_m, _] = clean.position_m.first().copied().unwrap_or_default();
                let grid = self.settings.grid([x_m, y_m])?;
                none.insert(Canvas::new(grid, self.settings.accuracy))
            }
        };
        Ok(canvas.add(clean, &self.settings, control)?)
    }

    fn settle_times(&mut self) {
        if self.queue.needs_times() {
            self.settle();
        }
        if let Some(kind) = self.clock_kind {
            let has_best = kind >= self.clock.expected();
            self.patience = self
                .patience
                .at(self.host_s, has_best, self.queue.is_half_full());
        }
    }

    fn settle(&mut self) {
        let settled = match self.clock.settle() {
            Ok(settled) => settled,
            Err(error) => {
                self.clock_trouble = Some(error.to_string());
                return;
            }
        };
        let (kind, change_s) = (settled.kind, settled.change_s);
        self.clock_sigma_s = Some(settled.sigma_s);
        self.clock_trouble = None;
        self.queue.settle_times(settled);
        let before = self.clock_kind.replace(kind);
        if let (Some(before), Some(change_s)) = (before, change_s) {
            self.begin_anew_where_torn(before, change_s);
        }
    }

    /// Restarts the picture where a better clock has moved times so far that earlier and later pulses would
    /// not focus together.
    fn begin_anew_where_torn(&mut self, before: ClockKind, change_s: f64) {
        let limit_m = TEAR_SHARE * self.settings.quarter_wavelength_m();
        let moved_m = (change_s * self.most_speed_m_s).abs();
        let has_imaged = std::mem::take(&mut self.has_imaged_by_it);
        let is_torn = has_imaged && moved_m > limit_m;
        let Some(canvas) = self.canvas.as_mut().filter(|_| is_torn) else {
            return;
        };
        canvas.clear();
        self.counts.begun_anew += std::mem::take(&mut self.counts.imaged);
        self.by_kind = ByKind::default();
        self.begun_anew = Some(BegunAnew {
            before: before.name(),
            change_ms: 1e3 * change_s,
            moved_m,
        });
    }

    /// Drops the oldest pulses whose positions are there and that imaging has no time for, all but `keep`.
    pub fn drop_behind(&mut self, keep: usize) {
        if let Some(latest) = self.positions.latest() {
            self.counts.too_many += self.queue.drop_behind(latest.time, keep);
        }
    }

    /// The image so far, and the places of its pixels.
    #[must_use]
    pub fn image(&self) -> Option<(&PlaneGrid, &LiveImage)> {
        let canvas = self.canvas.as_ref()?;
        Some((&canvas.grid, &canvas.image))
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

    /// The state, without fields that only the display knows.
    #[must_use]
    pub fn status(&self) -> Status {
        let latest = self.positions.latest();
        let mut pulses = self.counts;
        pulses.waiting = (self.queue.len() + self.cleaner.waiting()) as u64;
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
            clock: self.clock_kind.map(ClockKind::name),
            clock_doubt: match self.patience {
                Patience::Over => self.clock.hardware_trouble().map(str::to_owned),
                _ => None,
            },
            begun_anew: self.begun_anew,
            least_height_m: self.settings.least_height_m,
            waits_for: self.waits_for(),
            shift_ns: self.cleaner.shift_s().map(|s| 1e9 * s),
            link: self.scans.counts(),
            ..Status::default()
        }
    }

    /// Reason why pulses cannot be imaged.
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
        if self.patience.is_waiting() {
            let trouble = self.clock.hardware_trouble().unwrap_or_default();
            return Some(format!(
                "the better clock, {CLOCK_WAIT_S} s at most: {trouble}"
            ));
        }
        if let Some(trouble) = self.cleaner.trouble() {
            return Some(format!(
                "where range is zero ([flight] delay_ns states it): {trouble}"
            ));
        }
        if self.queue.is_without_heading() {
            return Some("motion that gives the heading, by which the lever arm turns".to_owned());
        }
        if self.cleaner.shift_s().is_some() {
            return None;
        }
        if self.counts.too_low > 0 && self.cleaner.waiting() == 0 {
            return Some(match self.settings.planned_height_m {
                Some(planned_m) => format!(
                    "a height of {:.1} m above the image plane, three quarters of the {planned_m:.1} m planned ([flight] \
                     height_m, [live] least_height_m)",
                    self.settings.least_height_m
                ),
                None => "take-off".to_owned(),
            });
        }
        Some("the first pulses in flight".to_owned())
    }
}
