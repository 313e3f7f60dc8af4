//! Tasks of the workspace, run as `cargo xtask NAME`.
//!
//! [`house`] reads the sources and says which file and which crate imports which, so that a test
//! can hold the layers of ARCHITECTURE.md. [`lines`] counts code, documentation and tests. [`ground`] computes the
//! full-wave scenes of the validation book.

pub mod ground;
pub mod house;
pub mod lines;
