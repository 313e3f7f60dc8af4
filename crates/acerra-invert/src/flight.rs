//! The flight, band and weights that an inversion models, and the exact echo of a point.

use crate::error::{InvertError, check_length};
use acerra_imaging::psf::PointSpread;
use acerra_imaging::reference::range_m;
use acerra_imaging::{Complex64, IncidenceWeight, PulseArrays, Pulses, Spreading};
use std::f64::consts::PI;

/// Positions, frequencies and weights of the pulses, and the data in the inner product of the
/// inversion.
///
/// Eq. (3) with weights w_m is the adjoint of Eq. (1) if data are compared by Σ w_m a* b: its image is A⁺W d,
/// with A of Eq. (1) and W = diag(w_m), and its least squares minimise Σ_m w_m Σ_n |d − Aσ|². With L = W^½ A
/// and W^½ d both become plain inner products: L⁺ W^½ d = A⁺W d is the image of Eq. (3), and ‖W^½ d − Lσ‖²
/// the weighted misfit. The weights held here are therefore the square roots √w_m, for forward and adjoint
/// alike.
#[derive(Debug, Clone)]
pub struct Flight {
    position_m: Vec<[f64; 3]>,
    root_weight: Vec<f64>,
    frequency_hz: Vec<f64>,
    light_speed_m_s: f64,
    spreading: Spreading,
    incidence: Option<(IncidenceWeight, f64)>,
    boresight: Option<Vec<[f64; 3]>>,
    spread: PointSpread,
}

/// Frequencies after which a recurrent phasor is computed afresh.
const RENEW: usize = 32;

impl Flight {
    /// The flight of `pulses`, seen with 1/R² in amplitude both ways.
    ///
    /// # Errors
    /// A weight below 0.
    pub fn of(pulses: &Pulses) -> Result<Self, InvertError> {
        if let Some(bad) = pulses.weight().iter().find(|w| **w < 0.0) {
            return Err(InvertError::OutOfRange {
                what: "weight of a pulse",
                expected: "at least 0",
                found: *bad,
            });
        }
        Ok(Self {
            position_m: pulses.position_m().to_vec(),
            root_weight: pulses.weight().iter().map(|w| w.sqrt()).collect(),
            frequency_hz: pulses.frequency_hz().to_vec(),
            light_speed_m_s: pulses.light_speed_m_s(),
            spreading: Spreading::InverseSquare,
            incidence: None,
            boresight: pulses.boresight().map(<[_]>::to_vec),
            spread: PointSpread::of(pulses),
        })
    }

    /// This flight with another weight by range.
    #[must_use]
    pub fn with_spreading(self, spreading: Spreading) -> Self {
        Self { spreading, ..self }
    }

    /// This flight with a weight by incidence over the level plane at `plane_z_m`; the antenna's pattern
    /// counts from the boresights of the pulses where these have any.
    #[must_use]
    pub fn with_incidence(self, weight: Option<IncidenceWeight>, plane_z_m: f64) -> Self {
        Self {
            incidence: weight.map(|w| (w, plane_z_m)),
            ..self
        }
    }

