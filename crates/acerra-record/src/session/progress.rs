//! Progress of a running recording.

use serde::Serialize;

use crate::driver::LinkCounts;

/// Progress of a running recording.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// Description of the event.
    Note(String),
    /// A fault: worth a beep.
    Warning(String),
    /// The state, about once a second.
    Health(Health),
}

/// The state of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Health {
    /// Seconds since its beginning.
    pub elapsed_s: f64,
    /// The account of the radio's link.
    pub radio: LinkCounts,
    /// Interval between scans by the radio's clock (s).
    pub scan_interval_s: f64,
    /// Temperature of the radio (°C), where the radio reported a temperature.
    pub temperature_c: Option<f64>,
    /// Messages of the radio whose time of arrival is the kernel's.
    pub kernel_stamped: u64,
    /// Bytes of the receiver.
    pub gnss_bytes: u64,
    /// Whether the receiver has a fix, and its satellites, where the receiver's messages contain them.
    pub fix: Option<Fix>,
    /// Pulses per second that were read.
    pub pulses: u64,
    /// Pulses, or doubled edges, that the kernel counted and that were not read.
    pub missed_pulses: u64,
    /// Scans with saturated samples.
    pub saturated_scans: u64,
    /// Bytes of the log.
    pub log_bytes: u64,
}

/// Fix reported by a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Fix {
    /// Whether it knows where it is.
    pub has_fix: bool,
    /// Satellites used, or measured.
    pub satellites: usize,
}
