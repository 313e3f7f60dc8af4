//! GPS time over radar time by pairs of scans and marks.

use super::fit::LEAST_PAIRS;

/// Residuals beyond so many deviations are of other marks, and the least deviation (s).
const OUTLYING: f64 = 4.0;
const RESOLUTION_S: f64 = 1e-7;
/// Share of the pairs that may be outlying.
const FEW: f64 = 0.1;
/// Marks of a block: residuals within one may be correlated.
const MARKS_PER_BLOCK: usize = 8;

/// A scan by radar time and a mark's GPS time at its middle, both in seconds.
#[derive(Clone, Copy)]
pub(super) struct MarkPair {
    pub radar_s: f64,
    pub gps_s: f64,
}

/// GPS time over radar time.
pub(super) struct MarkLine {
    middle_s: f64,
    value_s: f64,
    /// Seconds of GPS time in a second of radar time.
    pub slope: f64,
    /// Standard deviation of the value in the middle (s).
    pub sigma_s: f64,
    /// Pairs used.
    pub used: usize,
}

impl MarkLine {
    /// GPS time at radar time zero (s after the origin).
    pub fn at_zero_s(&self) -> f64 {
        self.value_s - self.slope * self.middle_s
    }

    fn residual_s(&self, pair: &MarkPair) -> f64 {
        pair.gps_s - self.value_s - self.slope * (pair.radar_s - self.middle_s)
    }

    /// The line through all pairs but outlying ones. Where those are more than a few, no line tells the
    /// pairs: they count for the deviation.
    pub fn through(all: &[MarkPair]) -> Option<Self> {
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

    fn least_squares(pairs: &[MarkPair]) -> Option<Self> {
        if pairs.len() < LEAST_PAIRS {
            return None;
        }
        let n = pairs.len() as f64;
        let middle_s = pairs.iter().map(|p| p.radar_s).sum::<f64>() / n;
        let value_s = pairs.iter().map(|p| p.gps_s).sum::<f64>() / n;
        let sums = pairs.iter().map(|p| {
            let x = p.radar_s - middle_s;
            [x * x, x * (p.gps_s - value_s)]
        });
        let [xx, xy] = sums.fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]]);
        (xx > 0.0).then(|| Self {
            middle_s,
            value_s,
            slope: xy / xx,
            sigma_s: 0.0,
            used: pairs.len(),
        })
    }

    /// The same with the deviation of its value: by the residuals' scatter, or by that of their means over
    /// blocks, where they are correlated.
    fn with_deviation(self, pairs: &[MarkPair]) -> Self {
        let residuals_s: Vec<f64> = pairs.iter().map(|p| self.residual_s(p)).collect();
        let n = residuals_s.len() as f64;
        let scatter_s = (residuals_s.iter().map(|r| r * r).sum::<f64>() / (n - 2.0)).sqrt();
        let blocks = residuals_s.chunks_exact(MARKS_PER_BLOCK);
        let means: Vec<f64> = blocks
            .map(|block| block.iter().sum::<f64>() / block.len() as f64)
            .collect();
        let of_means_s = match means.len() {
            0..=3 => 0.0,
            count => {
                let square = means.iter().map(|m| m * m).sum::<f64>() / (count - 2) as f64;
                (square / count as f64).sqrt()
            }
        };
        Self {
            sigma_s: (scatter_s / n.sqrt()).max(of_means_s).max(RESOLUTION_S),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(off_s: impl Fn(usize) -> f64) -> Vec<MarkPair> {
        let pair = |k: usize| MarkPair {
            radar_s: 0.1 * k as f64,
            gps_s: 3.0 + 0.1 * k as f64 + off_s(k),
        };
        (0..200).map(pair).collect()
    }

    #[test]
    fn a_few_outlying_pairs_do_not_count_and_many_make_the_line_uncertain() {
        let few = MarkLine::through(&pairs(|k| if k % 25 == 0 { 1e-3 } else { 0.0 })).unwrap();
        assert_eq!((few.used, few.sigma_s), (192, RESOLUTION_S));
        assert!((few.at_zero_s() - 3.0).abs() < 1e-9);
        // Steps of a millisecond for a third of the time.
        let steps = pairs(|k| if (60..120).contains(&k) { 1e-3 } else { 0.0 });
        let line = MarkLine::through(&steps).unwrap();
        assert!(line.sigma_s > 5e-5, "{}", line.sigma_s);
        assert!((line.at_zero_s() - 3.0).abs() < 1e-3);
        assert!(MarkLine::through(&steps[..10]).is_none());
    }
}
