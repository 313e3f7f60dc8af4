//! Tasks of the workspace, run as `cargo xtask NAME`.
//!
//! [`house`] reads the sources and lists the imports of files and crates, so that a test can check the layers
//! of ARCHITECTURE.md. [`lines`] counts code, documentation and tests. [`ground`] computes the full-wave
//! scenes of the validation book.

pub mod ground;
pub mod house;
pub mod lines;
