//! What a volume takes, planning, tables and self-checks of all slices included.
//!
//! `cargo bench -p acerra-imaging --bench volumes` images volumes about the track of the common scene (331 pulses,
//! 213 frequencies, antennas at 5 m) and prints the processor time of the whole, and the errors of the slices
//! against the double-precision sum: `slices`, 51 of 400 × 400 pixels of 2 cm; `cube`, 256³ voxels of 1 cm;
//! `tall`, 230 slices of 256 × 256 pixels of 2 cm up to 40 cm below the antennas; `small`, 64³ voxels of 2 cm;
//! `patterned`, `slices` with weights by incidence. Naming some takes those alone. `accuracy=1e-4` asks for
//! another accuracy, `level=avx2` for an instruction set, `runs=9` repeats more often, `plan` prints the plans,
//! `quick` leaves the errors out (for samples by `perf`). `forward` times the forward operator of the volume instead,
//! planning and run, beside the operators of its slices one by one, and prints how far their spectra are apart;
//! with `quick` by itself.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod scene;

use acerra_imaging::{
    Complex32, Complex64, Control, Engine, Forward, ForwardVolume, ImagingError, IncidenceWeight,
    PlanOptions, PlaneGrid, Pulses, SimdLevel, VolumeGrid, VolumeRun, image_volume_planned_once,
    reference,
};
use rand_chacha::rand_core::{RngCore, SeedableRng};
use scene::{Scene, processor_time_s};

/// Pixels of a slice that are compared, per axis.
const COMPARED: usize = 16;

fn argument(name: &str) -> Option<String> {
    std::env::args().find_map(|a| Some(a.strip_prefix(name)?.to_owned()))
}

fn has(name: &str) -> bool {
    std::env::args().any(|a| a == name)
}

/// A volume and the requirements on it.
struct Case {
    name: &'static str,
    volume: VolumeGrid,
    incidence: Option<IncidenceWeight>,
}

fn cases() -> Vec<Case> {
    let case = |name, corner_m: [f64; 3], pixel_m, size, nz| {
        let base = PlaneGrid::new(corner_m, pixel_m, size).unwrap();
        Case {
            name,
            volume: VolumeGrid::new(base, pixel_m, nz).unwrap(),
            incidence: None,
        }
    };
    let slices = || case("slices", [-4.0, -4.0, 0.0], 0.02, [400, 400], 51);
    vec![
        slices(),
        case("cube", [-1.28, -1.28, 0.0], 0.01, [256, 256], 256),
        case("tall", [-2.56, -2.56, 0.0], 0.02, [256, 256], 230),
        case("small", [-0.64, -0.64, -0.5], 0.02, [64, 64], 64),
        Case {
            name: "patterned",
            incidence: Some(IncidenceWeight {
                max_rad: 55f64.to_radians(),
                cosine_power: 1.0,
                ..IncidenceWeight::default()
            }),
            ..slices()
        },
    ]
}

fn main() {
    if has("--test") {
        return;
    }
    let number = |name: &str| argument(name).map(|v| v.parse::<f64>().unwrap());
    let level = argument("level=").map_or(SimdLevel::detect(), |name| {
        let matches = |l: &&SimdLevel| l.name().to_lowercase().starts_with(&name);
        *SimdLevel::available().iter().find(matches).unwrap()
    });
    let accuracy = number("accuracy=").unwrap_or(1e-3);
    let runs = number("runs=").map_or(3, |v| v as usize);
    let mut chosen = cases();
    if chosen.iter().any(|case| has(case.name)) {
        chosen.retain(|case| has(case.name));
    }
    let scene = Scene::of_pixels(0.01, 331);
    println!("accuracy {accuracy:.1e}, {level}");
    if has("forward") {
        println!(
            "| volume | plans | planning (s) | run (s) | one by one: planning | run | apart |"
        );
        println!("| --- | --- | --- | --- | --- | --- | --- |");
        for case in chosen {
            let options = PlanOptions::default()
                .with_accuracy(accuracy)
                .with_level(level)
                .with_incidence(case.incidence);
            time_forward(&scene, &case, &options);
        }
        return;
    }
    println!("| volume | plans | whole (s) | memory (MB) | errors of slices |");
    println!("| --- | --- | --- | --- | --- |");
    for case in chosen {
        let options = PlanOptions::default()
            .with_accuracy(accuracy)
            .with_level(level)
            .with_incidence(case.incidence);
        time(&scene, &case, &options, runs);
    }
}

