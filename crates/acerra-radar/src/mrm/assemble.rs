//! Assembling the messages of a scan.

use std::collections::{BTreeMap, VecDeque};

use super::header::ScanHeader;
use crate::report::{BlemishKind, Place, ReadReport};
use crate::scan::Scan;

/// Largest number of scans in progress. Filters interleave up to four scans; the other places are for
/// messages that overtake each other.
const UNDER_WAY: usize = 8;
/// Finished scans remembered, so that a late repetition is not mistaken for a new scan.
const REMEMBERED: usize = 16;

/// The part of a header that all messages of a scan share.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Key(ScanHeader);

impl Key {
    fn of(header: &ScanHeader) -> Self {
        Self(ScanHeader {
            samples_in_message: 0,
            message_index: 0,
            reserved: [0; 4],
            reserved_byte: 0,
            ..*header
        })
    }
}

struct UnderWay {
    key: Key,
    offset: u64,
    parts: BTreeMap<u16, Vec<i32>>,
    last_index: Option<u16>,
}

impl UnderWay {
    fn expected(&self) -> usize {
        usize::from(self.key.0.messages_total)
    }

    fn is_complete(&self) -> bool {
        self.parts.len() == self.expected()
    }
}

/// Collects messages and returns whole scans in the order in which they began. A scan of which a message is
/// missing is given up when eight more have begun.
#[derive(Default)]
pub struct ScanAssembler {
    under_way: VecDeque<UnderWay>,
    finished: VecDeque<Key>,
}

impl ScanAssembler {
    /// Adds a message, with the offset of its first byte in the input; whole scans are appended to `out`.
    pub fn push(
        &mut self,
        header: &ScanHeader,
        samples: Vec<i32>,
        offset: u64,
        report: &mut ReadReport,
        out: &mut VecDeque<Scan>,
    ) {
        let key = Key::of(header);
        let place = Place::Byte(offset);
        let (message_id, index) = (header.message_id, header.message_index);
        if self.finished.contains(&key) {
            let kind = BlemishKind::RepeatedMessage {
                message_id,
                index,
                identical: None,
            };
            report.add(place, kind);
            return;
        }
        let slot = match self.under_way.iter().position(|u| u.key == key) {
            Some(slot) => slot,
            None => {
                let parts = BTreeMap::new();
                self.under_way.push_back(UnderWay {
                    key,
                    offset,
                    parts,
                    last_index: None,
                });
                self.under_way.len() - 1
            }
        };
        let scan = &mut self.under_way[slot];
        if let Some(earlier) = scan.parts.get(&index) {
            let identical = Some(*earlier == samples);
            report.add(
                place,
                BlemishKind::RepeatedMessage {
                    message_id,
                    index,
                    identical,
                },
            );
        } else {
            if scan.last_index.is_some_and(|last| index < last) {
                report.add(place, BlemishKind::OutOfOrder { message_id, index });
            }
            scan.last_index = Some(scan.last_index.map_or(index, |last| last.max(index)));
            scan.parts.insert(index, samples);
        }
        while self.under_way.front().is_some_and(UnderWay::is_complete)
            || self.under_way.len() > UNDER_WAY
        {
            self.finish_front(false, report, out);
        }
    }

    /// Scans with missing messages that are still expected, or scans that wait for an earlier such scan.
    #[must_use]
    pub fn scans_under_way(&self) -> usize {
        self.under_way.len()
    }

    /// Ends the stream: whole scans are returned, incomplete ones reported.
    pub fn end(&mut self, report: &mut ReadReport, out: &mut VecDeque<Scan>) {
        while !self.under_way.is_empty() {
            self.finish_front(self.under_way.len() == 1, report, out);
        }
    }

    fn finish_front(&mut self, at_end: bool, report: &mut ReadReport, out: &mut VecDeque<Scan>) {
        let Some(scan) = self.under_way.pop_front() else {
            return;
        };
        self.finished.push_back(scan.key);
        if self.finished.len() > REMEMBERED {
            self.finished.pop_front();
        }
        let header = scan.key.0;
        let (message_id, place) = (header.message_id, Place::Byte(scan.offset));
        if !scan.is_complete() {
            let (found, expected) = (scan.parts.len(), scan.expected());
            let kind = BlemishKind::IncompleteScan {
                message_id,
                found,
                expected,
                at_end,
            };
            report.add(place, kind);
            return;
        }
        let samples: Vec<i32> = scan.parts.into_values().flatten().collect();
        let window = header.window();
        if samples.len() != window.samples {
            let (expected, found) = (window.samples, samples.len());
            report.add(
                place,
                BlemishKind::SampleCount {
                    message_id,
                    expected,
                    found,
                },
            );
            return;
        }
        report.whole_scans += 1;
        out.push_back(Scan {
            source_id: header.source_id,
            message_id,
            timestamp_ms: header.timestamp_ms,
            host_time_s: None,
            window,
            filtering: header.filtering,
            antenna_id: header.antenna_id,
            operation_mode: header.operation_mode,
            samples,
        });
    }
}
