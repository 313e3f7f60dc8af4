//! One clock against another from stamps that arrive late by unknown, never negative delays.
//!
//! Delays have a density that does not vanish at the shortest: then the shortest of a block of pairs
//! exceeds it by an exponentially distributed amount, whose mean equals its deviation. A line through
//! the blocks' shortest delays, less that deviation, is the clock; the deviation over the root of the
//! number of blocks is its error. A delay common to all messages is not observable from stamps.

use thiserror::Error;

/// Pairs of stamps below which no clock is fitted.
pub const LEAST_PAIRS: usize = 16;
/// Pairs of a block, and blocks, aimed at.
const PAIRS_PER_BLOCK: usize = 10;
const MOST_BLOCKS: usize = 32;
/// Deviations above the line from which a block counts as held up throughout, as in a burst.
const HELD_UP: f64 = 6.0;
/// Resolution of a computer's stamps (s): no clock is known better.
const RESOLUTION_S: f64 = 1e-6;

/// One clock as a line over another, with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockLine {
    /// Reading of the one clock about which the line is stated (s): the middle of the pairs.
    pub at_s: f64,
    /// Reading of the other there (s).
    pub reads_s: f64,
    /// Seconds of the other in a second of the one.
    pub rate: f64,
    /// Standard deviation of [`ClockLine::reads_s`] (s).
    pub sigma_s: f64,
    /// Standard deviation of [`ClockLine::rate`].
    pub sigma_rate: f64,
    /// Median of the delays above the shortest (s).
    pub jitter_s: f64,
    /// Pairs used.
    pub pairs: usize,
    /// Blocks left out because every pair in them was held up.
    pub held_up_blocks: usize,
}

/// Reason why no clock can be fitted.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// Too few pairs.
    #[error("expected {LEAST_PAIRS} pairs of stamps at least, found {found}")]
    Pairs {
        /// Pairs there.
        found: usize,
    },
    /// The pairs span no time, or are no numbers.
    #[error("the pairs of stamps span no time")]
    Span,
}

/// A stamp of the one clock and the reading of the other when it arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// When it was sent, by the sender's clock (s).
    pub sent_s: f64,
    /// When it arrived, by the receiver's clock (s).
    pub arrived_s: f64,
}

impl ClockLine {
    /// The other clock's reading.
    #[must_use]
    pub fn reading_s(&self, at_s: f64) -> f64 {
        self.reads_s + self.rate * (at_s - self.at_s)
    }

    /// Standard deviation of that reading (s).
    #[must_use]
    pub fn sigma_at_s(&self, at_s: f64) -> f64 {
        self.sigma_s.hypot(self.sigma_rate * (at_s - self.at_s))
    }
}

/// The receiver's clock over the sender's, as if every delay were the shortest one.
///
/// # Errors
/// Too few pairs, pairs that span no time.
///
/// ```
/// use acerra_record::timing::{Pair, clock_line};
/// let pairs: Vec<Pair> = (0..600)
///     .map(|i| {
///         let sent_s = 0.1 * f64::from(i);
///         let late_s = 0.005 * f64::from(i * 7919 % 97) / 97.0;
///         Pair { sent_s, arrived_s: 12.0 + 1.000_02 * sent_s + late_s }
///     })
///     .collect();
/// let line = clock_line(&pairs)?;
/// assert!((line.reading_s(30.0) - (12.0 + 1.000_02 * 30.0)).abs() < 2e-4);
/// # Ok::<(), acerra_record::timing::FitError>(())
/// ```
pub fn clock_line(pairs: &[Pair]) -> Result<ClockLine, FitError> {
    let mut sorted: Vec<Pair> = pairs
        .iter()
        .copied()
        .filter(|p| p.sent_s.is_finite() && p.arrived_s.is_finite())
        .collect();
    if sorted.len() < LEAST_PAIRS {
        return Err(FitError::Pairs {
            found: sorted.len(),
        });
    }
    sorted.sort_by(|a, b| a.sent_s.total_cmp(&b.sent_s));
    let middle_s = sorted.iter().map(|p| p.sent_s).sum::<f64>() / sorted.len() as f64;
    let edge = lower_edge(&sorted, middle_s).ok_or(FitError::Span)?;
    let delays_s: Vec<f64> = sorted
        .iter()
        .map(|p| p.arrived_s - edge.at(p.sent_s))
        .collect();
    let blocks = shortest_of_blocks(&sorted, &delays_s);
    let shortest = through_blocks(&blocks, middle_s);
    let mut jitter_s: Vec<f64> = sorted
        .iter()
        .zip(&delays_s)
        .map(|(p, d)| d - shortest.at(p.sent_s))
        .collect();
    jitter_s.sort_by(f64::total_cmp);
    Ok(ClockLine {
        at_s: middle_s,
        reads_s: edge.at(middle_s) + shortest.value_s - shortest.deviation_s,
        rate: edge.slope + shortest.slope,
        sigma_s: (shortest.deviation_s / (shortest.kept as f64).sqrt()).max(RESOLUTION_S),
        sigma_rate: (shortest.deviation_s / shortest.spread_s)
            .max(RESOLUTION_S / shortest.spread_s),
        jitter_s: jitter_s[jitter_s.len() / 2] + shortest.deviation_s,
        pairs: sorted.len(),
        held_up_blocks: blocks.len() - shortest.kept,
    })
}

