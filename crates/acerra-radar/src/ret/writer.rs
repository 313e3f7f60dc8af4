//! Writing an MRM-RET log, as the vendor's program would.

use std::io::{self, Write};

use crate::mrm::RadarConfig;
use crate::scan::Scan;

const HEADINGS: [&str; 3] = [
    "Timestamp, Config, NodeId, ScanStartPs, ScanStopPs, ScanResolutionBins, \
     BaseIntegrationIndex, Segment1NumSamples, Segment2NumSamples, Segment3NumSamples, \
     Segment4NumSamples, Segment1AdditionalIntegration, Segment2AdditionalIntegration, \
     Segment3AdditionalIntegration, Segment4AdditionalIntegration, AntennaMode, \
     TransmitGain, CodeChannel",
    "Timestamp, MrmControlRequest, MessageId, ScanCount, IntervalTimeMicroseconds",
    "Timestamp, MrmFullScanInfo, MessageId, SourceId, EmbeddedTimestamp, Reserved, Reserved, \
     Reserved, Reserved, ScanStartPs, ScanStopPs, ScanStepBins, Filtering, AntennaId, \
     OperationMode, NumberSamplesTotal, ScanData",
];

/// Writes events line by line.
///
/// ```
/// use acerra_radar::{Limits, mrm::RadarConfig, ret::RetWriter};
/// let mut text = Vec::new();
/// let mut writer = RetWriter::new(&mut text)?;
/// writer.config(1.25, &RadarConfig::default())?;
/// assert!(String::from_utf8(text)?.lines().last().unwrap().starts_with("1.25, Config, 1, 0, "));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct RetWriter<W> {
    writer: W,
}

impl<W: Write> RetWriter<W> {
    /// A writer that has written the headings.
    ///
    /// # Errors
    /// If the output fails.
    pub fn new(mut writer: W) -> io::Result<Self> {
        for heading in HEADINGS {
            writeln!(writer, "{heading}")?;
        }
        Ok(Self { writer })
    }

    /// Writes a `Config` line.
    ///
    /// # Errors
    /// If the output fails.
    pub fn config(&mut self, host_time_s: f64, config: &RadarConfig) -> io::Result<()> {
        write!(
            self.writer,
            "{host_time_s}, Config, {}, {}, {}, {}, {}",
            config.node_id,
            config.scan_start_ps,
            config.scan_stop_ps,
            config.scan_resolution_bins,
            config.integration_index
        )?;
        for samples in config.segment_samples {
            write!(self.writer, ", {samples}")?;
        }
        for integration in config.segment_integration {
            write!(self.writer, ", {integration}")?;
        }
        writeln!(
            self.writer,
            ", {}, {}, {}",
            config.antenna_mode, config.transmit_gain, config.code_channel
        )
    }

    /// Writes an `MrmControlRequest` line.
    ///
    /// # Errors
    /// If the output fails.
    pub fn control(
        &mut self,
        host_time_s: f64,
        message_id: u16,
        scan_count: u16,
        interval_us: u32,
    ) -> io::Result<()> {
        writeln!(
            self.writer,
            "{host_time_s}, MrmControlRequest, {message_id}, {scan_count}, {interval_us}"
        )
    }

    /// Writes an `MrmFullScanInfo` line; a scan without host time gets the radio's.
    ///
    /// # Errors
    /// If the output fails.
    pub fn scan(&mut self, scan: &Scan) -> io::Result<()> {
        let host_time_s = scan
            .host_time_s
            .unwrap_or(f64::from(scan.timestamp_ms) * 1e-3);
        write!(
            self.writer,
            "{host_time_s}, MrmFullScanInfo, {}, {}, {}, 0, 0, 0, 0, {}, {}, {}, {}, {}, {}, {}",
            scan.message_id,
            scan.source_id,
            scan.timestamp_ms,
            scan.window.start_ps,
            scan.window.stop_ps,
            scan.window.step_bins,
            scan.filtering.code(),
            scan.antenna_id,
            scan.operation_mode,
            scan.samples.len()
        )?;
        for sample in &scan.samples {
            write!(self.writer, ", {sample}")?;
        }
        writeln!(self.writer)
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
