//! Configuration of the radio: SET_CONFIG, GET_CONFIG.

use acerra_radar::mrm::{CONFIG_BYTES, RadarConfig};

use super::fields::Fields;
use super::status_code::StatusCode;

/// GET_CONFIG_CONFIRM: the configuration in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConfigConfirm {
    /// The configuration.
    pub config: RadarConfig,
    /// Radio clock, ms since boot.
    pub timestamp_ms: u32,
    /// Whether the request was carried out.
    pub status: StatusCode,
}

pub(super) fn decode_config(fields: &mut Fields<'_>) -> RadarConfig {
    RadarConfig::from_bytes(&fields.array::<CONFIG_BYTES>())
}

impl ConfigConfirm {
    pub(super) fn decode(fields: &mut Fields<'_>) -> Self {
        Self {
            config: decode_config(fields),
            timestamp_ms: fields.u32(),
            status: StatusCode::from_code(fields.u32()),
        }
    }

    pub(super) fn encode(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.config.to_bytes());
        out.extend_from_slice(&self.timestamp_ms.to_be_bytes());
        out.extend_from_slice(&self.status.code().to_be_bytes());
    }
}
