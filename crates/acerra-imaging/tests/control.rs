//! Every long operation can be cancelled and followed.

#![allow(clippy::unwrap_used)] // helpers of tests

mod common;
use common::{Campaign, band};

use acerra_imaging::metrics::{ImageView, MeasureOptions, measure_targets_in};
use acerra_imaging::psf::{PointSpread, psf_image};
use acerra_imaging::sensitivity::{ErrorModel, MonteCarlo, simulate};
use acerra_imaging::tracks::{CalibrationOptions, calibrate_on_target};
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, Forward, ImagingError, ImagingPlan, PlanOptions,
    PlaneGrid, Progress, Spreading, SurfaceGrid, VolumeGrid, image_volume,
};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

const ENGINES: [Engine; 4] = [
    Engine::Direct,
    Engine::Factorized,
    Engine::Double,
    Engine::Reference,
];

fn campaign() -> Campaign {
    let position = (0..60)
        .map(|m| [-3.0, 0.04 * f64::from(m) - 1.2, 4.0])
        .collect();
    Campaign::new(position, band(48), &[[0.2, 0.1, 0.0], [0.5, -0.4, 0.0]], 5)
}

fn grid() -> PlaneGrid {
    PlaneGrid::new([-0.4, -0.6, 0.0], 0.01, [150, 130]).unwrap()
}

/// Runs `work` with a flag that is set before it starts.
fn refuses(work: impl FnOnce(Control) -> Result<(), ImagingError>) {
    let stop = AtomicBool::new(true);
    let outcome = work(Control::default().cancelled_by(&stop));
    assert_eq!(outcome.unwrap_err(), ImagingError::Cancelled);
}

#[test]
fn nothing_starts_once_cancelled() {
    let data = campaign();
    let (pulses, grid) = (data.pulses(), grid());
    let spread = PointSpread::of(&pulses);
    for engine in ENGINES {
        let options = PlanOptions::default().with_engine(engine);
        if engine != Engine::Reference {
            refuses(|c| ImagingPlan::with_control(pulses, grid, &options, c).map(|_| ()));
        }
        // In double precision the forward operator is not planned.
        if matches!(engine, Engine::Direct | Engine::Factorized) {
            refuses(|c| Forward::with_control(pulses, grid, &options, c).map(|_| ()));
        }
        let plan = ImagingPlan::new(pulses, grid, &options).unwrap();
        let mut image = vec![Complex32::ZERO; grid.len()];
        refuses(|c| plan.run(&mut image, c));
        let forward = Forward::new(pulses, grid, &options).unwrap();
        let mut echo = vec![Complex64::ZERO; data.spectrum.len()];
        refuses(|c| forward.run(&image, &mut echo, c));
    }
    let options = PlanOptions::default();
    let volume = VolumeGrid::new(grid, 0.1, 3).unwrap();
    refuses(|c| image_volume(&volume, pulses, &options, c, |_, _, _| Ok(())).map(|_| ()));
    refuses(|c| psf_image(&spread, &[[0.2, 0.1, 0.0]], grid, c).map(|_| ()));
    let model = ErrorModel::white(0.002, data.position_m.len()).unwrap();
    let draws = MonteCarlo {
        trials: 40,
        seed: 1,
    };
    refuses(|c| simulate(&spread, [0.2, 0.1, 0.0], &model, draws, c).map(|_| ()));
    let search = CalibrationOptions {
        window_s: 1e-9,
        spreading: Spreading::InverseSquare,
    };
    let level = |_: f64, _: f64| 0.0;
    refuses(|c| calibrate_on_target(&[pulses], &[[0.2, 0.1, 0.0]], search, &level, c).map(|_| ()));
    let image = acerra_imaging::image(pulses, grid, &options, Control::default()).unwrap();
    let view = ImageView::new(&image, grid).unwrap();
    refuses(|c| measure_targets_in(&view, &pulses, &MeasureOptions::default(), c).map(|_| ()));
}

#[test]
fn a_run_stops_soon_after_it_is_cancelled() {
    let data = campaign();
    let grid = grid();
    let slope = |x: f64, _: f64| Ok::<_, ImagingError>(0.1 * x);
    let ground = SurfaceGrid::from_fn(grid, slope).unwrap();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(2)
        .build()
        .unwrap();
    let plans = ENGINES
        .map(|engine| {
            let options = PlanOptions::default().with_engine(engine);
            ImagingPlan::new(data.pulses(), grid, &options).unwrap()
        })
        .into_iter()
        .chain([ImagingPlan::new(data.pulses(), &ground, &PlanOptions::default()).unwrap()]);
    for plan in plans {
        let (stop, most) = (AtomicBool::new(false), AtomicU64::new(0));
        let follow = |p: Progress| {
            assert_eq!(p.total, plan.contributions());
            most.fetch_max(p.done, Ordering::Relaxed);
            stop.store(true, Ordering::Relaxed);
        };
        let control = Control::default().cancelled_by(&stop).reporting_to(&follow);
        let mut image = vec![Complex32::ZERO; plan.pixels()];
        let outcome = pool.install(|| plan.run(&mut image, control));
        assert_eq!(outcome.unwrap_err(), ImagingError::Cancelled);
        // A share that is under way on the other thread may still be finished.
        let most = most.into_inner();
        assert!(
            most > 0 && most < plan.contributions() / 2,
            "{most} of {}: {plan}",
            plan.contributions()
        );
        // The plan can be run again.
        plan.run(&mut image, Control::default()).unwrap();
    }
}

#[test]
fn progress_of_a_volume_runs_through_all_slices() {
    let data = campaign();
    let base = PlaneGrid::new([0.0; 3], 0.02, [30, 20]).unwrap();
    let volume = VolumeGrid::new(base, 0.1, 4).unwrap();
    let most = AtomicU64::new(0);
    let total = 4 * 30 * 20 * 60;
    let follow = |p: Progress| {
        assert_eq!(p.total, total);
        most.fetch_max(p.done, Ordering::Relaxed);
    };
    let control = Control::default().reporting_to(&follow);
    let options = PlanOptions::default();
    let take = |_: usize, _: &PlaneGrid, _: &[Complex32]| Ok::<_, ImagingError>(());
    image_volume(&volume, data.pulses(), &options, control, take).unwrap();
    assert_eq!(most.into_inner(), total);
}
