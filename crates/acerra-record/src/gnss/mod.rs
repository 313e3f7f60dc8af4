//! Logging a GNSS receiver: every byte kept, raw measurements configured, epochs stamped.

mod configure;
mod frames;
mod source;

pub use configure::{ConfigureError, Receiver, Setting, Solutions, configuration, configure};
pub use frames::FrameFinder;
pub use source::{ByteSource, SerialSource, SourceFault, TcpSource};
