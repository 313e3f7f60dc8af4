//! Lock-time indicators: the time of tracking without interruption, in steps, and cycle slips derived from
//! them.

use std::collections::HashMap;

use acerra_geo::time::GpsTime;

use crate::observations::satellite::SatelliteId;
use crate::observations::signal::SignalCode;

/// Least continuous tracking time (ms) of a 7-bit indicator (DF013, DF019 …).
pub(super) const fn least_of_7_bits_ms(indicator: u32) -> u32 {
    let i = indicator;
    1000 * match i {
        0..=23 => i,
        24..=47 => 2 * i - 24,
        48..=71 => 4 * i - 120,
        72..=95 => 8 * i - 408,
        96..=119 => 16 * i - 1176,
        120..=126 => 32 * i - 3096,
        _ => 937,
    }
}

/// Least continuous tracking time (ms) of a 4-bit indicator (DF402).
pub(super) const fn least_of_4_bits_ms(indicator: u32) -> u32 {
    match indicator {
        0 => 0,
        i @ 1..=15 => 16 << i,
        _ => 524_288,
    }
}

/// Least continuous tracking time (ms) of a 10-bit indicator (DF407); 0 for reserved ones.
pub(super) const fn least_of_10_bits_ms(indicator: u32) -> u32 {
    match indicator {
        i @ 0..64 => i,
        i @ 64..=704 => {
            let doublings = i / 32 - 1;
            (i - 32 * doublings) << doublings
        }
        _ => 0,
    }
}

/// History of each phase: time of the last observation, and its tracking time.
#[derive(Debug, Default)]
pub(super) struct LockTracker {
    last: HashMap<(SatelliteId, SignalCode), (GpsTime, u32)>,
}

impl LockTracker {
    /// Whether lock may have been lost since a phase was last observed: the tracking time has become shorter,
    /// or does not reach back to the last observation. The first observation of a phase is no loss.
    pub(super) fn lost(
        &mut self,
        signal: (SatelliteId, SignalCode),
        time: GpsTime,
        least_ms: u32,
    ) -> bool {
        let before = self.last.insert(signal, (time, least_ms));
        before.is_some_and(|(then, then_ms)| {
            least_ms < then_ms || f64::from(least_ms) <= 1e3 * time.seconds_since(then)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of RTCM 10403.3, tables 3.4-2, 3.5-74 and 3.5-75.
    #[test]
    fn tables_of_the_standard() {
        let seven = [
            (0, 0),
            (23, 23),
            (24, 24),
            (47, 70),
            (48, 72),
            (71, 164),
            (72, 168),
        ];
        for (indicator, least_s) in seven {
            assert_eq!(least_of_7_bits_ms(indicator), 1000 * least_s, "{indicator}");
        }
        for (indicator, least_s) in [(95, 352), (96, 360), (119, 728), (120, 744), (126, 936)] {
            assert_eq!(least_of_7_bits_ms(indicator), 1000 * least_s, "{indicator}");
        }
        assert_eq!(least_of_7_bits_ms(127), 937_000);
        for (indicator, least) in [(0, 0), (1, 32), (2, 64), (6, 1024), (15, 524_288)] {
            assert_eq!(least_of_4_bits_ms(indicator), least, "{indicator}");
        }
        let ten = [
            (0, 0),
            (63, 63),
            (64, 64),
            (95, 126),
            (96, 128),
            (127, 252),
            (128, 256),
        ];
        for (indicator, least) in ten {
            assert_eq!(least_of_10_bits_ms(indicator), least, "{indicator}");
        }
        for (indicator, least) in [(160, 512), (703, 66_060_288), (704, 67_108_864), (705, 0)] {
            assert_eq!(least_of_10_bits_ms(indicator), least, "{indicator}");
        }
    }

    #[test]
    fn a_shorter_time_or_one_that_does_not_reach_back_is_a_loss() {
        let mut tracker = LockTracker::default();
        let signal = ("G05".parse().unwrap(), SignalCode::new(1, 'C'));
        let start = GpsTime::from_week_tow(2262, 1000.0);
        let mut at = |later_s: f64, least_ms| tracker.lost(signal, start + later_s, least_ms);
        assert!(!at(0.0, 64), "first sight");
        assert!(!at(0.05, 64));
        assert!(!at(1.0, 1024));
        assert!(at(2.0, 512), "shorter");
        assert!(!at(3.0, 1024), "just longer than the second between");
        assert!(at(60.0, 32_768), "57 s without the phase, tracked for 33 s");
        assert!(!at(60.2, 32_768));
    }
}
