//! Every SIMD level keeps the accuracy asked for against the double-precision sum.

#![allow(clippy::unwrap_used)]

#[macro_use]
mod common;

use common::{C, Campaign, band};

use acerra_imaging::plan::Decision;
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ImagingError, ImagingPlan, PlanOptions, PlaneGrid,
    Progress, PulseArrays, Pulses, SimdLevel, Spreading, SurfaceGrid, TiltedGrid, reference,
};

fn error(plan: &ImagingPlan, pulses: &Pulses, grid: &TiltedGrid, spreading: Spreading) -> f64 {
    let mut image = vec![Complex32::ZERO; plan.pixels()];
    plan.run(&mut image, Control::default()).unwrap();
    let points: Vec<_> = (0..grid.rows)
        .flat_map(|j| (0..grid.columns).map(move |i| (i, j)))
        .map(|(i, j)| grid.point_m(i as f64, j as f64))
        .collect();
    let expected = reference::adjoint(pulses, &points, spreading).unwrap();
    let image: Vec<_> = image
        .iter()
        .map(|v| Complex64::new(f64::from(v.re), f64::from(v.im)))
        .collect();
    reference::relative_l2(&image, &expected).unwrap()
}

at_every_level!(
    the_accuracy_holds_at_any_range,
    large_pixels_and_tilted_rows,
    squares_of_coarse_pixels,
    uneven_frequencies,
    one_pulse_one_pixel_one_row,
    pulses_in_the_image_plane,
    repeated_positions,
    no_spreading,
    the_factorized_engine_keeps_the_accuracy,
    coarse_grids_of_fractions_of_pixels_keep_the_accuracy,
    below_single_precision_tables_are_double,
);

fn check(campaign: &Campaign, grid: impl Into<TiltedGrid>, options: &PlanOptions) {
    let grid = grid.into();
    let pulses = campaign.pulses();
    let plan = ImagingPlan::new(pulses, grid, options).unwrap();
    let found = error(&plan, &pulses, &grid, options.spreading);
    assert!(
        found <= options.accuracy,
        "{found:e} for {:e}\n{plan}",
        options.accuracy
    );
}

fn the_accuracy_holds_at_any_range(level: SimdLevel) {
    for (range_m, seed) in [(3.0, 1), (5.0, 2), (100.0, 3), (3000.0, 4)] {
        let campaign = Campaign::random(range_m, 40, band(120), seed);
        let grid = PlaneGrid::new([-0.32, -0.32, 0.0], 0.01, [64, 64]).unwrap();
        for accuracy in [1e-2, 1e-3, 1e-4, 1e-5] {
            check(
                &campaign,
                grid,
                &PlanOptions::default()
                    .with_accuracy(accuracy)
                    .with_level(level),
            );
        }
    }
}

fn large_pixels_and_tilted_rows(level: SimdLevel) {
    let campaign = Campaign::random(8.0, 25, band(90), 5);
    for accuracy in [1e-3, 1e-5] {
        let options = PlanOptions::default()
            .with_accuracy(accuracy)
            .with_level(level);
        check(
            &campaign,
            PlaneGrid::new([-3.0, -3.0, 0.3], 0.15, [40, 30]).unwrap(),
            &options,
        );
        let tilted = TiltedGrid::new(
            [0.0, -0.3, 0.1],
            [0.007, 0.007, 0.003],
            [-0.01, 0.01, 0.0],
            50,
            37,
        )
        .unwrap();
        check(&campaign, tilted, &options);
    }
}

fn uneven_frequencies(level: SimdLevel) {
    let mut f = band(70);
    for (k, f) in f.iter_mut().enumerate() {
        *f += 6e6 * ((k * k) as f64).sin();
    }
    f.swap(3, 50);
    let campaign = Campaign::random(6.0, 20, f, 6);
    let grid = PlaneGrid::new([-0.3, -0.3, 0.0], 0.012, [40, 40]).unwrap();
    for accuracy in [1e-3, 1e-5] {
        check(
            &campaign,
            grid,
            &PlanOptions::default()
                .with_accuracy(accuracy)
                .with_level(level),
        );
    }
}

