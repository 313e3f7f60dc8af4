//! Range tables: the range profile of every pulse as one short polynomial per range bin.
//!
//! A bin of width b about R_i = i·b holds the least-squares polynomial, of degree 1 to 3 in
//! δ = (R − R_i)/b ∈ [−½, ½], of the pulse's contribution at range R with the carrier's phase
//! advance within the bin removed: w_m Σ_n E(m, n) e^{j2πf_n τ(R)} e^{−jαδ} / R², τ being the
//! two-way travel time ([`TravelTime`]) and α the carrier's phase advance per bin. A least-squares
//! line has 2.4 times less error than one through the bin's ends, so bins may be wider. The phase of
//! the carrier at bin centres is part of the coefficients. For even frequencies the profile without
//! carrier is periodic in c/(2Δf); the bin divides the period, the coefficients come from one
//! inverse FFT a degree, and ranges beyond the period wrap exactly.

use super::phases::{BinPhases, Row};
use super::spec::TableSpec;
use crate::engine::planar::padded;
use crate::engine::weights::Weights;
use crate::error::ImagingError;
use crate::kernel::direct::job::TableView;
use crate::pulses::{Pulses, Spreading};
use acerra_control::Control;
use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::FftPlanner;

/// Entries at either end that vectors may load without using them.
pub(crate) const PADDING: usize = 36;

/// Range profiles of all pulses over the ranges that an image needs.
#[derive(Debug, Clone)]
pub(crate) struct RangeTable {
    pub spec: TableSpec,
    /// Two-way carrier phase advance per range bin, α, rad.
    pub carrier_rad: f64,
    /// Absolute bin number of each pulse's entry 0.
    pub first_bin: Vec<i64>,
    /// Numbers from one coefficient row to the next.
    pub stride: usize,
    /// `[pulse, degree + 1, re/im, stride]`, or `[pulse, stride, degree + 1, re/im]` interleaved.
    pub coefficients: Vec<f32>,
    /// Factor of the coefficients, a power of two that keeps them near 1.
    pub scale: f64,
}

impl RangeTable {
    /// Entries that a table over `ranges_m` (least and greatest a pulse) holds a row.
    pub fn stride_for(spec: &TableSpec, ranges_m: &[[f64; 2]]) -> usize {
        let widest = ranges_m
            .iter()
            .map(|[a, b]| (b / spec.bin_m).ceil() - (a / spec.bin_m).floor())
            .fold(0.0, f64::max);
        padded(widest as usize + 2 + 2 * PADDING)
    }

    /// Bytes of a table over `ranges_m`.
    pub fn bytes_for(spec: &TableSpec, ranges_m: &[[f64; 2]]) -> u128 {
        ranges_m.len() as u128
            * (spec.degree as u128 + 1)
            * 2
            * Self::stride_for(spec, ranges_m) as u128
            * size_of::<f32>() as u128
    }

    /// Absolute bin number of each pulse's entry 0.
    pub fn first_bins(spec: &TableSpec, ranges_m: &[[f64; 2]]) -> Vec<i64> {
        ranges_m
            .iter()
            .map(|r| (r[0] / spec.bin_m).floor() as i64 - PADDING as i64)
            .collect()
    }

    /// Numbers from one pulse to the next.
    pub fn pulse_stride(&self) -> usize {
        (self.spec.degree + 1) * 2 * self.stride
    }

