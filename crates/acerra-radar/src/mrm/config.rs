//! The radio's configuration: 32 bytes, alone or inside a message.

/// Bytes of an encoded [`RadarConfig`].
pub const CONFIG_BYTES: usize = 32;

/// Configuration of the radio, as SET_CONFIG_REQUEST carries it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct RadarConfig {
    /// Identity of the radio.
    pub node_id: u32,
    /// Start of the scan window, ps.
    pub scan_start_ps: i32,
    /// End of the scan window, ps.
    pub scan_stop_ps: i32,
    /// Spacing of samples, bins of 1.907 ps.
    pub scan_resolution_bins: u16,
    /// Pulse integration index: 2^PII pulses are summed for each sample.
    pub integration_index: u16,
    /// Samples of each segment (unused by current radios).
    pub segment_samples: [u16; 4],
    /// Additional integration of each segment.
    pub segment_integration: [u8; 4],
    /// 0 TxA/RxA, 1 TxB/RxB, 2 TxA/RxB, 3 TxB/RxA.
    pub antenna_mode: u8,
    /// Transmit gain index, 0–63.
    pub transmit_gain: u8,
    /// Code channel, 0–10.
    pub code_channel: u8,
    /// Whether the radio keeps the configuration over a restart.
    pub persist: u8,
}

impl RadarConfig {
    /// Decodes 32 big-endian bytes.
    #[must_use]
    pub fn from_bytes(b: &[u8; CONFIG_BYTES]) -> Self {
        let u16_at = |i: usize| u16::from_be_bytes([b[i], b[i + 1]]);
        let u32_at = |i: usize| u32::from_be_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]]);
        Self {
            node_id: u32_at(0),
            scan_start_ps: u32_at(4) as i32,
            scan_stop_ps: u32_at(8) as i32,
            scan_resolution_bins: u16_at(12),
            integration_index: u16_at(14),
            segment_samples: [u16_at(16), u16_at(18), u16_at(20), u16_at(22)],
            segment_integration: [b[24], b[25], b[26], b[27]],
            antenna_mode: b[28],
            transmit_gain: b[29],
            code_channel: b[30],
            persist: b[31],
        }
    }

    /// Encodes to 32 big-endian bytes.
    ///
    /// ```
    /// use acerra_radar::mrm::RadarConfig;
    /// let config = RadarConfig { scan_start_ps: 16_670, ..RadarConfig::default() };
    /// assert_eq!(RadarConfig::from_bytes(&config.to_bytes()), config);
    /// ```
    #[must_use]
    pub fn to_bytes(&self) -> [u8; CONFIG_BYTES] {
        let mut b = [0; CONFIG_BYTES];
        b[0..4].copy_from_slice(&self.node_id.to_be_bytes());
        b[4..8].copy_from_slice(&self.scan_start_ps.to_be_bytes());
        b[8..12].copy_from_slice(&self.scan_stop_ps.to_be_bytes());
        b[12..14].copy_from_slice(&self.scan_resolution_bins.to_be_bytes());
        b[14..16].copy_from_slice(&self.integration_index.to_be_bytes());
        for (i, s) in self.segment_samples.iter().enumerate() {
            b[16 + 2 * i..18 + 2 * i].copy_from_slice(&s.to_be_bytes());
        }
        b[24..28].copy_from_slice(&self.segment_integration);
        b[28..32].copy_from_slice(&[
            self.antenna_mode,
            self.transmit_gain,
            self.code_channel,
            self.persist,
        ]);
        b
    }

    /// Whether the radio accepts the values.
    #[must_use]
    pub fn is_plausible(&self) -> bool {
        self.scan_stop_ps > self.scan_start_ps
            && (1..=1024).contains(&self.scan_resolution_bins)
            && (1..=16).contains(&self.integration_index)
            && self.antenna_mode <= 3
            && self.transmit_gain <= 63
            && self.code_channel <= 10
    }
}

impl Default for RadarConfig {
    /// A P440 as flown: 32-bin steps, PII 11, transmit on A, receive on B, full gain.
    fn default() -> Self {
        Self {
            node_id: 1,
            scan_start_ps: 0,
            scan_stop_ps: 70_312,
            scan_resolution_bins: crate::DEFAULT_STEP_BINS,
            integration_index: 11,
            segment_samples: [0; 4],
            segment_integration: [0; 4],
            antenna_mode: 2,
            transmit_gain: 63,
            code_channel: 0,
            persist: 0,
        }
    }
}
