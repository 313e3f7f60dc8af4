//! Imaging allocates nothing in its loops over pulses and pixels.

#![allow(clippy::unwrap_used)]

mod common;
use common::{Campaign, band};

use acerra_imaging::{Complex32, Control, Engine, ImagingPlan, PlanOptions, PlaneGrid};

/// Allocations of a run on this thread alone, with the same plan made before.
fn allocations(engine: Engine, pixels: usize, pulses: usize) -> u64 {
    let position: Vec<_> = (0..pulses)
        .map(|m| [-3.0, 0.01 * m as f64 - 1.0, 4.0])
        .collect();
    let campaign = Campaign::new(position, band(40), &[[0.2, 0.1, 0.0]], 3);
    let grid = PlaneGrid::new([-0.5, -0.5, 0.0], 0.01, [pixels, pixels]).unwrap();
    let options = PlanOptions::default().with_engine(engine);
    let plan = ImagingPlan::new(campaign.pulses(), grid, &options).unwrap();
    assert_eq!(plan.engine(), engine);
    let mut image = vec![Complex32::ZERO; grid.len()];
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    pool.install(|| {
        plan.run(&mut image, Control::default()).unwrap();
        allocation_counter::measure(|| plan.run(&mut image, Control::default()).unwrap())
            .count_total
    })
}

#[test]
fn the_direct_engine_allocates_nothing() {
    for (pixels, pulses) in [(64, 20), (300, 20), (64, 400)] {
        assert_eq!(allocations(Engine::Direct, pixels, pulses), 0);
    }
}

#[test]
fn the_factorized_engine_allocates_for_its_sub_apertures_alone() {
    let small = allocations(Engine::Factorized, 100, 200);
    assert!(small < 200, "{small}");
    // Sixteen times the pixels, the same sub-apertures.
    let large = allocations(Engine::Factorized, 400, 200);
    assert!(large < 2 * small, "{small} {large}");
}
