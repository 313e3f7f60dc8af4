//! The recording computer's monotonic clock.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Monotonic nanoseconds since the start of a session; never set, never stepped.
#[derive(Debug, Clone, Copy)]
pub struct HostClock {
    start: Instant,
}

impl HostClock {
    /// A clock that begins now.
    #[must_use]
    pub fn start() -> Self {
        Self {
            start: Instant::now(),
        }
    }

    /// Nanoseconds since the start.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    /// The instant at which this clock read a number of nanoseconds.
    #[must_use]
    pub fn instant(&self, at_ns: u64) -> Instant {
        self.start
            .checked_add(Duration::from_nanos(at_ns))
            .unwrap_or(self.start)
    }
}

/// Seconds since 1970 by the computer's calendar clock, which may be wrong by anything; 0 before 1970.
#[must_use]
pub fn unix_time_s() -> f64 {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or(Duration::ZERO)
        .as_secs_f64()
}
