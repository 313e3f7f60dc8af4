//! Images two point targets, shows the plan and the progress, and measures what the image shows.
//!
//! `cargo run --release -p acerra-imaging --example two_targets`
#![allow(clippy::print_stdout)] // an example speaks

use acerra_imaging::metrics::{ImageView, MeasureOptions, measure_targets_in};
use acerra_imaging::reference::{self, Scatterer};
use acerra_imaging::{
    Complex32, Complex64, Control, ImagingError, ImagingPlan, PlanOptions, PlaneGrid, Progress,
    PulseArrays, Pulses, SPEED_OF_LIGHT_M_S, Spreading,
};

fn main() -> Result<(), ImagingError> {
    // A flight of 6 m along y, 5 m above the ground; 3.1 to 4.8 GHz in steps of 10 MHz.
    let position_m: Vec<[f64; 3]> = (0..301)
        .map(|m| {
            let y_m = 0.02 * f64::from(m) - 3.0;
            [0.1 * (0.5 * y_m).cos(), y_m, 5.0]
        })
        .collect();
    let frequency_hz: Vec<f64> = (0..171).map(|n| 3.1e9 + 1e7 * f64::from(n)).collect();

    // Echoes that two targets would return. Measured spectra take their place.
    let scene = [([2.0, 0.4, 0.0], 1.0), ([3.1, -0.7, 0.0], 0.6)].map(|(position_m, level)| {
        let reflectivity = Complex64::new(level, 0.0);
        Scatterer {
            position_m,
            reflectivity,
        }
    });
    let (c, spreading) = (SPEED_OF_LIGHT_M_S, Spreading::InverseSquare);
    let spectrum = reference::forward(&position_m, &frequency_hz, &scene, c, spreading)?;

    let weight = vec![1.0; position_m.len()];
    let pulses = Pulses::new(PulseArrays {
        position_m: &position_m,
        frequency_hz: &frequency_hz,
        spectrum: &spectrum,
        weight: &weight,
        light_speed_m_s: c,
    })?;
    let grid = PlaneGrid::from_ranges([0.5, 4.5], [-2.0, 2.0], 0.0, 0.01)?;
    let plan = ImagingPlan::new(pulses, grid, &PlanOptions::default().with_accuracy(1e-3))?;
    println!("{}\n", plan.report());

    let mut image = vec![Complex32::ZERO; plan.pixels()];
    let follow = |p: Progress| {
        if p.done == p.total {
            println!("imaged {:.2e} contributions", p.total as f64);
        }
    };
    plan.run(&mut image, Control::default().reporting_to(&follow))?;

    let view = ImageView::new(&image, grid)?;
    let options = MeasureOptions::default();
    let found = measure_targets_in(&view, &pulses, &options, Control::default())?;
    for target in &found.targets {
        println!(
            "target at x = {:.3} m, y = {:.3} m: {:.1} dB, {:.3} m along the track",
            target.x_m,
            target.y_m,
            target.level_db,
            target.along.rayleigh_m.unwrap_or(f64::NAN)
        );
    }
    Ok(())
}