/// Pixels along the row and across that the last plan of the direct engine expands together.
fn group(plan: &ImagingPlan) -> [usize; 2] {
    let mut groups = plan.report().decisions.iter().filter_map(|d| match d {
        Decision::Direct(choice) => Some(choice.group),
        _ => None,
    });
    groups.next_back().unwrap()
}

fn squares_of_coarse_pixels(level: SimdLevel) {
    let mut squares = 0;
    for (size_m, height_m, seed) in [(0.02, 4.0, 21), (0.05, 8.0, 22), (0.25, 60.0, 23)] {
        let campaign = Campaign::random(height_m, 20, band(90), seed);
        let [s, c] = [0.6 * size_m, 0.8 * size_m];
        let grids = [
            PlaneGrid::new([-20.0 * size_m, 0.3, 0.0], size_m, [131, 45])
                .unwrap()
                .into(),
            // Rotated, sloping, and with axes that are not at right angles.
            TiltedGrid::new([0.0; 3], [c, s, 0.1 * size_m], [-s, c, 0.0], 66, 37).unwrap(),
            TiltedGrid::new([0.0; 3], [size_m, 0.0, 0.0], [0.4 * size_m, c, 0.0], 50, 41).unwrap(),
        ];
        for (grid, accuracy) in grids
            .into_iter()
            .flat_map(|g| [1e-2, 1e-3, 1e-4, 1e-5].map(|a| (g, a)))
        {
            let options = PlanOptions::default()
                .with_accuracy(accuracy)
                .with_level(level)
                .with_engine(Engine::Direct);
            check(&campaign, grid, &options);
            let plan = ImagingPlan::new(campaign.pulses(), grid, &options).unwrap();
            squares += usize::from(plan.engine() == Engine::Direct && group(&plan) == [4, 4]);
        }
    }
    assert!(squares >= 12, "{squares} of 36 plans by squares");
}

fn one_pulse_one_pixel_one_row(level: SimdLevel) {
    let options = PlanOptions::default().with_level(level);
    for pulses in [1, 33] {
        let campaign = Campaign::random(5.0, pulses, band(60), 7);
        for (nx, ny) in [(1, 1), (1, 300), (300, 1), (9, 2), (700, 3)] {
            check(
                &campaign,
                PlaneGrid::new([-0.5, -0.5, 0.0], 0.01, [nx, ny]).unwrap(),
                &options,
            );
        }
    }
    // A single frequency has no step and no band.
    let tone = Campaign::random(5.0, 10, vec![3.9e9], 8);
    check(
        &tone,
        PlaneGrid::new([-0.2, -0.2, 0.0], 0.01, [50, 20]).unwrap(),
        &options,
    );
}

fn pulses_in_the_image_plane(level: SimdLevel) {
    // The track runs through the image, half a pixel off the centres, then straight above it.
    for height in [0.0, 0.02, 0.5] {
        let position: Vec<_> = (0..25)
            .map(|m| [0.005, -0.3 + 0.0237 * f64::from(m), height])
            .collect();
        let campaign = Campaign::new(position, band(60), &[[0.2, 0.1, 0.0]], 9);
        let grid = PlaneGrid::new([-0.3, -0.3, 0.0], 0.01, [61, 61]).unwrap();
        for (accuracy, spreading) in [
            (1e-3, Spreading::InverseSquare),
            (1e-5, Spreading::None),
            (1e-4, Spreading::InverseSquare),
        ] {
            check(
                &campaign,
                grid,
                &PlanOptions::default()
                    .with_accuracy(accuracy)
                    .with_spreading(spreading)
                    .with_level(level),
            );
        }
    }
}

fn repeated_positions(level: SimdLevel) {
    let campaign = Campaign::new(vec![[0.0, 0.0, 4.0]; 40], band(50), &[[0.3, 0.0, 0.0]], 10);
    let grid = PlaneGrid::new([-0.5, -0.5, 0.0], 0.02, [50, 50]).unwrap();
    check(&campaign, grid, &PlanOptions::default().with_level(level));
}

