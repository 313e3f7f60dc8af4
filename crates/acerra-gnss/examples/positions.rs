//! Positions from files: `cargo run --example positions -- ROVER BASE [NAV…]`.
//!
//! Files may be RINEX (plain, Hatanaka-compressed, gzipped) or u-blox UBX. Prints one line per
//! epoch, east, north and up of the base in metres, with standard deviations.
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example speaks"
)]

use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::input::Limits;
use acerra_gnss::{GnssFile, Navigation, PpkOptions, process, read_gnss};
use std::error::Error;
use std::fs::File;

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    if paths.len() < 2 {
        return Err("expected ROVER BASE [NAV…]".into());
    }
    let mut files = Vec::new();
    for path in &paths {
        let file = File::open(path).map_err(|e| format!("{path}: {e}"))?;
        files.push(read_gnss(file, Limits::default()).map_err(|e| format!("{path}: {e}"))?);
    }
    let mut navigation = Navigation::default();
    for part in files.iter_mut().filter_map(|f| f.navigation.take()) {
        navigation.merge(part);
    }
    let observations = |file: &mut GnssFile| file.observations.take().unwrap_or_default();
    let (rover, base) = (observations(&mut files[0]), observations(&mut files[1]));

    let solution = process(&rover, &base, &navigation, &PpkOptions::default())?;

    for warning in &solution.summary.warnings {
        eprintln!("warning: {warning}");
    }
    let origin = solution.base_position_ecef_m.ok_or("no base position")?;
    let frame = EnuFrame::from_ecef(origin);
    for epoch in &solution.epochs {
        let [east, north, up] = frame.enu_from_ecef(epoch.position_ecef_m);
        let covariance = frame.enu_covariance_from_ecef(&epoch.covariance_ecef_m2);
        let sigma = |k: usize| covariance[k][k].max(0.0).sqrt();
        println!(
            "{} {east:.4} {north:.4} {up:.4} ±{:.4} ±{:.4} ±{:.4} {:?}",
            epoch.time,
            sigma(0),
            sigma(1),
            sigma(2),
            epoch.quality
        );
    }
    let summary = &solution.summary;
    eprintln!("{} of {} epochs fixed", summary.fixed, summary.rover_epochs);
    Ok(())
}