    /// Number of data: pulses times frequencies.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.position_m.len() * self.frequency_hz.len()
    }

    /// Antenna phase centres, m.
    #[must_use]
    pub fn position_m(&self) -> &[[f64; 3]] {
        &self.position_m
    }

    /// Frequencies, Hz.
    #[must_use]
    pub fn frequency_hz(&self) -> &[f64] {
        &self.frequency_hz
    }

    /// Square roots of the pulses' weights.
    #[must_use]
    pub fn root_weight(&self) -> &[f64] {
        &self.root_weight
    }

    /// Propagation speed, m/s.
    #[must_use]
    pub fn light_speed_m_s(&self) -> f64 {
        self.light_speed_m_s
    }

    /// Weight by range.
    #[must_use]
    pub fn spreading(&self) -> Spreading {
        self.spreading
    }

    /// Weight by incidence, if any.
    #[must_use]
    pub fn incidence(&self) -> Option<IncidenceWeight> {
        self.incidence.map(|(weight, _)| weight)
    }

    /// The point spread of the flight, for widths and the closed form of the sum over frequencies.
    #[must_use]
    pub fn spread(&self) -> &PointSpread {
        &self.spread
    }

    /// The measured spectra `[M, N]` in the inner product of the inversion: W^½ d.
    ///
    /// # Errors
    /// The number of values differs from that of data.
    pub fn weighted(&self, spectrum: &[Complex64]) -> Result<Vec<Complex64>, InvertError> {
        check_length("spectrum", self.samples(), spectrum.len())?;
        let rows = spectrum.chunks(self.frequency_hz.len());
        Ok(rows
            .zip(&self.root_weight)
            .flat_map(|(row, root)| row.iter().map(move |e| e * root))
            .collect())
    }

    /// These spectra as pulses with the weights √w_m.
    ///
    /// # Errors
    /// Values that the imaging operators refuse.
    pub fn pulses<'a>(&'a self, spectrum: &'a [Complex64]) -> Result<Pulses<'a>, InvertError> {
        let pulses = Pulses::new(PulseArrays {
            position_m: &self.position_m,
            frequency_hz: &self.frequency_hz,
            spectrum,
            weight: &self.root_weight,
            light_speed_m_s: self.light_speed_m_s,
        })?;
        Ok(match &self.boresight {
            Some(boresight) => pulses.with_boresight(boresight)?,
            None => pulses,
        })
    }

    /// Amplitude of the echo that a unit point at `point_m` returns to `pulse`, times √w.
    #[must_use]
    pub fn amplitude(&self, pulse: usize, point_m: [f64; 3]) -> f64 {
        self.amplitude_at(pulse, range_m(self.position_m[pulse], point_m), point_m)
    }

    /// The weight where the range from the antenna, `range_m`, is known already.
    #[must_use]
    pub(crate) fn amplitude_at(&self, pulse: usize, range_m: f64, point_m: [f64; 3]) -> f64 {
        let incidence = self.incidence.map_or(1.0, |(weight, plane_z_m)| {
            let antenna_m = self.position_m[pulse];
            let range_m = range_m.max(1e-12);
            let height_m = (antenna_m[2] - plane_z_m).abs();
            let vertical_rad = (height_m / range_m).min(1.0).acos();
            let Some(boresight) = &self.boresight else {
                return weight.at(vertical_rad);
            };
            let looks = boresight[pulse];
            let along_m: f64 = (0..3).map(|a| looks[a] * (point_m[a] - antenna_m[a])).sum();
            weight.edge(vertical_rad) * weight.pattern(along_m / range_m)
        });
        self.root_weight[pulse] * self.spreading.weight(range_m) * incidence
    }

    /// Adds `reflectivity` times the echo of a unit point at `point_m` to weighted `data` `[M, N]`: a
    /// column of L, in double precision, anywhere in space.
    pub fn add_echo(&self, point_m: [f64; 3], reflectivity: Complex64, data: &mut [Complex64]) {
        let f = &self.frequency_hz;
        let step_hz = even_step_hz(f);
        for (pulse, row) in data.chunks_mut(f.len()).enumerate() {
            let range = range_m(self.position_m[pulse], point_m);
            let amplitude = reflectivity * self.amplitude_at(pulse, range, point_m);
            let delay = 4.0 * PI * range / self.light_speed_m_s;
            let Some(step_hz) = step_hz else {
                for (e, f) in row.iter_mut().zip(f) {
                    *e += amplitude * Complex64::cis(-f * delay);
                }
                continue;
            };
            let advance = Complex64::cis(-step_hz * delay);
            for (row, f) in row.chunks_mut(RENEW).zip(f.chunks(RENEW)) {
                let mut phasor = amplitude * Complex64::cis(-f[0] * delay);
                for e in row {
                    *e += phasor;
                    phasor *= advance;
                }
            }
        }
    }

    /// ⟨echo of a unit point at `point_m`, `data`⟩: a value of L⁺, in double precision.
    #[must_use]
    pub fn correlate(&self, point_m: [f64; 3], data: &[Complex64]) -> Complex64 {
        let f = &self.frequency_hz;
        let step_hz = even_step_hz(f);
        let mut sum = Complex64::ZERO;
        for (pulse, row) in data.chunks(f.len()).enumerate() {
            let range = range_m(self.position_m[pulse], point_m);
            let delay = 4.0 * PI * range / self.light_speed_m_s;
            let profile: Complex64 = match step_hz {
                None => row
                    .iter()
                    .zip(f)
                    .map(|(e, f)| e * Complex64::cis(f * delay))
                    .sum(),
                Some(step_hz) => {
                    let advance = Complex64::cis(step_hz * delay);
                    let pieces = row.chunks(RENEW).zip(f.chunks(RENEW));
                    pieces
                        .map(|(row, f)| {
                            let horner = |sum: Complex64, e: &Complex64| sum * advance + e;
                            let piece = row.iter().rev().fold(Complex64::ZERO, horner);
                            piece * Complex64::cis(f[0] * delay)
                        })
                        .sum()
                }
            };
            sum += profile * self.amplitude_at(pulse, range, point_m);
        }
        sum
    }

    /// ⟨Lₐ, L_b⟩ of two points: the true, place-dependent point spread, one term a pulse.
    #[must_use]
    pub fn overlap(&self, a_m: [f64; 3], b_m: [f64; 3]) -> Complex64 {
        let mut sum = Complex64::ZERO;
        for (pulse, antenna) in self.position_m.iter().enumerate() {
            let (to_a, to_b) = (range_m(*antenna, a_m), range_m(*antenna, b_m));
            let amplitude =
                self.amplitude_at(pulse, to_a, a_m) * self.amplitude_at(pulse, to_b, b_m);
            sum += self.spread.kernel(to_a - to_b) * amplitude;
        }
        sum
    }

    /// ‖Lₐ‖ of a point.
    #[must_use]
    pub fn column_norm(&self, point_m: [f64; 3]) -> f64 {
        let power: f64 = (0..self.position_m.len())
            .map(|pulse| self.amplitude(pulse, point_m).powi(2))
            .sum();
        (power * self.frequency_hz.len() as f64).sqrt()
    }
}

/// The step of evenly spaced frequencies.
fn even_step_hz(f: &[f64]) -> Option<f64> {
    let (first, last) = (*f.first()?, *f.last()?);
    if f.len() < 2 {
        return None;
    }
    let step_hz = (last - first) / (f.len() - 1) as f64;
    let is_even = |(n, v): (usize, &f64)| (v - (first + n as f64 * step_hz)).abs() <= 1e-9 * last;
    f.iter().enumerate().all(is_even).then_some(step_hz)
}
