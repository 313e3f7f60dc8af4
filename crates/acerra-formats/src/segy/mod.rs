//! SEG-Y, revisions 0, 1, 2 and 2.1, as ground-penetrating radars write it.
//!
//! Sources: SEG Technical Standards Committee, *SEG-Y_r2.1* (2023). Radars deviate in one way: the sample
//! interval counts picoseconds where the standard has microseconds, and delays count nanoseconds where it has
//! milliseconds. Taken literally, no radar record would be shorter than a microsecond a sample; only the
//! interval in double precision of revision 2 can hold a true one, and is then used unchanged.

mod binary;
mod place;
mod read;
mod sample;
mod text;
mod trace;
mod write;

pub use binary::is_segy;
pub use read::read_segy;
pub use write::{SegyTraces, write_segy};
