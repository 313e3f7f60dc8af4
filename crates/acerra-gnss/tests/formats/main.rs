//! Readers and writers of files: one program, since each links the whole crate.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    reason = "tests may fail loudly"
)]

mod common;

mod antex;
mod conf;
mod crinex;
mod mutations;
mod packed;
mod pos_files;
mod precise;
mod rinex_columns;
mod rinex_real;
mod rinex_v4;
mod rtcm_made;
mod rtcm_real;
mod ubx_made;
mod ubx_real;
mod unix_compress;
