//! The radio's clock on GPS time by hardware time marks: pulses of the radio that the receiver stamps.
//!
//! A mark does not identify its scan. By the clock from times of arrival each mark differs from its scan by
//! an error that is constant up to jitter. Among the differences between every mark and every scan near the
//! mark, the differences of matching pairs therefore cluster, even if marks or scans are lost or other events
//! are stamped. For evenly spaced scans there are clusters at every multiple of their interval: marks are
//! used where only one cluster is within the uncertainty of the arrival clock.

use acerra_geo::time::GpsTime;
use acerra_radar::LoggedClock;
use thiserror::Error;

use super::fit::LEAST_PAIRS;
use super::logged::{Latency, week_and_tow};
use super::robust_line::{LinePair, RobustLine};

/// Deviations of the arrival clock within which the marks are searched.
const REACH_SIGMAS: f64 = 4.0;
/// Width in which differences lie together, as a share of the scans' interval, and at least (s).
const WIDTH_SHARE: f64 = 0.125;
const LEAST_WIDTH_S: f64 = 2e-4;
/// Share of the marks that must follow the scans, and of the best place's that a rival has.
const LEAST_SHARE: f64 = 0.5;
/// Number of scans within reach of a mark beyond which the mark's scan cannot be identified.
const MOST_INTERVALS: f64 = 25.0;
/// Marks that differences are taken of, evenly spread over longer recordings.
const MOST_COMPARED: usize = 20_000;

/// Reason why time marks are not used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MarkError {
    /// Too few marks.
    #[error("expected {LEAST_PAIRS} time marks at least while the radio scans, found {found}")]
    TooFew {
        /// Marks there.
        found: usize,
    },
    /// The marks are of something else.
    #[error(
        "{following} of {marks} time marks follow the scans; is the radio's pulse on the receiver's EXTINT, one \
         a scan?"
    )]
    NotOfScans {
        /// Marks that lie together.
        following: usize,
        /// All marks while the radio scans.
        marks: usize,
    },
    /// The arrival clock does not identify the scan of a mark.
    #[error(
        "time marks each {:.1} ms cannot be assigned to scans by times of arrival, which are sure to {:.1} ms: measure \
         [radio] latency_ms {} with latency_sigma_ms, or scan less often",
        1e3 * interval_s, 1e3 * sigma_s,
        if *has_pulses { "and mark_delay_ms" } else { "and [gnss] latency_ms" }
    )]
    Ambiguous {
        /// Interval between scans (s).
        interval_s: f64,
        /// Standard deviation of the arrival clock, and of the marks' delay (s).
        sigma_s: f64,
        /// Whether pulses per second have measured the receiver's latency.
        has_pulses: bool,
    },
}

/// Scans of a run and marks, to be paired.
#[derive(Clone, Copy, Debug)]
pub struct MarkedScans<'a> {
    /// Radar time of each scan that came (s, from the first trace), rising.
    pub radar_s: &'a [f64],
    /// Times of the marks.
    pub marks: &'a [GpsTime],
    /// Time from the mark to the middle of its scan.
    pub delay: Latency,
}

/// The clock by the marks, `arrivals` being the one by times of arrival.
///
/// # Errors
/// Marks that are too few, do not follow the scans, or cannot be assigned to scans.
pub fn marked_clock(
    scans: &MarkedScans<'_>,
    arrivals: &LoggedClock,
) -> Result<LoggedClock, MarkError> {
    let origin = GpsTime::from_week_tow(arrivals.gps_week, arrivals.time_offset_s);
    let pairing = Pairing::new(scans, arrivals, origin);
    let shift_s = pairing.shift_s()?;
    let pairs = pairing.pairs_at(shift_s);
    let line = RobustLine::through(&pairs).ok_or(MarkError::TooFew { found: 0 })?;
    let (gps_week, time_offset_s) = week_and_tow(origin, line.at_zero_s());
    Ok(LoggedClock {
        gps_week,
        time_offset_s,
        rate: line.slope,
        sigma_stamps_s: line.sigma_s,
        sigma_s: line.sigma_s.hypot(scans.delay.sigma_s),
        marks: line.used,
        ..arrivals.clone()
    })
}

struct Pairing<'a> {
    radar_s: &'a [f64],
    /// GPS time of the scans by the arrival clock (s after the origin).
    scan_s: Vec<f64>,
    /// GPS time of the middle of the marks' scans (s after the origin).
    mark_s: Vec<f64>,
    interval_s: f64,
    width_s: f64,
    sigma_s: f64,
    has_pulses: bool,
}

/// Differences that lie together.
struct Place {
    shift_s: f64,
    marks: usize,
}

