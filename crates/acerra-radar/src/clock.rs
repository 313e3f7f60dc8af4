//! Reconstruction of the radio's even clock from time stamps in whole milliseconds.
//!
//! The radio starts scans evenly but stamps them in whole milliseconds, so neighbouring stamps differ by 21
//! or 22 ms where the interval is 21.573 ms. Scans are numbered (by the radio's own running number where it
//! counts scans, else by the stamps), a line is fitted through the stamps over those numbers, and the line
//! gives the times. Lost scans are whole multiples of the interval; a pause, or any other departure of the
//! stamps from the line, begins a new stretch with a separate line. Where no such lines fit, the stamps
//! themselves are kept and the report states it.

/// Spread of the error by rounding to whole milliseconds, ms.
const QUANTISATION_RMS_MS: f64 = 0.288_675_134_594_812_9;
/// Largest distance of a stamp from its line, ms: half a millisecond of rounding and as much again for the
/// radio's delay in stamping.
const TOLERANCE_MS: f64 = 1.0;
/// Scans that a stretch needs for its own interval.
const OWN_INTERVAL: usize = 32;
/// Fewer scans than this to a stretch, on average, and the clock is not even.
const EVEN_STRETCH: usize = 16;

/// Source of the times of traces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClockBasis {
    /// An even clock recovered from the radio's stamps.
    EvenRadioClock,
    /// The radio's stamps as they are (whole milliseconds): intervals are uneven.
    RadioStamps,
    /// The logging computer's clock: the radio's stamps do not advance.
    HostClock,
    /// The trace's number, in seconds: without any clock.
    TraceNumber,
}

/// Numbering of the scans.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbering {
    /// By the radio's running number.
    MessageId,
    /// By time stamps, in multiples of the usual interval.
    TimeStamps,
}

/// Scans without a break on one even line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockStretch {
    /// Index of its first scan.
    pub first: usize,
    /// Number of scans.
    pub scans: usize,
    /// Interval between scans, s.
    pub interval_s: f64,
}

/// Times of scans, and how they were found.
#[derive(Debug, Clone, PartialEq)]
pub struct RadioClock {
    /// Time of each scan after the first one, s.
    pub time_s: Vec<f64>,
    /// Source of the times.
    pub basis: ClockBasis,
    /// Numbering of the scans.
    pub numbering: Numbering,
    /// Interval between scans, s (of the longest stretch; the median where intervals are uneven).
    pub interval_s: f64,
    /// Stretches on one line each; empty where the clock is not even.
    pub stretches: Vec<ClockStretch>,
    /// Scans that the radio made but the log does not hold (inside stretches).
    pub lost_scans: u64,
    /// Root mean square of stamps less recovered times, s. Rounding alone gives 0.289 ms.
    pub residual_rms_s: f64,
    /// Largest such difference, s. Rounding alone gives 0.5 ms.
    pub residual_max_s: f64,
    /// Number of stamps off a line that fits the stamps before and after.
    pub stray_stamps: usize,
    /// Whether the radio's millisecond counter passed 2³².
    pub wrapped: bool,
}

