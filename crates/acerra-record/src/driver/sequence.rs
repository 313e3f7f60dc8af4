//! Scans and messages that a radio must have sent, inferred from their numbers: late, repeated, reordered or
//! lost.

use std::collections::VecDeque;

use acerra_radar::mrm::ScanHeader;

/// Messages remembered for recognising repeated ones: eight scans of the longest usual window.
const REMEMBERED: usize = 256;
/// Radio time that may go back by reordering alone, ms. A restart takes the radio longer.
const REORDERING_MS: i64 = 2_000;
/// Scans behind the newest after which a scan is given up, as the assembler does.
const GIVEN_UP_BEHIND: i64 = 8;

/// Relation of a SCAN_INFO message to those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// New and in order.
    New,
    /// New, but others that follow it came earlier.
    Reordered,
    /// It had come before.
    Repeated,
    /// Its scan was given up before it came, or belongs to the time before a restart.
    Late,
    /// The first after the radio was started again.
    Restarted,
}

/// Tracks the numbers of a radio's scans. Raw scans only, where each number identifies one scan.
#[derive(Debug, Default)]
pub struct Sequence {
    current: Option<Boot>,
    previous: Option<Boot>,
    recent: VecDeque<(u16, u32, u16)>,
    /// Scans of boots that are over.
    made_before: u64,
}

/// The time between two restarts of the radio.
#[derive(Debug, Clone, Copy)]
struct Boot {
    newest_id: u16,
    newest_ms: u32,
    /// Position of the newest message: scan and index.
    newest_index: u16,
    /// Scans from the first to the newest.
    made: u64,
    /// Usual interval between scans, ms.
    interval_ms: f64,
}

impl Boot {
    fn first(header: &ScanHeader) -> Self {
        Self {
            newest_id: header.message_id,
            newest_ms: header.timestamp_ms,
            newest_index: header.message_index,
            made: 1,
            interval_ms: 0.0,
        }
    }

    /// Milliseconds from the newest scan to another; stamps wrap at 2³².
    fn elapsed_ms(&self, header: &ScanHeader) -> i64 {
        i64::from(header.timestamp_ms.wrapping_sub(self.newest_ms) as i32)
    }

    /// Scans from the newest to another. Numbers wrap at 2¹⁶; stamps resolve the number of wraps.
    fn scans_since(&self, header: &ScanHeader) -> i64 {
        let by_number = i64::from(header.message_id.wrapping_sub(self.newest_id) as i16);
        if self.interval_ms <= 0.0 {
            return by_number;
        }
        let by_stamp = self.elapsed_ms(header) as f64 / self.interval_ms;
        let turns = ((by_stamp - by_number as f64) / 65_536.0).round() as i64;
        by_number + 65_536 * turns
    }
}

impl Sequence {
    /// Takes the header of a message in.
    pub fn take(&mut self, header: &ScanHeader) -> Standing {
        let key = (header.message_id, header.timestamp_ms, header.message_index);
        let standing = self.standing(header);
        if self.recent.contains(&key) {
            return Standing::Repeated;
        }
        if standing != Standing::Late {
            self.recent.push_back(key);
            if self.recent.len() > REMEMBERED {
                self.recent.pop_front();
            }
        }
        self.follow(header, standing);
        standing
    }

    /// Scans that the radio made from the first one received to the newest.
    #[must_use]
    pub fn scans_made(&self) -> u64 {
        self.made_before + self.current.map_or(0, |boot| boot.made)
    }

    /// Usual interval between scans by the radio's clock, s; 0 before two scans.
    #[must_use]
    pub fn interval_s(&self) -> f64 {
        self.current.map_or(0.0, |boot| boot.interval_ms * 1e-3)
    }

    /// Radio clock of the newest scan, ms.
    #[must_use]
    pub fn newest_ms(&self) -> Option<u32> {
        self.current.map(|boot| boot.newest_ms)
    }

    /// The radio's clock restarted: the following messages are of another boot.
    pub fn restart(&mut self) {
        if let Some(boot) = self.current.take() {
            self.made_before += boot.made;
            self.previous = Some(boot);
        }
        self.recent.clear();
    }

