//! Text logs of the vendor's MRM-RET program: one comma-separated line per event.

mod fields;
mod lines;
mod reader;
mod writer;

pub use reader::read_ret;
pub use writer::RetWriter;

pub(crate) use reader::recognise;
