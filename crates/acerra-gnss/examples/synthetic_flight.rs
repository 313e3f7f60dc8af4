//! Positions a self-made drone flight and prints how well: `cargo run --example synthetic_flight`.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/synthetic/mod.rs"]
mod synthetic;

use acerra_geo::geodesy::EnuFrame;
use acerra_gnss::{BasePosition, PpkOptions, Quality, System, SystemSet, process};

fn main() {
    let navigation = synthetic::navigation();
    let rover = synthetic::rover(&navigation, 300, &synthetic::L1);
    let base = synthetic::base(&navigation, 300, &synthetic::L1);
    let options = PpkOptions::default()
        .with_systems(SystemSet::GPS.with(System::Galileo))
        .with_base_position(BasePosition::Ecef(synthetic::BASE_ECEF_M));
    let solution = process(&rover, &base, &navigation, &options).unwrap();
    let mut worst_m = 0.0f64;
    for e in solution
        .epochs
        .iter()
        .filter(|e| e.quality == Quality::Fixed)
    {
        let truth = synthetic::flight(e.time.seconds_since(synthetic::start()));
        let [east, north, up] = EnuFrame::from_ecef(truth).enu_from_ecef(e.position_ecef_m);
        worst_m = worst_m.max(east.hypot(north).hypot(up));
    }
    println!(
        "{} of {} epochs fixed, the worst {:.1} mm off",
        solution.summary.fixed,
        solution.summary.rover_epochs,
        worst_m * 1e3
    );
}