    /// The table over `ranges_m`, least and greatest range of every pulse.
    pub fn build(
        pulses: &Pulses,
        spec: TableSpec,
        ranges_m: &[[f64; 2]],
        weights: &Weights,
        control: Control,
    ) -> Result<Self, ImagingError> {
        let stride = Self::stride_for(&spec, ranges_m);
        let carrier_rad = spec.carrier_rad(pulses);
        let first_bin = Self::first_bins(&spec, ranges_m);
        let scale = power_of_two_scale(pulses, ranges_m, weights.spreading);
        let mut coefficients = vec![0f32; ranges_m.len() * (spec.degree + 1) * 2 * stride];
        let first = first_bin.iter().copied().min().unwrap_or(0);
        let last = first_bin.iter().copied().max().unwrap_or(0) + stride as i64;
        let shared = BinPhases::new(pulses, weights, &spec, [first, last]);
        let fft = spec
            .period
            .map(|length| FftPlanner::new().plan_fft_inverse(length));
        coefficients
            .par_chunks_mut((spec.degree + 1) * 2 * stride)
            .enumerate()
            .for_each_init(
                || {
                    let length = spec.period.unwrap_or(stride);
                    let scratch = fft.as_ref().map_or(0, |f| f.get_immutable_scratch_len());
                    let profile = vec![Complex64::ZERO; length * (spec.degree + 1)];
                    // Only the frequencies' slots are ever written.
                    let padded = fft.as_ref().map(|_| profile.clone());
                    (
                        padded.unwrap_or_default(),
                        profile,
                        vec![Complex64::ZERO; scratch],
                    )
                },
                |(padded, profile, scratch), (m, out)| {
                    if control.is_cancelled() {
                        return;
                    }
                    let start = first_bin[m];
                    match &fft {
                        Some(fft) => {
                            shared.even(pulses, m, &spec, padded);
                            fft.process_immutable_with_scratch(padded, profile, scratch);
                        }
                        None => shared.uneven(pulses, m, &spec, start, profile),
                    }
                    let row = Row {
                        pulse: m,
                        first_bin: start,
                        factor: pulses.weight()[m] * scale,
                    };
                    shared.store(&spec, row, weights, profile, out);
                },
            );
        control.check()?;
        Ok(Self {
            spec,
            carrier_rad,
            first_bin,
            stride,
            coefficients,
            scale,
        })
    }

    /// Place of each pulse's entry 0, in bins from range zero, where every echo is delayed by a range of
    /// `beyond_m` relative to its pixel.
    pub fn first_bins_beyond(&self, beyond_m: f64) -> Vec<f64> {
        let beyond = beyond_m / self.spec.bin_m;
        (self.first_bin.iter())
            .map(|&bin| bin as f64 - beyond)
            .collect()
    }

    /// View of the table for the direct kernel, with the place of each pulse's entry 0.
    pub fn view<'a>(&'a self, first_bin: &'a [f64]) -> TableView<'a> {
        TableView {
            coefficients: &self.coefficients,
            first_bin,
            stride: self.stride,
            pulse_stride: self.pulse_stride(),
            bin_m: self.spec.bin_m,
            scale: self.scale,
            degree: self.spec.degree,
            interleaved: self.spec.interleaved,
        }
    }

    /// The contribution of a pulse at a range within the table, evaluated in double precision.
    #[cfg(test)]
    pub fn evaluate(&self, pulse: usize, range_m: f64) -> Complex64 {
        let t = range_m / self.spec.bin_m - self.first_bin[pulse] as f64;
        let i = t.round();
        let delta = t - i;
        let row = &self.coefficients[pulse * self.pulse_stride()..][..self.pulse_stride()];
        let at = |k: usize| f64::from(row[k * self.stride + i as usize]);
        let mut value = Complex64::ZERO;
        for p in (0..=self.spec.degree).rev() {
            value = value * delta + Complex64::new(at(2 * p), at(2 * p + 1));
        }
        value * Complex64::cis(self.carrier_rad * delta) / self.scale
    }
}