/// Recovers scan times from the radio's running numbers and millisecond stamps, which must not run
/// backwards (but may wrap).
///
/// ```
/// let ids: Vec<u16> = (0..200).collect();
/// let stamps: Vec<u32> = (0..200).map(|i| (5000.0 + 21.573 * f64::from(i)) as u32).collect();
/// let clock = acerra_radar::recover_clock(&ids, &stamps);
/// assert!((clock.interval_s - 21.573e-3).abs() < 1e-6);
/// assert!((clock.time_s[150] - 150.0 * 21.573e-3).abs() < 0.2e-3);
/// ```
///
/// # Panics
/// If the slices differ in length.
#[must_use]
pub fn recover_clock(message_ids: &[u16], timestamps_ms: &[u32]) -> RadioClock {
    assert_eq!(message_ids.len(), timestamps_ms.len(), "one stamp a scan");
    let (stamps, wrapped) = unwrap_stamps(timestamps_ms);
    let (numbers, numbering) = number_scans(message_ids, &stamps);
    let median_ms = median_interval(&numbers, &stamps);
    let uneven = |basis| {
        let time_s = stamps.iter().map(|s| (s - stamps[0]) * 1e-3).collect();
        RadioClock {
            time_s,
            basis,
            numbering,
            interval_s: median_ms * 1e-3,
            stretches: Vec::new(),
            lost_scans: 0,
            residual_rms_s: 0.0,
            residual_max_s: 0.0,
            stray_stamps: 0,
            wrapped,
        }
    };
    if stamps.len() < 3 || median_ms <= 0.0 {
        return uneven(ClockBasis::RadioStamps);
    }
    let (stretches, strays) = stretches(&numbers, &stamps, median_ms);
    if stretches.len() > 1 && stamps.len() / stretches.len() < EVEN_STRETCH {
        return uneven(ClockBasis::RadioStamps);
    }
    Stamped {
        numbers: &numbers,
        stamps: &stamps,
        strays: &strays,
        median_ms,
    }
    .even_clock(&stretches, numbering, wrapped)
}

/// Stamps as a rising count, ms, beyond the wrap at 2³².
fn unwrap_stamps(timestamps_ms: &[u32]) -> (Vec<f64>, bool) {
    let mut high = 0u64;
    let mut wrapped = false;
    let mut last = 0u32;
    let stamps = timestamps_ms
        .iter()
        .map(|&t| {
            if t < last && last - t > u32::MAX / 2 {
                high += 1 << 32;
                wrapped = true;
            }
            last = t;
            (high + u64::from(t)) as f64
        })
        .collect();
    (stamps, wrapped)
}

/// Running number of each scan from the first, lost scans counted.
fn number_scans(ids: &[u16], stamps: &[f64]) -> (Vec<f64>, Numbering) {
    let steps: Vec<u16> = ids.windows(2).map(|w| w[1].wrapping_sub(w[0])).collect();
    let ones = steps.iter().filter(|&&s| s == 1).count();
    let intervals: Vec<f64> = stamps.windows(2).map(|w| w[1] - w[0]).collect();
    let by_id = ones > 0 && 2 * ones >= steps.len();
    let usual = if by_id {
        median(
            steps
                .iter()
                .zip(&intervals)
                .filter(|(s, _)| **s == 1)
                .map(|(_, d)| *d)
                .collect(),
        )
    } else {
        pooled_interval(&intervals)
    };
    let mut number = 0.0;
    let mut numbers = vec![0.0];
    for (&step, &interval) in steps.iter().zip(&intervals) {
        let by_stamp = if usual > 0.0 {
            (interval / usual).round()
        } else {
            1.0
        };
        number += if by_id {
            let step = f64::from(step);
            // More than 65 536 lost scans leave whole turns of the counter that only the stamps show.
            step + (((by_stamp - step) / 65_536.0).round() * 65_536.0).max(0.0)
        } else {
            by_stamp.max(1.0)
        };
        numbers.push(number);
    }
    numbers.truncate(ids.len());
    (
        numbers,
        if by_id {
            Numbering::MessageId
        } else {
            Numbering::TimeStamps
        },
    )
}

/// Usual interval from intervals alone, ms: more precise than any single interval, so that the number of
/// scans lost in a long gap can be determined.
fn pooled_interval(intervals: &[f64]) -> f64 {
    /// Multiples that the first estimate of the interval determines uniquely.
    const NEAR: f64 = 6.0;
    let middle = median(intervals.to_vec());
    let single = intervals.iter().filter(|d| (**d - middle).abs() <= 1.0);
    let guess = single.clone().sum::<f64>() / single.count().max(1) as f64;
    if guess <= 0.0 {
        return guess;
    }
    // One slope shared by all stretches between long gaps.
    let (mut sxy, mut sxx) = (0.0, 0.0);
    let mut line = Line::default();
    let (mut x, mut y) = (0.0, 0.0);
    line.add(x, y);
    let mut close = |line: &Line| {
        sxy += line.sxy - line.sx * line.sy / line.n;
        sxx += line.spread();
    };
    for interval in intervals {
        let multiple = (interval / guess).round();
        if multiple > NEAR {
            close(&line);
            line = Line::default();
        }
        (x, y) = (x + multiple, y + interval);
        line.add(x, y);
    }
    close(&line);
    if sxx > 0.0 { sxy / sxx } else { guess }
}

fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 {
        values[middle]
    } else {
        (values[middle - 1] + values[middle]) / 2.0
    }
}

fn median_interval(numbers: &[f64], stamps: &[f64]) -> f64 {
    median(
        numbers
            .windows(2)
            .zip(stamps.windows(2))
            .filter(|(n, _)| n[1] > n[0])
            .map(|(n, s)| (s[1] - s[0]) / (n[1] - n[0]))
            .collect(),
    )
}

/// A least-squares line of stamps over numbers, updated point by point about a fixed origin.
#[derive(Clone, Copy, Default)]
struct Line {
    n: f64,
    x0: f64,
    y0: f64,
    sx: f64,
    sy: f64,
    sxx: f64,
    sxy: f64,
}

impl Line {
    fn add(&mut self, x: f64, y: f64) {
        if self.n == 0.0 {
            (self.x0, self.y0) = (x, y);
        }
        let (x, y) = (x - self.x0, y - self.y0);
        self.n += 1.0;
        self.sx += x;
        self.sy += y;
        self.sxx += x * x;
        self.sxy += x * y;
    }

    fn with(mut self, x: f64, y: f64) -> Self {
        self.add(x, y);
        self
    }

    fn through(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        points
            .into_iter()
            .fold(Self::default(), |mut line, (x, y)| {
                line.add(x, y);
                line
            })
    }

    fn spread(&self) -> f64 {
        self.sxx - self.sx * self.sx / self.n
    }

    /// Slope, or `fallback` while the points do not determine a reliable one.
    fn slope(&self, fallback: f64) -> f64 {
        let spread = self.spread();
        if self.n >= 3.0 && spread > 0.0 {
            (self.sxy - self.sx * self.sy / self.n) / spread
        } else {
            fallback
        }
    }

    fn at(&self, x: f64, slope: f64) -> f64 {
        self.y0 + self.sy / self.n + slope * (x - self.x0 - self.sx / self.n)
    }

    /// Standard deviation of the line's value at `x`, ms.
    fn uncertainty(&self, x: f64, fallback_slope_error: f64) -> f64 {
        let away = x - self.x0 - self.sx / self.n;
        let slope_variance = if self.n >= 3.0 && self.spread() > 0.0 {
            (QUANTISATION_RMS_MS.powi(2) / self.spread()).min(fallback_slope_error.powi(2))
        } else {
            fallback_slope_error.powi(2)
        };
        (QUANTISATION_RMS_MS.powi(2) / self.n + slope_variance * away * away).sqrt()
    }
}

/// Splits scans into stretches on one line each, `[first, end)`, and marks stray stamps.
fn stretches(numbers: &[f64], stamps: &[f64], median_ms: f64) -> (Vec<[usize; 2]>, Vec<bool>) {
    let mut pieces: Vec<[usize; 2]> = Vec::new();
    let mut line = Line::default();
    let mut first = 0;
    for (i, (&x, &y)) in numbers.iter().zip(stamps).enumerate() {
        if line.n > 0.0 {
            let expected = line.at(x, line.slope(median_ms));
            let slack = TOLERANCE_MS + 4.0 * line.uncertainty(x, 1.0);
            if (y - expected).abs() > slack {
                pieces.push([first, i]);
                (first, line) = (i, Line::default());
            }
        }
        line.add(x, y);
    }
    pieces.push([first, numbers.len()]);
    let mut strays = vec![false; numbers.len()];
    let merged = merge(&pieces, numbers, stamps, median_ms, &mut strays);
    (merged, strays)
}

