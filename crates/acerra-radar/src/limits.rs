//! Bounds on the memory that an untrusted file may make a reader hold.

/// Limits of the readers. The defaults admit every flight of a small drone and refuse files that only claim
/// to be large.
///
/// ```
/// let limits = acerra_radar::Limits::default().with_max_samples(1_000_000);
/// assert!(limits.max_scan_samples > 10_000);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Samples (or spectral values) held from one file.
    pub max_samples: usize,
    /// Samples in one scan.
    pub max_scan_samples: usize,
    /// Bytes in one line of a text log.
    pub max_line_bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_samples: 1 << 29,
            max_scan_samples: 1 << 17,
            max_line_bytes: 1 << 22,
        }
    }
}

impl Limits {
    /// These limits with another number of samples held from one file.
    #[must_use]
    pub const fn with_max_samples(mut self, max_samples: usize) -> Self {
        self.max_samples = max_samples;
        self
    }

    /// These limits with another length of a line, bytes.
    #[must_use]
    pub const fn with_max_line_bytes(mut self, max_line_bytes: usize) -> Self {
        self.max_line_bytes = max_line_bytes;
        self
    }
}
