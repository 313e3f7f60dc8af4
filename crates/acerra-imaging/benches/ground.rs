//! Slices below ground beside the engine above ground: 300 × 200 pixels of 2 cm, 200 pulses.
//!
//! `cargo bench -p acerra-imaging --bench ground` prints, for one antenna and for antennas 15 cm apart, the rate of a
//! slice in 10⁶ contributions (pixel × pulse) a second on all threads: above ground, below level ground, below a cart whose
//! antennas are 1 cm above the ground (pixels of 1 cm, 10 cm deep), and below uneven ground, with the share of the rate above ground, the time of planning and what the self-check found. The name of a
//! ground as argument leaves the others out.
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use acerra_imaging::refraction::{Ground, Layer, Relief, Soil, Surface};
use acerra_imaging::{
    Complex32, Complex64, Control, ImagingPlan, PlanOptions, PlaneGrid, PulseArrays, Pulses,
    SPEED_OF_LIGHT_M_S,
};
use std::f64::consts::TAU;
use std::time::{Duration, Instant};

const PULSES: usize = 200;
const FREQUENCIES: usize = 76;

/// Runs of which the fastest counts: so many, or as many as fit in this time.
const LEAST_RUNS: usize = 3;
const ENOUGH: Duration = Duration::from_millis(500);

fn main() {
    let mut state = 1_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    // A line of 4 m, a metre above the ground, with the motion of a multicopter.
    let position_m: Vec<[f64; 3]> = (0..PULSES)
        .map(|m| {
            let s = m as f64 / PULSES as f64;
            [
                4.0 * s,
                0.05 * (7.0 * s).sin() + 0.002 * random(),
                1.0 + 0.05 * (9.0 * s).cos() + 0.002 * random(),
            ]
        })
        .collect();
    let of_cart_m: Vec<[f64; 3]> = position_m.iter().map(|[x, y, _]| [*x, *y, 0.01]).collect();
    let frequency_hz: Vec<f64> = (0..FREQUENCIES).map(|n| 0.5e9 + 2e7 * n as f64).collect();
    let spectrum: Vec<Complex64> = (0..PULSES * FREQUENCIES)
        .map(|_| Complex64::new(random(), random()))
        .collect();
    // A lawn, a meadow, waves with slopes beyond 30°, furrows, and heights without order at the nodes of a raster of 5 cm.
    let meadow =
        |x: f64, y: f64| 0.05 * (TAU * x / 1.5).sin() * (TAU * y / 2.0 + 1.0).cos() + 0.05 * x;
    let lawn =
        |x: f64, y: f64| 0.03 * (TAU * x / 3.0).sin() * (TAU * y / 2.5 + 1.0).cos() + 0.05 * x;
    let waves = |x: f64, y: f64| 0.1 * (TAU * x).sin() * (TAU * y + 1.0).cos();
    let furrows = |x: f64, y: f64| 0.03 * (TAU * (x + 0.3 * y) / 0.4).sin();
    let rough: Vec<f64> = (0..121 * 101).map(|_| 0.015 * random()).collect();
    let grounds = [
        ("air", None),
        ("level", Some(Surface::Level { z_m: 0.0 })),
        ("cart", Some(Surface::Level { z_m: 0.0 })),
        ("lawn", Some(relief(lawn))),
        ("meadow", Some(relief(meadow))),
        ("waves", Some(relief(waves))),
        ("furrows", Some(relief(furrows))),
        (
            "rough",
            Some(Surface::Relief(
                Relief::new([-1.0, -2.0], 0.05, 121, rough).unwrap(),
            )),
        ),
    ];
    let names: Vec<String> = std::env::args().collect();
    let is_named = |name: &str| names.iter().any(|a| a == name);
    let is_one = grounds.iter().any(|(name, _)| is_named(name));
    println!(
        "| ground | antennas | engine | 10⁶ contributions/s | of air | planning (s) | self-check |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    let mut of_air = [f64::NAN; 2];
    for (name, surface) in grounds
        .into_iter()
        .filter(|(name, _)| !is_one || is_named(name))
    {
        let soil = Soil {
            relative_permittivity: 6.0,
            conductivity_s_m: 0.0,
        };
        let ground = surface.map(|s| Ground::new(s, &[Layer::below_all(soil)], 1.25e9).unwrap());
        let (position_m, depth_m, pixel_m) = match name {
            "cart" => (&of_cart_m, 0.1, 0.01),
            _ => (&position_m, 0.3, 0.02),
        };
        let moved = |by_m: f64| -> Vec<[f64; 3]> {
            let moved = |[x, y, z]: &[f64; 3]| [x + by_m, *y, *z];
            position_m.iter().map(moved).collect()
        };
        let (sent_m, received_m) = (moved(0.075), moved(-0.075));
        for (k, antennas) in ["one", "apart"].into_iter().enumerate() {
            let mut pulses = Pulses::new(PulseArrays {
                position_m,
                frequency_hz: &frequency_hz,
                spectrum: &spectrum,
                weight: &[1.0; PULSES],
                light_speed_m_s: SPEED_OF_LIGHT_M_S,
            })
            .unwrap();
            if antennas == "apart" {
                pulses = pulses.with_antennas(&sent_m, &received_m).unwrap();
            }
            if let Some(ground) = &ground {
                pulses = pulses.with_ground(ground).unwrap();
            }
            let grid = PlaneGrid::new([-1.0, -2.0, -depth_m], pixel_m, [300, 200]).unwrap();
            let start = Instant::now();
            let plan = ImagingPlan::new(pulses, grid, &PlanOptions::default()).unwrap();
            let planning_s = start.elapsed().as_secs_f64();
            if std::env::var_os("SHOW_PLAN").is_some() {
                println!("{plan}");
            }
            let mut image = vec![Complex32::ZERO; grid.len()];
            let (mut best_s, mut runs, first) = (f64::INFINITY, 0, Instant::now());
            while runs < LEAST_RUNS || first.elapsed() < ENOUGH {
                let start = Instant::now();
                plan.run(&mut image, Control::default()).unwrap();
                best_s = best_s.min(start.elapsed().as_secs_f64());
                runs += 1;
            }
            let rate = 1e-6 * plan.contributions() as f64 / best_s;
            if name == "air" {
                of_air[k] = rate;
            }
            println!(
                "| {name} | {antennas} | {:?} | {rate:.2} | {:.2} | {planning_s:.2} | {:.1e} |",
                plan.engine(),
                rate / of_air[k],
                plan.self_check().map_or(f64::NAN, |c| c.error),
            );
        }
    }
}

/// Heights of a function at the nodes of a raster of 5 cm.
fn relief(height_m: impl Fn(f64, f64) -> f64) -> Surface {
    let at = |k: usize| {
        let (column, row) = (k % 121, k / 121);
        height_m(-1.0 + 0.05 * column as f64, -2.0 + 0.05 * row as f64)
    };
    let heights_m = (0..121 * 101).map(at).collect();
    Surface::Relief(Relief::new([-1.0, -2.0], 0.05, 121, heights_m).unwrap())
}
