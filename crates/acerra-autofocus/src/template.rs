//! The spectrum common to the echoes of all points, and its correlations.

use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Nodes of a correlation table per range resolution c/2B.
const NODES_PER_CELL: f64 = 24.0;

/// The common spectrum S(n), and correlations of the echoes of two points.
#[derive(Clone, Debug)]
pub(crate) struct Template {
    /// S(n), `[N]`.
    pub spectrum: Vec<Complex64>,
    /// κ_n − κ_c, rad/m, with κ = 4πf/c.
    pub wavenumber: Vec<f64>,
    /// κ_c = Σ κ|S|²/Σ|S|², rad/m.
    pub carrier: f64,
    /// Σ|S|².
    pub energy: f64,
    /// Range resolution c/2B of the band, m.
    pub cell_m: f64,
    step_m: f64,
    /// Σ (κ − κ_c)^p |S|² e^{j(κ − κ_c)Δ} for p = 0…3 at Δ = i·step.
    nodes: Vec<[Complex64; 4]>,
}

impl Template {
    /// The template with amplitudes `spectrum` at `frequency_hz`, for pairs of points up to `longest_m` apart
    /// in range.
    pub fn new(
        spectrum: Vec<Complex64>,
        frequency_hz: &[f64],
        light_speed_m_s: f64,
        longest_m: f64,
    ) -> Self {
        let kappa: Vec<f64> = frequency_hz
            .iter()
            .map(|f| 4.0 * PI * f / light_speed_m_s)
            .collect();
        let energy: f64 = spectrum.iter().map(Complex64::norm_sqr).sum();
        let weighted: f64 = kappa
            .iter()
            .zip(&spectrum)
            .map(|(k, s)| k * s.norm_sqr())
            .sum();
        let carrier = weighted / energy;
        let wavenumber: Vec<f64> = kappa.iter().map(|k| k - carrier).collect();
        let band_hz = frequency_hz[frequency_hz.len() - 1] - frequency_hz[0];
        let cell_m = light_speed_m_s / (2.0 * band_hz);
        let step_m = cell_m / NODES_PER_CELL;
        let count = (longest_m / step_m).ceil() as usize + 3;
        let mut template = Self {
            spectrum,
            wavenumber,
            carrier,
            energy,
            cell_m,
            step_m,
            nodes: Vec::new(),
        };
        template.nodes = (0..count)
            .into_par_iter()
            .map(|i| template.moments(i as f64 * step_m))
            .collect();
        template
    }

    fn moments(&self, apart_m: f64) -> [Complex64; 4] {
        let mut sum = [Complex64::ZERO; 4];
        // The wavenumbers are evenly spaced: each factor follows from the one before.
        let mut factor = Complex64::cis(self.wavenumber[0] * apart_m);
        let turn = Complex64::cis((self.wavenumber[1] - self.wavenumber[0]) * apart_m);
        for (k, s) in self.wavenumber.iter().zip(&self.spectrum) {
            let mut term = factor * s.norm_sqr();
            for v in &mut sum {
                *v += term;
                term *= *k;
            }
            factor *= turn;
        }
        sum
    }

    /// Σ |S|² e^{j(κ − κ_c)Δ}.
    #[inline]
    pub fn correlation_value(&self, apart_m: f64) -> Complex64 {
        let at = apart_m.abs() / self.step_m;
        let i = at as usize;
        let Some([a, b]) = self.nodes.get(i..i + 2) else {
            return Complex64::ZERO;
        };
        let slope = |node: &[Complex64; 4]| Complex64::new(-node[1].im, node[1].re) * self.step_m;
        let value = hermite(at - i as f64, [a[0], b[0]], [slope(a), slope(b)]);
        if apart_m < 0.0 { value.conj() } else { value }
    }

    /// Σ (κ − κ_c)^p |S|² e^{j(κ − κ_c)Δ} for p = 0, 1, 2.
    pub fn correlation(&self, apart_m: f64) -> [Complex64; 3] {
        let at = apart_m.abs() / self.step_m;
        let i = at as usize;
        let (Some(a), Some(b)) = (self.nodes.get(i), self.nodes.get(i + 1)) else {
            return [Complex64::ZERO; 3];
        };
        let t = at - i as f64;
        let j_step = Complex64::I * self.step_m;
        // Derivatives over Δ: d/dΔ of moment p is j times moment p + 1.
        let of = |p: usize| hermite(t, [a[p], b[p]], [j_step * a[p + 1], j_step * b[p + 1]]);
        let values = [of(0), of(1), of(2)];
        if apart_m < 0.0 {
            values.map(|v| v.conj())
        } else {
            values
        }
    }
}

/// Cubic through two values with the derivatives given, per step.
#[inline]
pub(crate) fn hermite(t: f64, value: [Complex64; 2], slope: [Complex64; 2]) -> Complex64 {
    let u = 1.0 - t;
    value[0] * ((1.0 + 2.0 * t) * u * u)
        + value[1] * (t * t * (3.0 - 2.0 * t))
        + slope[0] * (t * u * u)
        - slope[1] * (t * t * u)
}

/// Amplitudes of the common spectrum from the mean power of all pulses: echoes of many ranges make it fade
/// equally at all frequencies.
pub(crate) fn mean_amplitudes(spectra: &[Complex64], frequencies: usize) -> Vec<Complex64> {
    let mut power = vec![0.0; frequencies];
    for pulse in spectra.chunks_exact(frequencies) {
        for (p, v) in power.iter_mut().zip(pulse) {
            *p += v.norm_sqr();
        }
    }
    let half = (frequencies / 40).max(1);
    (0..frequencies)
        .map(|n| {
            let part = &power[n.saturating_sub(half)..(n + half + 1).min(frequencies)];
            Complex64::from((part.iter().sum::<f64>() / part.len() as f64).sqrt())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulated_correlations_are_the_sums() {
        let frequency_hz: Vec<f64> = (0..86).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
        let spectrum = (0..86)
            .map(|n| Complex64::cis(0.1 * f64::from(n)) * (1.0 + 0.01 * f64::from(n)))
            .collect();
        let template = Template::new(spectrum, &frequency_hz, 3e8, 5.0);
        for apart in [-1.234, -0.01, 0.0, 0.031, 0.5, 4.9] {
            let exact = template.moments(apart);
            let found = template.correlation(apart);
            for p in 0..3 {
                let scale = template.moments(0.0)[0].re * 36.0_f64.powi(p as i32);
                assert!((found[p] - exact[p]).norm() < 1e-5 * scale, "{apart} {p}");
            }
            assert_eq!(template.correlation_value(apart), found[0]);
            let each = template.wavenumber.iter().zip(&template.spectrum);
            let direct: Complex64 = each
                .map(|(k, s)| Complex64::cis(k * apart) * s.norm_sqr())
                .sum();
            assert!(
                (exact[0] - direct).norm() < 1e-12 * template.energy,
                "{apart}"
            );
        }
    }
}