impl<'a> Pairing<'a> {
    fn new(scans: &MarkedScans<'a>, arrivals: &LoggedClock, origin: GpsTime) -> Self {
        let scan_s: Vec<f64> = scans.radar_s.iter().map(|r| arrivals.rate * r).collect();
        let mut gaps_s: Vec<f64> = scan_s.windows(2).map(|w| w[1] - w[0]).collect();
        gaps_s.sort_by(f64::total_cmp);
        let interval_s = gaps_s.get(gaps_s.len() / 2).copied().unwrap_or(0.0);
        let sigma_s = arrivals.sigma_s.hypot(scans.delay.sigma_s);
        let reach_s = REACH_SIGMAS * sigma_s + interval_s;
        let ends = scan_s.first().zip(scan_s.last());
        let is_in_run = |gps_s: &f64| {
            ends.is_some_and(|(first, last)| (first - reach_s..=last + reach_s).contains(gps_s))
        };
        let mut mark_s: Vec<f64> = scans
            .marks
            .iter()
            .map(|mark| mark.seconds_since(origin) + scans.delay.delay_s)
            .filter(is_in_run)
            .collect();
        mark_s.sort_by(f64::total_cmp);
        Self {
            radar_s: scans.radar_s,
            scan_s,
            mark_s,
            interval_s,
            width_s: (WIDTH_SHARE * interval_s).max(LEAST_WIDTH_S),
            sigma_s,
            has_pulses: arrivals.pulses > 0,
        }
    }

    /// Delay of the marks against the arrival clock (s).
    fn shift_s(&self) -> Result<f64, MarkError> {
        let marks = self.mark_s.len();
        if marks < LEAST_PAIRS {
            return Err(MarkError::TooFew { found: marks });
        }
        let ambiguous = MarkError::Ambiguous {
            interval_s: self.interval_s,
            sigma_s: self.sigma_s,
            has_pulses: self.has_pulses,
        };
        if self.reach_s() > MOST_INTERVALS * self.interval_s {
            return Err(ambiguous);
        }
        let marks = self.compared().count();
        let places = self.places();
        let most = places.iter().map(|p| p.marks).max().unwrap_or(0);
        if most < LEAST_PAIRS || (most as f64) < LEAST_SHARE * marks as f64 {
            return Err(MarkError::NotOfScans {
                following: most,
                marks,
            });
        }
        let mut rivals = places
            .iter()
            .filter(|place| place.marks as f64 >= LEAST_SHARE * most as f64);
        match (rivals.next(), rivals.next()) {
            (Some(place), None) => Ok(place.shift_s),
            _ => Err(ambiguous),
        }
    }

    /// Largest distance from the arrival clock at which the marks are searched (s).
    fn reach_s(&self) -> f64 {
        REACH_SIGMAS * self.sigma_s + self.width_s
    }

    /// The marks that differences are taken of.
    fn compared(&self) -> impl Iterator<Item = &f64> {
        let step = self.mark_s.len().div_ceil(MOST_COMPARED).max(1);
        self.mark_s.iter().step_by(step)
    }

    /// Where differences of marks and scans lie together, no nearer to one another than they are wide.
    fn places(&self) -> Vec<Place> {
        let reach_s = self.reach_s();
        let mut differences: Vec<f64> = Vec::new();
        for mark_s in self.compared() {
            let from = self.scan_s.partition_point(|s| *s < mark_s - reach_s);
            let near = self.scan_s[from..].iter();
            differences.extend(
                near.take_while(|s| **s <= mark_s + reach_s)
                    .map(|s| mark_s - s),
            );
        }
        differences.sort_by(f64::total_cmp);
        let mut windows: Vec<Place> = Vec::new();
        let mut end = 0;
        for (begin, from_s) in differences.iter().enumerate() {
            while differences
                .get(end)
                .is_some_and(|d| *d <= from_s + self.width_s)
            {
                end += 1;
            }
            windows.push(Place {
                shift_s: differences[(begin + end - 1) / 2],
                marks: end - begin,
            });
        }
        // The largest cluster first; one next to a larger cluster is a part of it.
        windows.sort_by_key(|window| std::cmp::Reverse(window.marks));
        let mut places: Vec<Place> = Vec::new();
        for window in windows {
            let is_near = |place: &Place| (place.shift_s - window.shift_s).abs() <= self.width_s;
            if !places.iter().any(is_near) {
                places.push(window);
            }
        }
        places
    }

    /// Each mark with the scan that it is of at this shift, where that scan came.
    fn pairs_at(&self, shift_s: f64) -> Vec<LinePair> {
        let pair = |mark_s: &f64| {
            let expected_s = mark_s - shift_s;
            let after = self.scan_s.partition_point(|s| *s < expected_s);
            let nearest = [after.checked_sub(1), Some(after)]
                .into_iter()
                .flatten()
                .filter(|i| *i < self.scan_s.len())
                .min_by(|a, b| {
                    let off = |i: &usize| (self.scan_s[*i] - expected_s).abs();
                    off(a).total_cmp(&off(b))
                })?;
            let is_of_it = (self.scan_s[nearest] - expected_s).abs() <= self.width_s;
            is_of_it.then(|| LinePair {
                at_s: self.radar_s[nearest],
                reads_s: *mark_s,
            })
        };
        self.mark_s.iter().filter_map(pair).collect()
    }
}
