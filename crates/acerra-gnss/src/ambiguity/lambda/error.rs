//! Reasons for the absence of an integer solution.

/// Reason why there is no integer solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LambdaError {
    /// The covariance is not positive definite (or not finite).
    #[error("covariance of the float ambiguities is not positive definite at index {index}")]
    NotPositiveDefinite {
        /// Column at which the factorisation failed.
        index: usize,
    },
    /// The covariance does not have n² elements.
    #[error("expected a covariance of {expected} elements, found {found}")]
    Shape {
        /// n².
        expected: usize,
        /// Elements given.
        found: usize,
    },
    /// The search visited too many nodes.
    #[error("integer search gave up after {visited} nodes")]
    SearchTooLong {
        /// Nodes visited.
        visited: usize,
    },
}
