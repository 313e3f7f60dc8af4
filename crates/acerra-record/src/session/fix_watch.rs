//! Monitoring of a receiver's fix and height, with warnings.

use acerra_gnss::ubx::FixState;

use super::fix_source::FixSource;
use super::progress::{Fix, Progress};
use super::reminder::Reminder;
use super::window_watch::WindowWatch;
use crate::gnss::FrameFinder;

/// Watches the fix by the receiver's own solution (NAV-PVT), or by the satellites that it measures.
pub(super) struct FixWatch {
    frames: FrameFinder,
    window: WindowWatch,
    latest: Option<Fix>,
    source: FixSource,
    /// Warnings that there is no fix.
    lost: Reminder,
    was_fixed: bool,
}

impl FixWatch {
    /// A watch that compares heights with the radio's window.
    pub fn new(window: WindowWatch) -> Self {
        Self {
            frames: FrameFinder::default(),
            window,
            latest: None,
            source: FixSource::default(),
            lost: Reminder::default(),
            was_fixed: false,
        }
    }

    /// The receiver's last report, if any.
    pub fn latest(&self) -> Option<Fix> {
        self.latest
    }

    /// Takes bytes that came at `host_s`; returns the notes and warnings.
    pub fn take(&mut self, bytes: &[u8], host_s: f64) -> Vec<Progress> {
        let mut states: Vec<FixState> = Vec::new();
        let source = &mut self.source;
        self.frames.take(bytes, host_s, |frame, _| {
            states.extend(source.take(frame, host_s));
        });
        let mut changes = Vec::new();
        for state in states {
            changes.extend(self.judge(&state, host_s));
            let height = state.height_m;
            changes.extend(
                height.and_then(|[height_m, sigma_m]| self.window.take(height_m, sigma_m, host_s)),
            );
        }
        changes
    }

    fn judge(&mut self, state: &FixState, host_s: f64) -> Option<Progress> {
        let FixState {
            has_fix,
            satellites,
            ..
        } = *state;
        self.latest = Some(Fix {
            has_fix,
            satellites,
        });
        if has_fix {
            let lost_s = self.lost.end();
            let is_first = !std::mem::replace(&mut self.was_fixed, true);
            let after = match lost_s {
                Some(lost_s) => format!(" after {:.0} s without", host_s - lost_s),
                None if is_first => String::new(),
                None => return None,
            };
            return Some(Progress::Note(format!(
                "the GNSS receiver has a fix{after}: {satellites} satellites"
            )));
        }
        self.lost.due(host_s).map(|since_s| {
            Progress::Warning(format!(
                "no GNSS fix for {since_s:.0} s, {satellites} satellites: these scans will have no position"
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{FlightSection, RadioSection};
    use acerra_gnss::ubx::frame::encode;

    fn watch() -> FixWatch {
        let radio = RadioSection {
            window_ps: [16_670, 86_982],
            ..RadioSection::default()
        };
        FixWatch::new(WindowWatch::new(&radio, &FlightSection::default()))
    }

    /// RXM-RAWX with a number of satellites.
    fn measurements(satellites: u8) -> Vec<u8> {
        let mut payload = vec![0; 16 + 32 * usize::from(satellites)];
        payload[11] = satellites;
        for k in 0..satellites {
            let signal = &mut payload[16 + 32 * usize::from(k)..];
            (signal[21], signal[30]) = (k + 1, 1);
        }
        encode(2, 0x15, &payload).unwrap()
    }

    /// NAV-PVT at a height.
    fn solution(kind: u8, height_m: f64) -> Vec<u8> {
        let mut payload = vec![0; 92];
        (payload[20], payload[21], payload[23]) = (kind, u8::from(kind == 3), 9);
        payload[32..36].copy_from_slice(&((1e3 * height_m) as i32).to_le_bytes());
        payload[44..48].copy_from_slice(&1_000_u32.to_le_bytes());
        encode(1, 7, &payload).unwrap()
    }

    /// Notes and warnings for messages that come each 0.2 s.
    fn reported(watch: &mut FixWatch, from_s: f64, to_s: f64, message: &[u8]) -> Vec<String> {
        let steps = ((to_s - from_s) / 0.2).round() as i32;
        let mut reported = Vec::new();
        for k in 0..steps {
            for progress in watch.take(message, from_s + 0.2 * f64::from(k)) {
                reported.push(match progress {
                    Progress::Note(text) => text,
                    Progress::Warning(text) => format!("! {text}"),
                    Progress::Health(_) => unreachable!("a watch reports no health"),
                });
            }
        }
        reported
    }

    #[test]
    fn a_fix_that_is_lost_is_told_once_and_again_and_when_it_is_back() {
        let mut watch = watch();
        let first = reported(&mut watch, 0.0, 5.0, &measurements(9));
        assert_eq!(first, ["the GNSS receiver has a fix: 9 satellites"]);
        // Shorter than the time to a warning.
        assert!(reported(&mut watch, 5.0, 6.0, &measurements(3)).is_empty());
        assert!(reported(&mut watch, 6.0, 7.0, &measurements(8)).is_empty());
        let lost = reported(&mut watch, 7.0, 40.0, &measurements(2));
        let text =
            |s| format!("! no GNSS fix for {s} s, 2 satellites: these scans will have no position");
        assert_eq!(lost, [text(2), text(32)]);
        let fix = watch.latest().unwrap();
        assert_eq!((fix.has_fix, fix.satellites), (false, 2));
        let back = reported(&mut watch, 40.0, 41.0, &measurements(7));
        assert_eq!(
            back,
            ["the GNSS receiver has a fix after 33 s without: 7 satellites"]
        );
    }

    #[test]
    fn the_receivers_own_word_counts_over_the_number_of_satellites() {
        let mut watch = watch();
        let both = [solution(0, 0.0), measurements(9)].concat();
        let lost = reported(&mut watch, 0.0, 4.0, &both);
        assert_eq!(lost.len(), 1, "{lost:?}");
        assert!(lost[0].starts_with("! no GNSS fix for 2 s, 9 satellites"));
    }

    #[test]
    fn a_climb_out_of_the_window_is_told() {
        let mut watch = watch();
        assert_eq!(reported(&mut watch, 0.0, 2.0, &solution(3, 100.0)).len(), 1);
        // The window holds echoes of the ground 13 m below.
        assert!(reported(&mut watch, 2.0, 8.0, &solution(3, 110.0)).is_empty());
        let high = reported(&mut watch, 8.0, 20.0, &solution(3, 131.0));
        assert_eq!(
            high,
            [
                "! the ground is behind the window ([radio] window_ps): 31 m above where the recording began it \
                 answers at 193 ns or later, and the window ends at 87 ns"
            ]
        );
    }
}
