//! Cancellation and progress of a run, and the threads that share the work.

pub(crate) mod watch;
pub(crate) mod workers;
