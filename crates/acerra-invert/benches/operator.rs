//! Seconds of the forward operator and of the adjoint, planning included, on the grid of the paper's
//! Figure 12 (1801 × 1801 pixels, 331 pulses of 341 frequencies) or with fewer pixels a side:
//! `cargo bench -p acerra-invert --bench operator -- 901`.

#![allow(clippy::print_stdout, clippy::unwrap_used)]

use acerra_imaging::{
    Complex64, Control, PlanOptions, PlaneGrid, PulseArrays, Pulses, SPEED_OF_LIGHT_M_S,
};
use acerra_invert::{Flight, Ground, LinearOperator, SceneOperator, Weighted, even_weights};
use std::time::Instant;

fn main() {
    let side = std::env::args()
        .filter_map(|a| a.parse().ok())
        .next()
        .unwrap_or(1801);
    let position_m: Vec<[f64; 3]> = (0..331)
        .map(|m| {
            let s = 0.1 * f64::from(m);
            [
                s - 7.0,
                2.0 + 0.2 * (0.4 * s).sin(),
                10.0 + 0.1 * (0.3 * s).cos(),
            ]
        })
        .collect();
    let frequency_hz: Vec<f64> = (0..341).map(|n| 3.1e9 + 5e6 * f64::from(n)).collect();
    let zeros = vec![Complex64::ZERO; 331 * 341];
    let pulses = Pulses::new(PulseArrays {
        position_m: &position_m,
        frequency_hz: &frequency_hz,
        spectrum: &zeros,
        weight: &[1.0; 331],
        light_speed_m_s: SPEED_OF_LIGHT_M_S,
    })
    .unwrap();
    let flight = Flight::of(&pulses).unwrap();
    let mut data = zeros.clone();
    for (x, y) in [(4.0, 0.0), (14.0, 0.0), (9.0, -3.0)] {
        flight.add_echo([x, y, 0.0], Complex64::ONE, &mut data);
    }
    let pixel_m = 18.0 / f64::from(side - 1);
    let grid = PlaneGrid::new([0.0, -9.0, 0.0], pixel_m, [side as usize, side as usize]).unwrap();
    for accuracy in [1e-4, 1e-3] {
        let timed = |what: &str, work: &mut dyn FnMut()| {
            let start = Instant::now();
            work();
            println!(
                "{accuracy:e} {what}: {:.3} s",
                start.elapsed().as_secs_f64()
            );
        };
        let options = PlanOptions::default().with_accuracy(accuracy);
        let ground = Ground::Plane(grid.into());
        let mut planned = None;
        timed("plan", &mut || {
            planned = Some(
                SceneOperator::new(&flight, &data, ground, options, Control::default()).unwrap(),
            );
        });
        let operator = planned.unwrap();
        let mut weight = Vec::new();
        timed("columns", &mut || {
            weight = even_weights(&flight, operator.grids())
        });
        let even = Weighted::new(&operator, &weight).unwrap();
        let mut image = vec![Complex64::ZERO; operator.pixels()];
        let mut back = data.clone();
        for _ in 0..2 {
            timed("adjoint", &mut || {
                even.adjoint(&back, &mut image, Control::default()).unwrap();
            });
            timed("forward", &mut || {
                even.forward(&image, &mut back, Control::default()).unwrap();
            });
        }
        println!("{}", operator.explained());
    }
}
