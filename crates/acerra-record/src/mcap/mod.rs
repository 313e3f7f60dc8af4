//! A session as one MCAP file: the log's content, on topics that other tools read.
//!
//! The file is made of `session.log`, which stays the recording. Messages are ROS 2 messages (CDR) whose
//! definitions are included in the file; each message begins with the host's clock as recorded in the log.
//!
//! | topic | type | holds |
//! | --- | --- | --- |
//! | `/radar/message` | `acerra_msgs/msg/Bytes` | each message of the radio as it came |
//! | `/radar/scan` | `acerra_msgs/msg/Scan` | each whole scan, once |
//! | `/radar/configuration` | `acerra_msgs/msg/Bytes` | the radio's settings, 32 bytes |
//! | `/gnss/bytes` | `acerra_msgs/msg/Bytes` | the receiver's bytes as they came |
//! | `/clock/epoch` | `acerra_msgs/msg/Epoch` | an epoch of the receiver and the host's clock at its first byte |
//! | `/clock/pulse` | `acerra_msgs/msg/Pulse` | a pulse per second that the kernel stamped |
//! | `/clock/fit` | `acerra_msgs/msg/Text` | `radar.clock.json`, if there is one |
//! | `/session/settings`, `/session/note`, `/session/end` | `acerra_msgs/msg/Text` | the session file, events, the counts at the end |
//!
//! The format is that of mcap.dev: records of kind, length and content, messages in chunks without packing, a
//! summary with statistics and the chunks' places.

mod cdr;
mod read;
mod topics;
mod write;

pub use read::{MAGIC, McapContent, McapError, McapReader, TopicCount};
pub use topics::{Topic, acerra_topics};
pub(crate) use topics::{epoch, pulse, scan, topic, wrapped_bytes, wrapped_text};
pub use write::McapWriter;
