//! An array of images that are written one by one.

use std::path::PathBuf;

use num_complex::Complex32;

use crate::cut::Cut;
use crate::dataset::StackShape;
use crate::error::CubeError;

/// Writes the images of a stack, each into separate chunks.
#[derive(Debug)]
pub struct StackWriter {
    name: String,
    folder: PathBuf,
    chunk: Vec<usize>,
    shape: StackShape,
    written: usize,
}

impl StackWriter {
    pub(super) fn new(name: &str, folder: PathBuf, chunk: Vec<usize>, shape: StackShape) -> Self {
        Self {
            name: name.to_owned(),
            folder,
            chunk,
            shape,
            written: 0,
        }
    }

    /// Writes the next image, row by row.
    ///
    /// # Errors
    /// The number of values differs from that of a slice, there is a slice too many, or the file cannot be written.
    pub fn slice(&mut self, image: &[Complex32]) -> Result<(), CubeError> {
        self.shape.check_image(&self.name, self.written, image)?;
        let shape = [self.shape.rows, self.shape.columns];
        let cut = Cut {
            shape: &shape,
            chunk: &self.chunk[1..],
        };
        // The chunks of a slice lie below its number.
        let slice = self.folder.join("c").join(self.written.to_string());
        cut.write_below(&slice, image)?;
        self.written += 1;
        Ok(())
    }

    /// Ends the stack.
    ///
    /// # Errors
    /// Slices that are missing.
    pub fn finish(self) -> Result<(), CubeError> {
        self.shape.check_complete(&self.name, self.written)
    }
}
