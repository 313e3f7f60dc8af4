//! A radar log: every whole scan of a file, with its configurations and the report of the reader.

use std::fmt;
use std::io;

use thiserror::Error;

use crate::mrm::{HeaderFault, RadarConfig};
use crate::report::{BlemishKind, Place, ReadReport};
use crate::scan::Scan;

/// Kinds of log this crate reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LogFormat {
    /// Binary messages of the radio ([`mrm`](crate::mrm)).
    Mrm,
    /// Text log of the vendor's MRM-RET program ([`ret`](crate::ret)).
    MrmRet,
}

impl fmt::Display for LogFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mrm => "MRM capture",
            Self::MrmRet => "MRM-RET log",
        })
    }
}

/// A configuration in a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConfigEvent {
    /// Number of whole scans before the configuration.
    pub before_scan: usize,
    /// The configuration.
    pub config: RadarConfig,
}

/// A log as read: every whole scan, whatever its filtering and window.
#[derive(Debug, Clone, PartialEq)]
pub struct RadarLog {
    /// Kind of log.
    pub format: LogFormat,
    /// Configurations, in the order of the file.
    pub configs: Vec<ConfigEvent>,
    /// Interval between scans that the radio was set to, µs (0: as fast as possible).
    pub requested_interval_us: Option<u32>,
    /// Whole scans, in the order in which they began.
    pub scans: Vec<Scan>,
    /// Records read, skipped and missing.
    pub report: ReadReport,
}

/// Reason why a log could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The input failed.
    #[error("reading failed: {0}")]
    Io(#[from] io::Error),
    /// The file is empty.
    #[error("the file is empty")]
    Empty,
    /// The content is of unknown kind.
    #[error(
        "not a radar file: expected an MRM capture, an MRM-RET text log or an NPZ archive, found \
         {found}"
    )]
    Unrecognised {
        /// The first bytes, in words.
        found: String,
    },
    /// Fields are little-endian.
    #[error(
        "{place}: SCAN_INFO message with its bytes swapped (little-endian); MRM captures are \
         big-endian"
    )]
    WrongEndian {
        /// Place of the first such message.
        place: Place,
    },
    /// The first message is inconsistent and no valid message follows nearby.
    #[error("{place}: SCAN_INFO header: {fault}")]
    BadHeader {
        /// Where it is.
        place: Place,
        /// Fault.
        fault: HeaderFault,
    },
    /// No whole scan in the file.
    #[error("no whole scan in the file{}", first_blemish(.report))]
    NoScans {
        /// What was met.
        report: Box<ReadReport>,
    },
    /// More samples than the limit.
    #[error("{place}: more than {limit} samples in the file (the reader's limit)")]
    Limit {
        /// Place at which the limit was exceeded.
        place: Place,
        /// The limit.
        limit: usize,
    },
}

fn first_blemish(report: &ReadReport) -> String {
    report
        .blemishes
        .first()
        .map(|b| format!("; {b}"))
        .unwrap_or_default()
}

/// Collects the scans of a reader of either kind.
pub(crate) struct LogBuilder {
    log: RadarLog,
    samples: usize,
    limit: usize,
}

impl LogBuilder {
    pub(crate) fn new(format: LogFormat, limit: usize) -> Self {
        let log = RadarLog {
            format,
            configs: Vec::new(),
            requested_interval_us: None,
            scans: Vec::new(),
            report: ReadReport::default(),
        };
        Self {
            log,
            samples: 0,
            limit,
        }
    }

    pub(crate) fn config(&mut self, place: Place, config: RadarConfig, report: &mut ReadReport) {
        let before_scan = self.log.scans.len();
        let changed = self
            .log
            .configs
            .last()
            .is_none_or(|last| last.config != config);
        if changed {
            if before_scan > 0 {
                report.add(place, BlemishKind::Reconfigured);
            }
            self.log.configs.push(ConfigEvent {
                before_scan,
                config,
            });
        }
    }

    pub(crate) fn interval(&mut self, interval_us: u32) {
        self.log.requested_interval_us = Some(interval_us);
    }

    pub(crate) fn scan(
        &mut self,
        place: Place,
        scan: Scan,
        report: &mut ReadReport,
    ) -> Result<(), ReadError> {
        self.samples = self.samples.saturating_add(scan.samples.len());
        if self.samples > self.limit {
            return Err(ReadError::Limit {
                place,
                limit: self.limit,
            });
        }
        let before = self
            .log
            .scans
            .iter()
            .rev()
            .find(|s| s.filtering == scan.filtering);
        if let Some(from) = before.map(|s| s.window)
            && from != scan.window
        {
            report.add(
                place,
                BlemishKind::WindowChanged {
                    from,
                    to: scan.window,
                },
            );
        }
        self.log.scans.push(scan);
        Ok(())
    }

    pub(crate) fn finish(mut self, report: ReadReport) -> Result<RadarLog, ReadError> {
        if self.log.scans.is_empty() {
            return Err(ReadError::NoScans {
                report: Box::new(report),
            });
        }
        self.log.report = report;
        Ok(self.log)
    }
}
