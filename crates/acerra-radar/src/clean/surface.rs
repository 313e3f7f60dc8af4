//! Finding the surface echo in a raw radargram, given the height of each trace.
//!
//! The logarithms of the envelopes are stacked along 2h/c plus a trial delay. The highest peak of the stack
//! gives the delay of the surface, since the surface is seen in every trace, a reflector in some. Coupling
//! and its tail are constant while the height changes: where the height changes at all, the stack is formed
//! of the traces without their constant part, and of the whole traces where these show no surface. About that
//! delay the echo is then followed from trace to trace by dynamic programming, which trades the envelope
//! against jumps, and refined to a fraction of a sample.

use super::background::{Background, median_of, remove_background};
use super::envelope::envelope_in_band;
use super::{CleanError, check_heights};
use crate::constants::two_way_delay_s;
use crate::radargram::Radargram;
use std::collections::VecDeque;

/// Contrast of the stack that counts as an echo, dB. A stack of noise alone stays below 2 dB.
const NEEDED_DB: f64 = 3.0;
/// Least length of the stack whose median is the level without an echo, s: ten times the length of an echo.
const LEVEL_S: f64 = 6e-9;
/// Spread of 2h/c above which the constant part can be subtracted without removing the surface: a quarter of
/// a period at 4 GHz.
const MOVES_S: f64 = 0.06e-9;

/// Search interval of the surface echo.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SurfaceOptions {
    /// Approximate fast time at which range is zero, if known, s.
    pub approximate_delay_s: Option<f64>,
    /// Largest distance of the true delay from the approximate one, s.
    pub search_s: f64,
    /// Range of delays tried without an approximate delay, s.
    pub unknown_delay_s: [f64; 2],
    /// Largest distance of the echo from 2h/c plus the delay found, s.
    pub follow_s: f64,
    /// Band of the pulse, Hz: noise outside the band is filtered out. `None` keeps all frequencies.
    pub band_hz: Option<[f64; 2]>,
}

impl Default for SurfaceOptions {
    /// Delays of −1 to 20 ns (of antenna cables and of the radio), distances of 1.5 ns (22 cm).
    fn default() -> Self {
        Self {
            approximate_delay_s: None,
            search_s: 3e-9,
            unknown_delay_s: [-1e-9, 20e-9],
            follow_s: 1.5e-9,
            band_hz: None,
        }
    }
}

impl SurfaceOptions {
    /// This search about an approximate delay, s.
    #[must_use]
    pub const fn with_approximate_delay_s(mut self, approximate_delay_s: f64) -> Self {
        self.approximate_delay_s = Some(approximate_delay_s);
        self
    }

    /// This search with another largest distance of the true delay from the approximate one, s.
    #[must_use]
    pub const fn with_search_s(mut self, search_s: f64) -> Self {
        self.search_s = search_s;
        self
    }

    /// This search with another largest distance of the echo from 2h/c, s.
    #[must_use]
    pub const fn with_follow_s(mut self, follow_s: f64) -> Self {
        self.follow_s = follow_s;
        self
    }

    /// This search with the band of the pulse, Hz.
    #[must_use]
    pub const fn with_band_hz(mut self, band_hz: [f64; 2]) -> Self {
        self.band_hz = Some(band_hz);
        self
    }
}

/// The surface echo in one trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePick {
    /// Fast time of the envelope's peak, s.
    pub fast_time_s: f64,
    /// Height of the envelope's peak, in samples' units.
    pub level: f64,
}

/// The surface echo over all traces.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceTrack {
    /// Fast time at which range is zero, by the stack over all traces, s.
    pub delay_s: f64,
    /// Contrast of the stack: its peak above its median, dB.
    pub contrast_db: f64,
    /// Echo of each trace; `None` where the height is unknown or 2h/c is outside the window.
    pub picks: Vec<Option<SurfacePick>>,
}

