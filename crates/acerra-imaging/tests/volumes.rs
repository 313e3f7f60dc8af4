//! Volumes whose slices share plans: every slice keeps the accuracy, whatever its distance from the antennas and
//! however dark it is.

#![allow(clippy::unwrap_used)]

#[macro_use]
mod common;

use common::{Campaign, band};

use acerra_imaging::{
    Complex32, Complex64, Control, Engine, ForwardVolume, ImagingError, IncidenceWeight,
    PlanOptions, PlaneGrid, Progress, SimdLevel, VolumeGrid, VolumeRun, image_volume_planned_once,
    reference,
};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

at_every_level!(
    tall_volumes_keep_the_accuracy_in_groups_of_slices,
    dark_slices_keep_the_accuracy,
    weights_by_incidence_are_those_of_each_slice,
    echoes_of_every_slice_keep_the_accuracy,
    weights_by_incidence_are_those_of_each_slice_in_echoes,
);

/// A limit of incidence whose edge passes through the slices at other places in each.
const NARROW: IncidenceWeight = IncidenceWeight {
    max_rad: 0.5,
    taper_rad: 0.2,
    cosine_power: 1.5,
};

/// Pixels of a slice from which every second along rows and columns is compared.
const MOST_COMPARED: usize = 5000;

/// A track of `pulses` along y, 4 m up.
fn track(pulses: u32, scene: &[[f64; 3]]) -> Campaign {
    let position_m = (0..pulses)
        .map(|m| {
            let s = f64::from(m) / f64::from(pulses) - 0.5;
            [0.1 * (7.0 * s).sin(), 4.0 * s, 4.0 + 0.05 * (5.0 * s).cos()]
        })
        .collect();
    Campaign::new(position_m, band(64), scene, 11)
}

fn volume(
    corner_m: [f64; 3],
    [pixel_m, step_m]: [f64; 2],
    size: [usize; 2],
    nz: usize,
) -> VolumeGrid {
    let base = PlaneGrid::new(corner_m, pixel_m, size).unwrap();
    VolumeGrid::new(base, step_m, nz).unwrap()
}

/// Relative errors of the slices of a volume, and what imaging it took.
fn errors(
    campaign: &Campaign,
    volume: &VolumeGrid,
    options: &PlanOptions,
) -> (Vec<f64>, VolumeRun) {
    let pulses = campaign.pulses();
    let mut errors = Vec::new();
    let take = |k: usize, grid: &PlaneGrid, image: &[Complex32]| {
        assert_eq!((k, *grid), (errors.len(), volume.slice(k)));
        let step = if grid.len() < MOST_COMPARED { 1 } else { 2 };
        let size = [grid.nx.div_ceil(step), grid.ny.div_ceil(step)];
        let corner_m = [grid.x0_m, grid.y0_m, grid.z_m];
        let sparse = PlaneGrid::new(corner_m, grid.pixel_m * step as f64, size)?;
        let exact = options.with_engine(Engine::Reference);
        let expected = acerra_imaging::image(pulses, sparse, &exact, Control::default())?;
        let at = |n: usize| (n / size[0] * grid.nx + n % size[0]) * step;
        let found: Vec<_> = (0..expected.len()).map(|n| wide(&image[at(n)])).collect();
        let expected: Vec<_> = expected.iter().map(wide).collect();
        errors.push(reference::relative_l2(&found, &expected)?);
        Ok::<_, ImagingError>(())
    };
    let control = Control::default();
    let run = image_volume_planned_once(volume, pulses, options, control, take).unwrap();
    assert_eq!(errors.len(), volume.nz);
    assert_eq!(run.plans.first().unwrap().start, 0);
    assert_eq!(run.plans.last().unwrap().end, volume.nz);
    assert!(run.plans.windows(2).all(|w| w[0].end == w[1].start));
    (errors, run)
}

fn wide(v: &Complex32) -> Complex64 {
    Complex64::new(v.re.into(), v.im.into())
}

fn check(campaign: &Campaign, volume: &VolumeGrid, options: &PlanOptions) -> VolumeRun {
    let (errors, run) = errors(campaign, volume, options);
    let broken: Vec<_> = (errors.iter().enumerate())
        .filter(|(_, error)| **error > options.accuracy)
        .collect();
    assert!(
        broken.is_empty(),
        "{broken:?} {:?} {:?} {}",
        run.plans,
        run.checked_error,
        run.report
    );
    assert!(run.checked_error.is_none_or(|e| e <= options.accuracy));
    run
}

