//! Seconds of the forward operator and of the adjoint, planning included, on the grid of the paper's
//! Figure 12 (1801 × 1801 pixels, 331 pulses of 341 frequencies) or with fewer pixels a side:
//! `cargo bench -p acerra-invert --bench operator -- 901`; on a volume of 256³ cells and five tracks of 331
//! pulses each, or with fewer cells a side: `-- volume 64`.

#![allow(clippy::print_stdout, clippy::unwrap_used)]

use acerra_imaging::{
    Complex64, Control, PlanOptions, PlaneGrid, PulseArrays, Pulses, SPEED_OF_LIGHT_M_S, VolumeGrid,
};
use acerra_invert::{Flight, Ground, LinearOperator, SceneOperator, Weighted, even_weights};
use std::time::Instant;

fn main() {
    let side = std::env::args().find_map(|a| a.parse().ok());
    if std::env::args().any(|a| a == "volume") {
        volume(side.unwrap_or(256));
    } else {
        plane(side.unwrap_or(1801));
    }
}

fn plane(side: usize) {
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
    let points_m = [[4.0, 0.0, 0.0], [14.0, 0.0, 0.0], [9.0, -3.0, 0.0]];
    let pixel_m = 18.0 / (side - 1) as f64;
    let grid = PlaneGrid::new([0.0, -9.0, 0.0], pixel_m, [side, side]).unwrap();
    for accuracy in [1e-4, 1e-3] {
        time(&position_m, &points_m, Ground::Plane(grid.into()), accuracy);
    }
}

/// Five parallel tracks, 1 m apart across and 0.4 m in height, over cells of 2 cm.
fn volume(side: usize) {
    let track = |k: u32| {
        let (y_m, z_m) = (f64::from(k) - 4.0, 10.0 + 0.4 * f64::from(k));
        (0..331).map(move |m| [0.1 * f64::from(m) - 16.5, y_m, z_m])
    };
    let position_m: Vec<[f64; 3]> = (0..5).flat_map(track).collect();
    let points_m = [[0.007, 0.006, 0.303], [0.207, -0.094, 0.703]];
    let corner_m = -0.01 * (side - 1) as f64;
    let base = PlaneGrid::new([corner_m, corner_m, 0.0], 0.02, [side, side]).unwrap();
    let cells = VolumeGrid::new(base, 0.02, side).unwrap();
    time(&position_m, &points_m, Ground::Volume(cells), 3e-4);
}

/// Says how long planning, columns, adjoint and forward take.
fn time(position_m: &[[f64; 3]], points_m: &[[f64; 3]], ground: Ground<'_>, accuracy: f64) {
    let frequency_hz: Vec<f64> = (0..341).map(|n| 3.1e9 + 5e6 * f64::from(n)).collect();
    let zeros = vec![Complex64::ZERO; position_m.len() * 341];
    let weight = vec![1.0; position_m.len()];
    let pulses = Pulses::new(PulseArrays {
        position_m,
        frequency_hz: &frequency_hz,
        spectrum: &zeros,
        weight: &weight,
        light_speed_m_s: SPEED_OF_LIGHT_M_S,
    });
    let flight = Flight::of(&pulses.unwrap()).unwrap();
    let mut data = zeros.clone();
    for point_m in points_m {
        flight.add_echo(*point_m, Complex64::ONE, &mut data);
    }
    let timed = |what: &str, work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        println!(
            "{accuracy:e} {what}: {:.3} s",
            start.elapsed().as_secs_f64()
        );
    };
    let options = PlanOptions::default().with_accuracy(accuracy);
    let mut planned = None;
    timed("plan", &mut || {
        planned =
            Some(SceneOperator::new(&flight, &data, ground, options, Control::default()).unwrap());
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
