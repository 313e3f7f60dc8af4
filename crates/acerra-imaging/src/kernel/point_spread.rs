//! The response of a band to a point, summed over pulses in double precision, several pulses side by side.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::lanes::{DOUBLES, Lanes};
use super::phasor::phasors;

/// Sines below which the closed form of an even comb is taken at its limit.
const LEAST_SINE: f64 = 1e-9;

/// Frequencies of a band, in two-way carrier cycles per metre of range: 2f/c.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Band<'a> {
    /// Evenly spaced, whose sum has a closed form.
    Even {
        /// Middle of the band.
        centre_per_m: f64,
        /// Step between neighbours.
        step_per_m: f64,
        /// Number of frequencies.
        count: f64,
    },
    /// Any frequencies.
    Uneven {
        /// Each frequency, Hz.
        frequency_hz: &'a [f64],
        /// 2/c.
        slowness_s_m: f64,
    },
}

impl Band<'_> {
    /// Σ_n e^{j4πf_n δ/c} at each excess range δ (m): real and imaginary parts.
    #[inline(always)]
    fn kernel<S: Lanes>(&self, s: S, excess_m: [f64; DOUBLES]) -> [[f64; DOUBLES]; 2] {
        match *self {
            Band::Even {
                centre_per_m,
                step_per_m,
                count,
            } => {
                let (mut carrier, mut half, mut whole) = (excess_m, excess_m, excess_m);
                for k in 0..DOUBLES {
                    carrier[k] = excess_m[k] * centre_per_m;
                    half[k] = excess_m[k] * (0.5 * step_per_m);
                    whole[k] = half[k] * count;
                }
                let carrier = phasors(s, carrier);
                let (half, whole) = (phasors(s, half), phasors(s, whole));
                let (re, im) = (s.store_f64(carrier.re), s.store_f64(carrier.im));
                let (half_re, half_im) = (s.store_f64(half.re), s.store_f64(half.im));
                let (whole_re, whole_im) = (s.store_f64(whole.re), s.store_f64(whole.im));
                let mut out = [re, im];
                for k in 0..DOUBLES {
                    // At every multiple of the unambiguous range: the limit, with its sign.
                    let envelope = if half_im[k].abs() < LEAST_SINE {
                        count * whole_re[k] / half_re[k]
                    } else {
                        whole_im[k] / half_im[k]
                    };
                    out[0][k] = envelope * re[k];
                    out[1][k] = envelope * im[k];
                }
                out
            }
            Band::Uneven {
                frequency_hz,
                slowness_s_m,
            } => {
                let mut out = [[0.0; DOUBLES]; 2];
                for f in frequency_hz {
                    let mut turns = excess_m;
                    for t in &mut turns {
                        *t *= f * slowness_s_m;
                    }
                    let one = phasors(s, turns);
                    let (re, im) = (s.store_f64(one.re), s.store_f64(one.im));
                    for k in 0..DOUBLES {
                        out[0][k] += re[k];
                        out[1][k] += im[k];
                    }
                }
                out
            }
        }
    }

    /// The sum at one excess range.
    pub fn kernel_at(&self, excess_m: f64) -> Complex64 {
        let phase_rad = |turns: f64| TAU * (turns - turns.round());
        match *self {
            Band::Even {
                centre_per_m,
                step_per_m,
                count,
            } => {
                let half_rad = phase_rad(0.5 * excess_m * step_per_m);
                let whole_rad = phase_rad(0.5 * excess_m * step_per_m * count);
                let sine = half_rad.sin();
                let envelope = if sine.abs() < LEAST_SINE {
                    count * whole_rad.cos() / half_rad.cos()
                } else {
                    whole_rad.sin() / sine
                };
                Complex64::cis(phase_rad(excess_m * centre_per_m)) * envelope
            }
            Band::Uneven {
                frequency_hz,
                slowness_s_m,
            } => frequency_hz
                .iter()
                .map(|f| Complex64::cis(phase_rad(excess_m * f * slowness_s_m)))
                .sum(),
        }
    }
}

