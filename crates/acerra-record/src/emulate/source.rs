//! Source of an emulated radio's measurements: a recording, or a pattern.

use acerra_radar::mrm::{CONFIG_BYTES, MessageType, RadarConfig, scan_messages};
use acerra_radar::{Filtering, RadarLog, Scan, ScanWindow};
use thiserror::Error;

use crate::driver::window_samples;
use crate::message::{Message, Packet};

/// One scan of a source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceScan {
    /// Radio time at its end, µs.
    pub radio_us: u64,
    /// Its SCAN_INFO messages, in order.
    pub messages: Vec<Vec<u8>>,
}

/// Where the scans of an emulated radio come from.
pub trait ScanSource: Send {
    /// Whether scans can be had with this configuration.
    fn accepts(&self, config: &RadarConfig) -> bool;

    /// The next scan; `None` at the end. `interval_us` is the client's setting.
    fn next_scan(&mut self, config: &RadarConfig, interval_us: u32) -> Option<SourceScan>;
}

/// Scans of a recording, one after another, byte for byte where the recording is a capture.
#[derive(Debug, Clone)]
pub struct Recorded {
    config: Option<RadarConfig>,
    window: ScanWindow,
    scans: std::collections::VecDeque<SourceScan>,
}

/// Reason why a recording cannot be replayed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SourceError {
    /// Nothing to send.
    #[error("expected scans to replay, found none")]
    NoScans,
    /// A scan that no messages can carry.
    #[error("scan {message_id}: {cause}")]
    Scan {
        /// Number.
        message_id: u16,
        /// Cause.
        cause: std::io::Error,
    },
}

impl Recorded {
    /// Every scan of a log, in its order.
    ///
    /// # Errors
    /// A log without scans, or with a scan that no messages can carry.
    pub fn from_log(log: &RadarLog) -> Result<Self, SourceError> {
        let config = log.configs.first().map(|event| event.config);
        Self::from_scans(config, &log.scans)
    }

    /// Scans, in their order.
    ///
    /// # Errors
    /// No scans, or a scan that no messages can carry.
    pub fn from_scans(config: Option<RadarConfig>, scans: &[Scan]) -> Result<Self, SourceError> {
        let mut messages = Vec::new();
        for scan in scans {
            let of_scan = scan_messages(scan).map_err(|cause| SourceError::Scan {
                message_id: scan.message_id,
                cause,
            })?;
            messages.extend(of_scan.map(|message| message.to_vec()));
        }
        Self::from_messages(config, messages)
    }

    /// The bytes of a capture without prefixes: its messages as they are, incomplete scans included.
    /// `None` where other bytes lie between the messages.
    ///
    /// # Errors
    /// A capture without scans.
    pub fn from_capture(bytes: &[u8]) -> Option<Result<Self, SourceError>> {
        let mut rest = bytes;
        let mut config = None;
        if Packet::decode(rest.get(..MessageType::ScanInfo.bytes())?).is_err() {
            let (head, tail) = rest.split_first_chunk::<CONFIG_BYTES>()?;
            config = Some(RadarConfig::from_bytes(head)).filter(RadarConfig::is_plausible);
            config?;
            rest = tail;
        }
        let mut messages = Vec::new();
        while let Some(code) = rest.first_chunk::<2>() {
            let kind = MessageType::from_code(u16::from_be_bytes(*code))?;
            let Some((message, tail)) = rest.split_at_checked(kind.bytes()) else {
                break;
            };
            if kind == MessageType::ScanInfo {
                Packet::decode(message).ok()?;
                messages.push(message.to_vec());
            }
            rest = tail;
        }
        Some(Self::from_messages(config, messages))
    }

    fn from_messages(
        config: Option<RadarConfig>,
        messages: Vec<Vec<u8>>,
    ) -> Result<Self, SourceError> {
        let mut window = None;
        let mut last = None;
        let mut scans = std::collections::VecDeque::<SourceScan>::new();
        for bytes in messages {
            let Some((key, stamp_ms, scan_window)) = scan_of(&bytes) else {
                continue;
            };
            window.get_or_insert(scan_window);
            match scans.back_mut() {
                Some(scan) if last == Some(key) => scan.messages.push(bytes),
                _ => scans.push_back(SourceScan {
                    radio_us: 1000 * u64::from(stamp_ms),
                    messages: vec![bytes],
                }),
            }
            last = Some(key);
        }
        Ok(Self {
            config,
            window: window.ok_or(SourceError::NoScans)?,
            scans,
        })
    }

