//! Tracking of echoes through a radargram at unknown heights.
//!
//! The strongest continuous ridges of the envelope are found one after another by dynamic programming
//! (Viterbi): each may move from trace to trace as fast as the platform climbs. Constant signals (direct
//! coupling and its tail) are removed first by subtracting the mean trace. The height determines which of the
//! ridges is the surface.

use std::ops::Range;

use rayon::prelude::*;

use super::AlignError;
use super::profile::REACH;
use crate::clean::{crest, envelopes_about_mean};
use crate::radargram::Radargram;
use acerra_control::Control;

/// Number of ridges followed.
const RIDGES: usize = 4;
/// Spacing of fast time on which ridges are followed, s: a quarter of an envelope's width.
const CELL_S: f64 = 0.12e-9;
/// Distance from a ridge within which the next one is not searched, s.
pub(super) const APART_S: f64 = 1e-9;
/// Envelope over the trace's median from which a pick counts.
const PRESENT: f64 = 2.5;
/// Envelope over the trace's median at which it is clipped, for ridges in the trace (few strong scatterers
/// must not draw a path away from an echo that is always present)…
const STRONG: f32 = 30.0;
/// …or at this higher limit, which is tried too.
const STRONGEST: f32 = 1000.0;
/// Standard deviation of picks over two seconds below which the echo is constant, s (3 mm): a constant echo
/// does not depend on the offset, and may be coupling.
const STILL_S: f64 = 0.02e-9;
/// Least number of picks of a ridge.
pub(super) const LEAST_PICKS: usize = 20;
/// Time over which an echo is tested for being constant, s.
const STILL_WINDOW_S: f64 = 2.0;

/// One echo followed over slow time.
#[derive(Debug, Clone, Default)]
pub(super) struct Ridge {
    /// Slow time of each pick, s.
    pub time_s: Vec<f64>,
    /// Fast time of each pick, s.
    pub fast_time_s: Vec<f64>,
    /// Envelope of the echo at each pick, in units of the samples.
    pub envelope: Vec<f64>,
}

/// Search interval of echoes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search {
    /// First and last fast time, s.
    pub window_s: [f64; 2],
    /// Largest rate of echoes: seconds of fast time in a second.
    pub rate: f64,
    /// Largest number of traces used, evenly spread.
    pub traces: usize,
}

/// Envelopes of the traces in which echoes are searched.
pub(super) struct Echoes {
    part: Radargram,
    /// Of the traces less their mean, which are free of the coupling, and of the traces as recorded, which are
    /// free of the loss that subtracting the mean causes to a nearly constant echo.
    envelopes: [Envelope; 2],
    rate: f64,
}

impl Echoes {
    /// The envelopes; `None` where the window holds too few samples.
    pub fn of(
        radargram: &Radargram,
        search: Search,
        control: Control<'_>,
    ) -> Result<Option<Self>, AlignError> {
        let stride = radargram.traces.div_ceil(search.traces.max(1)).max(1);
        let kept: Vec<usize> = (0..radargram.traces).step_by(stride).collect();
        let Ok(part) = radargram.select(&kept) else {
            return Ok(None);
        };
        control.check()?;
        let last = part.samples_per_trace - 1;
        let [low, high] = search
            .window_s
            .map(|t| part.sample_index(t).round().clamp(0.0, last as f64));
        let (low, high) = (low as usize, high as usize);
        if high < low + 16 || part.traces < 2 {
            return Ok(None);
        }
        let both = envelopes_about_mean(&part);
        control.check()?;
        let n = part.samples_per_trace;
        let envelopes = [0, 1].map(|of| Envelope::new(&both, of, n, [low, high]));
        Ok(Some(Self {
            part,
            envelopes,
            rate: search.rate,
        }))
    }

    /// Follows the strongest echoes; of ridges that are nearly the same, the first.
    pub fn ridges(&self, control: Control<'_>) -> Result<Vec<Ridge>, AlignError> {
        let step_s = median_step_s(&self.part.time_s);
        let cell = (CELL_S / self.part.fast_time_step_s).round().max(1.0) as usize;
        let cell_s = cell as f64 * self.part.fast_time_step_s;
        let climb = Climb::new(self.rate * step_s / cell_s);
        let apart = (APART_S / cell_s).ceil() as usize;
        let over_trace = self.envelopes[0].gain(cell);
        let over_column = over_trace.over_columns();
        let gains = [over_trace.limited(STRONG.ln()), over_trace, over_column];
        let of_gain = |mut gain: Gain| {
            let mut found = Vec::new();
            for _ in 0..RIDGES {
                let path = follow(&gain, climb, control)?;
                for envelope in &self.envelopes {
                    let ridge = envelope
                        .picks(&self.part, &path, cell)
                        .without_still_parts();
                    if ridge.time_s.len() >= LEAST_PICKS {
                        found.push(ridge);
                    }
                }
                gain.clear_about(&path, apart);
            }
            Ok(found)
        };
        let found: Vec<Vec<Ridge>> = gains
            .into_par_iter()
            .map(of_gain)
            .collect::<Result<_, AlignError>>()?;
        let mut ridges: Vec<Ridge> = Vec::new();
        for ridge in found.into_iter().flatten() {
            if !ridges.iter().any(|other| other.is_nearly(&ridge)) {
                ridges.push(ridge);
            }
        }
        Ok(ridges)
    }

