//! Selection of the receiver messages that report the fix.

use acerra_gnss::ubx::frame::Frame;
use acerra_gnss::ubx::{FixState, fix_state, is_solution};

/// Time after its latest solution for which a receiver's measurements are not judged (s): where it states
/// its fix itself, that counts.
const SOLUTION_HOLDS_S: f64 = 3.0;

/// The receiver's own report where it gives one, or else the satellites that it measures.
#[derive(Debug)]
pub struct FixSource {
    solution_s: f64,
}

impl Default for FixSource {
    fn default() -> Self {
        Self {
            solution_s: f64::NEG_INFINITY,
        }
    }
}

impl FixSource {
    /// Fix state in a message that came at `host_s`; `None` for other messages and for messages that do not count.
    pub fn take(&mut self, frame: &Frame<'_>, host_s: f64) -> Option<FixState> {
        let state = fix_state(frame)?;
        if is_solution(frame) {
            self.solution_s = host_s;
        } else if host_s - self.solution_s < SOLUTION_HOLDS_S {
            return None;
        }
        Some(state)
    }
}
