//! Times that plans foretell against times that they take, from 64² to 8192² pixels and from 50 to
//! 20,000 pulses.
//!
//! `cargo bench -p acerra-imaging --bench cost_model` prints one line a size and engine; images of more
//! than 100 Gbp, or 50 by the direct engine, are left out. `-- large` makes those alone, up to 200 Gbp by
//! the direct engine: it takes minutes and 16 GB.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod scene;

use acerra_imaging::{Complex32, Control, Engine, ImagingPlan, PlanOptions, Spreading};
use scene::Scene;
use std::time::Instant;

fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let large = std::env::args().any(|a| a == "large");
    println!("pixels     pulses  engine      estimated (s)  took (s)  ratio  Gbp/s  memory (MB)");
    let mut worst: f64 = 1.0;
    for size in [64, 256, 1024, 4096, 8192] {
        for pulses in [50, 300, 2000, 20_000] {
            let gbp = (size * size * pulses) as f64 * 1e-9;
            let none_wanted = if large { gbp <= 50.0 } else { gbp > 100.0 };
            if none_wanted {
                continue;
            }
            let scene = Scene::of_size(size, pulses);
            for engine in [Engine::Direct, Engine::Auto] {
                let usual = gbp
                    <= if engine == Engine::Direct {
                        50.0
                    } else {
                        100.0
                    };
                let too_long = engine == Engine::Direct && gbp > 200.0;
                if usual == large || too_long {
                    continue;
                }
                let options = PlanOptions::default()
                    .with_engine(engine)
                    .with_spreading(Spreading::None);
                let plan = ImagingPlan::new(scene.pulses(), scene.grid, &options).unwrap();
                if engine == Engine::Auto && plan.engine() == Engine::Direct {
                    continue;
                }
                let estimate = plan.estimate_run_time_s(Control::default());
                let mut image = vec![Complex32::ZERO; scene.grid.len()];
                let mut took = f64::INFINITY;
                for _ in 0..if gbp < 5.0 { 5 } else { 1 } {
                    let start = Instant::now();
                    plan.run(&mut image, Control::default()).unwrap();
                    took = took.min(start.elapsed().as_secs_f64());
                }
                let ratio = estimate / took;
                worst = worst.max(ratio.max(1.0 / ratio));
                println!(
                    "{size:4}²  {pulses:9}  {:10}  {estimate:13.5}  {took:8.5}  {ratio:5.2}  {:5.2}  {:11.1}",
                    format!("{:?}", plan.engine()),
                    gbp / took,
                    plan.memory_bytes() as f64 * 1e-6
                );
            }
        }
    }
    println!("farthest from 1: {worst:.2}");
}