fn time(scene: &Scene, case: &Case, options: &PlanOptions, runs: usize) {
    let mut errors = Vec::new();
    let mut take_errors = |_: usize, grid: &PlaneGrid, image: &[Complex32]| {
        errors.push(error(scene.pulses(), grid, image, options));
    };
    let mut run = None;
    if !has("quick") {
        run = Some(timed(scene, case, options, &mut take_errors).0);
    }
    let mut best_s = f64::INFINITY;
    for _ in 0..runs {
        let (found, whole_s) = timed(scene, case, options, &mut |_, _, _| ());
        best_s = best_s.min(whole_s);
        run = Some(found);
    }
    let run = run.unwrap();
    errors.sort_by(f64::total_cmp);
    let said = match errors[..] {
        [] => String::from("–"),
        [least, .., most] => format!("{least:.1e} to {most:.1e}"),
        [one] => format!("{one:.1e}"),
    };
    println!(
        "| {} | {} | {best_s:.3} | {:.1} | {said} |",
        case.name,
        run.plans.len(),
        run.memory_bytes as f64 * 1e-6,
    );
    if has("plan") {
        println!("{}\n", run.report);
    }
}

/// The value that some work makes, and the processor time that it takes, s.
fn timed_work<R>(work: impl FnOnce() -> R) -> (R, f64) {
    let start_s = processor_time_s();
    let made = work();
    (made, processor_time_s() - start_s)
}

/// Prints the times of the forward operator of a volume and of those of its slices.
fn time_forward(scene: &Scene, case: &Case, options: &PlanOptions) {
    let (pulses, control) = (scene.pulses(), Control::default());
    let random_slice = |k: usize, image: &mut [Complex32]| {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(k as u64);
        let mut part = || random.next_u32() as f32 / u32::MAX as f32 - 0.5;
        image.fill_with(|| Complex32::new(part(), part()));
    };
    let (planned, planning_s) =
        timed_work(|| ForwardVolume::new(&case.volume, pulses, options, control).unwrap());
    let mut echo = vec![Complex64::ZERO; scene.spectrum.len()];
    let ((), run_s) = timed_work(|| planned.run(random_slice, &mut echo, control).unwrap());
    let plans = planned.plans().count();
    let times = format!("| {} | {plans} | {planning_s:.2} | {run_s:.2} |", case.name);
    if has("plan") {
        planned.reports().for_each(|report| println!("{report}\n"));
    }
    if has("quick") {
        println!("{times} – | – | – |");
        return;
    }
    let of_slice = options.with_check_pixels((options.check_pixels / case.volume.nz).max(6));
    let (alone, alone_planning_s) = timed_work(|| {
        let plan =
            |k| Forward::with_control(pulses, case.volume.slice(k), &of_slice, control).unwrap();
        (0..case.volume.nz).map(plan).collect::<Vec<_>>()
    });
    let mut expected = vec![Complex64::ZERO; echo.len()];
    let ((), alone_s) = timed_work(|| {
        let mut image = vec![Complex32::ZERO; case.volume.base.len()];
        let mut part = vec![Complex64::ZERO; echo.len()];
        for (k, plan) in alone.iter().enumerate() {
            random_slice(k, &mut image);
            plan.run(&image, &mut part, control).unwrap();
            expected.iter_mut().zip(&part).for_each(|(e, p)| *e += p);
        }
    });
    let apart = reference::relative_l2(&echo, &expected).unwrap();
    println!("{times} {alone_planning_s:.2} | {alone_s:.2} | {apart:.1e} |");
}

/// A volume with the processor time that it takes, s.
fn timed(
    scene: &Scene,
    case: &Case,
    options: &PlanOptions,
    see: &mut dyn FnMut(usize, &PlaneGrid, &[Complex32]),
) -> (VolumeRun, f64) {
    let mut seeing_s = 0.0;
    let start_s = processor_time_s();
    let take = |k: usize, grid: &PlaneGrid, image: &[Complex32]| {
        let now_s = processor_time_s();
        see(k, grid, image);
        seeing_s += processor_time_s() - now_s;
        Ok::<(), ImagingError>(())
    };
    let (pulses, control) = (scene.pulses(), Control::default());
    let run = image_volume_planned_once(&case.volume, pulses, options, control, take).unwrap();
    (run, processor_time_s() - start_s - seeing_s)
}

/// Relative L2 error of a slice at some of its pixels.
fn error(pulses: Pulses, grid: &PlaneGrid, image: &[Complex32], options: &PlanOptions) -> f64 {
    let step = (grid.nx / COMPARED).max(1);
    let first = [grid.x_m(step / 2), grid.y_m(step / 2), grid.z_m];
    let sparse = PlaneGrid::new(first, grid.pixel_m * step as f64, [COMPARED; 2]).unwrap();
    let reference = options.with_engine(Engine::Reference);
    let wide = |v: &Complex32| Complex64::new(v.re.into(), v.im.into());
    let expected = acerra_imaging::image(pulses, sparse, &reference, Control::default()).unwrap();
    let expected: Vec<_> = expected.iter().map(wide).collect();
    let place =
        |k: usize| (step / 2 + k / COMPARED * step) * grid.nx + step / 2 + k % COMPARED * step;
    let found: Vec<_> = (0..expected.len())
        .map(|k| wide(&image[place(k)]))
        .collect();
    reference::relative_l2(&found, &expected).unwrap()
}