    fn standing(&self, header: &ScanHeader) -> Standing {
        let is_near = |boot: &Boot| boot.elapsed_ms(header).abs() <= REORDERING_MS;
        let Some(boot) = &self.current else {
            let is_of_previous = self.previous.as_ref().is_some_and(is_near);
            return if is_of_previous {
                Standing::Late
            } else {
                Standing::New
            };
        };
        let elapsed_ms = boot.elapsed_ms(header);
        if !is_near(boot) && self.previous.as_ref().is_some_and(is_near) {
            return Standing::Late;
        }
        if elapsed_ms < -REORDERING_MS {
            return Standing::Restarted;
        }
        let scans = boot.scans_since(header);
        if scans < 0 && elapsed_ms > REORDERING_MS {
            // The clock goes on while the numbers go back: a restart with a long pause after it.
            Standing::Restarted
        } else if scans < -GIVEN_UP_BEHIND {
            Standing::Late
        } else if scans < 0 || (scans == 0 && header.message_index < boot.newest_index) {
            Standing::Reordered
        } else {
            Standing::New
        }
    }

    fn follow(&mut self, header: &ScanHeader, standing: Standing) {
        match (standing, &mut self.current) {
            (Standing::New, None) => self.current = Some(Boot::first(header)),
            (Standing::New, Some(boot)) => {
                let scans = boot.scans_since(header);
                if scans > 0 {
                    let step_ms = boot.elapsed_ms(header) as f64 / scans as f64;
                    // The first gap begins the average; lost scans do not change it.
                    let weight = if boot.interval_ms > 0.0 { 0.02 } else { 1.0 };
                    boot.interval_ms += weight * (step_ms - boot.interval_ms);
                    boot.made += scans as u64;
                    (boot.newest_id, boot.newest_ms) = (header.message_id, header.timestamp_ms);
                }
                boot.newest_index = header.message_index;
            }
            (Standing::Restarted, _) => {
                self.restart();
                self.current = Some(Boot::first(header));
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_radar::Filtering;

    fn header(message_id: u16, timestamp_ms: u32, message_index: u16) -> ScanHeader {
        ScanHeader {
            message_id,
            source_id: 1,
            timestamp_ms,
            reserved: [0; 4],
            scan_start_ps: 0,
            scan_stop_ps: 40_000,
            scan_step_bins: 32,
            filtering: Filtering::Raw,
            reserved_byte: 3,
            antenna_id: 2,
            operation_mode: 1,
            samples_in_message: 322,
            samples_total: 672,
            message_index,
            messages_total: 2,
        }
    }

    #[test]
    fn numbers_and_stamps_may_wrap() {
        let mut sequence = Sequence::default();
        for scan in 0..200_000_u64 {
            let stamp = (u64::from(u32::MAX) - 5_000 + 10 * scan) as u32;
            let standing = sequence.take(&header(scan as u16, stamp, 0));
            assert_eq!(standing, Standing::New, "scan {scan}");
        }
        assert_eq!(sequence.scans_made(), 200_000);
        // A gap of more than one turn of the numbers.
        let stamp = (u64::from(u32::MAX) - 5_000 + 10 * 300_000) as u32;
        assert_eq!(
            sequence.take(&header(300_000_u64 as u16, stamp, 0)),
            Standing::New
        );
        assert_eq!(sequence.scans_made(), 300_001);
    }

    #[test]
    fn repetitions_overtaking_and_restarts_are_told_apart() {
        let mut sequence = Sequence::default();
        let mut take = |id, ms, index| sequence.take(&header(id, ms, index));
        assert_eq!(take(1, 60_000, 0), Standing::New);
        assert_eq!(take(2, 60_010, 0), Standing::New);
        assert_eq!(take(1, 60_000, 1), Standing::Reordered);
        assert_eq!(take(1, 60_000, 1), Standing::Repeated);
        assert_eq!(take(2, 60_010, 1), Standing::New);
        assert_eq!(take(20, 60_190, 0), Standing::New);
        assert_eq!(take(3, 60_020, 0), Standing::Late);
        // The radio was started again.
        assert_eq!(take(0, 900, 0), Standing::Restarted);
        assert_eq!(take(20, 60_190, 1), Standing::Late);
        assert_eq!(take(0, 900, 1), Standing::New);
        assert_eq!(sequence.scans_made(), 21);
    }

    /// A radio that was off for longer than it had been on has a later clock and small numbers.
    #[test]
    fn a_restart_shows_in_the_numbers_where_the_clock_is_later() {
        let mut sequence = Sequence::default();
        for scan in 0..500_u16 {
            sequence.take(&header(scan, 30_000 + 10 * u32::from(scan), 0));
        }
        assert_eq!(sequence.take(&header(0, 90_000, 0)), Standing::Restarted);
        assert_eq!(sequence.take(&header(1, 90_010, 0)), Standing::New);
        assert_eq!(sequence.scans_made(), 502);
    }
}