    /// The strongest echo of each trace within [`APART_S`] of an expected fast time, in both envelopes.
    pub fn about(&self, expected_s: impl Fn(f64) -> f64) -> [Ridge; 2] {
        let reach = APART_S / self.part.fast_time_step_s;
        std::array::from_fn(|of| {
            let envelope = &self.envelopes[of];
            let mut ridge = Ridge::default();
            for (m, row) in envelope.rows.iter().enumerate() {
                let at = self.part.sample_index(expected_s(self.part.time_s[m]))
                    - envelope.first_sample as f64;
                if !(at >= reach && at + reach < row.len() as f64) {
                    continue;
                }
                let (from, to) = ((at - reach) as usize, (at + reach) as usize + 1);
                envelope.pick(&self.part, m, from..to, &mut ridge);
            }
            ridge.without_still_parts()
        })
    }
}

fn median_step_s(time_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(1.0)
}

/// Envelopes within the window, one row a trace, and each row's median.
struct Envelope {
    rows: Vec<Vec<f64>>,
    median: Vec<f64>,
    first_sample: usize,
}

impl Envelope {
    /// The envelope `of` of both, `[traces, samples]` row-major with rows of `n` samples, within a window.
    fn new(both: &[[f64; 2]], of: usize, n: usize, [low, high]: [usize; 2]) -> Self {
        let (rows, median) = both
            .par_chunks_exact(n)
            .map(|row| {
                let row: Vec<f64> = row[low..=high].iter().map(|both| both[of]).collect();
                let mut sorted = row.clone();
                let middle = sorted.len() / 2;
                let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
                (row, median)
            })
            .unzip();
        Self {
            rows,
            median,
            first_sample: low,
        }
    }

    /// Logarithm of the largest envelope in each cell of fast time over the trace's median.
    fn gain(&self, cell: usize) -> Gain {
        let rows = self
            .rows
            .par_iter()
            .zip(&self.median)
            .map(|(row, median)| {
                row.chunks(cell)
                    .map(|c| {
                        let top = c.iter().copied().fold(0.0, f64::max);
                        let ratio = top / median.max(f64::MIN_POSITIVE);
                        ratio.clamp(1.0, f64::from(STRONGEST)).ln() as f32
                    })
                    .collect()
            })
            .collect();
        Gain { rows }
    }

    /// The largest peak of a trace's envelope about each cell of a path, where an echo is present.
    fn picks(&self, radargram: &Radargram, path: &[usize], cell: usize) -> Ridge {
        let mut ridge = Ridge::default();
        for (m, &at) in path.iter().enumerate() {
            let samples = self.rows[m].len();
            // The cell and its two neighbours.
            let from = (at * cell).saturating_sub(cell).min(samples - 1);
            let to = ((at + 2) * cell).clamp(from + 1, samples);
            self.pick(radargram, m, from..to, &mut ridge);
        }
        ridge
    }

    /// Adds the largest sample of a part of a trace's envelope to a ridge, to a fraction of a sample, where it is
    /// a peak of an echo that is present.
    fn pick(&self, radargram: &Radargram, m: usize, part: Range<usize>, ridge: &mut Ridge) {
        let row = &self.rows[m];
        let from = part.start;
        let top = part
            .max_by(|&a, &b| row[a].total_cmp(&row[b]))
            .unwrap_or(from);
        if row[top] < PRESENT * self.median[m] || top == 0 || top + 1 == row.len() {
            return;
        }
        let is_peak = row[top] >= row[top - 1] && row[top] >= row[top + 1];
        if !is_peak {
            return;
        }
        let (fraction, _) = crest(row, top);
        let sample = (self.first_sample + top) as f64 + fraction;
        ridge.time_s.push(radargram.time_s[m]);
        ridge.envelope.push(row[top]);
        ridge
            .fast_time_s
            .push(radargram.fast_time_start_s + sample * radargram.fast_time_step_s);
    }
}

impl Ridge {
    /// The ridge with every `stride`-th pick.
    pub(super) fn every(&self, stride: usize) -> Self {
        let some = |values: &[f64]| values.iter().copied().step_by(stride.max(1)).collect();
        Self {
            time_s: some(&self.time_s),
            fast_time_s: some(&self.fast_time_s),
            envelope: some(&self.envelope),
        }
    }

