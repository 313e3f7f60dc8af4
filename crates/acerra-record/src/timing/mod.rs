//! Clocks: the radio's and GPS time over the recording computer's, from the times at which messages
//! arrived.

mod fit;
mod logged;

pub use fit::{ClockLine, FitError, LEAST_PAIRS, Pair, clock_line};
pub use logged::{Latency, Stamps, TimingError, logged_clock};
