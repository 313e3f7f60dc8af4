//! Bounds on what a reader accepts.

/// Bounds of a reader, independent of the sizes stated in a file.
///
/// The defaults are far above any real log: a day of 10 Hz multi-GNSS RINEX 3 is about 2 GB.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Largest number of bytes read, after any gzip decompression.
    pub max_bytes: u64,
    /// Largest number of bytes in one line of a text format.
    pub max_line_bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_bytes: 8 << 30,
            max_line_bytes: 1 << 16,
        }
    }
}
