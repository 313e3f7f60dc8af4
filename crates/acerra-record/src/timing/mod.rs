//! Clocks: the radio's and GPS time over the recording computer's, from the times at which messages
//! arrived, pulses per second and time marks.

mod fit;
mod logged;
mod marks;
mod pulse;
mod pulsed;
mod pulses;
mod robust_line;

pub use fit::{ClockLine, FitError, LEAST_PAIRS, Pair, clock_line};
pub use logged::{Latency, Stamps, TimingError, logged_clock};
pub use marks::{MarkError, MarkedScans, marked_clock};
pub use pulse::{Pulse, PulseError};
pub use pulsed::{PulsedClock, PulsedClockError, pulsed_clock};
