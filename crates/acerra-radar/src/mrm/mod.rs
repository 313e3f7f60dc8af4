//! Captures of the PulsON 400 series: the radio's own MRM messages in a file.
//!
//! A capture is a 32-byte configuration and then SCAN_INFO messages, or messages alone, with or without the
//! serial prefix (0xA5A5 and a length) before each. All fields are big-endian. A scan longer than 350 samples
//! spans several messages; only complete scans are returned, incomplete ones are reported.

mod assemble;
mod config;
mod framer;
mod header;
mod message;
mod reader;
mod writer;

pub use assemble::ScanAssembler;
pub use config::{CONFIG_BYTES, RadarConfig};
pub use header::{
    HEADER_BYTES, HeaderFault, SAMPLES_PER_MESSAGE, SCAN_MESSAGE_BYTES, ScanHeader, samples_in,
};
pub use message::{MessageType, SERIAL_PREFIX};
pub use reader::{MrmItem, MrmReader, read_mrm};
pub use writer::{Framing, MrmWriter, scan_messages, write_mrm};

pub(crate) use framer::{Recognised, begins_with_scan, recognise};