/// From the ground up to 30 cm below the antennas, where ranges change fastest.
fn tall_volumes_keep_the_accuracy_in_groups_of_slices(level: SimdLevel) {
    let campaign = track(160, &[[0.4, 0.2, 0.1], [-0.3, 0.5, 1.4], [6.0, 2.0, 0.0]]);
    let tall = volume([-0.8, -0.9, -0.3], [0.02, 0.04], [81, 91], 100);
    let options = PlanOptions::default().with_level(level);
    let run = check(&campaign, &tall, &options);
    assert!(run.plans.len() > 1, "{:?}", run.plans);
    // Far slices need less than one plan for all would take.
    let far = VolumeGrid::new(tall.base, tall.step_m, 30).unwrap();
    let run = check(&campaign, &far, &options.with_accuracy(2e-4));
    assert!(run.plans.len() < 4, "{:?}", run.plans);
}

/// Echoes of targets at some height alone, under a narrow beam of tracks: above and below there is little.
fn dark_slices_keep_the_accuracy(level: SimdLevel) {
    let mut position_m = Vec::new();
    for x in [-2.0, -1.2, -0.4, 0.4, 1.2, 2.0] {
        position_m.extend((0..40).map(|m| [x, 0.1 * f64::from(m) - 2.0, 4.0]));
    }
    let target = |position_m| reference::Scatterer {
        position_m,
        reflectivity: Complex64::ONE,
    };
    let scene = [[0.1, 0.0, 0.0], [-0.1, 0.15, 0.02]].map(target);
    let campaign = Campaign::quiet(position_m, band(64), &scene);
    for size in [[40, 36], [70, 70]] {
        let half = 0.01 * size[0] as f64;
        let deep = volume([-half, -half, -0.6], [0.02, 0.04], size, 31);
        let (errors, run) = errors(&campaign, &deep, &PlanOptions::default().with_level(level));
        let worst = errors.iter().copied().fold(0.0, f64::max);
        assert!(worst <= 1e-3, "{worst:e} {:?}", run.plans);
    }
}

fn weights_by_incidence_are_those_of_each_slice(level: SimdLevel) {
    let campaign = track(120, &[[0.4, 0.2, 0.1], [-0.3, 0.5, 0.4]]);
    let options = PlanOptions::default()
        .with_level(level)
        .with_incidence(Some(NARROW));
    let slices = volume([-1.5, -1.5, 0.0], [0.05; 2], [61, 64], 9);
    let run = check(&campaign, &slices, &options);
    assert_eq!(run.plans.len(), 1);
    // The memory of one slice's tables, and in batches where it is scarce.
    let limit = options.with_memory_limit_bytes(run.memory_bytes * 2 / 3);
    let in_batches = check(&campaign, &slices, &limit);
    assert!(in_batches.memory_bytes <= run.memory_bytes * 2 / 3);
    // Tables in double precision hold no weights.
    let double = check(&campaign, &slices, &options.with_accuracy(1e-6));
    assert_eq!(double.report.engine, Engine::Double, "{}", double.report);
    assert_eq!(double.plans.len(), 1, "{:?}", double.plans);
}

#[test]
fn a_volume_planned_once_can_be_cancelled_and_followed() {
    let campaign = track(60, &[[0.4, 0.2, 0.1]]);
    let slices = volume([-0.3, -0.3, 0.0], [0.02; 2], [31, 30], 12);
    let total = 12 * 31 * 30 * 60;
    let (stop, most) = (AtomicBool::new(false), AtomicU64::new(0));
    let follow = |p: Progress| {
        assert_eq!(p.total, total);
        most.fetch_max(p.done, Ordering::Relaxed);
    };
    let control = Control::default().reporting_to(&follow).cancelled_by(&stop);
    let run = |last: usize| {
        let (pulses, options) = (campaign.pulses(), PlanOptions::default());
        let mut taken = 0;
        let outcome = image_volume_planned_once(&slices, pulses, &options, control, |k, _, _| {
            taken += 1;
            stop.store(k == last, Ordering::Relaxed);
            Ok::<_, ImagingError>(())
        });
        (outcome, taken)
    };
    let (outcome, taken) = run(usize::MAX);
    assert!(outcome.is_ok() && taken == 12);
    assert_eq!(most.swap(0, Ordering::Relaxed), total);
    let (outcome, taken) = run(4);
    assert_eq!((outcome.unwrap_err(), taken), (ImagingError::Cancelled, 5));
    assert!(most.into_inner() < total / 2);
}

