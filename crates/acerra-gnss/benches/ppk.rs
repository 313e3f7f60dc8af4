//! Time of whole runs: the walk of the shared data (where present) and a self-made flight.
//!
//! Side by side with RTKLIB: `time rnx2rtkp -k walk.conf rover.obs base.obs base.nav rover.nav`
//! with `reference/b34_fixhold_forward.conf` set to `soltype = combined`.

#![allow(clippy::unwrap_used)]

#[path = "../tests/rtklib/mod.rs"]
mod rtklib;
#[path = "../tests/synthetic/mod.rs"]
mod synthetic;

use acerra_gnss::{BasePosition, FilterDirection, PpkOptions, System, SystemSet, process};
use divan::Bencher;
use rtklib::sets::{Logs, WALK};
use std::sync::LazyLock;

fn main() {
    divan::main();
}

static WALK_LOGS: LazyLock<Option<Logs>> = LazyLock::new(|| WALK.read());

/// The walk (2072 epochs, GPS + GLONASS, L1), combined, with RTKLIB's settings.
#[divan::bench(args = [1, 2], sample_count = 5)]
fn walk_as_rtklib(bencher: Bencher<'_, '_>, threads: usize) {
    let Some(logs) = WALK_LOGS.as_ref() else {
        return;
    };
    let options = WALK.adapt(
        PpkOptions::rtklib()
            .with_direction(FilterDirection::Combined)
            .with_threads(threads),
    );
    bencher.bench(|| process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap());
}

/// The walk, combined, with this crate's defaults.
#[divan::bench(args = [1, 2], sample_count = 5)]
fn walk_by_default(bencher: Bencher<'_, '_>, threads: usize) {
    let Some(logs) = WALK_LOGS.as_ref() else {
        return;
    };
    let options = PpkOptions::default().with_threads(threads);
    bencher.bench(|| process(&logs.rover, &logs.base, &logs.navigation, &options).unwrap());
}

/// A self-made flight of 2000 epochs, GPS and Galileo, L1, combined.
#[divan::bench(args = [1, 2], sample_count = 3)]
fn flight_of_2000_epochs(bencher: Bencher<'_, '_>, threads: usize) {
    let navigation = synthetic::navigation();
    let rover = synthetic::rover(&navigation, 2_000, &synthetic::L1);
    let base = synthetic::base(&navigation, 2_000, &synthetic::L1);
    let options = PpkOptions::default()
        .with_systems(SystemSet::GPS.with(System::Galileo))
        .with_base_position(BasePosition::Ecef(synthetic::BASE_ECEF_M))
        .with_threads(threads);
    bencher.bench(|| process(&rover, &base, &navigation, &options).unwrap());
}