    /// Whether nine tenths of the picks of both ridges are of the same traces and within [`CELL_S`].
    fn is_nearly(&self, other: &Self) -> bool {
        const SHARE: f64 = 0.9;
        let of_other = |(time_s, fast_time_s): (&f64, &f64)| {
            let at = other
                .time_s
                .binary_search_by(|t| t.total_cmp(time_s))
                .ok()?;
            let is_near = (other.fast_time_s[at] - fast_time_s).abs() <= CELL_S;
            is_near.then_some(())
        };
        let picks = self.time_s.iter().zip(&self.fast_time_s);
        let same = picks.filter_map(of_other).count();
        same as f64 >= SHARE * self.time_s.len().max(other.time_s.len()) as f64
    }

    /// Drops the picks about which the echo is constant.
    fn without_still_parts(self) -> Self {
        let n = self.time_s.len();
        let (mut first, mut end) = (0, 0);
        let mut kept = Self {
            time_s: Vec::new(),
            fast_time_s: Vec::new(),
            envelope: Vec::new(),
        };
        for i in 0..n {
            let t = self.time_s[i];
            while self.time_s[first] < t - 0.5 * STILL_WINDOW_S {
                first += 1;
            }
            while end < n && self.time_s[end] <= t + 0.5 * STILL_WINDOW_S {
                end += 1;
            }
            let near = &self.fast_time_s[first..end];
            let mean = near.iter().sum::<f64>() / near.len() as f64;
            let power = near.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / near.len() as f64;
            if power.sqrt() > STILL_S {
                kept.time_s.push(t);
                kept.fast_time_s.push(self.fast_time_s[i]);
                kept.envelope.push(self.envelope[i]);
            }
        }
        kept
    }
}

/// Logarithmic gains, one row a trace, one value a cell of fast time.
struct Gain {
    rows: Vec<Vec<f32>>,
}

impl Gain {
    /// The gain relative to the median of each fast time over the traces: residues of coupling are removed,
    /// and so is an echo that is constant for half of the record.
    fn over_columns(&self) -> Self {
        let cells = self.rows.first().map_or(0, Vec::len);
        let floor: Vec<f32> = (0..cells)
            .into_par_iter()
            .map(|c| {
                let mut column: Vec<f32> = self.rows.iter().map(|row| row[c]).collect();
                let middle = column.len() / 2;
                *column.select_nth_unstable_by(middle, f32::total_cmp).1
            })
            .collect();
        let over = |row: &Vec<f32>| {
            row.iter()
                .zip(&floor)
                .map(|(gain, floor)| (gain - floor).max(0.0))
                .collect()
        };
        Self {
            rows: self.rows.iter().map(over).collect(),
        }
    }

    /// The gain, no more than a limit.
    fn limited(&self, most: f32) -> Self {
        let limit = |row: &Vec<f32>| row.iter().map(|gain| gain.min(most)).collect();
        Self {
            rows: self.rows.iter().map(limit).collect(),
        }
    }

    /// Removes the cells within `apart` cells of a path.
    fn clear_about(&mut self, path: &[usize], apart: usize) {
        for (row, &at) in self.rows.iter_mut().zip(path) {
            let end = (at + apart + 1).min(row.len());
            row[at.saturating_sub(apart)..end].fill(0.0);
        }
    }
}

/// Largest movement of a ridge from one trace to the next, in cells, and its cost.
#[derive(Clone, Copy)]
struct Climb {
    /// Largest number of cells, at most a hundred.
    reach: usize,
    cost_per_cell: f32,
}

impl Climb {
    fn new(cells: f64) -> Self {
        let usual = cells.max(1.0);
        Self {
            reach: ((REACH * usual).ceil() as usize + 1).min(100),
            cost_per_cell: (0.5 / usual) as f32,
        }
    }

    /// The best score within reach of each cell, less the cost of the jump from there.
    fn reached(&self, score: &[f32]) -> Vec<f32> {
        let cost = |cell: usize| self.cost_per_cell * cell as f32;
        // A jump upwards costs cost(to) − cost(from): the best jump to a cell has the largest score plus
        // cost(from). For jumps downwards the signs are exchanged.
        let upwards: Vec<f32> = (score.iter().enumerate())
            .map(|(cell, score)| score + cost(cell))
            .collect();
        let downwards: Vec<f32> = (score.iter().enumerate().rev())
            .map(|(cell, score)| score - cost(cell))
            .collect();
        let from_below = largest_of_last(upwards, self.reach + 1);
        let from_above = largest_of_last(downwards, self.reach + 1);
        (from_below.iter().zip(from_above.iter().rev()))
            .enumerate()
            .map(|(cell, (below, above))| larger(below - cost(cell), above + cost(cell)))
            .collect()
    }

