//! Heights over the base plane of a grid, in the form that kernels read.

/// Heights above a plane: pixel (i, j) is `heights_m[j·stride + i]` above it, along the third
/// axis; the plane's rows are level.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Relief<'a> {
    pub heights_m: &'a [f32],
    pub stride: usize,
}

impl<'a> Relief<'a> {
    /// The heights, counted from pixel (i, j).
    pub fn seen_from(self, i: usize, j: usize) -> Self {
        Self {
            heights_m: &self.heights_m[j * self.stride + i..],
            ..self
        }
    }
}
