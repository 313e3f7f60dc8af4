//! Echoes of an image on uneven ground: pixels added to range bins, bins turned into spectra.
//!
//! A pixel at range R = R_k + δ returns e^{−j4πfR/c} = e^{−j4πf_cR/c} e^{−j4π(f−f_c)R_k/c} Σ_q
//! (−j4π(f−f_c)δ/c)^q/q!. Its carrier is exact; the bins collect the powers of δ.

use crate::flight::Flight;
use acerra_imaging::reference::range_m;
use acerra_imaging::{Complex64, Control, SurfaceGrid};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Powers of δ: with [`REACH_RAD`] the first left out is 6·10⁻⁷.
const POWERS: usize = 5;
/// Greatest phase |4π(f−f_c)δ/c| within half a bin, rad.
const REACH_RAD: f64 = 0.15;

/// Adds to zeroed `data` `[M, N]` the echoes of `scene` on `surface` for all pulses. Incomplete once
/// cancelled.
pub(crate) fn add_echoes(
    flight: &Flight,
    surface: &SurfaceGrid,
    scene: &[Complex64],
    data: &mut [Complex64],
    control: Control,
) {
    let bright: Vec<(Complex64, [f64; 3])> = scene
        .iter()
        .enumerate()
        .filter(|(_, v)| **v != Complex64::ZERO)
        .map(|(k, v)| (*v, surface.point_m(k)))
        .collect();
    let count = flight.frequency_hz().len();
    data.par_chunks_mut(count)
        .enumerate()
        .for_each(|(pulse, row)| {
            if !control.is_cancelled() {
                Bins::of(flight, pulse, &bright, control).add_to(flight, row);
            }
        });
}

/// The range bins of one pulse.
struct Bins {
    first_m: f64,
    bin_m: f64,
    values: Vec<[Complex64; POWERS]>,
    centre_hz: f64,
}

impl Bins {
    fn of(
        flight: &Flight,
        pulse: usize,
        bright: &[(Complex64, [f64; 3])],
        control: Control,
    ) -> Self {
        let (low_hz, high_hz) = flight.spread().band_hz();
        let per_metre = 4.0 * PI / flight.light_speed_m_s();
        let centre_hz = 0.5 * (low_hz + high_hz);
        let half_band_hz = (0.5 * (high_hz - low_hz)).max(1.0);
        let bin_m = 2.0 * REACH_RAD / (per_metre * half_band_hz);
        let antenna = flight.position_m()[pulse];
        let ranges = || bright.iter().map(|(_, point)| range_m(antenna, *point));
        let (near, far) = ranges().fold((f64::INFINITY, 0.0_f64), |(near, far), r| {
            (near.min(r), far.max(r))
        });
        let first_m = if near.is_finite() { near } else { 0.0 };
        let bins = if near.is_finite() {
            ((far - near) / bin_m).ceil() as usize + 2
        } else {
            0
        };
        let mut values = vec![[Complex64::ZERO; POWERS]; bins];
        for (k, (value, point)) in bright.iter().enumerate() {
            if k % 65_536 == 0 && control.is_cancelled() {
                break;
            }
            let range = range_m(antenna, *point);
            let bin = ((range - first_m) / bin_m).round();
            let delta_m = range - first_m - bin * bin_m;
            let carrier = Complex64::cis(-per_metre * centre_hz * range);
            let mut term = value * carrier * flight.amplitude_at(pulse, range, *point);
            for slot in &mut values[bin as usize] {
                *slot += term;
                term *= delta_m;
            }
        }
        Self {
            first_m,
            bin_m,
            values,
            centre_hz,
        }
    }

    /// Adds the spectrum of the bins.
    fn add_to(&self, flight: &Flight, row: &mut [Complex64]) {
        let per_metre = 4.0 * PI / flight.light_speed_m_s();
        for (e, f) in row.iter_mut().zip(flight.frequency_hz()) {
            let wavenumber = per_metre * (f - self.centre_hz);
            let advance = Complex64::cis(-wavenumber * self.bin_m);
            let mut factors = [Complex64::ONE; POWERS];
            for q in 1..POWERS {
                factors[q] = factors[q - 1] * Complex64::new(0.0, -wavenumber / q as f64);
            }
            // Horner's scheme from the farthest bin to the nearest.
            let spectrum = self.values.iter().rev().fold(Complex64::ZERO, |sum, bin| {
                let value: Complex64 = bin.iter().zip(&factors).map(|(b, f)| b * f).sum();
                sum * advance + value
            });
            *e += spectrum * Complex64::cis(-wavenumber * self.first_m);
        }
    }
}