/// A target's echoes, pulse by pulse: range, a real factor, and a complex factor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Received<'a> {
    /// Range of the target, m.
    pub range_m: &'a [f64],
    /// Factors of the first sum.
    pub factor: &'a [f64],
    /// Factors of the second sum; empty where there is none.
    pub phasor: &'a [Complex64],
}

/// Σ_m a_m K(R_m − r_m)/R_m² at a point, R_m being its range from each place, and the sum with the complex
/// factors; K is the band's sum over frequencies. The number of pulses is that of the shortest list; without
/// factors the second sum is zero.
#[inline(always)]
pub(crate) fn responses<S: Lanes>(
    s: S,
    band: &Band<'_>,
    position_m: &[[f64; 3]],
    received: Received<'_>,
    at_m: [f64; 3],
) -> [Complex64; 2] {
    let pulses = position_m
        .len()
        .min(received.range_m.len())
        .min(received.factor.len());
    let has_phasors = !received.phasor.is_empty();
    let mut sums = [[0.0; DOUBLES]; 4];
    let mut first = 0;
    while first < pulses {
        let count = DOUBLES.min(pulses - first);
        let mut block = Block::default();
        for k in 0..count {
            let m = first + k;
            block.place_m[0][k] = position_m[m][0];
            block.place_m[1][k] = position_m[m][1];
            block.place_m[2][k] = position_m[m][2];
            block.range_m[k] = received.range_m[m];
            block.factor[k] = received.factor[m];
        }
        let mut square_m2 = [1.0; DOUBLES];
        let mut excess_m = [0.0; DOUBLES];
        for k in 0..DOUBLES {
            let [x, y, z] = [0, 1, 2].map(
                #[inline(always)]
                |axis| block.place_m[axis][k] - at_m[axis],
            );
            square_m2[k] = x * x + y * y + z * z;
            excess_m[k] = square_m2[k].sqrt() - block.range_m[k];
        }
        // Padding of the last block contributes nothing.
        for k in count..DOUBLES {
            (square_m2[k], excess_m[k]) = (1.0, 0.0);
        }
        let kernel = band.kernel(s, excess_m);
        for k in 0..DOUBLES {
            let factor = block.factor[k] / square_m2[k];
            sums[0][k] += kernel[0][k] * factor;
            sums[1][k] += kernel[1][k] * factor;
        }
        if has_phasors {
            for k in 0..count.min(received.phasor.len().saturating_sub(first)) {
                let phasor = received.phasor[first + k];
                (block.phasor[0][k], block.phasor[1][k]) = (phasor.re, phasor.im);
            }
            for k in 0..DOUBLES {
                let [re, im] = [
                    block.phasor[0][k] / square_m2[k],
                    block.phasor[1][k] / square_m2[k],
                ];
                sums[2][k] += kernel[0][k] * re - kernel[1][k] * im;
                sums[3][k] += kernel[0][k] * im + kernel[1][k] * re;
            }
        }
        first += DOUBLES;
    }
    let [a, b, c, d] = sums.map(|lanes| lanes.iter().sum::<f64>());
    [Complex64::new(a, b), Complex64::new(c, d)]
}

/// Range of a point from each place (m), and `weight`/R².
#[inline(always)]
pub(crate) fn received<S: Lanes>(
    _s: S,
    position_m: &[[f64; 3]],
    weight: &[f64],
    target_m: [f64; 3],
) -> (Vec<f64>, Vec<f64>) {
    let pulses = position_m.len().min(weight.len());
    let (mut range_m, mut factor) = (vec![0.0; pulses], vec![0.0; pulses]);
    let places = position_m.iter().zip(weight);
    for ((range_m, factor), (place, weight)) in range_m.iter_mut().zip(&mut factor).zip(places) {
        let square_m2 = square_m2(*place, target_m);
        *range_m = square_m2.sqrt();
        *factor = weight / square_m2;
    }
    (range_m, factor)
}

#[inline(always)]
fn square_m2(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}

/// Pulses side by side.
#[derive(Default)]
struct Block {
    place_m: [[f64; DOUBLES]; 3],
    range_m: [f64; DOUBLES],
    factor: [f64; DOUBLES],
    phasor: [[f64; DOUBLES]; 2],
}
