//! The height during the flight against the radio's window.

use super::plausibility::{delay_range_ns, echo_ns};
use super::progress::Progress;
use super::reminder::Reminder;
use super::settings::{FlightSection, RadioSection};

/// Heights that are less certain are not judged (m).
const MOST_SIGMA_M: f64 = 5.0;

/// Compares the height above where the recording began with the range that the window reaches.
pub(super) struct WindowWatch {
    window_end_ns: f64,
    least_delay_ns: f64,
    /// Height where the recording began (m).
    ground_m: Option<f64>,
    /// Warnings that the ground is behind the window.
    behind: Reminder,
}

impl WindowWatch {
    /// A watch over the window of a radio.
    pub fn new(radio: &RadioSection, flight: &FlightSection) -> Self {
        Self {
            window_end_ns: 1e-3 * f64::from(radio.window_ps[1]),
            least_delay_ns: delay_range_ns(flight)[0],
            ground_m: None,
            behind: Reminder::default(),
        }
    }

    /// Takes a height and its standard deviation (m) at `host_s`; the first height counts as the ground's.
    pub fn take(&mut self, height_m: f64, sigma_m: f64, host_s: f64) -> Option<Progress> {
        if sigma_m > MOST_SIGMA_M {
            return None;
        }
        let above_m = height_m - *self.ground_m.get_or_insert(height_m);
        // Two deviations lower it would still answer behind the window.
        let echo_ns = echo_ns((above_m - 2.0 * sigma_m).max(0.0), self.least_delay_ns);
        if echo_ns <= self.window_end_ns {
            self.behind.end();
            return None;
        }
        self.behind.due(host_s).map(|_| {
            Progress::Warning(format!(
                "the ground is behind the window ([radio] window_ps): {above_m:.0} m above where the recording \
                 began it answers at {echo_ns:.0} ns or later, and the window ends at {:.0} ns",
                self.window_end_ns
            ))
        })
    }
}
