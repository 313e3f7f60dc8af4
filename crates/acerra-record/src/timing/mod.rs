//! Clocks: the radio's and GPS time over the recording computer's, from the times at which messages
//! arrived.

mod fit;
mod logged;
mod mark_line;
mod marks;

pub use fit::{ClockLine, FitError, LEAST_PAIRS, Pair, clock_line};
pub use logged::{Latency, Stamps, TimingError, logged_clock};
pub use marks::{MarkError, MarkedScans, marked_clock};
