//! The time that several emulated instruments share.

use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// A world whose time begins when a client first starts the radio, so that no part of a flight is over before
/// a client listens.
#[derive(Debug, Clone)]
pub struct World {
    began: Arc<OnceLock<Instant>>,
    speed: f64,
}

impl World {
    /// A world that goes `speed` seconds in a second.
    #[must_use]
    pub fn new(speed: f64) -> Self {
        Self {
            began: Arc::default(),
            speed,
        }
    }

    /// Begins its time, where it has not begun.
    pub fn begin(&self) {
        self.began.get_or_init(Instant::now);
    }

    /// Seconds in a second.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// The instant of a world time (s); `None` before it begins, and of times that no instant has.
    #[must_use]
    pub fn instant(&self, at_s: f64) -> Option<Instant> {
        let after = Duration::try_from_secs_f64(at_s / self.speed).ok()?;
        self.began.get()?.checked_add(after)
    }

    /// Its time (s); `None` before it begins.
    #[must_use]
    pub fn now_s(&self) -> Option<f64> {
        let began = self.began.get()?;
        Some(began.elapsed().as_secs_f64() * self.speed)
    }
}
