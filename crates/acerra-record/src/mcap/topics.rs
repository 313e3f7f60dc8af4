//! The topics of a session's file, and the definitions of their messages.

use acerra_geo::time::GpsTime;
use acerra_radar::Scan;

use super::cdr::Cdr;
use crate::pps::PulseStamp;

/// A topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Name.
    pub name: &'static str,
    /// The type of its messages.
    pub schema: &'static str,
    /// The definition of that type in the language of ROS 2.
    pub definition: &'static str,
}

const BYTES: (&str, &str) = (
    "acerra_msgs/msg/Bytes",
    "# Bytes as they came.\nuint64 host_ns  # the host's clock when they came\nuint8[] data\n",
);
const TEXT: (&str, &str) = (
    "acerra_msgs/msg/Text",
    "uint64 host_ns  # the host's clock\nstring text\n",
);
const SCAN: (&str, &str) = (
    "acerra_msgs/msg/Scan",
    "# A whole scan of the radio.\nuint64 host_ns  # the host's clock when its last message came\n\
     uint16 message_id  # the radio's number\nuint32 timestamp_ms  # the radio's clock\n\
     int32 start_ps  # fast time of the first sample\nint32 stop_ps  # end of the window\n\
     uint16 step_bins  # distance of samples in bins of 1.907 ps\nint32[] samples\n",
);
const EPOCH: (&str, &str) = (
    "acerra_msgs/msg/Epoch",
    "# An epoch of the receiver's measurements.\nuint64 host_ns  # the host's clock at its first byte\n\
     int64 gps_week\nfloat64 gps_tow_s  # seconds of the week, GPS time\n",
);
const PULSE: (&str, &str) = (
    "acerra_msgs/msg/Pulse",
    "# A pulse per second that the kernel stamped.\nuint64 host_ns  # the host's clock at its edge\n\
     uint64 unix_s  # the calendar clock there\nuint32 nanoseconds\nuint32 sequence  # edges counted\n",
);

/// Indices of the topics.
pub(crate) mod topic {
    pub const MESSAGE: usize = 0;
    pub const WHOLE_SCAN: usize = 1;
    pub const CONFIGURATION: usize = 2;
    pub const GNSS: usize = 3;
    pub const CLOCK_EPOCH: usize = 4;
    pub const CLOCK_FIT: usize = 5;
    pub const SETTINGS: usize = 6;
    pub const NOTE: usize = 7;
    pub const END: usize = 8;
    pub const CLOCK_PULSE: usize = 9;
}

/// The topics, in the order of their numbers in the file.
#[must_use]
pub fn acerra_topics() -> [Topic; 10] {
    [
        ("/radar/message", BYTES),
        ("/radar/scan", SCAN),
        ("/radar/configuration", BYTES),
        ("/gnss/bytes", BYTES),
        ("/clock/epoch", EPOCH),
        ("/clock/fit", TEXT),
        ("/session/settings", TEXT),
        ("/session/note", TEXT),
        ("/session/end", TEXT),
        ("/clock/pulse", PULSE),
    ]
    .map(|(name, (schema, definition))| Topic {
        name,
        schema,
        definition,
    })
}

/// A message of bytes.
pub(crate) fn wrapped_bytes(host_ns: u64, data: &[u8]) -> Vec<u8> {
    let mut cdr = Cdr::at(host_ns);
    cdr.bytes(data);
    cdr.end()
}

/// A message of text.
pub(crate) fn wrapped_text(host_ns: u64, text: &str) -> Vec<u8> {
    let mut cdr = Cdr::at(host_ns);
    cdr.text(text);
    cdr.end()
}

/// A whole scan.
pub(crate) fn scan(host_ns: u64, scan: &Scan) -> Vec<u8> {
    let mut cdr = Cdr::at(host_ns);
    let window = scan.window;
    cdr.put(scan.message_id.to_le_bytes())
        .put(scan.timestamp_ms.to_le_bytes())
        .put(window.start_ps.to_le_bytes())
        .put(window.stop_ps.to_le_bytes())
        .put(window.step_bins.to_le_bytes())
        .i32s(scan.samples.iter().copied());
    cdr.end()
}

/// A pulse per second.
pub(crate) fn pulse(host_ns: u64, stamp: PulseStamp) -> Vec<u8> {
    let mut cdr = Cdr::at(host_ns);
    cdr.put(stamp.unix.as_secs().to_le_bytes())
        .put(stamp.unix.subsec_nanos().to_le_bytes())
        .put(stamp.sequence.to_le_bytes());
    cdr.end()
}

/// An epoch of the receiver.
pub(crate) fn epoch(host_ns: u64, time: GpsTime) -> Vec<u8> {
    let mut cdr = Cdr::at(host_ns);
    cdr.put(time.week().to_le_bytes())
        .put(time.tow_s().to_le_bytes());
    cdr.end()
}
