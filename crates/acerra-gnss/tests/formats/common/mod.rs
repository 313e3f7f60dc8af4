//! Access to the shared real data, which may be absent.
#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "shared by test binaries"
)]

use std::fs::File;
use std::path::PathBuf;

/// The path of a shared data file, or `None` (and a printed reason) where it is absent.
pub fn data(name: &str) -> Option<PathBuf> {
    let path =
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: {} is not there", path.display());
    None
}

/// A shared data file, opened.
pub fn open(name: &str) -> Option<File> {
    data(name).map(|path| File::open(path).unwrap())
}
