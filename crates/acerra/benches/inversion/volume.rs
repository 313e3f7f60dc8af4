//! A volume seen from five tracks.

use acerra_chain::Pixels;
use acerra_chain::focus::inversion::Method;
use acerra_imaging::{PlaneGrid, SPEED_OF_LIGHT_M_S, VolumeGrid};

use crate::scene::{Scene, Simulated};
use crate::solve::run;
use crate::{METHODS, table};

/// Slices, rows and columns.
const SIDE: usize = 256;
/// Edge of a cell (m).
const CELL_M: f64 = 0.02;
/// Iterations of the methods, of which settled solutions need some tens.
const ITERATIONS: usize = 2;

/// Prints time and memory of every method on 256³ cells and five tracks of 331 pulses, stopped after two iterations.
pub fn volume() {
    let scene = scene();
    print!("{}", table::COSTS_HEAD);
    let size = format!("{SIDE}³ × {}", scene.aligned.traces.len());
    for method in METHODS {
        let cap = (method != Method::Adjoint).then_some(ITERATIONS);
        let row = match run(&scene, method, cap) {
            Ok(run) => table::cost(&size, &run),
            Err(refusal) => format!(
                "| {size} | {} | refused: {refusal} | – | – | – | – |\n",
                method.name()
            ),
        };
        print!("{row}");
    }
}

/// Five parallel tracks of 33 m, 1 m apart across and 0.4 m in height, 10 m and more above the lowest slice.
fn scene() -> Scene {
    let track = |k: u32| -> Vec<[f64; 3]> {
        let (y_m, z_m) = (f64::from(k) - 4.0, 10.0 + 0.4 * f64::from(k));
        (0..331)
            .map(|m| [0.1 * f64::from(m) - 16.5, y_m, z_m])
            .collect()
    };
    let simulated = Simulated {
        tracks_m: (0..5).map(track).collect(),
        light_speed_m_s: SPEED_OF_LIGHT_M_S,
        points_m: vec![
            [0.007, 0.006, 1.003],
            [1.207, -0.994, 2.003],
            [-1.493, 1.006, 0.503],
        ],
        noise_db: -40.0,
    };
    let corner_m = -0.5 * CELL_M * (SIDE - 1) as f64;
    let base = PlaneGrid::new([corner_m, corner_m, 0.0], CELL_M, [SIDE, SIDE]).unwrap();
    let cells = VolumeGrid::new(base, CELL_M, SIDE).unwrap();
    simulated.scene("volume", Pixels::volume(cells))
}
