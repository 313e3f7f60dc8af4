//! One clock over another by pairs whose errors are of either sign, a few of them outlying.

use super::fit::LEAST_PAIRS;

/// Deviations beyond which a residual is an outlier, and the least deviation (s).
const OUTLYING: f64 = 4.0;
const RESOLUTION_S: f64 = 1e-7;
/// Share of the pairs that may be outlying.
const FEW: f64 = 0.1;
/// Pairs of a block: residuals within one may be correlated.
const PAIRS_PER_BLOCK: usize = 8;

/// The readings of two clocks at one moment (s).
#[derive(Clone, Copy)]
pub(super) struct LinePair {
    /// Of the one.
    pub at_s: f64,
    /// Of the other.
    pub reads_s: f64,
}

/// The other clock over the one.
#[derive(Clone, Copy, Debug)]
pub(super) struct RobustLine {
    /// Reading of the one in the middle of the pairs (s).
    pub middle_s: f64,
    /// Reading of the other there (s).
    pub value_s: f64,
    /// Seconds of the other in a second of the one.
    pub slope: f64,
    /// Standard deviation of the value in the middle (s).
    pub sigma_s: f64,
    /// Standard deviation of the slope.
    pub sigma_slope: f64,
    /// Scatter of the pairs used about the line (s).
    pub scatter_s: f64,
    /// Deviation of the means over blocks beyond what the scatter explains (s): the departure of the clocks
    /// from a line. 0 for few blocks.
    pub wander_s: f64,
    /// Root of the sum of squares of the times about their middle (s).
    spread_s: f64,
    /// Pairs used.
    pub used: usize,
}

impl RobustLine {
    /// Reading of the other where the one reads zero (s).
    pub fn at_zero_s(&self) -> f64 {
        self.value_s - self.slope * self.middle_s
    }

    fn residual_s(&self, pair: &LinePair) -> f64 {
        pair.reads_s - self.value_s - self.slope * (pair.at_s - self.middle_s)
    }

    /// The line through all pairs but outlying ones. Where outlying pairs are more than a few, no line
    /// describes the pairs, and outlying pairs count for the deviation.
    pub fn through(all: &[LinePair]) -> Option<Self> {
        let mut pairs = all.to_vec();
        loop {
            let line = Self::least_squares(&pairs)?;
            let mut sizes: Vec<f64> = pairs.iter().map(|p| line.residual_s(p).abs()).collect();
            sizes.sort_by(f64::total_cmp);
            // The deviation of a normal distribution by the median of moduli.
            let usual_s = (1.4826 * sizes[sizes.len() / 2]).max(RESOLUTION_S);
            let before = pairs.len();
            pairs.retain(|p| line.residual_s(p).abs() <= OUTLYING * usual_s);
            if pairs.len() == before || pairs.len() < LEAST_PAIRS {
                let are_few = (all.len() - pairs.len()) as f64 <= FEW * all.len() as f64;
                return Some(line.with_deviation(if are_few { &pairs } else { all }));
            }
        }
    }

    fn least_squares(pairs: &[LinePair]) -> Option<Self> {
        if pairs.len() < LEAST_PAIRS {
            return None;
        }
        let n = pairs.len() as f64;
        let middle_s = pairs.iter().map(|p| p.at_s).sum::<f64>() / n;
        let value_s = pairs.iter().map(|p| p.reads_s).sum::<f64>() / n;
        let sums = pairs.iter().map(|p| {
            let x = p.at_s - middle_s;
            [x * x, x * (p.reads_s - value_s)]
        });
        let [xx, xy] = sums.fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]]);
        (xx > 0.0).then(|| Self {
            middle_s,
            value_s,
            slope: xy / xx,
            sigma_s: 0.0,
            sigma_slope: 0.0,
            scatter_s: 0.0,
            wander_s: 0.0,
            spread_s: xx.sqrt(),
            used: pairs.len(),
        })
    }

    /// The line with the deviation of its value: by the residuals' scatter, or by that of their means over
    /// blocks, where residuals are correlated.
    fn with_deviation(self, pairs: &[LinePair]) -> Self {
        let residuals_s: Vec<f64> = pairs.iter().map(|p| self.residual_s(p)).collect();
        let n = residuals_s.len() as f64;
        let scatter_s = (residuals_s.iter().map(|r| r * r).sum::<f64>() / (n - 2.0)).sqrt();
        let blocks = residuals_s.chunks_exact(PAIRS_PER_BLOCK);
        let means: Vec<f64> = blocks
            .map(|block| block.iter().sum::<f64>() / block.len() as f64)
            .collect();
        let (of_means_s, wander_s) = match means.len() {
            0..=3 => (0.0, 0.0),
            count => {
                let square = means.iter().map(|m| m * m).sum::<f64>() / (count - 2) as f64;
                let explained = scatter_s * scatter_s / PAIRS_PER_BLOCK as f64;
                let wander_s = (square - explained).max(0.0).sqrt();
                ((square / count as f64).sqrt(), wander_s)
            }
        };
        let sigma_s = (scatter_s / n.sqrt()).max(of_means_s).max(RESOLUTION_S);
        Self {
            sigma_s,
            sigma_slope: sigma_s * n.sqrt() / self.spread_s,
            scatter_s,
            wander_s,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(off_s: impl Fn(usize) -> f64) -> Vec<LinePair> {
        let pair = |k: usize| LinePair {
            at_s: 0.1 * k as f64,
            reads_s: 3.0 + 0.1 * k as f64 + off_s(k),
        };
        (0..200).map(pair).collect()
    }

    #[test]
    fn a_few_outlying_pairs_do_not_count_and_many_make_the_line_uncertain() {
        let few = RobustLine::through(&pairs(|k| if k % 25 == 0 { 1e-3 } else { 0.0 })).unwrap();
        assert_eq!((few.used, few.sigma_s), (192, RESOLUTION_S));
        assert!((few.at_zero_s() - 3.0).abs() < 1e-9);
        // Steps of a millisecond for a third of the time.
        let steps = pairs(|k| if (60..120).contains(&k) { 1e-3 } else { 0.0 });
        let line = RobustLine::through(&steps).unwrap();
        assert!(line.sigma_s > 5e-5, "{}", line.sigma_s);
        assert!((line.at_zero_s() - 3.0).abs() < 1e-3);
        assert!(RobustLine::through(&steps[..10]).is_none());
    }
}
