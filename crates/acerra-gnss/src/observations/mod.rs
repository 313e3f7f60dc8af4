//! Observations of a receiver: satellites, signals, epochs, and the choice of signals.

pub(crate) mod join;
pub(crate) mod observation;
pub(crate) mod recorded;
pub(crate) mod satellite;
pub(crate) mod select;
pub(crate) mod signal;
