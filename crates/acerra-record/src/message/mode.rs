//! Operating and sleep modes: SET_OPMODE, SET_SLEEPMODE.

use super::fields::Fields;
use super::status_code::StatusCode;

/// Operating mode of the monostatic radar.
pub const OPERATING_MODE_MRM: u32 = 1;

/// Sleep mode in which the radio answers and scans.
pub const SLEEP_MODE_ACTIVE: u32 = 0;

/// Confirm of a request that sets a mode: the mode now in force, and whether it was set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModeConfirm {
    /// Operating mode (1: MRM), or sleep mode (0 active, 1 idle, 2 standby with Ethernet, 3 standby
    /// with serial, 4 sleep).
    pub mode: u32,
    /// Whether the request was carried out.
    pub status: StatusCode,
}

impl ModeConfirm {
    pub(super) fn decode(fields: &mut Fields<'_>) -> Self {
        Self {
            mode: fields.u32(),
            status: StatusCode::from_code(fields.u32()),
        }
    }

    pub(super) fn encode(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.mode.to_be_bytes());
        out.extend_from_slice(&self.status.code().to_be_bytes());
    }
}
