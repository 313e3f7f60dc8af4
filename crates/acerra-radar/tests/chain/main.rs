//! From records to spectra: alignment, clocks, delays, cleaning, quality: one program, since each links the whole crate.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests are like tests

#[path = "../common/mod.rs"]
mod common;

mod align;
mod clean;
mod clock;
mod offset;
mod quality;
