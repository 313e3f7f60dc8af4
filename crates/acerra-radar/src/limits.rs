//! Bounds on what an untrusted file may make a reader hold in memory.

/// Limits of the readers. The defaults admit every flight a small drone can make and refuse files
/// that only claim to be large.
///
/// ```
/// let limits = acerra_radar::Limits { max_samples: 1_000_000, ..Default::default() };
/// assert!(limits.max_scan_samples > 10_000);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
