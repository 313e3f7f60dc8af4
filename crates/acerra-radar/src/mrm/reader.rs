//! Reading a capture, scan by scan or whole.

use std::collections::VecDeque;
use std::io::{self, Read};

use super::assemble::ScanAssembler;
use super::config::RadarConfig;
use super::framer::{Framer, Message};
use super::header::HeaderFault;
use crate::limits::Limits;
use crate::log::{LogBuilder, LogFormat, RadarLog, ReadError};
use crate::report::{BlemishKind, Place, ReadReport};
use crate::scan::Scan;

/// One entry of a capture, in order of the file.
#[derive(Debug, Clone, PartialEq)]
pub enum MrmItem {
    /// A whole scan.
    Scan(Scan),
    /// A configuration and its place.
    Config(RadarConfig, Place),
    /// The interval between scans that the radio was set to, µs.
    Interval(u32),
}

/// Streams whole scans from a capture, holding a few scans at most.
///
/// ```
/// use acerra_radar::{Limits, mrm::MrmReader};
/// # let bytes: &[u8] = &[];
/// let mut reader = MrmReader::new(bytes, Limits::default());
/// for scan in reader.by_ref() {
///     let scan = scan?;
///     println!("{} ms: {} samples", scan.timestamp_ms, scan.samples.len());
/// }
/// assert_eq!(reader.report().incomplete_scans, 0);
/// # Ok::<(), std::io::Error>(())
/// ```
pub struct MrmReader<R> {
    framer: Framer<R>,
    assembler: ScanAssembler,
    limits: Limits,
    report: ReadReport,
    ready: VecDeque<Scan>,
    ended: bool,
}

impl<R: Read> MrmReader<R> {
    /// A reader of a capture; the input need not be buffered.
    pub fn new(reader: R, limits: Limits) -> Self {
        Self {
            framer: Framer::new(reader),
            assembler: ScanAssembler::default(),
            limits,
            report: ReadReport::default(),
            ready: VecDeque::new(),
            ended: false,
        }
    }

    /// Entries counted so far.
    #[must_use]
    pub fn report(&self) -> &ReadReport {
        &self.report
    }

    /// Bytes read from the input.
    #[must_use]
    pub fn offset(&self) -> u64 {
        self.framer.offset()
    }

    /// The next scan, configuration or interval; `None` at the end.
    ///
    /// # Errors
    /// If the input fails. Damage is not an error: damaged bytes are reported and skipped.
    pub fn next_item(&mut self) -> io::Result<Option<MrmItem>> {
        loop {
            if let Some(scan) = self.ready.pop_front() {
                return Ok(Some(MrmItem::Scan(scan)));
            }
            if self.ended {
                return Ok(None);
            }
            let message = self.framer.next(&mut self.report)?;
            self.report.bytes = self.framer.offset();
            match message {
                None => {
                    self.ended = true;
                    self.assembler.end(&mut self.report, &mut self.ready);
                }
                Some(Message::Scan {
                    header,
                    samples,
                    offset,
                }) => {
                    self.report.scan_messages += 1;
                    let limit = self.limits.max_scan_samples;
                    if header.samples_total as usize > limit {
                        let fault = HeaderFault::Limit {
                            samples: header.samples_total,
                            limit,
                        };
                        self.report
                            .add(Place::Byte(offset), BlemishKind::BadHeader(fault));
                        continue;
                    }
                    let (report, ready) = (&mut self.report, &mut self.ready);
                    self.assembler.push(&header, samples, offset, report, ready);
                }
                Some(Message::Config { config, offset }) => {
                    return Ok(Some(MrmItem::Config(config, Place::Byte(offset))));
                }
                Some(Message::Control { interval_us }) => {
                    return Ok(Some(MrmItem::Interval(interval_us)));
                }
                Some(Message::Other(kind)) => self.report.count_other(kind.name()),
            }
        }
    }
}

impl<R: Read> Iterator for MrmReader<R> {
    type Item = io::Result<Scan>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.next_item() {
                Ok(Some(MrmItem::Scan(scan))) => return Some(Ok(scan)),
                Ok(Some(_)) => {}
                Ok(None) => return None,
                Err(e) => return Some(Err(e)),
            }
        }
    }
}

/// Reads a whole capture.
///
/// # Errors
/// If the input fails, holds no whole scan, or more samples than [`Limits::max_samples`].
pub fn read_mrm(reader: impl Read, limits: &Limits) -> Result<RadarLog, ReadError> {
    let mut reader = MrmReader::new(reader, *limits);
    let mut builder = LogBuilder::new(LogFormat::Mrm, limits.max_samples);
    while let Some(item) = reader.next_item()? {
        let place = Place::Byte(reader.framer.offset());
        match item {
            MrmItem::Scan(scan) => builder.scan(place, scan, &mut reader.report)?,
            MrmItem::Config(config, place) => builder.config(place, config, &mut reader.report),
            MrmItem::Interval(interval_us) => builder.interval(interval_us),
        }
    }
    builder.finish(reader.report)
}