/// A line below all pairs.
struct Edge {
    x_s: f64,
    y_s: f64,
    slope: f64,
}

impl Edge {
    fn at(&self, x_s: f64) -> f64 {
        self.y_s + self.slope * (x_s - self.x_s)
    }
}

/// The edge of the pairs' lower convex hull below `middle_s`: of all lines that no pair lies below, the
/// one closest to the pairs on average (Moon, Skelly and Towsley 1999).
fn lower_edge(sorted: &[Pair], middle_s: f64) -> Option<Edge> {
    let mut hull: Vec<Pair> = Vec::new();
    for pair in sorted {
        let slope = |a: &Pair, b: &Pair| (b.arrived_s - a.arrived_s) / (b.sent_s - a.sent_s);
        if let Some(last) = hull.last()
            && last.sent_s == pair.sent_s
        {
            if last.arrived_s <= pair.arrived_s {
                continue;
            }
            hull.pop();
        }
        while let [.., a, b] = hull.as_slice() {
            if slope(a, b) < slope(b, pair) {
                break;
            }
            hull.pop();
        }
        hull.push(*pair);
    }
    let edge = hull
        .windows(2)
        .find(|edge| edge[1].sent_s >= middle_s)
        .or_else(|| hull.windows(2).last())?;
    let slope = (edge[1].arrived_s - edge[0].arrived_s) / (edge[1].sent_s - edge[0].sent_s);
    slope.is_finite().then_some(Edge {
        x_s: edge[0].sent_s,
        y_s: edge[0].arrived_s,
        slope,
    })
}

/// The shortest delay of a block of pairs, and when it was.
#[derive(Clone, Copy)]
struct Shortest {
    at_s: f64,
    delay_s: f64,
}

fn shortest_of_blocks(sorted: &[Pair], delays_s: &[f64]) -> Vec<Shortest> {
    let blocks = (sorted.len() / PAIRS_PER_BLOCK).clamp(4, MOST_BLOCKS);
    let size = sorted.len() / blocks;
    (0..blocks)
        .filter_map(|block| {
            (block * size..(block + 1) * size)
                .map(|i| Shortest {
                    at_s: sorted[i].sent_s,
                    delay_s: delays_s[i],
                })
                .min_by(|a, b| a.delay_s.total_cmp(&b.delay_s))
        })
        .collect()
}

/// A line through the blocks' shortest delays about `middle_s`.
struct Through {
    middle_s: f64,
    value_s: f64,
    slope: f64,
    /// Deviation of the blocks from the line (s).
    deviation_s: f64,
    /// Root of the sum of squares of the blocks' times about their mean (s).
    spread_s: f64,
    kept: usize,
}

impl Through {
    fn at(&self, x_s: f64) -> f64 {
        self.value_s + self.slope * (x_s - self.middle_s)
    }

    /// Least squares.
    fn fit(blocks: &[Shortest], middle_s: f64) -> Self {
        let n = blocks.len() as f64;
        let mean_x = blocks.iter().map(|b| b.at_s).sum::<f64>() / n;
        let mean_y = blocks.iter().map(|b| b.delay_s).sum::<f64>() / n;
        let sxx: f64 = blocks.iter().map(|b| (b.at_s - mean_x).powi(2)).sum();
        let sxy: f64 = blocks
            .iter()
            .map(|b| (b.at_s - mean_x) * (b.delay_s - mean_y))
            .sum();
        let slope = if sxx > 0.0 { sxy / sxx } else { 0.0 };
        let line = Self {
            middle_s,
            value_s: mean_y + slope * (middle_s - mean_x),
            slope,
            deviation_s: 0.0,
            spread_s: sxx.sqrt().max(f64::MIN_POSITIVE),
            kept: blocks.len(),
        };
        let squares: f64 = blocks
            .iter()
            .map(|b| (b.delay_s - line.at(b.at_s)).powi(2))
            .sum();
        Self {
            deviation_s: (squares / (n - 2.0).max(1.0)).sqrt(),
            ..line
        }
    }
}

/// The line through all blocks but those that were held up throughout.
fn through_blocks(blocks: &[Shortest], middle_s: f64) -> Through {
    let mut kept = blocks.to_vec();
    loop {
        let line = Through::fit(&kept, middle_s);
        let excess = |b: &Shortest| b.delay_s - line.at(b.at_s);
        let mut sizes: Vec<f64> = kept.iter().map(|b| excess(b).abs()).collect();
        sizes.sort_by(f64::total_cmp);
        // For an exponential distribution the deviation is twice the median distance from the mean.
        let usual_s = 2.0 * sizes[sizes.len() / 2];
        let sound: Vec<Shortest> = kept
            .iter()
            .copied()
            .filter(|b| excess(b) <= HELD_UP * usual_s.max(RESOLUTION_S))
            .collect();
        if sound.len() == kept.len() || sound.len() < 4 {
            return line;
        }
        kept = sound;
    }
}
