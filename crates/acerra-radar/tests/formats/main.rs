//! Readers of radar logs: one program, since each links the whole crate.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests are like tests

#[path = "../common/mod.rs"]
mod common;

mod fuzz_seeds;
mod mrm;
mod npz;
mod ret;
