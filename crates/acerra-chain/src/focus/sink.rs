//! Where looks and volume slices go, image by image, as the chain makes them.

use std::error::Error;

use acerra_imaging::{Complex32, PlaneGrid};

/// Receives the images of a stack one after another: `begin`, one `put` for each image, `finish`.
pub trait ImageSink {
    /// A stack begins.
    ///
    /// # Errors
    /// Why the sink cannot take it.
    fn begin(&mut self, stack: &StackHeader) -> Result<(), SinkError>;

    /// The next image, row-major `[ny, nx]`, row 0 at the smallest y.
    ///
    /// # Errors
    /// Why the sink cannot take it.
    fn put(&mut self, image: &[Complex32]) -> Result<(), SinkError>;

    /// The stack is complete; `arrays` describe it.
    ///
    /// # Errors
    /// Why the sink cannot take them.
    fn finish(&mut self, arrays: Vec<StackArray>) -> Result<(), SinkError>;
}

/// What a stack is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StackKind {
    /// Looks along the track.
    Looks,
    /// Slices of a volume.
    Volume,
}

impl StackKind {
    /// Its name, as arrays and files bear it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Looks => "looks",
            Self::Volume => "volume",
        }
    }
}

/// Properties of a stack before its first image.
#[derive(Clone, Debug)]
pub struct StackHeader {
    /// What it is made of.
    pub kind: StackKind,
    /// Columns and rows of each image; of a volume the lowest slice.
    pub grid: PlaneGrid,
    /// Number of images.
    pub count: usize,
}

/// A named array that describes a stack.
#[derive(Clone, Debug, PartialEq)]
pub struct StackArray {
    /// Its name.
    pub name: &'static str,
    /// Its shape.
    pub shape: Vec<usize>,
    /// Its values, row-major.
    pub values: Vec<f64>,
}

/// Why a sink does not take an image.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {cause}")]
pub struct SinkError {
    /// The file, or its substitute, and the failed operation.
    pub place: String,
    /// Why.
    pub cause: Box<dyn Error + Send + Sync>,
}

/// Keeps every stack in memory.
#[derive(Debug, Default)]
pub struct MemorySink {
    /// The stacks, in the order in which they began.
    pub stacks: Vec<MemoryStack>,
}

/// A stack in memory.
#[derive(Debug)]
pub struct MemoryStack {
    /// What it is made of.
    pub header: StackHeader,
    /// Its images.
    pub images: Vec<Vec<Complex32>>,
    /// The arrays that describe it.
    pub arrays: Vec<StackArray>,
}

impl MemorySink {
    fn last(&mut self) -> Result<&mut MemoryStack, SinkError> {
        self.stacks.last_mut().ok_or_else(|| SinkError {
            place: "memory".to_owned(),
            cause: "an image came before its stack began".into(),
        })
    }
}

impl ImageSink for MemorySink {
    fn begin(&mut self, stack: &StackHeader) -> Result<(), SinkError> {
        self.stacks.push(MemoryStack {
            header: stack.clone(),
            images: Vec::with_capacity(stack.count),
            arrays: Vec::new(),
        });
        Ok(())
    }

    fn put(&mut self, image: &[Complex32]) -> Result<(), SinkError> {
        self.last()?.images.push(image.to_vec());
        Ok(())
    }

    fn finish(&mut self, arrays: Vec<StackArray>) -> Result<(), SinkError> {
        self.last()?.arrays = arrays;
        Ok(())
    }
}
