//! The autopilot's clock on GPS time, by a robust line through readings of both.
//!
//! A message of a receiver is logged when it arrives, later than its instant by the latencies of receiver,
//! link and scheduler. The delay is never negative, so that the readings lie on one side of the line of least
//! delay: the reading of least delay in each interval of time is used, and the line is fitted to these
//! (Theil–Sen). The least delay itself cannot be found from the readings. Readings of one instant scatter to
//! both sides: there the stretches' medians count.

use acerra_geo::time::GpsTime;

use crate::error::LogError;
use crate::sample::{ClockPair, PairKind};

/// Readings further than this (s) from the middle one are another time's: leap seconds that the
/// receiver did not know yet, a date not yet found.
const AGREEMENT_S: f64 = 0.5;
/// Stretches of the log of which each gives one reading.
const STRETCHES: usize = 32;
/// Greatest rate error of a crystal (s/s): beyond it the line's slope is chance.
const GREATEST_RATE: f64 = 2e-4;
/// Deviation of the rates of crystals (s/s), the prior for a log too short to determine its own.
const USUAL_RATE: f64 = 3e-5;
/// Least deviation of a reading (s): clocks count microseconds.
const LEAST_SIGMA_S: f64 = 1e-6;

/// The autopilot's clock on GPS time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockFit {
    /// Instant of the autopilot's clock at which `gps` holds (s).
    pub boot_s: f64,
    /// GPS time then.
    pub gps: GpsTime,
    /// Rate of GPS time against the autopilot's clock, less one (s/s).
    pub rate: f64,
    /// Readings used.
    pub readings: usize,
    /// Readings left out, as readings of another time.
    pub left_out: usize,
    /// Nine tenths of the readings lie within this (s) of the line.
    pub spread_s: f64,
    /// The clock has no relation to GPS time.
    pub is_own: bool,
}

impl ClockFit {
    /// A clock without relation to GPS time: its zero counts as that of GPS time here.
    pub const fn own() -> Self {
        Self {
            boot_s: 0.0,
            gps: GpsTime::EPOCH,
            rate: 0.0,
            readings: 0,
            left_out: 0,
            spread_s: 0.0,
            is_own: true,
        }
    }

    /// Whether GPS time belongs to a reading of the autopilot's clock as it does elsewhere in the log.
    #[must_use]
    pub fn agrees(&self, gps: GpsTime, boot_s: f64) -> bool {
        (gps - self.gps_at(boot_s)).abs() <= AGREEMENT_S
    }

    /// Reading of the autopilot's clock (s) at an instant of GPS time.
    #[must_use]
    pub fn boot_at(&self, gps: GpsTime) -> f64 {
        self.boot_s + (gps - self.gps) / (1.0 + self.rate)
    }

    /// GPS time at a reading of the autopilot's clock.
    #[must_use]
    pub fn gps_at(&self, boot_s: f64) -> GpsTime {
        let since_s = boot_s - self.boot_s;
        self.gps + since_s + self.rate * since_s
    }
}

/// Fits the line; none without a reading.
///
/// # Errors
/// Readings of which not even two thirds agree.
pub fn fit(pairs: &[ClockPair], kind: PairKind) -> Result<Option<ClockFit>, LogError> {
    let finite = pairs.iter().filter(|p| p.boot_s.is_finite());
    let pairs: Vec<ClockPair> = finite.copied().collect();
    let Some(first) = pairs.first() else {
        return Ok(None);
    };
    // GPS time less the autopilot's clock (s), counted from the first reading.
    let offset = |p: &ClockPair| (p.gps - first.gps) - (p.boot_s - first.boot_s);
    let middle = median(pairs.iter().map(offset).collect());
    let is_near = |p: &&ClockPair| {
        let allowed = AGREEMENT_S + GREATEST_RATE * (p.boot_s - first.boot_s).abs();
        (offset(p) - middle).abs() <= allowed
    };
    let near: Vec<ClockPair> = pairs.iter().filter(is_near).copied().collect();
    if 3 * near.len() < 2 * pairs.len() {
        return Err(LogError::ClockUnknown {
            agreeing: near.len(),
            pairs: pairs.len(),
            tolerance_s: AGREEMENT_S,
        });
    }
    let chosen = chosen(&near, kind, offset);
    let rate = rate(&chosen).clamp(-GREATEST_RATE, GREATEST_RATE);
    let level = |(boot_s, offset_s): &(f64, f64)| offset_s - rate * (boot_s - first.boot_s);
    let level_s = median(chosen.iter().map(level).collect());
    let mut off: Vec<f64> = near
        .iter()
        .map(|p| (offset(p) - rate * (p.boot_s - first.boot_s) - level_s).abs())
        .collect();
    off.sort_by(f64::total_cmp);
    Ok(Some(ClockFit {
        boot_s: first.boot_s,
        gps: first.gps + level_s,
        rate,
        readings: near.len(),
        left_out: pairs.len() - near.len(),
        spread_s: off.get(off.len() * 9 / 10).copied().unwrap_or(0.0),
        is_own: false,
    }))
}

