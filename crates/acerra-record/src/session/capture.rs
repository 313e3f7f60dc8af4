//! From messages as they came to a capture: each once, in the order the radio made them.

use std::collections::BTreeMap;
use std::io::{self, Write};

use acerra_radar::mrm::{RadarConfig, ScanHeader};

use crate::driver::{Sequence, Standing};
use crate::message::{ConfigConfirm, Message, Packet, StatusCode};

/// Scans for which messages that were overtaken are waited for.
const WAITED_FOR: i64 = 64;

/// When scans came, by number and stamp of the radio.
pub type ArrivalTimes = BTreeMap<(u16, u32), u64>;

/// Writes a capture out of messages as they came.
pub struct CaptureWriter<W> {
    out: W,
    sequence: Sequence,
    /// Messages by scan, index and filtering.
    pending: BTreeMap<(i64, u16, u8), Vec<u8>>,
    newest: i64,
    newest_id: u16,
    written_until: i64,
    config: Option<RadarConfig>,
    arrivals: ArrivalTimes,
    /// Messages that came too late to be put in their place.
    left_out: u64,
}

impl<W: Write> CaptureWriter<W> {
    /// A capture into `out`.
    pub fn new(out: W) -> Self {
        Self {
            out,
            sequence: Sequence::default(),
            pending: BTreeMap::new(),
            newest: 0,
            newest_id: 0,
            written_until: i64::MIN,
            config: None,
            arrivals: ArrivalTimes::new(),
            left_out: 0,
        }
    }

    /// The radio's configuration from here on: at the beginning 32 bytes, later a message.
    ///
    /// # Errors
    /// If the output fails.
    pub fn config(&mut self, config: RadarConfig) -> io::Result<()> {
        match self.config.replace(config) {
            None => self.out.write_all(&config.to_bytes()),
            Some(before) if before == config => Ok(()),
            Some(_) => {
                self.write_below(i64::MAX)?;
                let confirm = ConfigConfirm {
                    config,
                    timestamp_ms: self.sequence.newest_ms().unwrap_or(0),
                    status: StatusCode::Success,
                };
                let packet = Packet {
                    id: 0,
                    message: Message::GetConfigConfirm(confirm),
                };
                self.out.write_all(&packet.encode())
            }
        }
    }

    /// A message body received at `at_ns`; messages other than scans are not part of a capture.
    ///
    /// # Errors
    /// If the output fails.
    pub fn message(&mut self, body: &[u8], at_ns: u64) -> io::Result<()> {
        let Ok(Packet {
            message: Message::ScanInfo(scan),
            ..
        }) = Packet::decode(body)
        else {
            return Ok(());
        };
        let header = scan.header;
        let standing = self.sequence.take(&header);
        if standing == Standing::Restarted {
            self.write_below(i64::MAX)?;
        }
        let Some(number) = self.number(&header, standing) else {
            self.left_out += u64::from(standing != Standing::Repeated);
            return Ok(());
        };
        let arrival = self
            .arrivals
            .entry((header.message_id, header.timestamp_ms))
            .or_insert(at_ns);
        *arrival = at_ns.min(*arrival);
        let key = (number, header.message_index, header.filtering.code());
        self.pending.entry(key).or_insert_with(|| body.to_vec());
        self.write_below(self.newest - WAITED_FOR)
    }

    /// The scan's running number; `None` for a message that is written or whose place is past.
    fn number(&mut self, header: &ScanHeader, standing: Standing) -> Option<i64> {
        let ahead = i64::from(header.message_id.wrapping_sub(self.newest_id) as i16);
        match standing {
            Standing::Repeated => return None,
            Standing::Restarted => {
                self.newest += WAITED_FOR;
                self.newest_id = header.message_id;
                return Some(self.newest);
            }
            // Numbers may have wrapped over a long gap: a new number counts as later.
            Standing::New if ahead < 0 => {
                self.newest += 1;
                self.newest_id = header.message_id;
                return Some(self.newest);
            }
            // Of before a restart: its place is past.
            Standing::Late if ahead.abs() > WAITED_FOR => return None,
            Standing::New | Standing::Reordered | Standing::Late => {}
        }
        let number = self.newest + ahead;
        if ahead > 0 {
            (self.newest, self.newest_id) = (number, header.message_id);
        }
        (number > self.written_until).then_some(number)
    }

    fn write_below(&mut self, limit: i64) -> io::Result<()> {
        while let Some(first) = self.pending.first_entry() {
            let scan = first.key().0;
            if scan >= limit {
                break;
            }
            self.out.write_all(&first.remove())?;
            self.written_until = self.written_until.max(scan);
        }
        Ok(())
    }

    /// Times of arrival of each scan's first message, since the last call.
    pub fn take_arrivals(&mut self) -> ArrivalTimes {
        std::mem::take(&mut self.arrivals)
    }

    /// Writes the remaining scans. Returns the output, and the number of messages that arrived too late for
    /// their place.
    ///
    /// # Errors
    /// If the output fails.
    pub fn finish(mut self) -> io::Result<(W, u64)> {
        self.write_below(i64::MAX)?;
        self.out.flush()?;
        Ok((self.out, self.left_out))
    }
}