/// Joins pieces that one line fits, over up to three stray stamps between them.
fn merge(
    pieces: &[[usize; 2]],
    numbers: &[f64],
    stamps: &[f64],
    median_ms: f64,
    strays: &mut [bool],
) -> Vec<[usize; 2]> {
    /// Points of a long stretch that a longer line is checked against.
    const CHECKED: usize = 512;
    let point = |i: usize| (numbers[i], stamps[i]);
    let mut merged: Vec<[usize; 2]> = Vec::new();
    let mut line = Line::default();
    let mut k = 0;
    while k < pieces.len() {
        let joined = merged.last().and_then(|&[first, end]| {
            let stride = (end - first).div_ceil(CHECKED);
            (k..pieces.len())
                .take_while(|&j| pieces[j][0] - pieces[k][0] <= 3)
                .map(|j| {
                    let longer = (pieces[j][0]..pieces[j][1]).map(point);
                    (j, longer.fold(line, |line, (x, y)| line.with(x, y)))
                })
                .find(|(j, line)| {
                    let slope = line.slope(median_ms);
                    (first..end)
                        .step_by(stride)
                        .filter(|&i| !strays[i])
                        .chain(pieces[*j][0]..pieces[*j][1])
                        .map(point)
                        .all(|(x, y)| (y - line.at(x, slope)).abs() <= TOLERANCE_MS)
                })
        });
        match (joined, merged.last_mut()) {
            (Some((j, longer)), Some(last)) => {
                strays[pieces[k][0]..pieces[j][0]].fill(true);
                last[1] = pieces[j][1];
                line = longer;
                k = j + 1;
            }
            _ => {
                merged.push(pieces[k]);
                line = Line::through((pieces[k][0]..pieces[k][1]).map(point));
                k += 1;
            }
        }
    }
    merged
}

/// Scans with their numbers and unwrapped stamps.
struct Stamped<'a> {
    numbers: &'a [f64],
    /// Radio time, ms.
    stamps: &'a [f64],
    /// Number of stamps outside every stretch of even clock.
    strays: &'a [bool],
    median_ms: f64,
}

impl Stamped<'_> {
    /// Times on a straight line through each piece's stamps, `[first, end)`.
    fn even_clock(&self, pieces: &[[usize; 2]], numbering: Numbering, wrapped: bool) -> RadioClock {
        let Self {
            numbers,
            stamps,
            strays,
            median_ms,
        } = *self;
        let line_of = |[first, end]: [usize; 2]| {
            Line::through(
                (first..end)
                    .filter(|&i| !strays[i])
                    .map(|i| (numbers[i], stamps[i])),
            )
        };
        let longest = pieces
            .iter()
            .copied()
            .max_by_key(|p| p[1] - p[0])
            .unwrap_or([0, 0]);
        let shared_ms = line_of(longest).slope(median_ms);
        let mut time_ms = vec![0.0; stamps.len()];
        let mut stretches = Vec::new();
        let mut lost = 0.0;
        for &[first, end] in pieces {
            let line = line_of([first, end]);
            let slope = if end - first >= OWN_INTERVAL {
                line.slope(shared_ms)
            } else {
                shared_ms
            };
            for i in first..end {
                time_ms[i] = line.at(numbers[i], slope);
            }
            lost += numbers[end - 1] - numbers[first] - (end - first - 1) as f64;
            stretches.push(ClockStretch {
                first,
                scans: end - first,
                interval_s: slope * 1e-3,
            });
        }
        let residuals = || {
            stamps
                .iter()
                .zip(&time_ms)
                .zip(strays)
                .filter(|(_, stray)| !**stray)
                .map(|((s, t), _)| s - t)
        };
        let kept = residuals().count().max(1) as f64;
        let rms_ms = (residuals().map(|r| r * r).sum::<f64>() / kept).sqrt();
        let max_ms = residuals().fold(0.0, |m: f64, r| m.max(r.abs()));
        let zero_ms = time_ms[0];
        RadioClock {
            time_s: time_ms.iter().map(|t| (t - zero_ms) * 1e-3).collect(),
            basis: ClockBasis::EvenRadioClock,
            numbering,
            interval_s: shared_ms * 1e-3,
            stretches,
            lost_scans: lost as u64,
            residual_rms_s: rms_ms * 1e-3,
            residual_max_s: max_ms * 1e-3,
            stray_stamps: strays.iter().filter(|s| **s).count(),
            wrapped,
        }
    }
}
