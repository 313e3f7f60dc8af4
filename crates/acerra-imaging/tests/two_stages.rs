//! Large images: sub-apertures are merged from shorter ones, and the image is right.

#![allow(clippy::unwrap_used)]

#[macro_use]
mod common;

use common::{Campaign, band};

use acerra_imaging::plan::{Decision, FactorizedChoice};
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ImagingError, ImagingPlan, PlanOptions, PlaneGrid,
    SimdLevel, Spreading, SurfaceGrid, reference,
};

at_every_level!(
    shorter_sub_apertures_keep_the_accuracy,
    uneven_ground_keeps_the_accuracy_too,
);

/// Pixels from one that is compared to the next: a prime, so that they meet every phase of the interpolations.
const STEP: usize = 3989;

/// Two tracks across a grid's diagonal: both axes are interpolated in both stages.
fn campaign() -> Campaign {
    let position_m = (0..1400)
        .map(|m| {
            let (track, s) = (f64::from(m / 700), f64::from(m % 700) / 700.0 - 0.5);
            let along = 12.0 * s;
            [
                0.8 * along + 1.5 * track,
                0.6 * along - 2.0 * track + 0.05 * (9.0 * s).sin(),
                5.0 + 0.05 * (7.0 * s).cos(),
            ]
        })
        .collect();
    let scene = [[0.3, 0.1, 0.0], [2.4, -3.2, 0.0], [-4.0, 1.7, 0.0]];
    Campaign::new(position_m, band(32), &scene, 17)
}

fn base() -> PlaneGrid {
    PlaneGrid::new([-3.3, -3.0, 0.0], 0.006, [1100, 1000]).unwrap()
}

fn options(level: SimdLevel, accuracy: f64) -> PlanOptions {
    PlanOptions::default()
        .with_accuracy(accuracy)
        .with_level(level)
        .with_engine(Engine::Factorized)
}

/// The partition of a plan: the last one tried is that which was accepted.
fn partition(plan: &ImagingPlan) -> FactorizedChoice {
    let choice = (plan.report().decisions.iter().rev()).find_map(|d| match d {
        Decision::Factorized(choice) => Some(*choice),
        _ => None,
    });
    choice.unwrap()
}

fn run(plan: &ImagingPlan, threads: usize) -> Vec<Complex32> {
    let mut image = vec![Complex32::ZERO; plan.pixels()];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let run = || plan.run(&mut image, Control::default());
    pool.unwrap().install(run).unwrap();
    image
}

/// Relative error of some pixels whose values are known.
fn error(image: &[Complex32], pixels: &[usize], expected: &[Complex64]) -> f64 {
    let value = |k: &usize| Complex64::new(image[*k].re.into(), image[*k].im.into());
    let image: Vec<_> = pixels.iter().map(value).collect();
    reference::relative_l2(&image, expected).unwrap()
}

fn shorter_sub_apertures_keep_the_accuracy(level: SimdLevel) {
    let (campaign, grid) = (campaign(), base());
    let pulses = campaign.pulses();
    let sparse: Vec<usize> = (0..grid.len()).step_by(STEP).collect();
    let points: Vec<_> = sparse.iter().map(|k| grid.point_m(*k)).collect();
    let expected = reference::adjoint(&pulses, &points, Spreading::InverseSquare).unwrap();
    for accuracy in [2e-3, 1e-3] {
        let plan = ImagingPlan::new(pulses, grid, &options(level, accuracy)).unwrap();
        let choice = partition(&plan);
        let shorter = choice.merged_from.unwrap_or_else(|| panic!("{plan}"));
        assert!(
            2 * shorter.sub_aperture_pulses <= choice.sub_aperture_pulses
                && shorter.coarse[0] >= choice.coarse[0]
                && shorter.coarse[1] >= choice.coarse[1],
            "{plan}"
        );
        let image = run(&plan, 1);
        assert!(image == run(&plan, 3), "bits hang on the number of threads");
        let found = error(&image, &sparse, &expected);
        assert!(found <= accuracy, "{found:e} for {accuracy:e}\n{plan}");
        assert!(plan.estimate_run_time_s(Control::default()) > 0.0);
    }
}

fn uneven_ground_keeps_the_accuracy_too(level: SimdLevel) {
    let (campaign, base) = (campaign(), base());
    let pulses = campaign.pulses();
    let hill = |x: f64, y: f64| {
        let knoll = (-0.2 * (x * x + y * y)).exp();
        Ok::<_, ImagingError>(0.1 * x - 0.05 * y + 0.4 * knoll + 0.02 * (3.0 * x + 2.0 * y).sin())
    };
    let ground = SurfaceGrid::from_fn(base, hill).unwrap();
    // All over the image, and at its edges, beyond which the ground is continued.
    let (columns, rows) = (base.nx, base.ny);
    let edges = (0..rows).step_by(41).flat_map(|j| {
        let i = (17 * j) % columns;
        [
            j * columns + j % 7,
            (j + 1) * columns - 1 - j % 5,
            i,
            (rows - 1) * columns + i,
        ]
    });
    let pixels: Vec<usize> = (0..ground.len()).step_by(STEP).chain(edges).collect();
    let points: Vec<_> = pixels.iter().map(|k| ground.point_m(*k)).collect();
    let expected = reference::adjoint(&pulses, &points, Spreading::InverseSquare).unwrap();
    for accuracy in [2e-3, 2e-4] {
        let plan = ImagingPlan::new(pulses, &ground, &options(level, accuracy)).unwrap();
        let choice = partition(&plan);
        assert_eq!(plan.engine(), Engine::Factorized, "{plan}");
        // Both axes are interpolated.
        assert!(choice.coarse.iter().all(|pixels| *pixels > 1.0), "{plan}");
        assert!(accuracy < 1e-3 || choice.merged_from.is_some(), "{plan}");
        let image = run(&plan, 1);
        assert!(image == run(&plan, 3), "bits hang on the number of threads");
        let found = error(&image, &pixels, &expected);
        assert!(found <= accuracy, "{found:e} for {accuracy:e}\n{plan}");
        assert!(plan.estimate_run_time_s(Control::default()) > 0.0);
    }
}