fn no_spreading(level: SimdLevel) {
    let campaign = Campaign::random(5.0, 30, band(100), 11);
    let grid = PlaneGrid::new([-0.3, -0.3, 0.0], 0.01, [64, 40]).unwrap();
    let options = PlanOptions::default()
        .with_spreading(Spreading::None)
        .with_level(level);
    check(&campaign, grid, &options);
}

/// Pixels so coarse that no whole number of them makes an interval of a coarse grid.
fn coarse_grids_of_fractions_of_pixels_keep_the_accuracy(level: SimdLevel) {
    let position: Vec<_> = (0..96)
        .map(|m| {
            let s = 0.024 * f64::from(m) - 1.15;
            [0.05 * (4.0 * s).sin(), s, 5.0 + 0.03 * (6.0 * s).cos()]
        })
        .collect();
    let scene = [[2.0, 0.3, 0.0], [-3.1, 2.2, 0.0], [12.0, -8.0, 0.0]];
    let campaign = Campaign::new(position, band(64), &scene, 23);
    let pulses = campaign.pulses();
    let (mut fractions, mut many_taps) = (0, 0);
    for pixel_m in [0.024, 0.031, 0.04, 0.05] {
        // Neither whole cells nor whole vectors.
        let plane = PlaneGrid::new([-2.3, -1.7, 0.0], pixel_m, [131, 97]).unwrap();
        let tilted = TiltedGrid::new(
            [-2.0, -1.5, 0.1],
            [pixel_m, 0.2 * pixel_m, 0.05 * pixel_m],
            [-0.1 * pixel_m, pixel_m, 0.0],
            77,
            101,
        );
        for grid in [plane.into(), tilted.unwrap()] {
            // Few pixels, at every place of a cell in both directions.
            let sparse: Vec<usize> = (0..grid.columns * grid.rows).step_by(11).collect();
            let points: Vec<_> = (sparse.iter())
                .map(|k| grid.point_m((k % grid.columns) as f64, (k / grid.columns) as f64))
                .collect();
            let expected = reference::adjoint(&pulses, &points, Spreading::InverseSquare).unwrap();
            for accuracy in [5e-3, 5e-4] {
                let options = PlanOptions::default()
                    .with_accuracy(accuracy)
                    .with_level(level)
                    .with_engine(Engine::Factorized);
                let plan = ImagingPlan::new(pulses, grid, &options).unwrap();
                for decision in &plan.report().decisions {
                    if let Decision::Factorized(choice) = decision {
                        fractions += usize::from(choice.coarse.iter().any(|d| d.fract() > 0.0));
                        many_taps += usize::from(choice.taps > 12);
                    }
                }
                let mut image = vec![Complex32::ZERO; plan.pixels()];
                plan.run(&mut image, Control::default()).unwrap();
                let found: Vec<_> = (sparse.iter())
                    .map(|k| Complex64::new(image[*k].re.into(), image[*k].im.into()))
                    .collect();
                let found = reference::relative_l2(&found, &expected).unwrap();
                assert!(found <= accuracy, "{found:e} for {accuracy:e}\n{plan}");
            }
        }
    }
    assert!(fractions >= 6 && many_taps >= 2, "{fractions} {many_taps}");
}

