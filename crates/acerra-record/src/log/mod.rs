//! The log of a session: every message of the radio and every byte of the receiver, stamped and
//! guarded by checksums, in one file that a power cut cannot spoil.

mod frame;
mod reader;
mod writer;

pub use frame::{LOG_SIGNATURE, MAX_PAYLOAD_BYTES, Record, RecordKind};
pub use reader::{LogDamage, LogReadError, LogReader};
pub(crate) use writer::sync_folder;
pub use writer::{LogWriteError, LogWriter, SYNC_EVERY};
