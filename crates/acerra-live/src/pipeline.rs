//! From a recording's records to an image: scans put together, timed, placed, cleaned, imaged.
//!
//! A pulse is imaged twice: as soon as it has come, where the motion of the platform puts it, and anew once
//! the position after it has come. The first kind is taken out of the picture before, so that what stays is
//! what would have been imaged without it.

use std::collections::VecDeque;
use std::time::Instant;

use acerra_gnss::ubx::epoch_time;
use acerra_imaging::{Control, LiveImage, PlaneGrid};
use acerra_record::gnss::FrameFinder;
use acerra_record::log::{Record, RecordKind};
use num_complex::Complex32;

use crate::canvas::{Canvas, MOST_PULSES};
use crate::clean::{Clean, Cleaner};
use crate::clock::RunningClock;
use crate::error::LiveError;
use crate::foresight::Foresight;
use crate::place::{Latest, RadarPlace};
use crate::positions::Positions;
use crate::queue::{PlacedScan, Queue};
use crate::scans::Scans;
use crate::settings::LiveSettings;
use crate::status::{ByKind, PulseCounts, Status};

/// What is new in the image.
#[derive(Debug)]
pub struct Step {
    /// When the last message came of each pulse that no picture has shown before and that did not wait for the
    /// heading.
    pub came: Vec<Instant>,
    /// When the imaging began.
    pub begun: Instant,
    /// Pulses that are there to stay: their clean traces, and how their places are known.
    pub settled: Option<(Clean, Vec<RadarPlace>)>,
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
    /// The cleaning as it goes on behind the scans whose places are known.
    cleaner_ahead: Option<Cleaner>,
    foresight: Foresight,
    looks_ahead: bool,
    canvas: Option<Canvas>,
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
            scans: Scans::default(),
            queue: Queue::default(),
            held: VecDeque::new(),
            cleaner: Cleaner::new(&settings),
            cleaner_ahead: None,
            foresight: Foresight::new(4.0 * settings.quarter_wavelength_m()),
            looks_ahead: true,
            canvas: None,
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
                self.counts.without_position += self.queue.forget_untimed();
            }
            RecordKind::Radio => self.message(&record.payload, host_s, came),
            RecordKind::Gnss => self.gnss(&record.payload, host_s),
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

    /// Images the pulses that can be imaged by now, a batch of them at most; none where nothing is new.
    ///
    /// # Errors
    /// Traces that cannot be cleaned, pulses that cannot be imaged, cancellation.
    pub fn step(&mut self, control: Control<'_>) -> Result<Option<Step>, LiveError> {
        let begun = Instant::now();
        self.settle_times();
        let (taken, placed) = self.settle(control)?;
        let mut step = Step {
            came: Vec::new(),
            begun,
            settled: None,
        };
        if let Some((clean, scans)) = placed {
            let new = scans.iter().filter(|scan| scan.is_fresh);
            step.came.extend(new.map(|scan| scan.came));
            let places = scans.iter().map(|scan| scan.place).collect();
            step.settled = Some((clean, places));
        }
        // A full batch has others behind it whose places are known.
        let mut is_more_ahead = false;
        if taken < MOST_PULSES
            && let Some(came) = self.image_ahead(control)?
        {
            step.came.extend(came);
            is_more_ahead = true;
        }
        let is_new = step.settled.is_some() || is_more_ahead;
        Ok(is_new.then_some(step))
    }

    fn settle_times(&mut self) {
        if !self.queue.needs_times() {
            return;
        }
        match self.clock.settle() {
            Ok(settled) => {
                self.clock_sigma_s = Some(settled.sigma_s);
                self.clock_trouble = None;
                self.queue.settle_times(settled);
            }
            Err(error) => self.clock_trouble = Some(error.to_string()),
        }
    }

    /// Images scans whose places are known: how many were taken, and those imaged with their clean traces.
    #[expect(clippy::type_complexity, reason = "a pair that is used once")]
    fn settle(
        &mut self,
        control: Control<'_>,
    ) -> Result<(usize, Option<(Clean, Vec<PlacedScan>)>), LiveError> {
        let (settings, counts) = (&self.settings, &mut self.counts);
        let (traces, placed) = self
            .queue
            .take_placed(&mut self.positions, settings, counts);
        let taken = traces.len();
        for off_m in placed.iter().filter_map(|scan| scan.off_m) {
            self.foresight.take(off_m);
        }
        self.held.extend(placed);
        if taken == 0 {
            return Ok((0, None));
        }
        let (clean, given_up) = self.cleaner.take(traces)?;
        self.counts.not_cleaned += given_up;
        // Those that were given up are the oldest ones.
        for _ in 0..given_up {
            self.held.pop_front();
        }
        let Some(clean) = clean else {
            return Ok((taken, None));
        };
        let scans: Vec<PlacedScan> = self.held.drain(..).collect();
        let canvas = match &mut self.canvas {
            Some(canvas) => canvas,
            none => {
                let [x_m, y_m, _] = clean.position_m.first().copied().unwrap_or_default();
                let grid = self.settings.grid([x_m, y_m])?;
                none.insert(Canvas::new(grid, self.settings.accuracy))
            }
        };
        canvas.settle(&clean, &self.settings, control)?;
        self.counts.imaged += scans.len() as u64;
        for scan in &scans {
            self.by_kind.count(scan.place.status);
        }
        Ok((taken, Some((clean, scans))))
    }

    /// Images scans beyond the latest position; returns when those of them came that are fresh, and none without
    /// any scans.
    fn image_ahead(&mut self, control: Control<'_>) -> Result<Option<Vec<Instant>>, LiveError> {
        if self.queue.is_unseen() {
            self.forget_ahead();
        }
        let (Some(canvas), Some(window), true) =
            (&mut self.canvas, self.cleaner.window(), self.looks_ahead)
        else {
            return Ok(None);
        };
        let are_shown = self.foresight.is_good();
        let (positions, settings) = (&mut self.positions, &self.settings);
        let (traces, placed) = self
            .queue
            .look_ahead(positions, settings, window, are_shown);
        let cleaner = self
            .cleaner_ahead
            .get_or_insert_with(|| self.cleaner.clone());
        let (Some(clean), _) = cleaner.take(traces)? else {
            return Ok(None);
        };
        canvas.add_ahead(&clean, &self.settings, control)?;
        let new = placed.iter().filter(|scan| scan.is_fresh);
        Ok(Some(new.map(|scan| scan.came).collect()))
    }

    /// Takes pulses at extrapolated places out of the image.
    fn forget_ahead(&mut self) {
        self.cleaner_ahead = None;
        if let Some(canvas) = &mut self.canvas {
            canvas.forget_ahead();
        }
    }

    /// Whether pulses beyond the latest position are imaged; they are by default.
    pub fn look_ahead(&mut self, looks_ahead: bool) {
        self.looks_ahead = looks_ahead;
        if !looks_ahead {
            self.forget_ahead();
        }
    }

    /// Drops the oldest pulses whose positions are there and that imaging has no time for, all but `keep`.
    pub fn drop_behind(&mut self, keep: usize) {
        if let Some(latest) = self.positions.latest() {
            self.counts.too_many += self.queue.drop_behind(latest.time, keep);
        }
    }

    /// The image of the pulses between positions, and where its pixels are.
    #[must_use]
    pub fn image(&self) -> Option<(&PlaneGrid, &LiveImage)> {
        let canvas = self.canvas.as_ref()?;
        Some((&canvas.grid, canvas.settled()))
    }

    /// The image with the pulses beyond the latest position, and where its pixels are.
    #[must_use]
    pub fn shown(&mut self) -> Option<(PlaneGrid, &[Complex32])> {
        let canvas = self.canvas.as_mut()?;
        Some((canvas.grid, canvas.shown()))
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
        pulses.waiting = (self.queue.len() + self.cleaner.waiting()) as u64;
        let canvas = self.canvas.as_ref();
        pulses.ahead = canvas.map_or(0, |canvas| canvas.pulses_ahead() as u64);
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
            foresight: self.foresight.figures(),
            link: self.scans.counts(),
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
        if self.queue.is_without_heading() {
            return Some("motion that tells the heading, by which the lever arm turns".to_owned());
        }
        if self.cleaner.shift_s().is_some() {
            return None;
        }
        if self.counts.too_low > 0 && self.cleaner.waiting() == 0 {
            return Some("take-off".to_owned());
        }
        Some("the first pulses in flight".to_owned())
    }
}
