//! The frequency of the antenna that a header states, against the spectrum of the echoes.

use acerra_formats::{AntennaFrequency, Contradiction};
use acerra_radar::Radargram;
use acerra_radar::clean::{Background, remove_background};
use acerra_radar::quality::spectrum_occupancy;

/// Factor to either side of an antenna's nominal frequency within which its echoes have energy: near the ground antennas
/// radiate down to 0.4 times the frequency that they are named after.
const FACTOR: f64 = 3.0;
/// Share of the energy that echoes have within that factor at least. Slow drifts of a receiver hold the rest.
const LEAST_SHARE: f64 = 0.05;

/// Contradiction where the spectrum of the echoes, the mean of the traces removed, has its band elsewhere and no energy about the
/// nominal frequency of the antenna: the sample interval or the frequency has a wrong unit.
pub(super) fn off_antenna(
    nominal: &AntennaFrequency,
    radargram: &Radargram,
) -> Option<Contradiction> {
    let echoes = remove_background(radargram.clone(), Background::Mean).ok()?;
    let spectrum = spectrum_occupancy(&echoes)?;
    let near_hz = [nominal.hz / FACTOR, nominal.hz * FACTOR];
    let share = spectrum.share_within(near_hz);
    let centre_hz = centre_hz(&spectrum.frequency_hz, &spectrum.power)?;
    let is_apart = spectrum.band_hz[1] < near_hz[0] || spectrum.band_hz[0] > near_hz[1];
    (is_apart && share < LEAST_SHARE).then(|| Contradiction {
        about: format!(
            "antenna frequency: spectrum of the echoes by the sample interval, {}",
            nominal.field
        ),
        used: 1e-6 * centre_hz,
        other: 1e-6 * nominal.hz,
        unit: "MHz",
    })
}

/// The frequency below which half of the energy is (Hz).
fn centre_hz(frequency_hz: &[f64], power: &[f64]) -> Option<f64> {
    let half = 0.5 * power.iter().sum::<f64>();
    let mut below = 0.0;
    let mut counted = frequency_hz.iter().zip(power);
    let reaches = |(_, power): &(&f64, &f64)| {
        below += **power;
        below >= half
    };
    counted.find(reaches).map(|(hz, _)| *hz)
}

#[cfg(test)]
mod tests {
    use acerra_radar::Samples;

    use super::*;

    /// Traces with pulses of 300 MHz at many delays, coupling and a slow drift, as sampled every `step_s`.
    fn judged(step_s: f64, nominal_hz: f64) -> Option<Contradiction> {
        let (traces, samples) = (40, 512);
        let value = |i: usize| {
            let (trace, k) = ((i / samples) as f64, (i % samples) as f64);
            let pulse = |at: f64| {
                let t = (k - at) * 0.1e-9;
                (-(t / 3e-9).powi(2)).exp() * (std::f64::consts::TAU * 300e6 * t).cos()
            };
            let echoes = pulse(150.0 + 1.3 * trace) + pulse(400.0 - 2.1 * trace);
            let drift = 0.2 * (0.7 * trace).sin() * (-k / 200.0).exp();
            (3.0 * pulse(60.0) + echoes + drift) as f32
        };
        let values: Vec<f32> = (0..traces * samples).map(value).collect();
        let nominal = AntennaFrequency {
            hz: nominal_hz,
            field: "ANTENNAS",
        };
        let time_s = (0..traces).map(|i| i as f64).collect();
        let radargram = Radargram::new(time_s, 0.0, step_s, Samples::Real(values)).unwrap();
        off_antenna(&nominal, &radargram)
    }

    #[test]
    fn nominal_frequencies_of_ground_coupled_antennas_agree() {
        for nominal_hz in [200e6, 300e6, 500e6, 700e6] {
            assert_eq!(judged(0.1e-9, nominal_hz), None, "{nominal_hz}");
        }
    }

    #[test]
    fn a_power_of_ten_contradicts_with_both_values() {
        for (step_s, expected_mhz) in [(1e-9, 30.0), (0.01e-9, 3000.0)] {
            let found = judged(step_s, 400e6).unwrap();
            assert!((found.used / expected_mhz - 1.0).abs() < 0.5, "{found:?}");
            assert!((found.other - 400.0).abs() < 1e-9);
        }
        assert!(judged(0.1e-9, 4e9).is_some());
    }
}
