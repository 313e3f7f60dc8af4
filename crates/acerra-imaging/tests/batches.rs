//! Memory that does not hold the tables of all pulses: batches of pulses give the same image.

#![allow(clippy::unwrap_used)]

#[macro_use]
mod common;

use common::{Campaign, band};

use acerra_imaging::plan::Decision;
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ImagingError, ImagingPlan, IncidenceWeight, PlanOptions,
    PlaneGrid, Progress, Pulses, SimdLevel, Spreading, VolumeGrid, image_volume_planned_once,
    reference,
};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

at_every_level!(
    batches_keep_the_accuracy_within_the_memory_allowed,
    weights_by_incidence_stay_with_their_pulses,
);

/// Two tracks of 90 pulses, the second one turned.
fn campaign() -> Campaign {
    campaign_of(90)
}

/// The same tracks with another number of pulses each.
fn campaign_of(pulses: u32) -> Campaign {
    let position_m = (0..2 * pulses)
        .map(|m| {
            let s = f64::from(m % pulses) * 2.7 / f64::from(pulses);
            let (x, y) = if m < pulses {
                (-1.0, s - 1.3)
            } else {
                (s - 1.0, 2.0)
            };
            [x, y, 4.0 + 0.05 * (5.0 * s).cos()]
        })
        .collect();
    let scene = [[0.2, 0.1, 0.0], [0.9, -0.4, 0.1], [30.0, 3.0, 0.0]];
    Campaign::new(position_m, band(48), &scene, 23)
}

fn grid() -> PlaneGrid {
    PlaneGrid::new([-0.4, -0.6, 0.0], 0.01, [150, 130]).unwrap()
}

/// A limit that leaves a third of what the whole plan takes, beside an image and its sum.
fn a_third(options: &PlanOptions, pulses: Pulses) -> PlanOptions {
    let whole = ImagingPlan::new(pulses, grid(), options).unwrap();
    assert_eq!(batches(&whole), 1);
    options.with_memory_limit_bytes(2 * 8 * grid().len() as u128 + whole.memory_bytes() / 3)
}

fn batches(plan: &ImagingPlan) -> usize {
    let found = plan.report().decisions.iter().rev();
    found
        .filter_map(|d| match d {
            Decision::Batches { batches } => Some(*batches),
            _ => None,
        })
        .next()
        .unwrap_or(1)
}

fn image(plan: &ImagingPlan) -> Vec<Complex64> {
    let mut image = vec![Complex32::ZERO; plan.pixels()];
    plan.run(&mut image, Control::default()).unwrap();
    let double = |v: &Complex32| Complex64::new(f64::from(v.re), f64::from(v.im));
    image.iter().map(double).collect()
}

fn batches_keep_the_accuracy_within_the_memory_allowed(level: SimdLevel) {
    let campaign = campaign();
    let pulses = campaign.pulses();
    let points: Vec<_> = (0..grid().len())
        .map(|k| {
            [
                -0.4 + 0.01 * (k % 150) as f64,
                -0.6 + 0.01 * (k / 150) as f64,
                0.0,
            ]
        })
        .collect();
    let expected = reference::adjoint(&pulses, &points, Spreading::InverseSquare).unwrap();
    for engine in [Engine::Direct, Engine::Factorized] {
        for accuracy in [1e-3, 1e-5] {
            let options = PlanOptions::default()
                .with_accuracy(accuracy)
                .with_level(level)
                .with_engine(engine);
            let options = a_third(&options, pulses);
            let plan = ImagingPlan::new(pulses, grid(), &options).unwrap();
            assert!(batches(&plan) >= 3 && plan.engine() == engine, "{plan}");
            assert!(plan.memory_bytes() <= options.memory_limit_bytes, "{plan}");
            let found = reference::relative_l2(&image(&plan), &expected).unwrap();
            assert!(found <= accuracy, "{found:e}\n{plan}");
        }
    }
}

fn weights_by_incidence_stay_with_their_pulses(level: SimdLevel) {
    let campaign = campaign();
    let weight = IncidenceWeight {
        cosine_power: 3.0,
        ..Default::default()
    };
    let options = PlanOptions::default()
        .with_level(level)
        .with_incidence(Some(weight));
    let whole = ImagingPlan::new(campaign.pulses(), grid(), &options).unwrap();
    let few = a_third(&options, campaign.pulses());
    let plan = ImagingPlan::new(campaign.pulses(), grid(), &few).unwrap();
    assert!(batches(&plan) > 1, "{plan}");
    let found = reference::relative_l2(&image(&plan), &image(&whole)).unwrap();
    assert!(found <= 2e-3, "{found:e}\n{plan}");
}

