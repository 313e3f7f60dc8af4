//! One module for each command: its arguments and its execution.
//!
//! Each `run` writes its answer to the given writer and returns the failure, if any, with the
//! file and the place in its context; [`crate::cli`] prints it.

pub mod calibrate;
pub mod completions;
pub mod convert;
pub mod demo;
pub mod emulate;
mod emulate_pps;
pub mod focus;
pub mod info;
pub mod init;
pub mod live;
pub mod man;
pub mod merge;
pub mod plan;
pub mod ppk;
pub mod psf;
pub mod record;
pub mod resolution;
pub mod schema;
pub mod simulate;
pub mod values;
pub mod view;
