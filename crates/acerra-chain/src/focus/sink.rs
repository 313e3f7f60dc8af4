//! Receivers of looks and volume slices, image by image.

use std::error::Error;

use acerra_imaging::{Complex32, PlaneGrid};

/// Receives the images of a stack one after another: `begin`, one `put` for each image, `finish`.
pub trait ImageSink {
    /// Begins a stack.
    ///
    /// # Errors
    /// Any failure of the sink.
    fn begin(&mut self, stack: &StackHeader) -> Result<(), SinkError>;

    /// Takes the next image, row-major `[ny, nx]`, row 0 at the smallest y.
    ///
    /// # Errors
    /// Any failure of the sink.
    fn put(&mut self, image: &[Complex32]) -> Result<(), SinkError>;

    /// Completes the stack, which `arrays` describe.
    ///
    /// # Errors
    /// Any failure of the sink.
    fn finish(&mut self, arrays: Vec<StackArray>) -> Result<(), SinkError>;
}

/// Kind of the images of a stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StackKind {
    /// Looks along the track.
    Looks,
    /// Slices of a volume.
    Volume,
}

impl StackKind {
    /// Name of the kind in arrays and files.
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
    /// Kind of the images.
    pub kind: StackKind,
    /// Columns and rows of each image; for a volume those of the lowest slice.
    pub grid: PlaneGrid,
    /// Number of images.
    pub count: usize,
}

/// A named array that describes a stack.
#[derive(Clone, Debug, PartialEq)]
pub struct StackArray {
    /// Name of the array.
    pub name: &'static str,
    /// Shape of the array.
    pub shape: Vec<usize>,
    /// Values of the array, row-major.
    pub values: Vec<f64>,
}

/// Failure of a sink.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {cause}")]
pub struct SinkError {
    /// The file, or its substitute, and the failed operation.
    pub place: String,
    /// Cause of the failure.
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
    /// Header of the stack.
    pub header: StackHeader,
    /// Images of the stack.
    pub images: Vec<Vec<Complex32>>,
    /// Arrays that describe the stack.
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