fn the_factorized_engine_keeps_the_accuracy(level: SimdLevel) {
    // A wavering track beside, over and far from the patch; tilted and uneven steps as well.
    for (distance_m, height_m) in [(3.0, 4.0), (0.0, 3.0), (2500.0, 1500.0)] {
        let position: Vec<_> = (0..60)
            .map(|m| {
                let s = f64::from(m) * 0.04;
                [
                    0.1 * (3.0 * s).sin() - distance_m,
                    s - 1.2,
                    height_m + 0.05 * (5.0 * s).cos(),
                ]
            })
            .collect();
        let scene = [
            [0.2, 0.1, 0.0],
            [1.0, -0.4, 0.1],
            [30.0, 3.0, 0.0],
            [0.5, 0.9, 0.0],
        ];
        let campaign = Campaign::new(position, band(48), &scene, 17);
        let grids = [
            PlaneGrid::new([-0.4, -0.6, 0.0], 0.01, [150, 130])
                .unwrap()
                .into(),
            TiltedGrid::new(
                [0.0, -0.5, 0.1],
                [0.008, 0.003, 0.002],
                [-0.004, 0.012, 0.0],
                140,
                90,
            )
            .unwrap(),
        ];
        for grid in grids {
            for accuracy in [1e-2, 1e-3, 1e-4] {
                let options = PlanOptions::default()
                    .with_accuracy(accuracy)
                    .with_level(level)
                    .with_engine(Engine::Factorized);
                let pulses = campaign.pulses();
                let plan = ImagingPlan::new(pulses, grid, &options).unwrap();
                if accuracy > 5e-4 {
                    assert_eq!(plan.engine(), Engine::Factorized, "{plan}");
                }
                let mut image = vec![Complex32::ZERO; plan.pixels()];
                plan.run(&mut image, Control::default()).unwrap();
                let chosen: Vec<usize> = (0..image.len()).step_by(23).collect();
                let points: Vec<_> = chosen
                    .iter()
                    .map(|k| grid.point_m((k % grid.columns) as f64, (k / grid.columns) as f64))
                    .collect();
                let expected =
                    reference::adjoint(&pulses, &points, Spreading::InverseSquare).unwrap();
                let found: Vec<_> = chosen
                    .iter()
                    .map(|&k| Complex64::new(f64::from(image[k].re), f64::from(image[k].im)))
                    .collect();
                let error = reference::relative_l2(&found, &expected).unwrap();
                assert!(error <= accuracy, "{error:e} for {accuracy:e}\n{plan}");
            }
        }
    }
}

#[test]
fn the_same_plan_gives_the_same_bits_on_any_number_of_threads() {
    let campaign = Campaign::random(5.0, 50, band(80), 12);
    let grid = PlaneGrid::new([-1.0, -1.0, 0.0], 0.01, [201, 150]).unwrap();
    for engine in [Engine::Direct, Engine::Factorized] {
        let options = PlanOptions::default().with_engine(engine);
        let plan = ImagingPlan::new(campaign.pulses(), grid, &options).unwrap();
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let mut image = vec![Complex32::ZERO; grid.len()];
            pool.install(|| plan.run(&mut image, Control::default()))
                .unwrap();
            image
                .iter()
                .map(|v| (v.re.to_bits(), v.im.to_bits()))
                .collect::<Vec<_>>()
        };
        let one = run(1);
        assert!(one == run(2) && one == run(5) && one == run(1));
    }
}

#[test]
fn a_point_target_stands_where_it_is() {
    let target = [0.4, 0.25, 0.0];
    let position: Vec<_> = (0..80)
        .map(|m| [-3.0, -2.0 + 0.05 * f64::from(m), 4.0])
        .collect();
    let f = band(100);
    let one = [reference::Scatterer {
        position_m: target,
        reflectivity: Complex64::ONE,
    }];
    let spectrum = reference::forward(&position, &f, &one, C, Spreading::None).unwrap();
    let weight = vec![1.0; 80];
    let pulses = Pulses::new(PulseArrays {
        position_m: &position,
        frequency_hz: &f,
        spectrum: &spectrum,
        weight: &weight,
        light_speed_m_s: C,
    })
    .unwrap();
    let grid = PlaneGrid::new([0.0, 0.0, 0.0], 0.01, [81, 51]).unwrap();
    let options = PlanOptions::default().with_spreading(Spreading::None);
    let image = acerra_imaging::image(pulses, grid, &options, Control::default()).unwrap();
    let (peak, value) = image
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()))
        .unwrap();
    assert_eq!(peak, 25 * 81 + 40);
    assert!((value.re - 8000.0).abs() < 8.0 && value.im.abs() < 8.0);
}