/// Follows the surface echo through a radargram whose fast time need not be zero-timed.
///
/// # Errors
/// If there is not one height a trace, the window does not reach the surface, or no echo that follows the
/// height is clear.
pub fn track_surface(
    radargram: &Radargram,
    height_m: &[f64],
    options: &SurfaceOptions,
) -> Result<SurfaceTrack, CleanError> {
    check_heights(radargram.traces, height_m)?;
    let surface_s: Vec<f64> = height_m
        .iter()
        .map(|&h| {
            if h.is_finite() && h > 0.0 {
                two_way_delay_s(h)
            } else {
                f64::NAN
            }
        })
        .collect();
    // Traces without their constant part are free of the coupling; where the surface is absent from them, the
    // whole traces are used.
    let found_in = |part: &Radargram| {
        let envelope = envelope_in_band(part, options.band_hz);
        let section = Section {
            radargram,
            envelope: &envelope,
            surface_s: &surface_s,
        };
        let (delay_s, contrast_db) = section.stack(options)?;
        if contrast_db < NEEDED_DB {
            return Err(CleanError::NoSurface {
                contrast_db,
                needed_db: NEEDED_DB,
            });
        }
        Ok((delay_s, contrast_db, envelope))
    };
    let (delay_s, contrast_db, envelope) = match changing(radargram, &surface_s) {
        Some(changing) => found_in(&changing).or_else(|_| found_in(radargram)),
        None => found_in(radargram),
    }?;
    let section = Section {
        radargram,
        envelope: &envelope,
        surface_s: &surface_s,
    };
    Ok(SurfaceTrack {
        delay_s,
        contrast_db,
        picks: section.follow(delay_s, options.follow_s),
    })
}

/// Crests of the envelopes of whole traces at the picks of an echo. Picks may come from traces without their
/// constant part, and are then shifted by the subtraction. None where the crest is farther than `within_s`
/// from the pick.
#[must_use]
pub fn crests_near(
    radargram: &Radargram,
    track: &SurfaceTrack,
    within_s: f64,
) -> Vec<Option<SurfacePick>> {
    let envelope = envelope_in_band(radargram, None);
    let section = Section {
        radargram,
        envelope: &envelope,
        surface_s: &[],
    };
    let crest = |(trace, pick): (usize, &Option<SurfacePick>)| {
        let near_s = pick.as_ref()?.fast_time_s;
        let crest = section.refine(trace, near_s);
        ((crest.fast_time_s - near_s).abs() <= within_s).then_some(crest)
    };
    track.picks.iter().enumerate().map(crest).collect()
}

/// Traces without their constant part, where the height changes enough to keep the surface.
fn changing(radargram: &Radargram, surface_s: &[f64]) -> Option<Radargram> {
    let known: Vec<f64> = surface_s
        .iter()
        .copied()
        .filter(|t| t.is_finite())
        .collect();
    let count = known.len().max(1) as f64;
    let mean = known.iter().sum::<f64>() / count;
    let spread = (known.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / count).sqrt();
    if spread <= MOVES_S {
        return None;
    }
    remove_background(radargram.clone(), Background::Mean).ok()
}

/// Envelopes with the curve along which they are stacked.
struct Section<'a> {
    radargram: &'a Radargram,
    envelope: &'a [f64],
    surface_s: &'a [f64],
}

