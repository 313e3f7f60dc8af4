//! From messages to whole scans, with counts of missing ones.

use std::collections::VecDeque;

use acerra_radar::mrm::ScanAssembler;
use acerra_radar::{ReadReport, Scan};

use super::counts::LinkCounts;
use super::sequence::{Sequence, Standing};
use crate::message::{Message, Packet, ScanMessage};

/// Takes messages as they come and hands out whole scans, each once, in the order in which their
/// first messages came.
#[derive(Default)]
pub struct Intake {
    sequence: Sequence,
    assembler: ScanAssembler,
    report: ReadReport,
    ready: VecDeque<Scan>,
    counts: LinkCounts,
    bytes: u64,
}

/// Kind of a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Taken {
    /// Samples.
    Scan(Standing),
    /// Any other message.
    Other(Packet),
    /// No message.
    Undecodable,
}

impl Intake {
    /// Takes a message body in.
    pub fn take(&mut self, body: &[u8]) -> Taken {
        self.counts.packets += 1;
        self.counts.bytes += body.len() as u64;
        match Packet::decode(body) {
            Ok(Packet {
                message: Message::ScanInfo(message),
                ..
            }) => Taken::Scan(self.take_scan(&message)),
            Ok(packet) => Taken::Other(packet),
            Err(_) => {
                self.counts.undecodable += 1;
                Taken::Undecodable
            }
        }
    }

    fn take_scan(&mut self, message: &ScanMessage) -> Standing {
        self.counts.scan_messages += 1;
        let standing = self.sequence.take(&message.header);
        match standing {
            Standing::Repeated => self.counts.repeated += 1,
            Standing::Late => self.counts.late += 1,
            Standing::Reordered => self.counts.reordered += 1,
            Standing::Restarted => {
                self.counts.restarts += 1;
                self.give_up_unfinished();
            }
            Standing::New => {}
        }
        if !matches!(standing, Standing::Repeated | Standing::Late) {
            let (report, ready) = (&mut self.report, &mut self.ready);
            let samples = message.samples().to_vec();
            self.assembler
                .push(&message.header, samples, self.bytes, report, ready);
            self.bytes += 1;
        }
        standing
    }

    /// The next whole scan.
    pub fn next_scan(&mut self) -> Option<Scan> {
        self.ready.pop_front()
    }

    /// Scans in progress are closed: the whole ones are returned, the others counted.
    pub fn give_up_unfinished(&mut self) {
        self.assembler.end(&mut self.report, &mut self.ready);
    }

    /// The radio was restarted, though no message has reported it yet.
    pub fn restart(&mut self) {
        self.counts.restarts += 1;
        self.give_up_unfinished();
        self.sequence.restart();
    }

    /// The account so far.
    #[must_use]
    pub fn counts(&self) -> LinkCounts {
        let mut counts = self.counts;
        counts.whole_scans = self.report.whole_scans;
        counts.incomplete_scans = self.report.incomplete_scans;
        counts.scans_under_way = self.assembler.scans_under_way() as u64;
        let known = counts.scans_made();
        counts.lost_scans = self.sequence.scans_made().saturating_sub(known);
        counts
    }

    /// The numbers of the scans.
    #[must_use]
    pub fn sequence(&self) -> &Sequence {
        &self.sequence
    }

    pub(super) fn count_silence(&mut self) {
        self.counts.silences += 1;
    }

    pub(super) fn count_retry(&mut self) {
        self.counts.retries += 1;
    }
}
