//! Correlated noise: the number of independent samples in a series.

/// Autocorrelation of a series.
pub(crate) struct Autocorrelation(Vec<f64>);

impl Autocorrelation {
    /// At lags 0, 1, … (mean removed), up to a quarter of the series' length and not beyond the first lag at which the
    /// autocorrelation is no longer positive.
    pub fn of(values: &[f64]) -> Self {
        let n = values.len();
        let mean = values.iter().sum::<f64>() / n.max(1) as f64;
        let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
        let power = dot(&centred, &centred);
        if power <= 0.0 {
            return Self(vec![1.0]);
        }
        let mut out = vec![1.0];
        for lag in 1..=n / 4 {
            let rho = dot(&centred[lag..], &centred[..n - lag]) / power;
            if rho <= 0.0 {
                break;
            }
            // Unbiased by the number of pairs used.
            out.push((rho * n as f64 / (n - lag) as f64).min(1.0));
        }
        Self(out)
    }

    /// Samples with the information of one independent sample (Bartlett): 1 + 2 Σ ρ(k), at least 1.
    pub fn length(&self) -> f64 {
        1.0 + 2.0 * self.0[1..].iter().sum::<f64>()
    }

    /// Samples that determine as much of their spread as one independent sample (Bayley and Hammersley 1946):
    /// 1 + 2 Σ ρ(k)².
    pub fn spread_length(&self) -> f64 {
        1.0 + 2.0 * self.0[1..].iter().map(|r| r * r).sum::<f64>()
    }
}

/// [`Autocorrelation::length`] of a series.
pub(crate) fn correlation_length(values: &[f64]) -> f64 {
    Autocorrelation::of(values).length()
}

/// Sum of products, in partial sums that are evaluated together.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let (mut sums, [a, b]) = ([0.0; LANES], [a, b].map(|v| v.chunks_exact(LANES)));
    let rest = a.remainder().iter().zip(b.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Factor by which noise that lasts as long as a regressor raises the variance of a fit, relative to white
/// noise of equal variance: the variance of means over the regressor's correlation length (samples), relative
/// to that of means of white noise. At least 1.
///
/// Autocorrelations of the residual alone miss a small slow part under much white noise; means over
/// blocks do not.
pub(super) fn variance_inflation(residual: &[f64], regressor_length: f64) -> f64 {
    let n = residual.len();
    let length = (regressor_length.ceil() as usize).clamp(1, (n / 4).max(1));
    let mean = residual.iter().sum::<f64>() / n.max(1) as f64;
    let power = residual.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / n.max(1) as f64;
    if length < 2 || power <= 0.0 {
        return 1.0;
    }
    // Means over blocks from running sums.
    let mut until = vec![0.0; n + 1];
    for (k, r) in residual.iter().enumerate() {
        until[k + 1] = until[k] + (r - mean);
    }
    let blocks = (length..=n).map(|end| (until[end] - until[end - length]) / length as f64);
    let of_means = blocks.map(|b| b * b).sum::<f64>() / (n + 1 - length) as f64;
    // Means over n/length blocks about their own mean: one degree of freedom is used.
    let count = n as f64 / length as f64;
    (length as f64 * of_means / power * count / (count - 1.0)).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_slow_part_under_white_noise_is_seen() {
        let mut state = 11u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let (mut slow, mut regressor) = (0.0, 0.0);
        let (mut residual, mut against) = (Vec::new(), Vec::new());
        for _ in 0..4000 {
            slow = 0.95 * slow + 0.1 * uniform();
            regressor = 0.95 * regressor + uniform();
            residual.push(uniform() + slow);
            against.push(regressor);
        }
        // Variances 1/12 and 1/12 · 0.01/(1 − 0.95²); over blocks of about 39.
        let got = variance_inflation(&residual, correlation_length(&against));
        assert!((2.0..5.0).contains(&got), "{got}");
        let white: Vec<f64> = (0..4000).map(|_| uniform()).collect();
        assert!(variance_inflation(&white, correlation_length(&against)) < 1.6);
    }

    #[test]
    fn a_spread_is_known_sooner_than_a_mean() {
        // ρ(k) = φᵏ: (1 + φ²)/(1 − φ²) against (1 + φ)/(1 − φ).
        let mut state = 7u64;
        let mut x = 0.0;
        let series: Vec<f64> = (0..40_000)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                x = 0.9 * x + (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
                x
            })
            .collect();
        let got = Autocorrelation::of(&series).spread_length();
        assert!((got / (1.81 / 0.19) - 1.0).abs() < 0.2, "{got}");
    }

    #[test]
    fn an_autoregressive_series_has_its_correlation_length() {
        let mut state = 5u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for phi in [0.0, 0.5, 0.9] {
            let mut x = 0.0;
            let series: Vec<f64> = (0..40_000)
                .map(|_| {
                    x = phi * x + uniform();
                    x
                })
                .collect();
            let want = (1.0 + phi) / (1.0 - phi);
            let got = correlation_length(&series);
            assert!((got / want - 1.0).abs() < 0.25, "{phi}: {got} for {want}");
        }
    }
}