/// A power of two that brings the largest contributions near 1.
pub(crate) fn power_of_two_scale(
    pulses: &Pulses,
    ranges_m: &[[f64; 2]],
    spreading: Spreading,
) -> f64 {
    let peak = pulses
        .spectrum()
        .iter()
        .map(|e| e.re.abs().max(e.im.abs()))
        .fold(0.0, f64::max);
    let weight = pulses.weight().iter().map(|w| w.abs()).fold(0.0, f64::max);
    let range = ranges_m
        .iter()
        .map(|r| 0.5 * (r[0] + r[1]))
        .fold(f64::INFINITY, f64::min)
        .max(1e-3);
    let size = peak * weight * spreading.weight(range) * pulses.frequency_hz().len() as f64;
    if size > 0.0 && size.is_finite() {
        2f64.powi(-(size.log2().round().clamp(-900.0, 900.0) as i32))
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::reference::pulse_at_range;
    use crate::pulses::PulseArrays;

    fn error(f: &[f64], spec: TableSpec, ranges: [f64; 2], spreading: Spreading) -> f64 {
        let n = f.len();
        let spectrum: Vec<_> = (0..n)
            .map(|k| Complex64::cis((k * k) as f64 * 0.7) * (1.0 + (k as f64).sin()))
            .collect();
        let position = [[0.0; 3]];
        let pulses = Pulses::new(PulseArrays {
            position_m: &position,
            frequency_hz: f,
            spectrum: &spectrum,
            weight: &[0.7],
            light_speed_m_s: 3e8,
        })
        .unwrap();
        let table = RangeTable::build(
            &pulses,
            spec,
            &[ranges],
            &Weights::spreading_alone(spreading),
            Control::default(),
        )
        .unwrap();
        let (mut difference, mut power) = (0.0, 0.0);
        for k in 0..2000 {
            let r = ranges[0] + (ranges[1] - ranges[0]) * (k as f64 * 0.618_034).fract();
            let expected = pulse_at_range(&pulses, 0, r) * (0.7 * spreading.weight(r));
            difference += (table.evaluate(0, r) - expected).norm_sqr();
            power += expected.norm_sqr();
        }
        (difference / power).sqrt()
    }

    #[test]
    fn the_fit_error_is_as_predicted_at_any_range_and_degree() {
        let f: Vec<f64> = (0..213).map(|n| 3.102e9 + 8e6 * f64::from(n)).collect();
        for degree in 1..=3 {
            let spec = TableSpec {
                bin_m: 3e8 / 16e6 / 1536.0,
                degree,
                period: Some(1536),
                carrier: 106,
                interleaved: false,
                reach: 1.0,
            };
            let spectrum = vec![Complex64::ONE; 213];
            let pulses = Pulses::new(PulseArrays {
                position_m: &[[0.0; 3]],
                frequency_hz: &f,
                spectrum: &spectrum,
                weight: &[1.0],
                light_speed_m_s: 3e8,
            })
            .map(|p| spec.fit_error(&p, &vec![1.0; 213]))
            .unwrap();
            // 100 and 3000 m lie many periods (18.75 m) away: wrapping is exact.
            for ranges in [[3.0, 9.0], [97.0, 105.0], [2999.0, 3010.0]] {
                let found = error(&f, spec, ranges, Spreading::None);
                assert!(
                    (0.7..1.3).contains(&(found / pulses)) || found < 3e-7,
                    "{degree}: {found:e} for {pulses:e}"
                );
                let weighted = error(&f, spec, ranges, Spreading::InverseSquare);
                assert!(weighted < 1.5 * pulses + 3e-7, "{weighted:e} {pulses:e}");
            }
        }
    }

    #[test]
    fn uneven_frequencies_are_summed_plainly() {
        let f: Vec<f64> = (0..60)
            .map(|n| 3.1e9 + 8e6 * f64::from(n) + 1.3e6 * f64::from(n * n % 7))
            .collect();
        let spec = TableSpec {
            bin_m: 0.02,
            degree: 3,
            period: None,
            carrier: 30,
            interleaved: false,
            reach: 1.0,
        };
        assert!(error(&f, spec, [40.0, 60.0], Spreading::InverseSquare) < 2e-5);
    }
}
