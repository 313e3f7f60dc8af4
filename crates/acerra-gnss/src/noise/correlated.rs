//! Noise of a code that is correlated in time: the information of a further sample.

/// A semivariogram counts as still rising where its last value exceeds its value at half the lag by this
/// factor.
const RISING: f64 = 1.25;
/// Variance factors are kept within these bounds.
const VARIANCE_FACTORS: [f64; 2] = [0.01, 100.0];
/// Ratio of the variance of lasting multipath to the variance of the varying part.
const LASTING_SHARE: f64 = 0.25;
/// Number of samples of one ambiguity after which every further sample has the information of the last.
const LARGEST_COUNT: usize = 1_000;
/// Least information of a sample, in units of the first sample's information.
const LEAST_INFORMATION: f64 = 1e-4;

/// Noise of one system's codes on one frequency, in units of the model's variance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CodeNoise {
    /// Variance of a single code.
    pub(super) variance_factor: f64,
    /// Variance of the n-th sample of a constant (by its additional information) over the variance of the
    /// first sample.
    sample_factors: Vec<f64>,
    /// Variance of the mean of n samples of the varying part.
    mean_factors: Vec<f64>,
    /// Variance of the part that lasts longer than any lag.
    pub(super) lasting: Lasting,
}

/// Variance of the lasting part, in units of the model's.
///
/// A variance assumed too small makes wrong integers look certain, and a variance assumed too large makes
/// float positions look too inaccurate: integers use an upper bound, float positions the expected value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lasting {
    /// An upper bound for the weights of codes and the trust in integers.
    pub guarded: f64,
    /// The expected variance, for the stated errors of float positions.
    pub expected: f64,
}

impl Lasting {
    /// No lasting part, as in the codes' model.
    const NONE: Self = Self {
        guarded: 0.0,
        expected: 0.0,
    };

    /// Both variances changed by one factor.
    pub(crate) fn map(self, change: impl Fn(f64) -> f64) -> Self {
        Self {
            guarded: change(self.guarded),
            expected: change(self.expected),
        }
    }
}

impl CodeNoise {
    /// The model's noise: white, with the stated variance.
    pub(super) fn model() -> Self {
        Self {
            variance_factor: 1.0,
            sample_factors: vec![1.0],
            mean_factors: vec![1.0],
            lasting: Lasting::NONE,
        }
    }

    /// Noise with the variance `varying` and autocorrelations at lags of 1, 2, … epochs, without the part
    /// that lasts longer than any lag; `delays` are the variances of receivers' delays.
    pub(super) fn new(varying: f64, delays: Lasting, correlation: impl Fn(usize) -> f64) -> Self {
        let (mut sum, mut moment) = (0.0, 0.0);
        let mut mean_factors = Vec::with_capacity(LARGEST_COUNT);
        for n in 1..=LARGEST_COUNT {
            let count = n as f64;
            mean_factors.push(varying * (1.0 + 2.0 * (sum - moment / count)) / count);
            let rho = correlation(n).clamp(0.0, 1.0);
            sum += rho;
            moment += rho * count;
        }
        Self::with_means(
            mean_factors,
            delays.map(|own| LASTING_SHARE * varying + own),
        )
    }

    fn with_means(mean_factors: Vec<f64>, lasting: Lasting) -> Self {
        let variance_factor = mean_factors[0] + lasting.guarded;
        let mut information = 0.0;
        let of_sample = |mean_factor: &f64| {
            let own = variance_factor / (mean_factor + lasting.guarded);
            let gained = (own - information).max(LEAST_INFORMATION);
            information = own;
            1.0 / gained
        };
        Self {
            variance_factor,
            sample_factors: mean_factors.iter().map(of_sample).collect(),
            mean_factors,
            lasting,
        }
    }

    /// This noise with another variance of the lasting part.
    pub(crate) fn with_lasting(&self, lasting: Lasting) -> Self {
        Self::with_means(self.mean_factors.clone(), lasting)
    }

    /// Variance of the part that lasts longer than any lag.
    pub(crate) fn lasting(&self) -> Lasting {
        self.lasting
    }

    /// Variance of the mean of `count` codes without the lasting part.
    pub(crate) fn mean_factor(&self, count: usize) -> f64 {
        let last = self.mean_factors.len() - 1;
        self.mean_factors[count.saturating_sub(1).min(last)]
    }