/// One reading of each stretch: (autopilot's clock, GPS time less it), s.
fn chosen(
    pairs: &[ClockPair],
    kind: PairKind,
    offset: impl Fn(&ClockPair) -> f64,
) -> Vec<(f64, f64)> {
    let mut sorted: Vec<&ClockPair> = pairs.iter().collect();
    sorted.sort_by(|a, b| a.boot_s.total_cmp(&b.boot_s));
    let length = sorted.len().div_ceil(STRETCHES).max(1);
    let stretches = sorted.chunks(length);
    stretches
        .filter_map(|stretch| {
            let mut ranked = stretch.to_vec();
            ranked.sort_by(|a, b| offset(a).total_cmp(&offset(b)));
            let one = match kind {
                PairKind::Arrival => ranked.last()?,
                PairKind::Simultaneous => ranked.get(ranked.len() / 2)?,
            };
            Some((one.boot_s, offset(one)))
        })
        .collect()
}

/// The slope of the points, drawn towards none as far as their scatter leaves it open.
fn rate(points: &[(f64, f64)]) -> f64 {
    let slope = slope(points);
    let level = median(points.iter().map(|p| p.1 - slope * p.0).collect());
    let off = points.iter().map(|p| (p.1 - slope * p.0 - level).abs());
    // 1.48 times the median of absolute deviations is σ of a normal distribution.
    let sigma_s = (1.48 * median(off.collect())).max(LEAST_SIGMA_S);
    let mean_s = points.iter().map(|p| p.0).sum::<f64>() / points.len().max(1) as f64;
    let spread_s2: f64 = points.iter().map(|p| (p.0 - mean_s).powi(2)).sum();
    let variance = sigma_s * sigma_s / spread_s2.max(1e-12);
    slope * USUAL_RATE.powi(2) / (USUAL_RATE.powi(2) + variance)
}

/// Median of the slopes between all pairs of points.
fn slope(points: &[(f64, f64)]) -> f64 {
    let mut slopes = Vec::new();
    for (i, a) in points.iter().enumerate() {
        for b in &points[i + 1..] {
            if b.0 > a.0 {
                slopes.push((b.1 - a.1) / (b.0 - a.0));
            }
        }
    }
    median(slopes)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A log of 300 s: the clock is 20 ppm slow, messages arrive after 80 ms and up to 60 ms more.
    fn arrivals() -> Vec<ClockPair> {
        let start = GpsTime::from_week_tow(2300, 1000.0);
        (0..1500_u32)
            .map(|k| {
                let gps_s = 0.2 * f64::from(k);
                let jitter_s = 0.06 * f64::from(k.wrapping_mul(2_654_435_761) >> 8) / 16_777_216.0;
                let arrival_s = gps_s + 0.08 + jitter_s;
                ClockPair {
                    boot_s: 50.0 + arrival_s * (1.0 - 2e-5),
                    gps: start + gps_s,
                }
            })
            .collect()
    }

    #[test]
    fn least_delay_and_rate_are_found_under_jitter_and_a_late_leap_second() {
        let mut pairs = arrivals();
        for pair in &mut pairs[..100] {
            pair.gps = pair.gps - 2.0;
        }
        let fit = fit(&pairs, PairKind::Arrival).unwrap().unwrap();
        assert_eq!((fit.readings, fit.left_out), (1400, 100));
        assert!((fit.rate - 2e-5).abs() < 5e-6, "{}", fit.rate);
        // The least delay stays in: 80 ms, and a ms or two of the jitter.
        for gps_s in [10.0, 150.0, 290.0] {
            let boot_s = 50.0 + gps_s * (1.0 - 2e-5);
            let off_s = fit.gps_at(boot_s) - (GpsTime::from_week_tow(2300, 1000.0) + gps_s);
            assert!((off_s + 0.08).abs() < 0.003, "{off_s}");
        }
    }

    #[test]
    fn readings_that_do_not_agree_are_refused_and_none_gives_none() {
        assert_eq!(fit(&[], PairKind::Arrival).unwrap(), None);
        let start = GpsTime::from_week_tow(2300, 0.0);
        let pairs: Vec<ClockPair> = (0..30)
            .map(|k| ClockPair {
                boot_s: f64::from(k),
                gps: start + 7.0 * f64::from(k * k % 13),
            })
            .collect();
        let error = fit(&pairs, PairKind::Simultaneous).unwrap_err();
        assert!(matches!(error, LogError::ClockUnknown { pairs: 30, .. }));
    }
}
