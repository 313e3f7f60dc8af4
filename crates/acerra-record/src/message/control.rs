//! Starting and stopping scans: CONTROL.

use super::fields::Fields;

/// CONTROL_REQUEST: number and interval of scans.
///
/// ```
/// use acerra_record::message::ControlRequest;
/// assert_eq!(ControlRequest::STOP.scan_count, 0);
/// assert_eq!(ControlRequest::continuous(10_000).scan_count, 65_535);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ControlRequest {
    /// Scans to make: 0 stops, 65 535 goes on until stopped.
    pub scan_count: u16,
    /// Reserved.
    pub reserved: u16,
    /// Interval between the starts of scans, µs; 0 is as fast as possible.
    pub scan_interval_us: u32,
}

impl ControlRequest {
    /// Scan count that means "until stopped".
    pub const CONTINUOUS: u16 = u16::MAX;

    /// Ends scanning.
    pub const STOP: Self = Self {
        scan_count: 0,
        reserved: 0,
        scan_interval_us: 0,
    };

    /// Scans until stopped, `scan_interval_us` apart.
    #[must_use]
    pub const fn continuous(scan_interval_us: u32) -> Self {
        Self {
            scan_count: Self::CONTINUOUS,
            reserved: 0,
            scan_interval_us,
        }
    }

    pub(super) fn decode(fields: &mut Fields<'_>) -> Self {
        Self {
            scan_count: fields.u16(),
            reserved: fields.u16(),
            scan_interval_us: fields.u32(),
        }
    }

    pub(super) fn encode(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.scan_count.to_be_bytes());
        out.extend_from_slice(&self.reserved.to_be_bytes());
        out.extend_from_slice(&self.scan_interval_us.to_be_bytes());
    }
}