    /// The previous cell of the best path to a cell; the lowest of equal ones.
    fn origin(&self, score: &[f32], cell: usize) -> usize {
        let first = cell.saturating_sub(self.reach);
        let last = (cell + self.reach).min(score.len().saturating_sub(1));
        let value = |from: usize| score[from] - self.cost_per_cell * from.abs_diff(cell) as f32;
        first_best((first..=last).map(|from| (from, value(from))))
    }
}

/// Running maximum over `count` values: each value and those before it.
fn largest_of_last(mut values: Vec<f32>, count: usize) -> Vec<f32> {
    let mut wider = values.clone();
    // The maximum over twice as many values is the larger of two maxima.
    let mut width = 1;
    while width < count.min(values.len()) {
        let step = width.min(count - width);
        let pairs = values[step..].iter().zip(&values);
        for (wider, (value, before)) in wider[step..].iter_mut().zip(pairs) {
            *wider = larger(*value, *before);
        }
        wider[..step].copy_from_slice(&values[..step]);
        std::mem::swap(&mut values, &mut wider);
        width += step;
    }
    values
}

/// The path with the largest sum of gains less the cost of its jumps.
fn follow(gain: &Gain, climb: Climb, control: Control<'_>) -> Result<Vec<usize>, AlignError> {
    // Best sum over the paths that end in each cell of each trace, less the best of the trace.
    let mut scores: Vec<Vec<f32>> = Vec::with_capacity(gain.rows.len());
    for (k, row) in gain.rows.iter().enumerate() {
        if k % 64 == 0 {
            control.check()?;
        }
        let mut score = scores
            .last()
            .map_or_else(|| vec![0.0; row.len()], |before| climb.reached(before));
        for (score, gain) in score.iter_mut().zip(row) {
            *score += gain;
        }
        let best = score.iter().copied().fold(f32::NEG_INFINITY, larger);
        for score in &mut score {
            *score -= best;
        }
        scores.push(score);
    }
    let mut path = vec![0; scores.len()];
    let mut after = None;
    for (score, at) in scores.iter().zip(&mut path).rev() {
        *at = after.map_or_else(
            || first_best(score.iter().copied().enumerate()),
            |cell| climb.origin(score, cell),
        );
        after = Some(*at);
    }
    Ok(path)
}

/// The first of the greatest values.
fn first_best(values: impl Iterator<Item = (usize, f32)>) -> usize {
    let better = |best: (usize, f32), one: (usize, f32)| if one.1 > best.1 { one } else { best };
    values.fold((0, f32::NEG_INFINITY), better).0
}

/// The larger of two numbers, neither of which is NaN; unlike [`f32::max`] a single instruction.
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_control::Control;

    /// Pseudorandom numbers from 0 to 1.
    fn noise(seed: u64) -> impl Iterator<Item = f32> {
        let mut state = seed;
        std::iter::repeat_with(move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f32 / (1u64 << 24) as f32
        })
    }

    #[test]
    fn the_path_is_the_best_of_all() {
        let climb = Climb {
            reach: 2,
            cost_per_cell: 0.21,
        };
        for seed in 0..12 {
            let mut numbers = noise(seed);
            let rows: Vec<Vec<f32>> = (0..6).map(|_| numbers.by_ref().take(7).collect()).collect();
            let sum = |path: &[usize]| {
                let jumps = path.windows(2).map(|w| w[0].abs_diff(w[1]) as f32);
                let gains = path.iter().zip(&rows).map(|(at, row)| row[*at]);
                gains.sum::<f32>() - climb.cost_per_cell * jumps.sum::<f32>()
            };
            let is_within_reach =
                |path: &[usize]| path.windows(2).all(|w| w[0].abs_diff(w[1]) <= 2);
            let all = (0..7usize.pow(6)).map(|code| {
                let cell = |k: u32| code / 7usize.pow(k) % 7;
                (0..6).map(cell).collect::<Vec<_>>()
            });
            let best = all
                .filter(|path| is_within_reach(path))
                .map(|path| sum(&path))
                .fold(f32::NEG_INFINITY, f32::max);
            let gain = Gain { rows: rows.clone() };
            let path = follow(&gain, climb, Control::default()).unwrap();
            assert!(is_within_reach(&path), "{path:?}");
            assert!((sum(&path) - best).abs() < 1e-5, "{} of {best}", sum(&path));
        }
    }

    #[test]
    fn the_largest_of_the_last_is_that_of_every_count() {
        let values: Vec<f32> = noise(3).take(40).collect();
        for count in [1, 2, 3, 5, 8, 13, 40, 60] {
            let found = largest_of_last(values.clone(), count);
            for (k, found) in found.iter().enumerate() {
                let from = (k + 1).saturating_sub(count);
                let largest = values[from..=k].iter().copied().fold(0.0, f32::max);
                assert!((found - largest).abs() < f32::EPSILON);
            }
        }
    }
}
