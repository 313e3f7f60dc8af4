//! An array of images that are written one by one.

use std::path::PathBuf;

use num_complex::Complex32;

use super::chunks::Cut;
use crate::error::CubeError;

/// Images, rows and columns of a stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StackShape {
    /// Images.
    pub images: usize,
    /// Rows of each.
    pub rows: usize,
    /// Columns of each.
    pub columns: usize,
}

impl StackShape {
    pub(super) fn lengths(self) -> [usize; 3] {
        [self.images, self.rows, self.columns]
    }
}

/// Writes the images of a stack, each into chunks of its own.
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
    /// Another number of values than a slice has, a slice too many, a file that cannot be written.
    pub fn slice(&mut self, image: &[Complex32]) -> Result<(), CubeError> {
        let StackShape {
            images,
            rows,
            columns,
        } = self.shape;
        if image.len() != rows * columns {
            return Err(CubeError::Length {
                variable: self.name.clone(),
                expected: rows * columns,
                found: image.len(),
            });
        }
        if self.written == images {
            return Err(self.wrong_count(images + 1));
        }
        let shape = [rows, columns];
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
        if self.written == self.shape.images {
            Ok(())
        } else {
            Err(self.wrong_count(self.written))
        }
    }

    fn wrong_count(&self, found: usize) -> CubeError {
        CubeError::Slices {
            variable: self.name.clone(),
            expected: self.shape.images,
            found,
        }
    }
}
