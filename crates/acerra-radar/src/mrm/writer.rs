//! Writing a capture, byte for byte as the radio sends it.

use std::io::{self, Write};

use super::config::RadarConfig;
use super::header::{HEADER_BYTES, SAMPLES_PER_MESSAGE, SCAN_MESSAGE_BYTES, ScanHeader};
use super::message::SERIAL_PREFIX;
use crate::scan::Scan;

/// Prefix of each message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Framing {
    /// No prefix: bodies as UDP carries them.
    #[default]
    Bare,
    /// 0xA5A5 and the length, as USB and serial links carry them.
    Serial,
}

/// Writes scans as SCAN_INFO messages.
///
/// ```
/// use acerra_radar::mrm::{Framing, MrmWriter, RadarConfig};
/// let mut bytes = Vec::new();
/// let writer = MrmWriter::new(&mut bytes, Framing::Bare, Some(&RadarConfig::default()))?;
/// writer.finish()?;
/// assert_eq!(bytes.len(), 32);
/// # Ok::<(), std::io::Error>(())
/// ```
pub struct MrmWriter<W> {
    writer: W,
    framing: Framing,
}

impl<W: Write> MrmWriter<W> {
    /// A writer; a given configuration is written first.
    ///
    /// # Errors
    /// If the output fails.
    pub fn new(mut writer: W, framing: Framing, config: Option<&RadarConfig>) -> io::Result<Self> {
        if let Some(config) = config {
            writer.write_all(&config.to_bytes())?;
        }
        Ok(Self { writer, framing })
    }

    /// Writes every message of a scan.
    ///
    /// # Errors
    /// If the output fails, or the scan has no samples, more than 65 535 messages' worth, or
    /// another number than its window declares ([`io::ErrorKind::InvalidInput`]).
    pub fn scan(&mut self, scan: &Scan) -> io::Result<()> {
        for message in scan_messages(scan)? {
            self.message(&message)?;
        }
        Ok(())
    }

    /// Writes one message body after the framing's prefix.
    ///
    /// # Errors
    /// If the output fails or the body is longer than 65 535 bytes.
    pub fn message(&mut self, body: &[u8]) -> io::Result<()> {
        if self.framing == Framing::Serial {
            let length = u16::try_from(body.len())
                .map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "message too long"))?;
            self.writer.write_all(&SERIAL_PREFIX)?;
            self.writer.write_all(&length.to_be_bytes())?;
        }
        self.writer.write_all(body)
    }

    /// Flushes and returns the output.
    ///
    /// # Errors
    /// If the output fails.
    pub fn finish(mut self) -> io::Result<W> {
        self.writer.flush()?;
        Ok(self.writer)
    }
}

/// The SCAN_INFO messages of a scan, in order.
///
/// # Errors
/// If the scan has no samples, more than 65 535 messages' worth, or another number than its window
/// declares ([`io::ErrorKind::InvalidInput`]).
pub fn scan_messages(scan: &Scan) -> io::Result<impl Iterator<Item = [u8; SCAN_MESSAGE_BYTES]>> {
    let invalid = |why| io::Error::new(io::ErrorKind::InvalidInput, why);
    if scan.samples.is_empty() || scan.samples.len() != scan.window.samples {
        return Err(invalid(
            "a scan must hold as many samples as its window declares",
        ));
    }
    let messages_total = u16::try_from(scan.samples.len().div_ceil(SAMPLES_PER_MESSAGE))
        .map_err(|_| invalid("a scan must fit 65 535 messages of 350 samples"))?;
    Ok(scan
        .samples
        .chunks(SAMPLES_PER_MESSAGE)
        .zip(0u16..)
        .map(move |(chunk, message_index)| {
            let header = ScanHeader {
                message_id: scan.message_id,
                source_id: scan.source_id,
                timestamp_ms: scan.timestamp_ms,
                reserved: [0; 4],
                scan_start_ps: scan.window.start_ps,
                scan_stop_ps: scan.window.stop_ps,
                scan_step_bins: scan.window.step_bins,
                filtering: scan.filtering,
                // Every message of the radios that made the known captures holds 3 in this field.
                reserved_byte: 3,
                antenna_id: scan.antenna_id,
                operation_mode: scan.operation_mode,
                samples_in_message: chunk.len() as u16,
                samples_total: scan.samples.len() as u32,
                message_index,
                messages_total,
            };
            let mut message = [0; SCAN_MESSAGE_BYTES];
            message[..HEADER_BYTES].copy_from_slice(&header.to_bytes());
            for (bytes, sample) in message[HEADER_BYTES..].chunks_exact_mut(4).zip(chunk) {
                bytes.copy_from_slice(&sample.to_be_bytes());
            }
            message
        }))
}

/// Writes a whole capture: configuration (if given), then every scan.
///
/// # Errors
/// As [`MrmWriter::scan`].
pub fn write_mrm<'a, W: Write>(
    writer: W,
    framing: Framing,
    config: Option<&RadarConfig>,
    scans: impl IntoIterator<Item = &'a Scan>,
) -> io::Result<W> {
    let mut writer = MrmWriter::new(writer, framing, config)?;
    for scan in scans {
        writer.scan(scan)?;
    }
    writer.finish()
}
