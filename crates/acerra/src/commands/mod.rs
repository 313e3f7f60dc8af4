//! One module for each command: its arguments and what it does with them.
//!
//! Each `run` writes its answer to the given writer and returns the failure, if any, with the
//! file and the place in its context; [`crate::cli`] prints it.

pub mod calibrate;
pub mod demo;
pub mod focus;
pub mod info;
pub mod plan;
pub mod ppk;
pub mod psf;
pub mod resolution;
pub mod simulate;
pub mod values;

/// Tells the user something that stops nothing, on stderr.
fn warn(note: &str) {
    use std::io::Write;
    // Nothing is left to tell if stderr is closed.
    let _ = writeln!(std::io::stderr(), "acerra: note: {note}");
}
