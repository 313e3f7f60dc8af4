//! Errors of drawing a figure.

/// A figure that cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// An array's length does not match the array's stated shape.
    #[error("{what}: expected {expected} values, found {found}")]
    ShapeMismatch {
        /// The array.
        what: &'static str,
        /// Values that the stated shape needs.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// No data to draw: an empty grid, or a grid whose extent is not a finite number.
    #[error("{what}: nothing to draw ({reason})")]
    NothingToDraw {
        /// The figure or array.
        what: &'static str,
        /// Reason why it is empty.
        reason: &'static str,
    },
    /// The PNG could not be made.
    #[error("encoding the figure as PNG: {0}")]
    Encode(String),
}

/// Checks that `found` values are there for a shape that needs `expected`.
pub(super) fn check_len(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), FigureError> {
    if expected == found {
        Ok(())
    } else {
        Err(FigureError::ShapeMismatch {
            what,
            expected,
            found,
        })
    }
}
