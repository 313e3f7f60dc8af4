//! The validation book: what the paper computes and measures, as Acerra computes it, each figure
//! held to its tolerance and each page of `docs/validation` held to what the code gives.
//!
//! `cargo xtask book` writes the pages again.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // tests, and helpers of tests

mod autofocus;
mod campaign;
mod flights;
mod ground;
mod page;
mod positions;
mod resolution;
mod steps;
