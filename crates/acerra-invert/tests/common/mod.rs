//! Flights, scenes and dense matrices that the tests share.

#![allow(dead_code, clippy::unwrap_used)]

use acerra_imaging::{Complex64, Control, PulseArrays, Pulses};
use acerra_invert::{Flight, LinearOperator};
use nalgebra::DMatrix;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub const C: f64 = acerra_imaging::SPEED_OF_LIGHT_M_S;

/// A wavering track along x with unequal weights, and a band.
pub struct Survey {
    pub position_m: Vec<[f64; 3]>,
    pub frequency_hz: Vec<f64>,
    pub weight: Vec<f64>,
}

impl Survey {
    pub fn new(pulses: usize, frequencies: usize) -> Self {
        let step = 3.0 / (pulses - 1) as f64;
        Self {
            position_m: (0..pulses)
                .map(|m| {
                    let x = step * m as f64 - 1.5;
                    [x, 0.06 * (2.1 * x).sin(), 3.0 + 0.04 * (3.0 * x).cos()]
                })
                .collect(),
            frequency_hz: (0..frequencies)
                .map(|n| 3.1e9 + 1.7e9 * n as f64 / (frequencies - 1) as f64)
                .collect(),
            weight: (0..pulses).map(|m| 1.0 + 0.4 * (m as f64).sin()).collect(),
        }
    }

    pub fn flight(&self) -> Flight {
        let zeros = vec![Complex64::ZERO; self.position_m.len() * self.frequency_hz.len()];
        let pulses = Pulses::new(PulseArrays {
            position_m: &self.position_m,
            frequency_hz: &self.frequency_hz,
            spectrum: &zeros,
            weight: &self.weight,
            light_speed_m_s: C,
        })
        .unwrap();
        Flight::of(&pulses).unwrap()
    }

    /// The same with every position off by a random `sigma_m`: data are never simulated with the very
    /// operator that inverts them.
    pub fn displaced(&self, sigma_m: f64, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let position_m = self
            .position_m
            .iter()
            .map(|p| p.map(|v| v + sigma_m * random.gauss()))
            .collect();
        Self {
            position_m,
            frequency_hz: self.frequency_hz.clone(),
            weight: self.weight.clone(),
        }
    }
}

pub struct Random(ChaCha8Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// A standard normal number (Box & Muller).
    pub fn gauss(&mut self) -> f64 {
        let (u, v): (f64, f64) = (self.0.random(), self.0.random());
        (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }

    /// A circular complex normal number of unit variance.
    pub fn complex(&mut self) -> Complex64 {
        Complex64::new(self.gauss(), self.gauss()) * 0.5f64.sqrt()
    }

    pub fn vector(&mut self, length: usize) -> Vec<Complex64> {
        (0..length).map(|_| self.complex()).collect()
    }
}

/// Weighted echoes of off-grid points along a displaced flight, with noise of `sigma` a datum.
pub fn echoes(survey: &Survey, points: &[([f64; 3], Complex64)], sigma: f64) -> Vec<Complex64> {
    let flight = survey.displaced(1e-3, 5).flight();
    let mut data = vec![Complex64::ZERO; flight.samples()];
    for (point, reflectivity) in points {
        flight.add_echo(*point, *reflectivity, &mut data);
    }
    let mut random = Random::new(11);
    let count = survey.frequency_hz.len();
    for (m, row) in data.chunks_mut(count).enumerate() {
        for e in row {
            *e += random.complex() * sigma * survey.weight[m].sqrt();
        }
    }
    data
}

/// Points of a sparse lattice beside the track.
pub fn lattice(nx: usize, ny: usize, step_m: [f64; 2]) -> Vec<[f64; 3]> {
    (0..nx * ny)
        .map(|k| {
            let (i, j) = ((k % nx) as f64, (k / nx) as f64);
            let x = (i - 0.5 * (nx - 1) as f64) * step_m[0];
            [x, 1.0 + j * step_m[1], 0.0]
        })
        .collect()
}

/// The matrix of an operator, column by column.
pub fn dense(operator: &dyn LinearOperator) -> DMatrix<Complex64> {
    let (rows, columns) = (operator.samples(), operator.pixels());
    let mut matrix = DMatrix::zeros(rows, columns);
    let mut unit = vec![Complex64::ZERO; columns];
    let mut data = vec![Complex64::ZERO; rows];
    for j in 0..columns {
        unit[j] = Complex64::ONE;
        operator
            .forward(&unit, &mut data, Control::default())
            .unwrap();
        unit[j] = Complex64::ZERO;
        for (i, v) in data.iter().enumerate() {
            matrix[(i, j)] = *v;
        }
    }
    matrix
}

pub fn inner(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}

pub fn norm(a: &[Complex64]) -> f64 {
    a.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

/// ‖a − b‖ / ‖b‖.
pub fn relative(a: &[Complex64], b: &[Complex64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let difference: Vec<Complex64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    norm(&difference) / norm(b)
}
