//! Reads a trajectory of any known format, says what it holds, and where the platform was.
//!
//! `cargo run -p acerra-geo --example track -- flight.pos [TIME_S…]`; without a file a table of its
//! own is read.

#![allow(clippy::print_stdout)] // an example talks to its user

use std::error::Error;
use std::fs::File;
use std::io::{BufRead, BufReader};

use acerra_geo::interpolate::{InterpolationOptions, Interpolator};
use acerra_geo::read::{ReadOptions, read_trajectory};

const TABLE: &str = "time_s,x_m,y_m,z_m\n0,0.00,0,4.00\n0.2,0.31,0,4.02\n0.4,0.60,0,4.03\n\
                     0.6,0.92,0,4.01\n0.8,1.21,0,4.00\n";

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let input: Box<dyn BufRead> = match arguments.next() {
        Some(path) => Box::new(BufReader::new(File::open(path)?)),
        None => Box::new(TABLE.as_bytes()),
    };
    let (track, report) = read_trajectory(input, &ReadOptions::default())?;
    println!("{}: {report}", report.format);
    for warning in &report.warnings {
        println!("warning: {warning}");
    }
    println!(
        "{} to {} s, {:.2} m of path; {}",
        track.start_s(),
        track.end_s(),
        track.path_length_m(),
        track.status_counts()
    );
    let at = Interpolator::new(&track, &InterpolationOptions::default());
    let middle_s = 0.5 * (track.start_s() + track.end_s());
    let mut times_s = arguments
        .map(|t| t.parse())
        .collect::<Result<Vec<f64>, _>>()?;
    if times_s.is_empty() {
        times_s.push(middle_s);
    }
    for t in times_s {
        let place = at.at(t);
        let [x, y, z] = place.position_m;
        println!("{t} s: x {x:.3}, y {y:.3}, z {z:.3} m ({})", place.flag);
    }
    Ok(())
}