#[test]
fn progress_reaches_the_total_and_cancelling_ends_between_batches() {
    let campaign = campaign();
    let options =
        PlanOptions::default().with_memory_limit_bytes(8 * 3 * grid().len() as u128 + 200_000);
    let plan = ImagingPlan::new(campaign.pulses(), grid(), &options).unwrap();
    assert!(batches(&plan) > 1, "{plan}");
    assert!(plan.estimate_run_time_s(Control::default()) > 0.0);
    let mut image = vec![Complex32::ZERO; plan.pixels()];
    let (last, cancelled) = (AtomicU64::new(0), AtomicBool::new(false));
    let follow = |p: Progress| {
        last.fetch_max(p.done, Ordering::Relaxed);
        assert_eq!(p.total, plan.contributions());
    };
    plan.run(&mut image, Control::default().reporting_to(&follow))
        .unwrap();
    assert_eq!(last.into_inner(), plan.contributions());
    let stop = |_: Progress| cancelled.store(true, Ordering::Relaxed);
    let control = Control::default()
        .cancelled_by(&cancelled)
        .reporting_to(&stop);
    match plan.run(&mut image, control) {
        Err(ImagingError::Cancelled) => {}
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_direct_engine_stands_in_where_no_sub_aperture_fits() {
    // Enough pulses that planning the factorized engine is worth its time.
    let campaign = campaign_of(900);
    let limit_bytes = 2 * 8 * grid().len() as u128 + 300_000;
    let options = PlanOptions::default().with_memory_limit_bytes(limit_bytes);
    let plan = ImagingPlan::new(campaign.pulses(), grid(), &options).unwrap();
    let too_large = |d: &Decision| matches!(d, Decision::FactorizedTooLarge { .. });
    assert!(plan.report().decisions.iter().any(too_large), "{plan}");
    assert!(
        plan.engine() == Engine::Direct && batches(&plan) > 1,
        "{plan}"
    );
    let forced = options.with_engine(Engine::Factorized);
    match ImagingPlan::new(campaign.pulses(), grid(), &forced) {
        Err(ImagingError::TooLarge { bytes, .. }) => assert!(bytes > limit_bytes),
        other => panic!("{other:?}"),
    }
}

#[test]
fn few_contributions_are_imaged_directly_unless_repeated() {
    let campaign = campaign();
    let options = PlanOptions::default();
    let plan = ImagingPlan::new(campaign.pulses(), grid(), &options).unwrap();
    let few = |d: &Decision| matches!(d, Decision::FewContributions { direct_operations } if *direct_operations < 2e7);
    assert_eq!(plan.engine(), Engine::Direct, "{plan}");
    assert!(plan.report().decisions.iter().any(few), "{plan}");
    // As many slices as make it worth planning.
    let volume = VolumeGrid::new(grid(), 0.002, 40).unwrap();
    let run = image_volume_planned_once(
        &volume,
        campaign.pulses(),
        &options,
        Control::default(),
        |_, _, _| Ok::<(), ImagingError>(()),
    )
    .unwrap();
    assert!(!run.report.decisions.iter().any(few), "{}", run.report);
}

#[test]
fn a_volume_is_imaged_in_batches() {
    let campaign = campaign();
    let volume = VolumeGrid::new(grid(), 0.1, 3).unwrap();
    let run = |options: &PlanOptions| {
        let mut images = vec![];
        let pulses = campaign.pulses();
        let control = Control::default();
        let run = image_volume_planned_once(&volume, pulses, options, control, |_, _, image| {
            images.extend(
                image
                    .iter()
                    .map(|v| Complex64::new(v.re.into(), v.im.into())),
            );
            Ok::<_, ImagingError>(())
        });
        (run.unwrap(), images)
    };
    let (_, whole) = run(&PlanOptions::default());
    let few = a_third(&PlanOptions::default(), campaign.pulses());
    let (of_batches, images) = run(&few);
    assert!(of_batches.memory_bytes <= few.memory_limit_bytes);
    assert!(
        of_batches
            .report
            .decisions
            .iter()
            .any(|d| matches!(d, Decision::Batches { .. }))
    );
    assert!(reference::relative_l2(&images, &whole).unwrap() <= 2e-3);
}
