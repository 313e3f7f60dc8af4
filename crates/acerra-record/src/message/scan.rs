//! Samples: SCAN_INFO.

use acerra_radar::mrm::{HEADER_BYTES, HeaderFault, SAMPLES_PER_MESSAGE, ScanHeader, samples_in};

/// SCAN_INFO: up to 350 samples of a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScanMessage {
    /// The fixed part, type and id included.
    pub header: ScanHeader,
    /// Every place of the message, valid or not.
    pub slots: [i32; SAMPLES_PER_MESSAGE],
}

impl ScanMessage {
    /// The valid samples.
    #[must_use]
    pub fn samples(&self) -> &[i32] {
        let valid = usize::from(self.header.samples_in_message);
        &self.slots[..valid.min(SAMPLES_PER_MESSAGE)]
    }

    /// From a whole message, type and id included.
    pub(super) fn decode(message: &[u8]) -> Result<Self, HeaderFault> {
        let header = ScanHeader::parse(message)?;
        let mut slots = [0; SAMPLES_PER_MESSAGE];
        let found = samples_in(message.get(HEADER_BYTES..).unwrap_or_default());
        for (slot, sample) in slots.iter_mut().zip(found) {
            *slot = sample;
        }
        Ok(Self { header, slots })
    }

    /// A whole message, type and id included.
    pub(super) fn encode(&self, message_id: u16, out: &mut Vec<u8>) {
        let header = ScanHeader {
            message_id,
            ..self.header
        };
        out.extend_from_slice(&header.to_bytes());
        for sample in &self.slots {
            out.extend_from_slice(&sample.to_be_bytes());
        }
    }
}
