//! Log-likelihoods over a whole range of offsets.

/// Log-likelihood of every offset of an even grid.
#[derive(Debug, Clone, PartialEq)]
pub struct LikelihoodCurve {
    /// First offset, s.
    pub start_s: f64,
    /// Spacing of offsets, s.
    pub step_s: f64,
    /// Natural logarithm of the likelihood, up to a constant.
    pub log_likelihood: Vec<f64>,
}

/// An interval of offsets that are all likely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mode {
    /// Index of the most likely offset.
    pub peak: usize,
    /// First and last index of the interval.
    pub ends: [usize; 2],
}

impl LikelihoodCurve {
    /// Offset `index`, s.
    #[must_use]
    pub fn offset_s(&self, index: usize) -> f64 {
        self.start_s + index as f64 * self.step_s
    }

    /// Log-likelihood at an offset, linear between the grid's offsets, constant beyond its ends.
    #[must_use]
    pub fn at(&self, offset_s: f64) -> f64 {
        let last = self.log_likelihood.len() - 1;
        let x = ((offset_s - self.start_s) / self.step_s).clamp(0.0, last as f64);
        let i = (x as usize).min(last.saturating_sub(1));
        let next = self.log_likelihood[(i + 1).min(last)];
        self.log_likelihood[i] + (x - i as f64) * (next - self.log_likelihood[i])
    }

    /// The most likely offset, s, refined by a parabola, and its log-likelihood.
    #[must_use]
    pub fn best(&self) -> (f64, f64) {
        let peak = self.peak();
        (self.vertex_s(peak), self.log_likelihood[peak])
    }

    pub(super) fn peak(&self) -> usize {
        (0..self.log_likelihood.len())
            .max_by(|&a, &b| self.log_likelihood[a].total_cmp(&self.log_likelihood[b]))
            .unwrap_or(0)
    }

    /// Width of the likely offsets, s: the integral of the likelihood over its maximum.
    pub(super) fn likely_s(&self) -> f64 {
        let (_, best) = self.best();
        let over_best = self.log_likelihood.iter().map(|l| (l - best).exp());
        self.step_s * over_best.sum::<f64>()
    }

    /// Vertex of the parabola about a peak, s.
    pub(super) fn vertex_s(&self, peak: usize) -> f64 {
        let l = &self.log_likelihood;
        if peak == 0 || peak + 1 >= l.len() {
            return self.offset_s(peak);
        }
        let (before, after) = (l[peak - 1], l[peak + 1]);
        let curvature = before - 2.0 * l[peak] + after;
        let fraction = if curvature < 0.0 {
            (0.5 * (before - after) / curvature).clamp(-0.5, 0.5)
        } else {
            0.0
        };
        self.offset_s(peak) + fraction * self.step_s
    }

    /// Standard deviation of the offset about a peak, s: the second moment of the likelihood over the
    /// interval about the peak, at least the grid's resolution.
    pub(super) fn sigma_s(&self, mode: Mode) -> f64 {
        let top = self.log_likelihood[mode.peak];
        let centre = self.vertex_s(mode.peak);
        let (mut weight, mut moment) = (0.0, 0.0);
        for i in mode.ends[0]..=mode.ends[1] {
            let w = (self.log_likelihood[i] - top).exp();
            weight += w;
            moment += w * (self.offset_s(i) - centre).powi(2);
        }
        let spread = (moment / weight).sqrt();
        let l = &self.log_likelihood;
        // For a peak narrower than the grid the curvature at the vertex is used.
        let curvature = if mode.peak > 0 && mode.peak + 1 < l.len() {
            (2.0 * l[mode.peak] - l[mode.peak - 1] - l[mode.peak + 1]) / self.step_s.powi(2)
        } else {
            0.0
        };
        if spread < 0.7 * self.step_s && curvature > 0.0 {
            curvature.sqrt().recip()
        } else {
            spread
        }
    }

    /// Peaks within `margin` of the best, the most likely first, each with the interval about it within three
    /// standard deviations (a log-likelihood of 4.5). Peaks nearer to an interval than `apart_s` belong to
    /// the interval.
    pub(super) fn modes(&self, margin: f64, apart_s: f64) -> Vec<Mode> {
        /// Log-likelihood three standard deviations from a peak.
        const STRETCH: f64 = 4.5;
        const MOST: usize = 12;
        let l = &self.log_likelihood;
        let apart = (apart_s / self.step_s).round() as usize;
        let mut free = vec![true; l.len()];
        let floor = l[self.peak()] - margin;
        let mut modes = Vec::new();
        while modes.len() < MOST {
            let highest = (0..l.len())
                .filter(|&i| free[i] && l[i] >= floor)
                .max_by(|&a, &b| l[a].total_cmp(&l[b]));
            let Some(peak) = highest else { break };
            let likely = |i: &usize| free[*i] && l[*i] >= l[peak] - STRETCH;
            let first = (0..=peak).rev().take_while(likely).last().unwrap_or(peak);
            let last = (peak..l.len()).take_while(likely).last().unwrap_or(peak);
            modes.push(Mode {
                peak,
                ends: [first, last],
            });
            let end = (last + apart + 1).min(l.len());
            free[first.saturating_sub(apart)..end].fill(false);
        }
        modes
    }

    /// The sum of two curves over the same offsets.
    pub(super) fn add(&mut self, other: &Self) {
        for (sum, value) in self.log_likelihood.iter_mut().zip(&other.log_likelihood) {
            *sum += value;
        }
    }
}