impl Section<'_> {
    fn row(&self, trace: usize) -> &[f64] {
        let n = self.radargram.samples_per_trace;
        &self.envelope[trace * n..(trace + 1) * n]
    }

    /// Envelope of a trace at a fast time, by linear interpolation; `None` outside the window.
    fn at(&self, trace: usize, fast_time_s: f64) -> Option<f64> {
        let x = self.radargram.sample_index(fast_time_s);
        if !(x >= 0.0 && x <= (self.radargram.samples_per_trace - 1) as f64) {
            return None;
        }
        let (row, i) = (self.row(trace), x as usize);
        let next = row.get(i + 1).copied().unwrap_or(row[i]);
        Some(row[i] + (x - i as f64) * (next - row[i]))
    }

    /// Delay of the highest stack along 2h/c, and its contrast in dB.
    fn stack(&self, options: &SurfaceOptions) -> Result<(f64, f64), CleanError> {
        let searched = match options.approximate_delay_s {
            Some(d) => [d - options.search_s, d + options.search_s],
            None => options.unknown_delay_s,
        };
        // The level without an echo is that about the delays searched, however few these are.
        let about_s = 0.5 * (LEVEL_S - (searched[1] - searched[0])).max(0.0);
        let [from, to] = [searched[0] - about_s, searched[1] + about_s];
        let step = self.radargram.fast_time_step_s;
        let trials = ((to - from) / step).ceil().max(1.0) as usize + 1;
        // A delay counts where the window holds it in at least half of the traces.
        let known = self.surface_s.iter().filter(|t| t.is_finite()).count();
        let mut stack: Vec<Stacked> = Vec::with_capacity(trials.min(1 << 20));
        for k in 0..trials.min(1 << 20) {
            let delay_s = from + k as f64 * step;
            let values =
                (self.surface_s.iter().enumerate()).filter_map(|(m, t)| self.at(m, t + delay_s));
            let (sum, logs, count) = values.fold((0.0, 0.0, 0), |(sum, logs, count), v| {
                (sum + v, logs + v.max(f64::MIN_POSITIVE).ln(), count + 1)
            });
            if count > 0 && 2 * count >= known {
                stack.push(Stacked {
                    delay_s,
                    mean: sum / count as f64,
                    log_mean: logs / count as f64,
                });
            }
        }
        if stack.len() < 3 {
            let finite = || self.surface_s.iter().copied().filter(|t| t.is_finite());
            return Err(CleanError::SurfaceOutside {
                window_start_s: self.radargram.fast_time_start_s,
                window_end_s: self.radargram.fast_time_end_s(),
                expected_start_s: finite().fold(f64::INFINITY, f64::min) + searched[0],
                expected_end_s: finite().fold(f64::NEG_INFINITY, f64::max) + searched[1],
            });
        }
        let is_searched = |k: usize| (searched[0]..=searched[1]).contains(&stack[k].delay_s);
        let means: Vec<f64> = stack.iter().map(|s| s.mean).collect();
        let log_means: Vec<f64> = stack.iter().map(|s| s.log_mean).collect();
        let median = median_of(&mut means.clone()).max(f64::MIN_POSITIVE);
        let contrast_db = |peak: usize| 20.0 * (means[peak] / median).log10();
        // The ground is seen in every trace, a reflector in some: the ground's echo is the highest peak of
        // the logarithms, which a strong echo in a few traces does not raise. Where the ground itself is seen
        // in few traces, its echo is the highest peak of the sum.
        let delay = |levels: &[f64]| {
            let peak = highest_peak(levels, is_searched)?;
            let delay_s = stack[peak].delay_s + step * peak_offset(levels, peak);
            Some((delay_s, contrast_db(peak)))
        };
        delay(&log_means)
            .filter(|(_, contrast_db)| *contrast_db >= NEEDED_DB)
            .or_else(|| delay(&means))
            .ok_or(CleanError::NoSurface {
                contrast_db: 0.0,
                needed_db: NEEDED_DB,
            })
    }

    /// Follows the echo within `follow_s` of 2h/c + `delay_s` (Viterbi).
    fn follow(&self, delay_s: f64, follow_s: f64) -> Vec<Option<SurfacePick>> {
        let step = self.radargram.fast_time_step_s;
        let half = (follow_s / step).round().max(1.0) as usize;
        let states = 2 * half + 1;
        let offset = |state: usize| (state as f64 - half as f64) * step;
        let traces: Vec<usize> = (0..self.radargram.traces)
            .filter(|&m| self.at(m, self.surface_s[m] + delay_s).is_some())
            .collect();
        // Log of the envelope relative to its largest value in the strip: independent of the echo's strength.
        // A jump costs as much as a loss to 1/e for every 0.1 ns.
        let jump_cost = step / 0.1e-9;
        let reach = ((0.5e-9 / step).ceil() as usize).max(1);
        let mut score = vec![0.0; states];
        let mut from: Vec<Vec<u32>> = Vec::with_capacity(traces.len());
        for (k, &m) in traces.iter().enumerate() {
            let centre = self.surface_s[m] + delay_s;
            let strip: Vec<f64> = (0..states)
                .map(|s| self.at(m, centre + offset(s)).unwrap_or(0.0))
                .collect();
            let top = strip.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
            let before = match k {
                0 => (0..states).collect(),
                _ => best_before(&score, reach, jump_cost),
            };
            let gain = |s: usize| (strip[s] / top).max(1e-4).ln();
            score = (before.iter().enumerate())
                .map(|(s, &p)| score[p] - jump_cost * p.abs_diff(s) as f64 + gain(s))
                .collect();
            from.push(before.into_iter().map(|p| p as u32).collect());
        }
        let mut picks = vec![None; self.radargram.traces];
        let mut state = (0..states)
            .max_by(|&a, &b| score[a].total_cmp(&score[b]))
            .unwrap_or(half);
        for (&m, back) in traces.iter().zip(&from).rev() {
            let fast_time_s = self.surface_s[m] + delay_s + offset(state);
            picks[m] = Some(self.refine(m, fast_time_s));
            state = back[state] as usize;
        }
        picks
    }

    /// The envelope's nearest peak, to a fraction of a sample.
    fn refine(&self, trace: usize, fast_time_s: f64) -> SurfacePick {
        let row = self.row(trace);
        let last = row.len() - 1;
        let mut i = self
            .radargram
            .sample_index(fast_time_s)
            .round()
            .clamp(0.0, last as f64) as usize;
        while i < last && row[i + 1] > row[i] {
            i += 1;
        }
        while i > 0 && row[i - 1] > row[i] {
            i -= 1;
        }
        let (fraction, level) = crest(row, i);
        let fast_time_s = self.radargram.fast_time_start_s
            + (i as f64 + fraction) * self.radargram.fast_time_step_s;
        SurfacePick { fast_time_s, level }
    }
}

