//! Instruments that fall silent.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use serde::Serialize;

use crate::log::RecordKind;

/// Time without a record after which an instrument counts as silent at least: the one who flies knows within 2 s.
pub const LEAST_SILENCE: Duration = Duration::from_millis(1_500);
/// Ratio of a silence to the longest interval seen between two records, for instruments that send seldom.
const INTERVALS: u32 = 2;
/// Records of an instrument before its intervals are known.
const FIRST_RECORDS: u32 = 8;
/// Silence within the first records, as a receiver starts slowly.
const FIRST_SILENCE: Duration = Duration::from_secs(5);

/// An instrument that is silent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Silence {
    /// The instrument.
    pub instrument: &'static str,
    /// For how long (s).
    pub for_s: f64,
    /// Last time of a message, by this computer's clock in UTC, such as `12:03:04`.
    pub last_heard_utc: String,
}

impl std::fmt::Display for Silence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} IS SILENT for {:.0} s, last heard at {} UTC",
            self.instrument.to_uppercase(),
            self.for_s,
            self.last_heard_utc
        )
    }
}

/// Watches the time since the instruments' last messages.
#[derive(Clone, Debug, Default)]
pub struct SilenceWatch {
    radio: Option<Heard>,
    receiver: Option<Heard>,
}

#[derive(Clone, Copy, Debug)]
struct Heard {
    last: Instant,
    records: u32,
    longest: Duration,
}

impl Heard {
    fn patience(&self) -> Duration {
        let usual = LEAST_SILENCE.max(INTERVALS * self.longest);
        if self.records < FIRST_RECORDS {
            usual.max(FIRST_SILENCE)
        } else {
            usual
        }
    }
}

impl SilenceWatch {
    /// Takes in that a record came.
    pub fn hear(&mut self, kind: RecordKind, at: Instant) {
        let heard = match kind {
            RecordKind::Radio => &mut self.radio,
            RecordKind::Gnss => &mut self.receiver,
            _ => return,
        };
        let Some(heard) = heard else {
            *heard = Some(Heard {
                last: at,
                records: 1,
                longest: Duration::ZERO,
            });
            return;
        };
        let since = at.saturating_duration_since(heard.last);
        // A silence is no usual interval.
        if since <= heard.patience() {
            heard.longest = heard.longest.max(since);
        }
        heard.records = heard.records.saturating_add(1);
        heard.last = heard.last.max(at);
    }

    /// Instruments that have sent messages before and are silent now.
    #[must_use]
    pub fn silent(&self, now: Instant) -> Vec<Silence> {
        let each = [
            ("the radio", self.radio),
            ("the GNSS receiver", self.receiver),
        ];
        each.into_iter()
            .filter_map(|(instrument, heard)| {
                let heard = heard?;
                let since = now.saturating_duration_since(heard.last);
                (since > heard.patience()).then(|| Silence {
                    instrument,
                    for_s: since.as_secs_f64(),
                    last_heard_utc: clock_reading(SystemTime::now().checked_sub(since)),
                })
            })
            .collect()
    }
}

/// Hours, minutes and seconds of the day in UTC.
fn clock_reading(time: Option<SystemTime>) -> String {
    let since = time.and_then(|time| time.duration_since(UNIX_EPOCH).ok());
    let of_day = since.map_or(0, |since| since.as_secs() % 86_400);
    format!(
        "{:02}:{:02}:{:02}",
        of_day / 3600,
        of_day / 60 % 60,
        of_day % 60
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_silence_is_reported_within_two_seconds_and_ends_with_the_next_record() {
        let begin = Instant::now();
        let at = |ms: u64| begin + Duration::from_millis(ms);
        let mut watch = SilenceWatch::default();
        // Scans each 50 ms, positions each 200 ms, until 4 s.
        for ms in (0..=4_000).step_by(50) {
            watch.hear(RecordKind::Radio, at(ms));
            if ms % 200 == 0 {
                watch.hear(RecordKind::Gnss, at(ms));
            }
        }
        assert_eq!(watch.silent(at(5_400)), []);
        // The radio goes on, the receiver does not.
        for ms in (4_050..=6_000).step_by(50) {
            watch.hear(RecordKind::Radio, at(ms));
        }
        let silent = watch.silent(at(6_000));
        assert_eq!(silent.len(), 1);
        assert_eq!(silent[0].instrument, "the GNSS receiver");
        assert!((silent[0].for_s - 2.0).abs() < 1e-9);
        assert!(
            silent[0]
                .to_string()
                .starts_with("THE GNSS RECEIVER IS SILENT for 2 s, last heard at ")
        );
        watch.hear(RecordKind::Gnss, at(9_000));
        watch.hear(RecordKind::Radio, at(9_000));
        assert_eq!(watch.silent(at(9_100)), []);
        // The silence before does not make it patient.
        assert_eq!(watch.silent(at(10_600)).len(), 2);
    }

    #[test]
    fn an_instrument_that_sends_seldom_is_not_silent_between() {
        let begin = Instant::now();
        let at = |s: u64| begin + Duration::from_secs(s);
        let mut watch = SilenceWatch::default();
        for k in 0..20 {
            assert_eq!(watch.silent(at(4 * k)), []);
            watch.hear(RecordKind::Gnss, at(4 * k));
        }
        assert_eq!(watch.silent(at(4 * 19 + 7)), []);
        assert_eq!(watch.silent(at(4 * 19 + 9)).len(), 1);
        // An instrument that never sent a message is not silent.
        assert_eq!(SilenceWatch::default().silent(at(100)), []);
    }

    #[test]
    fn times_of_day_are_read_off() {
        let time = UNIX_EPOCH + Duration::from_secs(86_400 * 20_000 + 3_600 * 12 + 60 * 3 + 4);
        assert_eq!(clock_reading(Some(time)), "12:03:04");
    }
}