    /// The configuration that the recording was made with, as far as the recording contains the configuration.
    #[must_use]
    pub fn config(&self) -> RadarConfig {
        RadarConfig {
            scan_start_ps: self.window.start_ps,
            scan_stop_ps: self.window.stop_ps,
            scan_resolution_bins: self.window.step_bins,
            ..self.config.unwrap_or_default()
        }
    }

    /// Scans left.
    #[must_use]
    pub fn remaining(&self) -> usize {
        self.scans.len()
    }

    /// Mean interval between the scans, µs.
    #[must_use]
    pub fn interval_us(&self) -> u32 {
        match (self.scans.front(), self.scans.back()) {
            (Some(first), Some(last)) if self.scans.len() > 1 => {
                let span = last.radio_us.saturating_sub(first.radio_us);
                (span / (self.scans.len() as u64 - 1)) as u32
            }
            _ => 0,
        }
    }
}

/// Identity of a message's scan, the scan's stamp and window.
fn scan_of(bytes: &[u8]) -> Option<((u16, u32, u8), u32, ScanWindow)> {
    let Ok(Packet {
        id,
        message: Message::ScanInfo(scan),
    }) = Packet::decode(bytes)
    else {
        return None;
    };
    let header = scan.header;
    let key = (id, header.timestamp_ms, header.filtering.code());
    Some((key, header.timestamp_ms, header.window()))
}

impl ScanSource for Recorded {
    fn accepts(&self, config: &RadarConfig) -> bool {
        // Recorded scans are not available in another window.
        config.scan_start_ps == self.window.start_ps
            && config.scan_resolution_bins == self.window.step_bins
            && window_samples(config) as usize == self.window.samples
    }

    fn next_scan(&mut self, _config: &RadarConfig, _interval_us: u32) -> Option<SourceScan> {
        self.scans.pop_front()
    }
}

/// Scans of any window whose samples encode scan and position, so that a test can identify each sample.
#[derive(Debug, Clone)]
pub struct Pattern {
    scans: u64,
    made: u64,
    /// Radio time of the latest scan, µs.
    radio_us: u64,
}

impl Pattern {
    /// A number of scans, from a radio that was started a minute before.
    #[must_use]
    pub fn new(scans: u64) -> Self {
        Self {
            scans,
            made: 0,
            radio_us: 60_000_000,
        }
    }

    /// The sample at a place of scan `number`.
    #[must_use]
    pub fn sample(number: u64, place: usize) -> i32 {
        let mixed = (number.wrapping_mul(0x9E37_79B9) ^ place as u64).wrapping_mul(0x85EB_CA6B);
        ((mixed >> 8) as i32 & 0xFFFF) - 0x8000
    }
}

impl ScanSource for Pattern {
    fn accepts(&self, _config: &RadarConfig) -> bool {
        true
    }

    fn next_scan(&mut self, config: &RadarConfig, interval_us: u32) -> Option<SourceScan> {
        if self.made >= self.scans {
            return None;
        }
        let number = self.made;
        self.made += 1;
        self.radio_us += u64::from(interval_us.max(100));
        let samples = window_samples(config) as usize;
        let scan = Scan {
            source_id: config.node_id,
            message_id: number as u16,
            timestamp_ms: (self.radio_us / 1000) as u32,
            host_time_s: None,
            window: ScanWindow {
                start_ps: config.scan_start_ps,
                stop_ps: config.scan_stop_ps,
                step_bins: config.scan_resolution_bins,
                samples,
            },
            filtering: Filtering::Raw,
            antenna_id: config.antenna_mode,
            operation_mode: 1,
            samples: (0..samples).map(|i| Self::sample(number, i)).collect(),
        };
        let messages = scan_messages(&scan).ok()?.map(|m| m.to_vec()).collect();
        Some(SourceScan {
            radio_us: self.radio_us,
            messages,
        })
    }
}
