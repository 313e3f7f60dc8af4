//! Bounds on what a reader accepts.

/// Bounds that a reader keeps, whatever a file claims about itself.
///
/// The defaults are far above any real log: a day of 10 Hz multi-GNSS RINEX 3 is about 2 GB.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Most bytes taken from the input after any gzip decompression.
    pub max_bytes: u64,
    /// Most bytes in one line of a text format.
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
