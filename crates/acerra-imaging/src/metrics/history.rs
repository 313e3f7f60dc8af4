//! Blur of a target, estimated from its own echoes.
//!
//! Position errors of a few millimetres shift the phases of a target's echoes from pulse to pulse and leave
//! the amplitudes unchanged; the images of the target and of its ghost then break into pieces that no ideal
//! point spread function predicts. The echoes of two targets in one range cell beat instead: amplitude and
//! phase vary alike. The phases of the echoes at the target's range, combined with smoothed amplitudes,
//! therefore predict a blurred target in full, but a weaker second target only by half.

use num_complex::Complex64;

use crate::engine::reference::pulse_at_range;
use crate::engine::weights::profile_at;
use crate::pulses::Pulses;
use crate::vector::range_m;

/// Half-length of the path over which amplitudes are smoothed, as a fraction of the range: long against the
/// beat of two resolved targets, short against the pattern of an antenna or a corner reflector.
const SMOOTHING: f64 = 0.1;
/// Rms deviation of the amplitudes from their smooth course above which echoes belong to several targets (two
/// of equal strength: 0.48) or to none.
const STEADY: f64 = 0.3;

/// The echoes at one target's range, with the received phases and smoothed amplitudes.
#[derive(Clone, Debug)]
pub(super) struct History {
    /// Share of each pulse in the image of the target, without the pixel's 1/R².
    phasor: Vec<Complex64>,
    /// Modulus of the phasors' sum at the target itself.
    own: f64,
    unsteadiness: f64,
}

impl History {
    /// Extracts the echo at a target's range, `ranges_m`, from every pulse. `None` where all echoes are zero.
    pub fn of(pulses: &Pulses<'_>, ranges_m: &[f64]) -> Option<Self> {
        let step_hz = pulses.frequency_step_hz();
        let echo: Vec<Complex64> = ranges_m
            .iter()
            .enumerate()
            .map(|(m, r)| {
                let echo = match step_hz {
                    Some(step_hz) => profile_at(pulses, m, *r, step_hz),
                    None => pulse_at_range(pulses, m, *r),
                };
                echo * pulses.weight()[m]
            })
            .collect();
        let path_m = path(pulses.position_m());
        let mut phasor = Vec::with_capacity(echo.len());
        let (mut departure, mut whole) = (0.0, 0.0);
        let (mut from, mut to) = (0, 0);
        let mut energy = 0.0;
        for (m, e) in echo.iter().enumerate() {
            let reach_m = SMOOTHING * ranges_m[m];
            while to < echo.len() && path_m[to] <= path_m[m] + reach_m {
                energy += echo[to].norm_sqr();
                to += 1;
            }
            while path_m[from] < path_m[m] - reach_m {
                energy -= echo[from].norm_sqr();
                from += 1;
            }
            let smooth = (energy.max(0.0) / (to - from) as f64).sqrt();
            let strength = e.norm();
            // Weight of the pulse in the image.
            let share = ranges_m[m].powi(-4);
            departure += share * (strength - smooth).powi(2);
            whole += share * smooth * smooth;
            phasor.push(if strength > 0.0 {
                e * (smooth / strength)
            } else {
                Complex64::default()
            });
        }
        // At the target itself all frequencies of a pulse are in phase.
        let in_phase = pulses.frequency_hz().len() as f64;
        let own: Complex64 = phasor.iter().zip(ranges_m).map(|(p, r)| p / (r * r)).sum();
        let history = Self {
            phasor,
            own: in_phase * own.norm(),
            unsteadiness: (departure / whole).sqrt(),
        };
        (history.own > 0.0 && history.own.is_finite()).then_some(history)
    }

    /// Whether the amplitude is steady, as of the echoes of one target.
    pub fn is_steady(&self) -> bool {
        self.unsteadiness <= STEADY
    }

    /// Share of each pulse in the image of the target, without the pixel's 1/R².
    pub fn phasor(&self) -> &[Complex64] {
        &self.phasor
    }

    /// Amplitude of `sum`, the image of the phasors at a place, relative to the amplitude at the target.
    pub fn level(&self, sum: Complex64) -> f64 {
        sum.norm() / self.own
    }
}

/// Path flown up to each pulse, m.
fn path(position_m: &[[f64; 3]]) -> Vec<f64> {
    let mut way_m = 0.0;
    let mut before = position_m[0];
    position_m
        .iter()
        .map(|p| {
            way_m += range_m(*p, before);
            before = *p;
            way_m
        })
        .collect()
}
