//! Whether two processes prepared the same data: samples of positions and spectra.
//!
//! Offsets, delays and corrections that are searched for depend on the processor by rounding, and a close
//! decision may fall otherwise on another one. Tiles of both would make an image of neither.

use acerra_chain::Prepared;
use serde::{Deserialize, Serialize};

/// Traces that are compared, spread evenly.
const TRACES: usize = 16;
/// Difference of positions (m) and, in units of their root mean square, of spectra that no image shows: a
/// hundredth of a radian at 4 GHz.
const POSITION_M: f64 = 5e-5;
const SPECTRUM: f64 = 1e-2;

/// Samples of prepared data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Probe {
    traces: usize,
    position_m: Vec<[f64; 3]>,
    /// Real and imaginary parts at the first and the last frequency.
    spectrum: Vec<[f64; 4]>,
}

impl Probe {
    /// Samples of these data.
    pub fn of(prepared: &Prepared) -> Self {
        let positions = &prepared.aligned.position_m;
        let frequencies = prepared.spectrum.frequency_hz.len();
        let step = positions.len().div_ceil(TRACES).max(1);
        let chosen = (0..positions.len()).step_by(step);
        let values = |m: usize| {
            let row = prepared
                .spectrum
                .values
                .get(m * frequencies..(m + 1) * frequencies)?;
            let (first, last) = (row.first()?, row.last()?);
            Some([first.re, first.im, last.re, last.im])
        };
        Self {
            traces: positions.len(),
            position_m: chosen.clone().map(|m| positions[m]).collect(),
            spectrum: chosen.filter_map(values).collect(),
        }
    }

    /// Whether both make the same image.
    pub fn agrees(&self, other: &Self) -> bool {
        let apart = |a: &[f64], b: &[f64]| {
            let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let power = self.spectrum.as_flattened().iter().map(|v| v * v);
        let rms = (power.sum::<f64>() / self.spectrum.len().max(1) as f64).sqrt();
        let positions = self.position_m.iter().zip(&other.position_m);
        let spectra = self.spectrum.iter().zip(&other.spectrum);
        self.traces == other.traces
            && self.position_m.len() == other.position_m.len()
            && self.spectrum.len() == other.spectrum.len()
            && positions
                .into_iter()
                .all(|(a, b)| apart(a, b) <= POSITION_M)
            && spectra
                .into_iter()
                .all(|(a, b)| apart(a, b) <= SPECTRUM * rms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_the_same_and_another_offset_is_not() {
        let probe = |along_m: f64, phase_rad: f64| Probe {
            traces: 100,
            position_m: vec![[along_m, 0.0, 4.0]; TRACES],
            spectrum: vec![[phase_rad.cos(), phase_rad.sin(), 1.0, 0.0]; TRACES],
        };
        let stated = probe(1.0, 0.3);
        assert!(stated.agrees(&probe(1.0 + 1e-9, 0.3 + 1e-6)));
        // A millisecond at 2 m/s; a tenth of a nanosecond turns 4 GHz by more than two radians.
        assert!(!stated.agrees(&probe(1.002, 0.3)));
        assert!(!stated.agrees(&probe(1.0, 2.8)));
        let shorter = Probe {
            traces: 99,
            ..stated.clone()
        };
        assert!(!stated.agrees(&shorter));
    }
}