/// The best state before every state: that of the largest score less `jump_cost` for each state between both, at most
/// `reach` states away.
fn best_before(score: &[f64], reach: usize, jump_cost: f64) -> Vec<usize> {
    let last = score.len().saturating_sub(1);
    let key = |slope: f64| move |p: usize| score[p] + slope * p as f64;
    let lower = window_maxima(
        score.len(),
        |s| [s.saturating_sub(reach), s],
        key(jump_cost),
    );
    let upper = window_maxima(score.len(), |s| [s, (s + reach).min(last)], key(-jump_cost));
    let value = |p: usize, s: usize| score[p] - jump_cost * p.abs_diff(s) as f64;
    (lower.into_iter().zip(upper).enumerate())
        .map(|(s, (a, b))| if value(a, s) > value(b, s) { a } else { b })
        .collect()
}

/// The index of the largest key in the window of each of `count` places, the last of equal ones. First and last index
/// of the windows never decrease.
fn window_maxima(
    count: usize,
    window: impl Fn(usize) -> [usize; 2],
    key: impl Fn(usize) -> f64,
) -> Vec<usize> {
    // Indices that may become the maximum: their keys decrease.
    let mut candidates = VecDeque::new();
    let mut next = 0;
    let maximum = |place: usize| {
        let [first, last] = window(place);
        while next <= last {
            while candidates.back().is_some_and(|&p| key(p) <= key(next)) {
                candidates.pop_back();
            }
            candidates.push_back(next);
            next += 1;
        }
        while candidates.front().is_some_and(|&p| p < first) {
            candidates.pop_front();
        }
        candidates.front().copied().unwrap_or(last)
    };
    (0..count).map(maximum).collect()
}