fn below_single_precision_tables_are_double(level: SimdLevel) {
    let keeps = |campaign: &Campaign, grid: TiltedGrid, accuracy: f64, spreading: Spreading| {
        let options = PlanOptions::default()
            .with_accuracy(accuracy)
            .with_spreading(spreading)
            .with_level(level);
        let plan = ImagingPlan::new(campaign.pulses(), grid, &options).unwrap();
        assert_eq!(plan.engine(), Engine::Double, "{plan}");
        assert!(plan.self_check().is_some_and(|c| c.error_bound <= accuracy));
        check(campaign, grid, &options);
    };
    let fine = PlaneGrid::new([-0.1, -0.1, 0.0], 0.01, [21, 20]).unwrap();
    let coarse = PlaneGrid::new([-3.0, -3.0, 0.3], 0.15, [40, 30]).unwrap();
    let (along, across) = ([0.007, 0.007, 0.003], [-0.01, 0.01, 0.0]);
    let tilted = TiltedGrid::new([0.0, -0.3, 0.1], along, across, 21, 17).unwrap();
    for (range_m, seed) in [(3.0, 1), (100.0, 3), (3000.0, 4)] {
        let campaign = Campaign::random(range_m, 40, band(120), seed);
        for accuracy in [1e-6, 2e-7] {
            for grid in [fine.into(), coarse.into(), tilted] {
                keeps(&campaign, grid, accuracy, Spreading::InverseSquare);
            }
        }
    }
    let campaign = Campaign::random(5.0, 40, band(120), 8);
    keeps(&campaign, fine.into(), 1e-6, Spreading::None);
    // Next to an antenna, where 1/R² changes by orders of magnitude within a bin.
    let place = vec![[0.055, 0.031, 0.004], [0.3, 0.2, 1.0]];
    let near = Campaign::new(place, band(120), &[[1.0, 0.0, 0.0], [0.05, 0.03, 0.0]], 15);
    keeps(&near, fine.into(), 1e-6, Spreading::InverseSquare);
}

#[test]
fn uneven_ground_is_imaged_in_double_precision() {
    let campaign = Campaign::random(5.0, 40, band(120), 9);
    let base = PlaneGrid::new([-1.0, -1.0, 0.0], 0.05, [41, 37]).unwrap();
    let height = |x_m: f64, y_m: f64| Ok::<_, ImagingError>(0.3 * (2.0 * x_m).sin() * y_m);
    let ground = SurfaceGrid::from_fn(base, height).unwrap();
    let options = PlanOptions::default().with_accuracy(1e-6);
    let plan = ImagingPlan::new(campaign.pulses(), &ground, &options).unwrap();
    assert_eq!(plan.engine(), Engine::Double, "{plan}");
    let run = |plan: &ImagingPlan| {
        let mut image = vec![Complex32::ZERO; plan.pixels()];
        plan.run(&mut image, Control::default()).unwrap();
        let wide = |v: &Complex32| Complex64::new(f64::from(v.re), f64::from(v.im));
        image.iter().map(wide).collect::<Vec<_>>()
    };
    let exact = options.with_engine(Engine::Reference);
    let exact = ImagingPlan::new(campaign.pulses(), &ground, &exact).unwrap();
    let error = reference::relative_l2(&run(&plan), &run(&exact)).unwrap();
    assert!(error < 1e-6, "{error:e}");
}

