//! Continuous scanning under watch: a radio that falls silent or starts again is set up and started
//! again, for as long as it takes.

use std::time::{Duration, Instant};

use acerra_radar::Scan;
use acerra_radar::mrm::RadarConfig;

use super::counts::LinkCounts;
use super::error::DriverError;
use super::request::Driver;
use super::setup::Setup;
use crate::link::{Arrival, Link};
use crate::message::StatusInfo;

/// Radio time that may pass less than host time over a silence, ms, before the radio counts as started
/// again: delays of messages and drift of either clock over hours.
const CLOCK_TOLERANCE_MS: i64 = 2_000;

/// Time after which a radio counts as silent, and interval of status requests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WatchOptions {
    /// Time without a scan after which the radio's status is requested.
    pub silence: Duration,
    /// Time between attempts to reach a silent radio.
    pub retry: Duration,
    /// Time between requests for status and temperature; zero for none.
    pub status_every: Duration,
}

impl Default for WatchOptions {
    fn default() -> Self {
        Self {
            silence: Duration::from_secs(1),
            retry: Duration::from_secs(1),
            status_every: Duration::from_secs(10),
        }
    }
}

/// Events while a radio scans.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A message came, as it is.
    Message(Arrival),
    /// A scan is whole.
    Scan(Scan),
    /// Versions and temperature.
    Status(StatusInfo),
    /// No scan arrived for this time, and the radio does not answer; the text gives the cause.
    Silent(String),
    /// The radio scans again after a silence.
    Resumed {
        /// Seconds from the last scan before.
        after_s: f64,
        /// Whether its clock started again.
        restarted: bool,
    },
}

/// A radio that scans under watch.
pub struct Watched<L> {
    driver: Driver<L>,
    setup: Setup,
    options: WatchOptions,
    config: RadarConfig,
    last_scan: Instant,
    last_status: Instant,
    last_attempt: Instant,
    is_silent: bool,
}

impl<L: Link> Watched<L> {
    /// Sets the radio up and starts scans.
    ///
    /// # Errors
    /// A radio that does not answer, refuses a setting, or reads back another.
    pub fn start(
        mut driver: Driver<L>,
        setup: Setup,
        options: WatchOptions,
    ) -> Result<Self, DriverError> {
        let config = driver.set_up(&setup)?;
        driver.start(setup.scan_interval_us)?;
        let now = Instant::now();
        Ok(Self {
            driver,
            setup,
            options,
            config,
            last_scan: now,
            last_status: now,
            last_attempt: now,
            is_silent: false,
        })
    }

    /// The configuration in force.
    #[must_use]
    pub fn config(&self) -> RadarConfig {
        self.config
    }

    /// The account so far.
    #[must_use]
    pub fn counts(&mut self) -> LinkCounts {
        self.driver.intake().counts()
    }

    /// Interval between scans by the radio's clock, s.
    pub fn interval_s(&mut self) -> f64 {
        self.driver.intake().sequence().interval_s()
    }

    /// The next event; `None` without one within `wait`. Silence is not a failure: it is reported once, and
    /// the radio is retried until it answers again. Every refusal of the settings by a radio that came back
    /// is reported.
    pub fn next_event(&mut self, wait: Duration) -> Option<Event> {
        if let Some(scan) = self.driver.intake().next_scan() {
            return Some(Event::Scan(scan));
        }
        if self.is_silent {
            return self.look_for_radio(wait);
        }
        if !self.options.status_every.is_zero()
            && self.last_status.elapsed() >= self.options.status_every
        {
            self.last_status = Instant::now();
            // A status that does not come is no failure while scans do.
            if let Ok(status) = self.driver.status() {
                return Some(Event::Status(status));
            }
        }
        let before = self.driver.intake().counts().scan_messages;
        let arrival = match self.driver.next_arrival(wait) {
            Ok(arrival) => arrival,
            Err(error) => return Some(self.fall_silent(&error.to_string())),
        };
        if self.driver.intake().counts().scan_messages > before {
            self.last_scan = Instant::now();
        } else if self.last_scan.elapsed() >= self.patience() {
            return match arrival {
                Some(arrival) => Some(Event::Message(arrival)),
                None => {
                    let peer = self.driver.link().peer();
                    let why = format!("{peer}: the radio does not scan, or its cable is out");
                    Some(self.fall_silent(&why))
                }
            };
        }
        arrival.map(Event::Message)
    }

    /// Stops scans and reads messages in transit; scans that are still incomplete are given up.
    pub fn stop(&mut self) -> Vec<Event> {
        let mut events = Vec::new();
        // A radio that is gone needs no stopping.
        let _ = self.driver.stop();
        while let Ok(Some(arrival)) = self.driver.next_arrival(Duration::from_millis(50)) {
            events.push(Event::Message(arrival));
        }
        self.driver.intake().give_up_unfinished();
        while let Some(scan) = self.driver.intake().next_scan() {
            events.push(Event::Scan(scan));
        }
        events
    }

    /// Time without a scan that is too long: the option, or a few intervals of slow scans.
    fn patience(&mut self) -> Duration {
        let interval_s = f64::from(self.setup.scan_interval_us) * 1e-6;
        let interval_s = interval_s.max(self.interval_s());
        self.options
            .silence
            .max(Duration::from_secs_f64(4.0 * interval_s.min(60.0)))
    }

    fn fall_silent(&mut self, why: &str) -> Event {
        self.is_silent = true;
        self.driver.intake().count_silence();
        // The first attempt follows at once.
        self.last_attempt = Instant::now()
            .checked_sub(self.options.retry)
            .unwrap_or_else(Instant::now);
        Event::Silent(format!(
            "no scan for {:.1} s: {why}",
            self.last_scan.elapsed().as_secs_f64()
        ))
    }

    fn look_for_radio(&mut self, wait: Duration) -> Option<Event> {
        let since = self.last_attempt.elapsed();
        if since < self.options.retry {
            std::thread::sleep(wait.min(self.options.retry - since));
            return None;
        }
        self.last_attempt = Instant::now();
        match self.set_up_again() {
            Ok(restarted) => {
                let after_s = self.last_scan.elapsed().as_secs_f64();
                self.is_silent = false;
                self.last_scan = Instant::now();
                Some(Event::Resumed { after_s, restarted })
            }
            Err(error @ (DriverError::Refused { .. } | DriverError::ReadBack { .. })) => {
                Some(Event::Silent(error.to_string()))
            }
            Err(_) => None,
        }
    }

    /// Everything that a radio fresh from power-on needs. Returns whether its clock started again.
    fn set_up_again(&mut self) -> Result<bool, DriverError> {
        self.driver.link().reopen()?;
        let newest_ms = self.driver.intake().sequence().newest_ms();
        let silent_ms = self.last_scan.elapsed().as_millis() as i64;
        let clock_ms = self.driver.config()?.timestamp_ms;
        // Stamps wrap, hence the signed difference.
        let passed_ms = newest_ms.map(|newest| i64::from(clock_ms.wrapping_sub(newest) as i32));
        let restarted = passed_ms.is_some_and(|ms| ms < silent_ms - CLOCK_TOLERANCE_MS);
        if restarted {
            self.driver.intake().restart();
        }
        self.config = self.driver.set_up(&self.setup)?;
        self.driver.start(self.setup.scan_interval_us)?;
        Ok(restarted)
    }
}