/// Envelopes along 2h/c and a trial delay.
struct Stacked {
    delay_s: f64,
    /// Mean over the traces.
    mean: f64,
    /// Mean of their logarithms.
    log_mean: f64,
}

/// The highest value that is searched and a peak, not the flank of a peak outside the range.
fn highest_peak(levels: &[f64], is_searched: impl Fn(usize) -> bool) -> Option<usize> {
    (1..levels.len() - 1)
        .filter(|i| is_searched(*i))
        .filter(|&i| levels[i] >= levels[i - 1] && levels[i] >= levels[i + 1])
        .max_by(|&a, &b| levels[a].total_cmp(&levels[b]))
}

/// Vertex of the parabola through three neighbours, in samples from `i`.
fn peak_offset(values: &[f64], i: usize) -> f64 {
    let (Some(b), Some(&after)) = (i.checked_sub(1), values.get(i + 1)) else {
        return 0.0;
    };
    let (before, at) = (values[b], values[i]);
    let curvature = before - 2.0 * at + after;
    if curvature < 0.0 {
        (0.5 * (before - after) / curvature).clamp(-0.5, 0.5)
    } else {
        0.0
    }
}

/// Vertex of the least-squares parabola through the upper third of a peak: its place in samples from `i`, and
/// its height. Many samples enter the fit, so that noise on one sample has little effect.
pub(crate) fn crest(values: &[f64], i: usize) -> (f64, f64) {
    const REACH: usize = 64;
    let floor = values[i] * 2.0 / 3.0;
    let above = |v: &&f64| **v >= floor;
    let left = values[..i]
        .iter()
        .rev()
        .take(REACH)
        .take_while(above)
        .count();
    let right = values[i + 1..].iter().take(REACH).take_while(above).count();
    // Symmetric about the peak, so that a neighbouring echo on one side does not shift the vertex.
    let reach = left.min(right);
    if reach < 2 {
        let fraction = peak_offset(values, i);
        return (fraction, values[i]);
    }
    let (mut s2, mut s4, mut y0, mut y1, mut y2) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (k, y) in values[i - reach..=i + reach].iter().enumerate() {
        let x = k as f64 - reach as f64;
        s2 += x * x;
        s4 += x.powi(4);
        y0 += y;
        y1 += x * y;
        y2 += x * x * y;
    }
    let n = (2 * reach + 1) as f64;
    let curvature = (n * y2 - s2 * y0) / (n * s4 - s2 * s2);
    let slope = y1 / s2;
    if curvature >= 0.0 {
        return (0.0, values[i]);
    }
    let fraction = (-0.5 * slope / curvature).clamp(-1.0, 1.0);
    let constant = (y0 - curvature * s2) / n;
    (fraction, constant + 0.5 * slope * fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_state_before_is_found_as_by_trying_all() {
        let score: Vec<f64> = (0..57)
            .map(|k| 3.0 * (0.9 * k as f64).sin() + (0.13 * (k * k) as f64).cos())
            .collect();
        for (reach, jump_cost) in [(1, 0.2), (4, 0.05), (90, 0.4), (12, 0.0)] {
            for (s, found) in best_before(&score, reach, jump_cost)
                .into_iter()
                .enumerate()
            {
                let value = |p: usize| score[p] - jump_cost * p.abs_diff(s) as f64;
                let expected = (s.saturating_sub(reach)..(s + reach + 1).min(score.len()))
                    .max_by(|a, b| value(*a).total_cmp(&value(*b)))
                    .unwrap();
                assert_eq!(found, expected, "{s} of {reach}");
            }
        }
    }
}
