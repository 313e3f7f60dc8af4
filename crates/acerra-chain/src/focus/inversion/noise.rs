//! Noise level, measured on the samples before the first echo.

use acerra_imaging::{Complex64, PlaneGrid};
use acerra_invert::{Flight, InvertError, NoiseLevel, measure_noise};

use crate::scene::pixels::Pixels;

/// Noise level, and the share of the unambiguous range covered by the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseFound {
    /// The noise level.
    pub level: NoiseLevel,
    /// Share of the unambiguous range covered by the data; the rest is zero.
    pub held: f64,
}

/// Nearest range that is used, m: nearer echoes are residues of the direct coupling.
const NEAREST_M: f64 = 0.5;

/// Measures the noise at ranges nearer than the ground (`height_m` below each trace) and every pixel,
/// within the ranges `held_m` that the gate keeps.
///
/// # Errors
/// Arrays of other lengths.
pub fn noise_before_first_echo(
    flight: &Flight,
    spectrum: &[Complex64],
    pixels: &Pixels,
    (height_m, held_m): (&[f64], &[[f64; 2]]),
) -> Result<Option<NoiseFound>, InvertError> {
    let f = flight.frequency_hz();
    let (Some(low), Some(high)) = (f.first(), f.last()) else {
        return Ok(None);
    };
    // Two cells of the band clear of the gate's edge and of the first echo.
    let margin_m = flight.light_speed_m_s() / (high - low).max(1.0);
    let top_m = pixels.span_m()[1];
    let quiet_m: Vec<[f64; 2]> = flight
        .position_m()
        .iter()
        .zip(height_m)
        .zip(held_m)
        .map(|((antenna, height_m), [near_m, _])| {
            let first_m = nearest_m(&pixels.grid, top_m, *antenna).min(height_m.abs());
            [(near_m + margin_m).max(NEAREST_M), first_m - margin_m]
        })
        .collect();
    let step_hz = (high - low) / (f.len() - 1).max(1) as f64;
    let unambiguous_m = 0.5 * flight.light_speed_m_s() / step_hz.max(1.0);
    let share = |[near_m, far_m]: &[f64; 2]| ((far_m - near_m) / unambiguous_m).clamp(0.0, 1.0);
    let held = held_m.iter().map(share).sum::<f64>() / held_m.len().max(1) as f64;
    let level = measure_noise(flight, spectrum, &quiet_m)?;
    Ok(level.map(|level| NoiseFound { level, held }))
}

/// Range from an antenna to the nearest place of a rectangle at a height.
fn nearest_m(grid: &PlaneGrid, top_m: f64, antenna: [f64; 3]) -> f64 {
    let x_m = antenna[0].clamp(grid.x_m(0), grid.x_m(grid.nx - 1));
    let y_m = antenna[1].clamp(grid.y_m(0), grid.y_m(grid.ny - 1));
    let off = [antenna[0] - x_m, antenna[1] - y_m, antenna[2] - top_m];
    off.iter().map(|v| v * v).sum::<f64>().sqrt()
}
