//! Parts that every reader of this crate shares: recognising a file by its content, reading lines from it,
//! limits against hostile input, errors that name a place, and a report of dropped data.

mod error;
mod kind;
mod limits;
mod lines;
mod report;
mod unix_compress;

pub use crate::sniff::sniff;
pub use error::ReadError;
pub use kind::FileKind;
pub use limits::Limits;
pub(crate) use lines::{BYTE_ORDER_MARK, line_end};
pub use lines::{LineSource, Lines};
pub use report::{DropReason, Dropped, Place, ReadReport};
pub use unix_compress::UnixCompressed;
