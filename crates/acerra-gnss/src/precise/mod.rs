//! Precise orbits and clocks of analysis centres: SP3-c and SP3-d, RINEX clock files.
//!
//! ```no_run
//! use acerra_gnss::{input::Limits, read_navigation};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let open = |path| std::fs::File::open(path);
//! let (mut navigation, _) = read_navigation(open("base.nav")?, Limits::default())?;
//! for path in ["igs22625.sp3", "igs22625.clk"] {
//!     navigation.merge(read_navigation(open(path)?, Limits::default())?.0);
//! }
//! // `process` now takes these for every satellite that the products hold.
//! # Ok(())
//! # }
//! ```

mod clock_file;
mod sp3;

pub use crate::orbits::products::{PreciseGap, PreciseProducts};
pub(crate) use clock_file::read_clock_lines;
pub(crate) use sp3::read_sp3_lines;
