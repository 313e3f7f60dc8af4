//! Parts of each scan that the radio sends: SET_FILTER_CONFIG, GET_FILTER_CONFIG.

use super::fields::Fields;
use super::status_code::StatusCode;

/// Scans and lists that the radio sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilterConfig {
    /// Sum of [`FilterConfig::RAW`], [`FilterConfig::BAND_PASS`], [`FilterConfig::MOTION`] and
    /// [`FilterConfig::DETECTION_LIST`].
    pub filter_mask: u16,
    /// Which motion filter.
    pub motion_filter_index: u8,
    /// Reserved.
    pub reserved: u8,
}

impl FilterConfig {
    /// Raw scans.
    pub const RAW: u16 = 1;
    /// Scans band-passed in fast time.
    pub const BAND_PASS: u16 = 2;
    /// Motion-filtered scans.
    pub const MOTION: u16 = 4;
    /// Detection lists.
    pub const DETECTION_LIST: u16 = 8;

    /// Raw scans only, as imaging needs them.
    pub const RAW_ONLY: Self = Self {
        filter_mask: Self::RAW,
        motion_filter_index: 0,
        reserved: 0,
    };

    pub(super) fn decode(fields: &mut Fields<'_>) -> Self {
        Self {
            filter_mask: fields.u16(),
            motion_filter_index: fields.u8(),
            reserved: fields.u8(),
        }
    }

    pub(super) fn encode(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.filter_mask.to_be_bytes());
        out.extend_from_slice(&[self.motion_filter_index, self.reserved]);
    }
}

/// GET_FILTER_CONFIG_CONFIRM: the filters in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilterConfirm {
    /// The filters.
    pub filter: FilterConfig,
    /// Whether the request was carried out.
    pub status: StatusCode,
}

impl FilterConfirm {
    pub(super) fn decode(fields: &mut Fields<'_>) -> Self {
        Self {
            filter: FilterConfig::decode(fields),
            status: StatusCode::from_code(fields.u32()),
        }
    }

    pub(super) fn encode(&self, out: &mut Vec<u8>) {
        self.filter.encode(out);
        out.extend_from_slice(&self.status.code().to_be_bytes());
    }
}
