//! Echo histories: the echo of a point, trace by trace, against the phase that its place predicts.

use acerra_radar::Spectrum;
use num_complex::Complex64;

use std::f64::consts::TAU;

/// Spectra of a track, and where they were measured.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measured<'a> {
    /// Place of each trace (m).
    pub position_m: &'a [[f64; 3]],
    /// Evenly spaced frequencies (Hz).
    pub frequency_hz: &'a [f64],
    /// Spectra, trace after trace.
    pub values: &'a [Complex64],
    /// Propagation speed (m/s).
    pub light_speed_m_s: f64,
}

impl<'a> Measured<'a> {
    /// The traces of a part of a survey.
    pub fn part(
        position_m: &'a [[f64; 3]],
        spectrum: &'a Spectrum,
        traces: std::ops::Range<usize>,
        light_speed_m_s: f64,
    ) -> Option<Self> {
        let width = spectrum.frequency_hz.len();
        Some(Self {
            position_m: position_m.get(traces.clone())?,
            frequency_hz: &spectrum.frequency_hz,
            values: spectrum
                .values
                .get(traces.start * width..traces.end * width)?,
            light_speed_m_s,
        })
    }

    /// Mean frequency of the echoes, weighted by their power (Hz).
    pub fn mean_frequency_hz(&self) -> f64 {
        let (mut power, mut moment) = (0.0, 0.0);
        for trace in self.values.chunks_exact(self.frequency_hz.len().max(1)) {
            for (value, frequency_hz) in trace.iter().zip(self.frequency_hz) {
                power += value.norm_sqr();
                moment += value.norm_sqr() * frequency_hz;
            }
        }
        if power > 0.0 { moment / power } else { 0.0 }
    }

    /// The echo of a point in each trace, Σₙ Sₙ·exp(j4πfₙR/c): its contribution to Eq. (3) without
    /// spreading. Of a point target its phase is constant but for errors of range,
    /// −4πf/c·(true range − predicted range).
    pub fn history(&self, point_m: [f64; 3]) -> Vec<Complex64> {
        let [first_hz, second_hz, ..] = self.frequency_hz else {
            return Vec::new();
        };
        let turns = |frequency_hz: f64, range_m: f64| {
            Complex64::from_polar(
                1.0,
                2.0 * TAU * frequency_hz * range_m / self.light_speed_m_s,
            )
        };
        self.values
            .chunks_exact(self.frequency_hz.len())
            .zip(self.position_m)
            .map(|(trace, position_m)| {
                let range_m = distance_m(*position_m, point_m);
                let step = turns(second_hz - first_hz, range_m);
                let mut phasor = turns(*first_hz, range_m);
                let mut sum = Complex64::default();
                for value in trace {
                    sum += phasor * value;
                    phasor *= step;
                }
                sum
            })
            .collect()
    }
}

/// Distance of two places (m).
pub(crate) fn distance_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_history_of_a_point_target_is_constant_at_its_place() {
        let position_m: Vec<[f64; 3]> = (0..20).map(|k| [f64::from(k) * 0.1, 0.0, 5.0]).collect();
        let frequency_hz: Vec<f64> = (0..86).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
        let point_m = [1.0, 2.0, 0.0];
        let light_speed_m_s = 299_792_458.0;
        let values: Vec<Complex64> = position_m
            .iter()
            .flat_map(|p| {
                let range_m = distance_m(*p, point_m);
                frequency_hz.iter().map(move |f| {
                    let phase = -2.0 * TAU * f * range_m / light_speed_m_s;
                    Complex64::from_polar(1.0, phase)
                })
            })
            .collect();
        let measured = Measured {
            position_m: &position_m,
            frequency_hz: &frequency_hz,
            values: &values,
            light_speed_m_s,
        };
        for echo in measured.history(point_m) {
            assert!((echo - Complex64::new(86.0, 0.0)).norm() < 0.1, "{echo}");
        }
        assert!((measured.mean_frequency_hz() - 3.95e9).abs() < 1e3);
    }
}
