//! Hatanaka-compressed RINEX ("compact RINEX", versions 1 and 3), expanded on the fly.
//!
//! Y. Hatanaka, "A compression format and tools for GNSS observation data", Bulletin of the
//! Geographical Survey Institute 55, 2008: text lines as character differences against the line
//! before, observations as differences (to an order chosen at the start of an arc) of integers in
//! the last decimal.

mod difference;
mod epoch;

pub use epoch::CrinexLines;
