//! Bounds on the memory that an untrusted file may make a reader hold.

use crate::error::{FormatError, Place};

/// Limits of the readers.
///
/// ```
/// let mut limits = acerra_formats::Limits::default();
/// limits.max_samples = 1_000_000;
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Samples held from one file, all channels together.
    pub max_samples: u64,
    /// Samples in one trace.
    pub max_trace_samples: u64,
    /// Bytes of a file that is read as a whole: HDF5, MATLAB and text.
    pub max_file_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_samples: 1 << 29,
            max_trace_samples: 1 << 20,
            max_file_bytes: 1 << 32,
        }
    }
}

/// Samples that any packed file may hold (64 MiB of them), and number for a byte of it beyond that: bytes
/// become numbers of eight bytes, and measured values hardly compress.
const FREE_SAMPLES: u64 = 1 << 23;
const SAMPLES_PER_TWO_BYTES: u64 = 3;

impl Limits {
    /// These limits for a file of this length whose values may be packed.
    pub(crate) fn justified_by(self, file_bytes: u64) -> Self {
        let justified = FREE_SAMPLES.max(file_bytes.saturating_mul(SAMPLES_PER_TWO_BYTES) / 2);
        Self {
            max_samples: self.max_samples.min(justified),
            ..self
        }
    }

    pub(crate) fn check_samples(&self, place: Place, found: u64) -> Result<(), FormatError> {
        let limit = self.max_samples;
        if found <= limit {
            return Ok(());
        }
        Err(FormatError::TooLarge {
            place,
            what: "samples",
            limit,
            found,
        })
    }

    pub(crate) fn check_trace(&self, place: Place, found: u64) -> Result<(), FormatError> {
        let limit = self.max_trace_samples;
        if found <= limit {
            return Ok(());
        }
        Err(FormatError::TooLarge {
            place,
            what: "samples a trace",
            limit,
            found,
        })
    }
}
