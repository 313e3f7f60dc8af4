//! Detections of the radio's own motion filter: DETECTION_LIST_INFO.

use super::fields::Fields;

/// Detections that every message has room for.
pub const DETECTIONS_PER_MESSAGE: usize = 350;

/// One detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Detection {
    /// Sample of the scan.
    pub index: u16,
    /// Magnitude there.
    pub magnitude: u16,
}

/// DETECTION_LIST_INFO.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DetectionList {
    /// Number of valid detections, as the radio states it.
    pub count: u16,
    /// Reserved.
    pub reserved: u16,
    /// Every place of the message, valid or not.
    pub slots: [Detection; DETECTIONS_PER_MESSAGE],
}

impl DetectionList {
    /// The valid detections.
    #[must_use]
    pub fn detections(&self) -> &[Detection] {
        &self.slots[..usize::from(self.count).min(DETECTIONS_PER_MESSAGE)]
    }

    pub(super) fn decode(fields: &mut Fields<'_>) -> Self {
        let (count, reserved) = (fields.u16(), fields.u16());
        let mut slots = [Detection::default(); DETECTIONS_PER_MESSAGE];
        for slot in &mut slots {
            *slot = Detection {
                index: fields.u16(),
                magnitude: fields.u16(),
            };
        }
        Self {
            count,
            reserved,
            slots,
        }
    }

    pub(super) fn encode(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.count.to_be_bytes());
        out.extend_from_slice(&self.reserved.to_be_bytes());
        for slot in &self.slots {
            out.extend_from_slice(&slot.index.to_be_bytes());
            out.extend_from_slice(&slot.magnitude.to_be_bytes());
        }
    }
}
