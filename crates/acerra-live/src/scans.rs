//! The radio's messages put together to whole scans, each with the host time of its first message.

use std::collections::VecDeque;

use acerra_radar::{Filtering, Scan};
use acerra_record::driver::{Intake, LinkCounts, Standing, Taken};
use acerra_record::message::{Message, Packet};

/// Scans whose arrival is remembered until they are whole.
const MOST_ARRIVALS: usize = 64;

/// When the first message of a scan came.
struct Arrival {
    key: (u16, u32),
    host_s: f64,
}

/// Messages to be assembled to whole scans.
#[derive(Default)]
pub(crate) struct Scans {
    intake: Intake,
    arrivals: VecDeque<Arrival>,
}

impl Scans {
    /// Takes a message that came at a host time (s); returns whether the radio has restarted.
    pub fn take(&mut self, body: &[u8], host_s: f64) -> bool {
        if let Ok(Packet {
            message: Message::ScanInfo(message),
            ..
        }) = Packet::decode(body)
        {
            let key = (message.header.message_id, message.header.timestamp_ms);
            if self.arrivals.iter().all(|arrival| arrival.key != key) {
                self.arrivals.push_back(Arrival { key, host_s });
                if self.arrivals.len() > MOST_ARRIVALS {
                    self.arrivals.pop_front();
                }
            }
        }
        self.intake.take(body) == Taken::Scan(Standing::Restarted)
    }

    /// The next whole raw scan, with the host time of its first message (s), or `otherwise_s` where that is
    /// forgotten.
    pub fn next(&mut self, otherwise_s: f64) -> Option<(Scan, f64)> {
        loop {
            let scan = self.intake.next_scan()?;
            if scan.filtering != Filtering::Raw {
                continue;
            }
            let key = (scan.message_id, scan.timestamp_ms);
            let arrival = self.arrivals.iter().find(|arrival| arrival.key == key);
            let host_s = arrival.map_or(otherwise_s, |arrival| arrival.host_s);
            return Some((scan, host_s));
        }
    }

    /// Counts of the messages.
    pub fn counts(&self) -> LinkCounts {
        self.intake.counts()
    }
}