    /// Factor on the model's variance of the `count`-th code (from 0) of an ambiguity.
    pub(crate) fn factor(&self, count: f64) -> f64 {
        let last = self.sample_factors.len() - 1;
        let place = (count as usize).min(last);
        self.variance_factor * self.sample_factors[place]
    }
}

/// Variance and correlation from semivariances at growing lags (epochs).
pub(super) fn noise_from_semivariogram(
    curve: &[(usize, f64)],
    delays: Lasting,
) -> Option<CodeNoise> {
    let &(_, first) = curve.first()?;
    let &(last_lag, last) = curve.last()?;
    // The sill is the mean of the longer lags; a curve that still rises at its end has not reached the sill.
    let tail = &curve[3 * curve.len() / 4..];
    let mean = tail.iter().map(|(_, v)| v).sum::<f64>() / tail.len() as f64;
    let halfway = curve.iter().find(|(lag, _)| 2 * lag >= last_lag)?.1;
    let rising = curve.len() > 1 && last > RISING * halfway;
    let sill = if rising { 1.5 * last } else { mean.max(first) };
    if sill.is_nan() || sill <= 0.0 {
        return None;
    }
    let correlation = |lag: usize| {
        let value = if lag >= last_lag {
            // Beyond the measured lags the curve continues with its last slope up to its sill.
            let slope = if rising {
                2.0 * (last - halfway) / last_lag as f64
            } else {
                sill
            };
            last + slope * (lag - last_lag) as f64
        } else {
            let k = curve.partition_point(|(l, _)| *l <= lag);
            let (a, early) = if k == 0 { (0, first) } else { curve[k - 1] };
            let (b, late) = curve[k];
            early + (late - early) * (lag - a) as f64 / (b - a) as f64
        };
        1.0 - value / sill
    };
    let factor = sill.clamp(VARIANCE_FACTORS[0], VARIANCE_FACTORS[1]);
    Some(CodeNoise::new(factor, delays, correlation))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DELAYS: Lasting = Lasting {
        guarded: 0.025,
        expected: 0.003,
    };

    /// Semivariances of a first-order Gauss–Markov process.
    fn gauss_markov(variance: f64, correlation_epochs: f64, largest: usize) -> Vec<(usize, f64)> {
        let mut curve = Vec::new();
        let mut lag = 1;
        while lag <= largest {
            let rho = (-(lag as f64) / correlation_epochs).exp();
            curve.push((lag, variance * (1.0 - rho)));
            lag = (lag + 1).max(lag * 3 / 2);
        }
        curve
    }

    /// Variance of the mean of n samples by their weights.
    fn mean_variance(noise: &CodeNoise, n: u32) -> f64 {
        1.0 / (0..n)
            .map(|k| 1.0 / noise.factor(f64::from(k)))
            .sum::<f64>()
    }

    fn lasting(varying: f64) -> f64 {
        LASTING_SHARE * varying + DELAYS.guarded
    }

    #[test]
    fn white_noise_averages_out_down_to_what_lasts() {
        let curve: Vec<_> = (1..10).map(|lag| (lag, 2.0)).collect();
        let noise = noise_from_semivariogram(&curve, DELAYS).unwrap();
        for n in [1, 2, 10, 900] {
            let exact = 2.0 / f64::from(n) + lasting(2.0);
            let ratio = mean_variance(&noise, n) / exact;
            assert!((0.95..1.05).contains(&ratio), "{n}: {ratio}");
        }
        assert!(noise_from_semivariogram(&[], DELAYS).is_none());
    }

    #[test]
    fn a_gauss_markov_process_is_recognised() {
        for tau in [5.0, 20.0, 60.0] {
            let noise = noise_from_semivariogram(&gauss_markov(4.0, tau, 300), DELAYS).unwrap();
            for n in [1u32, 10, 100, 500] {
                let exact = (1..n)
                    .map(|k| (1.0 - f64::from(k) / f64::from(n)) * (-f64::from(k) / tau).exp());
                let exact = 4.0 * (1.0 + 2.0 * exact.sum::<f64>()) / f64::from(n) + lasting(4.0);
                let ratio = mean_variance(&noise, n) / exact;
                assert!((0.7..1.3).contains(&ratio), "{tau} {n}: {ratio}");
            }
        }
    }

    #[test]
    fn a_curve_without_a_sill_is_extrapolated() {
        let noise = noise_from_semivariogram(&gauss_markov(4.0, 60.0, 20), DELAYS).unwrap();
        assert!(
            mean_variance(&noise, 20) > 0.7 * noise.factor(0.0),
            "not correlated"
        );
    }
}
