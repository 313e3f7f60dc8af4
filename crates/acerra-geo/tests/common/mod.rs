//! Real measurements, where this machine has them.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use acerra_geo::read::{ReadOptions, ReadReport, read_trajectory};
use acerra_geo::trajectory::Trajectory;

#[expect(clippy::print_stdout, reason = "a skipped test says so")]
/// Reads a file of the shared measurements; none, with the reason printed, where it is absent.
pub fn read_shared(name: &str) -> Option<(Trajectory, ReadReport)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(name);
    let file = match File::open(&path) {
        Ok(file) => file,
        Err(error) => {
            println!("skipped: {}: {error}", path.display());
            return None;
        }
    };
    Some(read_trajectory(BufReader::new(file), &ReadOptions::default()).expect(name))
}
