//! The positioning chain on receivers that are emulated: one program, since each links the whole crate.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "tests may fail loudly"
)]

#[path = "../synthetic/mod.rs"]
mod synthetic;

mod chain;
mod moving_base;
mod outputs;
mod products_chain;
mod single_point_prior;
mod sky;
mod street;
