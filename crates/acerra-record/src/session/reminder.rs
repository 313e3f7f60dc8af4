//! Warnings about a lasting condition, given after a while and repeated.

/// Time for which a condition lasts before a warning is given, and after which it is repeated (s).
const FIRST_AFTER_S: f64 = 2.0;
const AGAIN_AFTER_S: f64 = 30.0;

/// A condition that may last, and its warnings.
#[derive(Default)]
pub(super) struct Reminder {
    /// Host times of the condition's beginning and of the last warning (s).
    since_s: Option<f64>,
    warned_s: Option<f64>,
}

impl Reminder {
    /// The condition holds at `host_s`; its duration (s) where a warning is due.
    pub fn due(&mut self, host_s: f64) -> Option<f64> {
        let lasted_s = host_s - *self.since_s.get_or_insert(host_s);
        let is_due = match self.warned_s {
            None => lasted_s >= FIRST_AFTER_S,
            Some(warned_s) => host_s - warned_s >= AGAIN_AFTER_S,
        };
        is_due.then(|| {
            self.warned_s = Some(host_s);
            lasted_s
        })
    }

    /// The condition has ended; its beginning (s) where a warning was given.
    pub fn end(&mut self) -> Option<f64> {
        let ended = std::mem::take(self);
        ended.since_s.filter(|_| ended.warned_s.is_some())
    }
}
