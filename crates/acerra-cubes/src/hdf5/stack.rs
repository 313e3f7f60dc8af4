//! Arrays of complex images that are written one by one.

use std::io::{Seek, Write};

use num_complex::Complex32;

use super::array::Chunks;
use super::datatype::real32;
use super::file::Hdf5File;
use crate::dataset::{StackShape, Values, Variable, check_name};
use crate::error::CubeError;

/// Writes the images of a stack: their real and their imaginary parts into an array each.
#[derive(Debug)]
pub struct Hdf5Stack<'a, W> {
    file: &'a mut Hdf5File<W>,
    parts: [(Variable<'static>, Chunks); 2],
    name: String,
    shape: StackShape,
    written: usize,
}

impl<'a, W: Write + Seek> Hdf5Stack<'a, W> {
    /// Begins the two arrays. Dimensions that were not declared get the stack's lengths.
    ///
    /// # Errors
    /// A name or a length that does not fit.
    pub fn begin(
        file: &'a mut Hdf5File<W>,
        variable: &Variable<'_>,
        shape: StackShape,
    ) -> Result<Self, CubeError> {
        check_name(&variable.name)?;
        for (name, length) in variable.dimensions.iter().zip(shape.lengths()) {
            file.dimension(name, length)?;
        }
        let part = |part: &str| {
            let variable = Variable {
                name: format!("{}_{part}", variable.name),
                dimensions: variable.dimensions.clone(),
                values: Values::from(Vec::<f32>::new()),
                attributes: variable.attributes.clone(),
            };
            let chunks = Chunks::of_images([shape.rows, shape.columns], size_of::<f32>());
            (variable, chunks)
        };
        Ok(Self {
            file,
            parts: ["real", "imag"].map(part),
            name: variable.name.clone(),
            shape,
            written: 0,
        })
    }

    /// Writes the next image, row by row.
    ///
    /// # Errors
    /// The number of values differs from that of an image, there is an image too many, or the file cannot be written.
    pub fn slice(&mut self, image: &[Complex32]) -> Result<(), CubeError> {
        self.shape.check_image(&self.name, self.written, image)?;
        let shape = [self.shape.rows, self.shape.columns];
        let take: [fn(&Complex32) -> f32; 2] = [|z| z.re, |z| z.im];
        for ((_, chunks), part) in self.parts.iter_mut().zip(take) {
            let values: Vec<f32> = image.iter().map(part).collect();
            chunks.write(&mut self.file.out, &values, &shape, &[self.written])?;
        }
        self.written += 1;
        Ok(())
    }

    /// Ends the stack.
    ///
    /// # Errors
    /// Images that are missing.
    pub fn finish(self) -> Result<(), CubeError> {
        self.shape.check_complete(&self.name, self.written)?;
        for (variable, chunks) in self.parts {
            let place = chunks.finish(&mut self.file.out)?;
            let shape = self.shape.lengths().to_vec();
            self.file.object(&variable, shape, real32(), place)?;
        }
        Ok(())
    }
}
