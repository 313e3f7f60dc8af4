//! Figure 7's point spread function: 601 × 601 pixels, 601 positions, 341 frequencies.

#![allow(missing_docs, clippy::unwrap_used)]

use acerra_imaging::psf::{Analysis, PointSpread, TrackShape, psf_image, synthetic_track};
use acerra_imaging::{Control, PlaneGrid};

fn main() {
    divan::main();
}

fn figure_7() -> PointSpread {
    let shape = TrackShape::Cosine {
        amplitude_m: 0.15,
        period_m: 24.0,
    };
    let track = synthetic_track(shape, 3.0, 0.01, 5.0).unwrap();
    let frequency_hz = (0..341).map(|n| 3.1e9 + 5e6 * f64::from(n)).collect();
    PointSpread::new(track, None, frequency_hz, 3e8).unwrap()
}

/// The image, planned anew each time.
#[divan::bench(sample_count = 10)]
fn image(bencher: divan::Bencher) {
    let spread = figure_7();
    let grid = PlaneGrid::from_ranges([-3.0, 3.0], [-3.0, 3.0], 0.0, 0.01).unwrap();
    bencher
        .counter(divan::counter::ItemsCount::new(
            grid.len() * spread.position_m().len(),
        ))
        .bench_local(|| psf_image(&spread, &[[0.0, 2.0, 0.0]], grid, Control::default()).unwrap());
}

/// Peak, cuts and ghost on the exact function.
#[divan::bench(sample_count = 10)]
fn analysis(bencher: divan::Bencher) {
    let spread = figure_7();
    bencher.bench_local(|| Analysis::of(&spread, [0.0, 2.0, 0.0], 0.0).unwrap());
}