#[test]
fn the_sum_itself_is_run_where_no_double_tables_keep_the_accuracy() {
    let campaign = Campaign::random(5.0, 10, band(30), 13);
    let grid = PlaneGrid::new([0.0, 0.0, 0.0], 0.01, [20, 20]).unwrap();
    let reference_for = |campaign: &Campaign, options: &PlanOptions| {
        let plan = ImagingPlan::new(campaign.pulses(), grid, options).unwrap();
        assert_eq!(plan.engine(), Engine::Reference, "{plan}");
        assert!(plan.report().decisions.contains(&Decision::NoDoubleTables));
        let error = error(&plan, &campaign.pulses(), &grid.into(), options.spreading);
        assert!(error < 1e-7, "{error:e}");
    };
    // An image in single precision rounds to 3e-8.
    reference_for(&campaign, &PlanOptions::default().with_accuracy(1e-9));
    // Room for the image alone.
    let options = PlanOptions::default().with_accuracy(1e-6);
    reference_for(&campaign, &options.with_memory_limit_bytes(20_000));
    let mut uneven = band(30);
    uneven[7] += 3e6;
    reference_for(&Campaign::random(5.0, 10, uneven, 13), &options);
}

#[test]
fn impossible_requests_are_refused() {
    let campaign = Campaign::random(5.0, 3, band(30), 14);
    let grid = PlaneGrid::new([0.0, 0.0, 0.0], 0.01, [20, 20]).unwrap();
    for accuracy in [0.0, -1.0, 0.5, f64::NAN] {
        let options = PlanOptions::default().with_accuracy(accuracy);
        assert!(ImagingPlan::new(campaign.pulses(), grid, &options).is_err());
    }
    let options = PlanOptions::default().with_memory_limit_bytes(4000);
    match ImagingPlan::new(campaign.pulses(), grid, &options) {
        Err(ImagingError::TooLarge {
            bytes,
            limit_bytes: 4000,
            ..
        }) => assert!(bytes > 4000),
        other => panic!("{other:?}"),
    }
    let on_pixel = Campaign::new(vec![[0.05, 0.03, 0.0]], band(30), &[[1.0, 0.0, 0.0]], 15);
    match ImagingPlan::new(on_pixel.pulses(), grid, &PlanOptions::default()) {
        Err(ImagingError::ZeroRange { pulse: 0, point }) => assert_eq!(point, 3 * 20 + 5),
        other => panic!("{other:?}"),
    }
    let plan = ImagingPlan::new(campaign.pulses(), grid, &PlanOptions::default()).unwrap();
    assert!(
        plan.run(&mut [Complex32::ZERO; 3], Control::default())
            .is_err()
    );
}

#[test]
fn progress_reaches_the_total_and_the_plan_explains_itself() {
    use std::sync::atomic::{AtomicU64, Ordering};
    let campaign = Campaign::random(5.0, 12, band(30), 16);
    let grid = PlaneGrid::new([0.0, 0.0, 0.0], 0.01, [100, 90]).unwrap();
    let plan = ImagingPlan::new(campaign.pulses(), grid, &PlanOptions::default()).unwrap();
    let most = AtomicU64::new(0);
    let mut image = vec![Complex32::ZERO; grid.len()];
    let follow = |p: Progress| {
        assert_eq!(p.total, 12 * 9000);
        most.fetch_max(p.done, Ordering::Relaxed);
    };
    plan.run(&mut image, Control::default().reporting_to(&follow))
        .unwrap();
    assert_eq!(most.into_inner(), 12 * 9000);
    let text = plan.report().to_string();
    assert!(
        text.contains("self-check") && text.contains("range bins"),
        "{text}"
    );
    assert!((plan.self_check().unwrap().error) <= 1e-3);
}

#[test]
fn long_sparse_tracks_are_factorized_too() {
    // 31 m of track 4 m up, as in the paper's Track 1: the longest parts are no good, short ones are.
    let position: Vec<_> = (0..251)
        .map(|m| [0.125 * f64::from(m) - 15.6, 0.0, 4.0])
        .collect();
    let campaign = Campaign::new(position, band(60), &[[0.3, 0.1, 0.0]], 4);
    let grid = PlaneGrid::new([-4.0, -4.0, 0.0], 0.01, [800, 800]).unwrap();
    let plan = ImagingPlan::new(campaign.pulses(), grid, &PlanOptions::default()).unwrap();
    assert_eq!(plan.engine(), Engine::Factorized, "{plan}");
}
