//! ArduPilot's DataFlash logs, `.bin`.
//!
//! The formats are those of ArduPilot's sources (`AP_Logger/LogStructure.h`) and of the page
//! "Onboard message log messages" of its documentation. Positions in 1e-7 degrees are given to 11 mm.

mod layout;
mod messages;

use std::collections::HashMap;
use std::io::Read;

use crate::bytes::LogBytes;
use crate::collect::{ClockSource, Collector, Origin};
use crate::error::LogError;
use crate::format::LogFormat;
use crate::sample::{PairKind, Recording, SourceKind, Teller};

use layout::{FMT_LENGTH, FMT_TYPE, HEADER, Layout, MARK};
use messages::Record;

/// Whether a log begins like this: with the record that defines definitions.
pub fn begins(start: &[u8]) -> bool {
    start.starts_with(&[MARK[0], MARK[1], FMT_TYPE]) && start.get(5..8) != Some(&[0, 0, 0])
}

/// Reads a log.
///
/// # Errors
/// A log that is cut off within a record, damaged beyond use, or beyond the limit.
pub fn read<R: Read>(bytes: &mut LogBytes<R>, limit: usize) -> Result<Recording, LogError> {
    let mut log = Reader {
        layouts: HashMap::new(),
        found: Collector::new(LogFormat::ArduPilot, limit),
        clock_receiver: None,
        last_fix: HashMap::new(),
        gimbal_kinds: HashMap::new(),
    };
    while !bytes.is_at_end()? {
        let offset = bytes.offset();
        let start = bytes.peek(FMT_LENGTH)?;
        if start.len() < HEADER && MARK.starts_with(&start[..start.len().min(2)]) {
            bytes.whole(HEADER, "record's mark")?;
        }
        let Some((kind, length)) = log.next_length(bytes.peek(FMT_LENGTH)?) else {
            log.pass_over(bytes)?;
            continue;
        };
        let what = log.layouts.get(&kind).map_or("FMT", |l| l.name.as_str());
        let what = format!("record {what}");
        let record = bytes.whole(length, &what)?.to_vec();
        if kind == FMT_TYPE {
            log.define(&record, offset)?;
        } else {
            log.take(kind, &record, offset)?;
        }
        bytes.advance(length);
    }
    // Parameters may come after the first angles.
    for (name, teller) in &log.gimbal_kinds {
        let samples = log.found.gimbal_samples(name);
        samples.iter_mut().for_each(|s| s.teller = *teller);
    }
    let clock = ClockSource {
        kind: PairKind::Arrival,
        name: "a record GPS with week and milliseconds",
        allows_own: false,
    };
    log.found.finish(clock, bytes.offset())
}

struct Reader {
    layouts: HashMap<u8, Layout>,
    found: Collector,
    /// The receiver whose messages give the time: the first with a fix.
    clock_receiver: Option<String>,
    /// Clock reading (s) of each receiver's latest record, where that had a position.
    last_fix: HashMap<String, f64>,
    /// The reference of each gimbal's angles by the parameters.
    gimbal_kinds: HashMap<String, Teller>,
}

impl Reader {
    /// Type and length of the record that begins here; none where none that is known does.
    fn next_length(&self, start: &[u8]) -> Option<(u8, usize)> {
        if !start.starts_with(&MARK) {
            return None;
        }
        let kind = *start.get(2)?;
        if kind == FMT_TYPE {
            return Some((kind, FMT_LENGTH));
        }
        Some((kind, self.layouts.get(&kind)?.length))
    }

    /// Goes to the next record of a known type.
    fn pass_over<R: Read>(&mut self, bytes: &mut LogBytes<R>) -> Result<(), LogError> {
        let offset = bytes.offset();
        let (passed, is_blank) =
            bytes.seek(MARK.len() + 1, |start| self.next_length(start).is_some())?;
        // Flash memory that was never written ends many a log.
        if !(is_blank && bytes.is_at_end()?) {
            self.found.damage.add(offset, passed);
        }
        Ok(())
    }

    fn define(&mut self, record: &[u8], offset: u64) -> Result<(), LogError> {
        let (kind, layout) = Layout::of(record).map_err(|found| LogError::Malformed {
            offset,
            expected: "a record FMT whose fields fill its length".to_owned(),
            found,
        })?;
        if kind != FMT_TYPE {
            self.layouts.insert(kind, layout);
        }
        Ok(())
    }

    fn take(&mut self, kind: u8, bytes: &[u8], offset: u64) -> Result<(), LogError> {
        let Some(layout) = self.layouts.get(&kind) else {
            return Ok(());
        };
        let record = Record { layout, bytes };
        match layout.name.as_str() {
            "GPS" | "GPS2" | "GPSB" => {
                let name = record.receiver();
                let position = record.gnss_position();
                match position.and(record.boot_s()) {
                    Some(boot_s) => self.last_fix.insert(name.clone(), boot_s),
                    None => self.last_fix.remove(&name),
                };
                if let Some(pair) = record.clock_pair() {
                    let teller = self.clock_receiver.get_or_insert_with(|| name.clone());
                    if *teller == name {
                        self.found.pair(pair, offset)?;
                    }
                }
                self.found
                    .position(Origin::first(&name, SourceKind::Gnss), position, offset)
            }
            "GPA" | "GPA2" => {
                let name = record.receiver();
                let is_same = self.last_fix.get(&name).copied() == record.boot_s();
                if let Some(position) = self.found.latest(&name).filter(|_| is_same) {
                    record.complete(position);
                }
                Ok(())
            }
            "POS" => {
                let position = record.filter_position();
                self.found
                    .position(Origin::first("POS", SourceKind::Filter), position, offset)
            }
            "ATT" => match record.attitude() {
                Some(attitude) => self.found.attitude("ATT", attitude, offset),
                None => Ok(()),
            },
            "PARM" => {
                self.gimbal_kinds.extend(record.gimbal_kind());
                Ok(())
            }
            "MNT" => {
                let sample = record.gimbal_attitude();
                self.found.gimbal(&record.gimbal(), 0, sample, offset)
            }
            _ => Ok(()),
        }
    }
}
