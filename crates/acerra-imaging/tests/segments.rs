//! Long tracks: segments by distance from the image have partitions of their own, and the image is right.

#![allow(clippy::unwrap_used)]

#[macro_use]
mod common;

use common::{Campaign, band};

use acerra_imaging::plan::{Decision, FactorizedChoice};
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ImagingPlan, PlanOptions, PlaneGrid, SimdLevel,
    Spreading, reference,
};

at_every_level!(a_long_track_keeps_the_accuracy);

fn a_long_track_keeps_the_accuracy(level: SimdLevel) {
    // 300 m past an image of 4 m: distances from 4 m to 150 m.
    let position_m = (0..4000)
        .map(|m| {
            let y = 0.075 * f64::from(m) - 150.0;
            [
                0.05 * (1.3 * y).sin() - 1.0,
                y,
                4.0 + 0.05 * (0.9 * y).cos(),
            ]
        })
        .collect();
    let scene = [[0.3, 0.1, 0.0], [1.4, -1.2, 0.0], [-1.0, 60.0, 0.0]];
    let campaign = Campaign::new(position_m, band(24), &scene, 31);
    let pulses = campaign.pulses();
    let grid = PlaneGrid::new([-2.0, -2.0, 0.0], 0.05, [80, 80]).unwrap();
    // A ninth of the pixels, shifted from row to row: they meet every phase of the interpolation.
    let sparse: Vec<usize> = (0..grid.len()).step_by(9).collect();
    let place = |k: usize| -2.0 + 0.05 * k as f64;
    let points: Vec<_> = (sparse.iter())
        .map(|k| [place(k % 80), place(k / 80), 0.0])
        .collect();
    let expected = reference::adjoint(&pulses, &points, Spreading::InverseSquare).unwrap();
    for accuracy in [1e-2, 1e-3] {
        let options = PlanOptions::default()
            .with_accuracy(accuracy)
            .with_level(level)
            .with_engine(Engine::Factorized);
        let plan = ImagingPlan::new(pulses, grid, &options).unwrap();
        let choices: Vec<FactorizedChoice> = (plan.report().decisions.iter())
            .filter_map(|d| match d {
                Decision::Factorized(choice) => Some(*choice),
                _ => None,
            })
            .collect();
        let first = choices.iter().map(|c| c.pulses).scan(0, |sum, n| {
            *sum += n;
            Some(*sum)
        });
        // The choices of the plan that was accepted, or of one more that was rejected before it.
        assert!(
            choices.len() >= 3 && first.into_iter().any(|sum| sum == 4000),
            "{plan}"
        );
        let [longest, shortest] = [usize::max, usize::min].map(|of| {
            let lengths = choices.iter().map(|c| c.sub_aperture_pulses);
            lengths.reduce(of).unwrap()
        });
        assert!(longest >= 2 * shortest, "{plan}");
        let mut image = vec![Complex32::ZERO; grid.len()];
        plan.run(&mut image, Control::default()).unwrap();
        let image: Vec<_> = (sparse.iter())
            .map(|k| Complex64::new(image[*k].re.into(), image[*k].im.into()))
            .collect();
        let found = reference::relative_l2(&image, &expected).unwrap();
        assert!(found <= accuracy, "{found:e} for {accuracy:e}\n{plan}");
        assert!(plan.estimate_run_time_s(Control::default()) > 0.0);
    }
}
