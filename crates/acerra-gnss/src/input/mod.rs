//! What every reader of this crate shares: recognising a file by its content, taking lines from
//! it, limits against hostile input, errors that name a place, and an account of what was dropped.

mod error;
mod limits;
mod lines;
mod report;
mod sniff;
mod unix_compress;

pub use error::ReadError;
pub use limits::Limits;
pub use lines::{LineSource, Lines};
pub use report::{DropReason, Dropped, Place, ReadReport};
pub(crate) use sniff::SNIFF_BYTES;
pub use sniff::{FileKind, sniff};
pub use unix_compress::UnixCompressed;
