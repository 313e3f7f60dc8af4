//! Arrays in memory to images in memory: prepared once, imaged on two grids, cancelled once.
#![allow(
    clippy::missing_errors_doc,
    clippy::print_stdout,
    clippy::type_complexity
)]
use acerra_chain::{Control, ImageRequest, Journal, MemorySink, Recording, Scene, prepare};
use acerra_chain::{clean::CleanOptions, focus::plan::ImageError};
use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
use acerra_imaging::{PlaneGrid, SPEED_OF_LIGHT_M_S};
use acerra_radar::{Radargram, Samples};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Where two images show a reflector at (0.3, 1, 0) m that a 4 GHz radar passes, 4 m up at 1 m/s.
pub fn run() -> Result<(Vec<[f64; 3]>, ImageError), Box<dyn std::error::Error>> {
    let t_s: Vec<f64> = (0..81).map(|k| 0.05 * f64::from(k)).collect();
    let echo = |t: f64, n: i32| {
        let s = 61e-12 * f64::from(n) - 2.0 * (t - 2.3).hypot(1.0).hypot(4.0) / SPEED_OF_LIGHT_M_S;
        ((-(s / 0.3e-9).powi(2)).exp() * (std::f64::consts::TAU * 4e9 * s).cos()) as f32
    };
    let samples = t_s.iter().flat_map(|t| (0..800).map(move |n| echo(*t, n)));
    let samples = Samples::Real(samples.collect());
    let fixes = t_s.iter().map(|t| Fix::new(*t, [t - 2.0, 0.0, 4.0]));
    let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes.collect())?;
    let radargram = Radargram::new(t_s, 0.0, 61e-12, samples)?;
    let flight = Recording::new("flight", radargram, trajectory).clean_by(CleanOptions::none());
    let (stop, journal) = (AtomicBool::new(false), &mut Journal::default());
    let (calibration, mut sink) = (Default::default(), MemorySink::default());
    let control = Control::default().cancelled_by(&stop);
    let coarse = PlaneGrid::from_ranges([0.0, 1.0], [0.5, 1.5], 0.0, 0.05)?;
    let fine = PlaneGrid::from_ranges([0.2, 0.4], [0.8, 1.2], 0.0, 0.01)?;
    let scene = Scene::plane(coarse);
    let prepared = prepare(vec![flight], scene, &calibration, journal, &control)?;
    let mut image = |grid| prepared.image(&ImageRequest::on(grid), &mut sink, &control);
    let maxima_m = vec![image(coarse)?.maximum_m(), image(fine)?.maximum_m()];
    stop.store(true, Relaxed);
    Ok((maxima_m, image(fine).expect_err("the flag is set")))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{:.2?}", run()?);
    Ok(())
}
