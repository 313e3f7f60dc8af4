//! The forward operator beside imaging, by the direct engines: 1000 × 1000 pixels, 331 pulses.
//!
//! `cargo bench -p acerra-imaging --bench forward` prints, for pixels of 0.5 to 10 cm, the size of the groups
//! that the forward operator sums, Gbp/s of both operators in turn (10⁹ pixel × pulse contributions a second
//! of processor time, times the threads), and the forward operator's relative L2 error at some pulses.
//! `engine=auto` takes the engines that plans choose, which need not be the same, `pixel=4` one size (cm), `accuracy=1e-3` another accuracy, `level=avx2` an instruction set,
//! `threads=1` a number of threads, `runs=9` more runs of which the best counts, `plan` prints the plans.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod scene;

use acerra_imaging::plan::Decision;
use acerra_imaging::{
    Complex32, Complex64, Control, Engine, Forward, ImagingPlan, PlanOptions, PulseArrays, Pulses,
    SPEED_OF_LIGHT_M_S, SimdLevel, Spreading, reference,
};
use rand_chacha::rand_core::{RngCore, SeedableRng};
use scene::{Scene, processor_time_s};

/// Pulses from one compared with the double-precision sum to the next.
const COMPARED: usize = 66;

fn argument(name: &str) -> Option<String> {
    std::env::args().find_map(|a| Some(a.strip_prefix(name)?.to_owned()))
}

fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let number = |name: &str| argument(name).map(|v| v.parse::<f64>().unwrap());
    let accuracy = number("accuracy=").unwrap_or(2e-3);
    let threads = number("threads=").map_or_else(rayon::current_num_threads, |v| v as usize);
    let level = argument("level=").map_or(SimdLevel::detect(), |name| {
        let matches = |l: &&SimdLevel| l.name().to_lowercase().starts_with(&name);
        *SimdLevel::available().iter().find(matches).unwrap()
    });
    let sizes_cm = number("pixel=").map_or(vec![0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 10.0], |p| vec![p]);
    println!("accuracy {accuracy:.1e}, {level}, {threads} thread(s)");
    println!(
        "| pixel (cm) | group | engines | forward (Gbp/s) | imaging (Gbp/s) | forward's error |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    for size_cm in sizes_cm {
        pool.install(|| time(size_cm, accuracy, level, threads));
    }
}

fn time(size_cm: f64, accuracy: f64, level: SimdLevel, threads: usize) {
    let scene = Scene::of_pixels(0.01 * size_cm, 331);
    let options = PlanOptions::default()
        .with_accuracy(accuracy)
        .with_spreading(Spreading::None)
        .with_level(level)
        .with_engine(match argument("engine=").as_deref() {
            Some("auto") => Engine::Auto,
            Some("factorized") => Engine::Factorized,
            _ => Engine::Direct,
        });
    // Independent pixels: the echoes of a periodic image cancel, and no error is relative to them.
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let mut part = || random.next_u32() as f32 / u32::MAX as f32 - 0.5;
    let sigma: Vec<Complex32> = (0..scene.grid.len())
        .map(|_| Complex32::new(part(), part()))
        .collect();
    let forward = Forward::new(scene.pulses(), scene.grid, &options).unwrap();
    let imaging = ImagingPlan::new(scene.pulses(), scene.grid, &options).unwrap();
    let mut echo = vec![Complex64::ZERO; scene.spectrum.len()];
    let mut image = vec![Complex32::ZERO; scene.grid.len()];
    let mut best_s = [f64::INFINITY; 2];
    let runs = argument("runs=").map_or(3, |v| v.parse().unwrap());
    for _ in 0..runs {
        let start_s = processor_time_s();
        forward.run(&sigma, &mut echo, Control::default()).unwrap();
        let middle_s = processor_time_s();
        imaging.run(&mut image, Control::default()).unwrap();
        best_s[0] = best_s[0].min(middle_s - start_s);
        best_s[1] = best_s[1].min(processor_time_s() - middle_s);
    }
    let rate = |seconds: f64| scene.gbp() * threads as f64 / seconds;
    let group = forward
        .report()
        .decisions
        .iter()
        .rev()
        .find_map(|d| match d {
            Decision::Direct(choice) => Some(choice.group),
            _ => None,
        });
    println!(
        "| {size_cm} | {group:?} | {:?}, {:?} | {:.2} | {:.2} | {:.1e} |",
        forward.engine(),
        imaging.engine(),
        rate(best_s[0]),
        rate(best_s[1]),
        error(&scene, &sigma, &echo),
    );
    if std::env::args().any(|a| a == "plan") {
        println!("{forward}");
    }
}

/// Relative L2 error of every [`COMPARED`]th pulse's spectrum.
fn error(scene: &Scene, sigma: &[Complex32], echo: &[Complex64]) -> f64 {
    let n = scene.frequency_hz.len();
    let position_m: Vec<_> = scene.position_m.iter().copied().step_by(COMPARED).collect();
    let mut expected = vec![Complex64::ZERO; position_m.len() * n];
    let spectrum = vec![Complex64::ZERO; expected.len()];
    let pulses = Pulses::new(PulseArrays {
        position_m: &position_m,
        frequency_hz: &scene.frequency_hz,
        spectrum: &spectrum,
        weight: &scene.weight[..position_m.len()],
        light_speed_m_s: SPEED_OF_LIGHT_M_S,
    })
    .unwrap();
    let options = PlanOptions::default()
        .with_spreading(Spreading::None)
        .with_engine(Engine::Reference);
    Forward::new(pulses, scene.grid, &options)
        .unwrap()
        .run(sigma, &mut expected, Control::default())
        .unwrap();
    let found: Vec<_> = echo
        .chunks(n)
        .step_by(COMPARED)
        .flatten()
        .copied()
        .collect();
    reference::relative_l2(&found, &expected).unwrap()
}
