//! A file that knows where it is.

use std::io::{self, Write};

/// A writer with its position.
#[derive(Debug)]
pub(super) struct Out<W> {
    inner: W,
    position: u64,
}

impl<W: Write> Out<W> {
    pub(super) const fn at(inner: W, position: u64) -> Self {
        Self { inner, position }
    }

    /// File offset of the next byte.
    pub(super) const fn position(&self) -> u64 {
        self.position
    }

    /// Fills up to a multiple of eight bytes.
    pub(super) fn align(&mut self) -> io::Result<()> {
        let missing = (self.position.next_multiple_of(8) - self.position) as usize;
        self.inner.write_all(&[0; 8][..missing])?;
        self.position += missing as u64;
        Ok(())
    }

    /// Writes at the next multiple of eight bytes, and returns the address.
    pub(super) fn put(&mut self, bytes: &[u8]) -> io::Result<u64> {
        self.align()?;
        let address = self.position;
        self.inner.write_all(bytes)?;
        self.position += bytes.len() as u64;
        Ok(address)
    }

    /// The writer itself.
    pub(super) fn into_inner(self) -> W {
        self.inner
    }
}
