//! Large images: sub-apertures are merged from shorter ones, and the image is right.

#![allow(clippy::unwrap_used)]

#[macro_use]
mod common;

use common::{Campaign, band};

use acerra_imaging::plan::{Decision, FactorizedChoice};
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ImagingPlan, PlanOptions, PlaneGrid, SimdLevel,
    Spreading, reference,
};

at_every_level!(shorter_sub_apertures_keep_the_accuracy);

/// Pixels from one that is compared to the next: a prime, so that they meet every phase of the interpolations.
const STEP: usize = 3989;

fn shorter_sub_apertures_keep_the_accuracy(level: SimdLevel) {
    // Two tracks across a grid's diagonal: both axes are interpolated in both stages.
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
    let campaign = Campaign::new(position_m, band(32), &scene, 17);
    let pulses = campaign.pulses();
    let (columns, pixel_m) = (1100, 0.006);
    let grid = PlaneGrid::new([-3.3, -3.0, 0.0], pixel_m, [columns, 1000]).unwrap();
    let sparse: Vec<usize> = (0..grid.len()).step_by(STEP).collect();
    let points: Vec<_> = (sparse.iter())
        .map(|k| {
            let place = |first: f64, k: usize| first + pixel_m * k as f64;
            [place(-3.3, k % columns), place(-3.0, k / columns), 0.0]
        })
        .collect();
    let expected = reference::adjoint(&pulses, &points, Spreading::InverseSquare).unwrap();
    for accuracy in [2e-3, 1e-3] {
        let options = PlanOptions::default()
            .with_accuracy(accuracy)
            .with_level(level)
            .with_engine(Engine::Factorized);
        let plan = ImagingPlan::new(pulses, grid, &options).unwrap();
        // Of the plan that was accepted, the last one tried.
        let choice = (plan.report().decisions.iter().rev()).find_map(|d| match d {
            Decision::Factorized(choice) => Some(*choice),
            _ => None,
        });
        let choice: FactorizedChoice = choice.unwrap();
        let shorter = choice.merged_from.unwrap_or_else(|| panic!("{plan}"));
        assert!(
            2 * shorter.sub_aperture_pulses <= choice.sub_aperture_pulses
                && shorter.coarse[0] >= choice.coarse[0]
                && shorter.coarse[1] >= choice.coarse[1],
            "{plan}"
        );
        let run = |threads: usize| {
            let mut image = vec![Complex32::ZERO; grid.len()];
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let run = || plan.run(&mut image, Control::default());
            pool.unwrap().install(run).unwrap();
            image
        };
        let image = run(1);
        assert!(image == run(3), "bits hang on the number of threads");
        let image: Vec<_> = (sparse.iter())
            .map(|k| Complex64::new(image[*k].re.into(), image[*k].im.into()))
            .collect();
        let found = reference::relative_l2(&image, &expected).unwrap();
        assert!(found <= accuracy, "{found:e} for {accuracy:e}\n{plan}");
        assert!(plan.estimate_run_time_s(Control::default()) > 0.0);
    }
}