/// The spectra of some random voxels in the slices that `is_bright` names.
fn echoes(
    forward: &ForwardVolume,
    campaign: &Campaign,
    is_bright: &dyn Fn(usize) -> bool,
) -> Vec<Complex64> {
    let give = |k: usize, image: &mut [Complex32]| {
        let mut random = common::Random(k as u64 + 1);
        image.fill_with(|| {
            let value = random.complex();
            // The double-precision sum leaves dark voxels out.
            match is_bright(k) && random.next() > 0.8 {
                true => Complex32::new(value.re as f32, value.im as f32),
                false => Complex32::ZERO,
            }
        });
    };
    let mut echo = vec![Complex64::ZERO; campaign.pulses().spectrum().len()];
    forward.run(give, &mut echo, Control::default()).unwrap();
    echo
}

/// Compares the echoes of single slices, and of all, with the double-precision sum.
fn check_echoes(campaign: &Campaign, volume: &VolumeGrid, options: &PlanOptions) -> Vec<Engine> {
    let plan = |options: &PlanOptions| {
        ForwardVolume::new(volume, campaign.pulses(), options, Control::default()).unwrap()
    };
    let (fast, exact) = (plan(options), plan(&options.with_engine(Engine::Reference)));
    let last = volume.nz - 1;
    for slices in [0..1, last / 2..last / 2 + 1, last..last + 1, 0..volume.nz] {
        let is_bright = |k: usize| slices.contains(&k);
        let found = echoes(&fast, campaign, &is_bright);
        let expected = echoes(&exact, campaign, &is_bright);
        let error = reference::relative_l2(&found, &expected).unwrap();
        assert!(
            error <= options.accuracy,
            "{slices:?} of {fast:?}: {error:e}"
        );
    }
    let ends: Vec<_> = fast.plans().collect();
    assert_eq!((ends[0].start, ends[ends.len() - 1].end), (0, volume.nz));
    assert!(ends.windows(2).all(|w| w[0].end == w[1].start));
    assert!(fast.memory_bytes() <= options.memory_limit_bytes);
    fast.reports().map(|report| report.engine).collect()
}

/// Slices from the ground up to 30 cm below the antennas, by both engines, with all bins at once and in batches.
fn echoes_of_every_slice_keep_the_accuracy(level: SimdLevel) {
    let campaign = track(90, &[]);
    let options = PlanOptions::default().with_level(level);
    let tall = volume([-0.4, -0.5, -0.3], [0.02, 0.25], [41, 51], 17);
    let low = volume([-0.4, -0.5, -0.3], [0.01, 0.05], [61, 71], 5);
    for (engine, accuracy, volume) in [
        (Engine::Direct, 1e-3, &tall),
        (Engine::Direct, 2e-5, &tall),
        (Engine::Factorized, 1e-3, &low),
    ] {
        let options = options.with_engine(engine).with_accuracy(accuracy);
        let engines = check_echoes(&campaign, volume, &options);
        assert!(engines.contains(&engine), "{engines:?}");
    }
    let direct = options.with_engine(Engine::Direct);
    let forward = |options: &PlanOptions| {
        ForwardVolume::new(&tall, campaign.pulses(), options, Control::default()).unwrap()
    };
    let whole_bytes = forward(&direct).memory_bytes();
    let scarce = direct.with_memory_limit_bytes(whole_bytes * 2 / 3);
    assert!(forward(&scarce).memory_bytes() <= whole_bytes * 2 / 3);
    check_echoes(&campaign, &tall, &scarce);
}

fn weights_by_incidence_are_those_of_each_slice_in_echoes(level: SimdLevel) {
    let campaign = track(60, &[]);
    let options = PlanOptions::default()
        .with_level(level)
        .with_incidence(Some(NARROW));
    let slices = volume([-1.5, -1.5, 0.0], [0.05; 2], [31, 34], 5);
    check_echoes(&campaign, &slices, &options);
}
