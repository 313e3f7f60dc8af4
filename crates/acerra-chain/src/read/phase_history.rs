//! Spectra with positions from phase history data (CPHD).

use std::io::{Read, Seek};

use acerra_cphd::{CphdFile, ReadError, ReadOptions, read_cphd};
use acerra_geo::trajectory::{Frame, TimeOrigin};
use acerra_radar::{RadargramError, Spectrum};

use crate::read::trace_positions::TracePositions;

/// Content of a CPHD file for the chain.
pub(crate) struct PhaseHistory {
    /// Spectra, ready for the adjoint.
    pub spectrum: Spectrum,
    /// Positions at which the spectra were measured.
    pub positions: TracePositions,
    /// One line on the file.
    pub summary: String,
    /// Remarks on content of the file that is not used.
    pub remarks: Vec<String>,
}

/// Reason why phase history data cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PhaseHistoryError {
    /// The file cannot be read, or holds data of a kind that cannot be used.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The values make no spectra.
    #[error(transparent)]
    Spectrum(#[from] RadargramError),
}

/// Reads `channel` of a file, or its reference channel.
pub(crate) fn read_phase_history(
    reader: impl Read + Seek,
    channel: Option<&str>,
) -> Result<PhaseHistory, PhaseHistoryError> {
    let mut options = ReadOptions::default();
    options.channel = channel.map(str::to_owned);
    let CphdFile {
        history,
        other_channels,
        left_out,
    } = read_cphd(reader, &options)?;
    let (frame, start) = (history.frame, history.start);
    let mut channels = history.channels.into_iter();
    let Some(read) = channels.next() else {
        let channel = channel.unwrap_or_default().to_owned();
        return Err(ReadError::Empty { channel }.into());
    };
    let mut remarks = Vec::new();
    if channel.is_none() && !other_channels.is_empty() {
        remarks.push(format!(
            "channel {:?} is used; [radar] channel names another: {}",
            read.name,
            other_channels.join(", ")
        ));
    }
    if left_out > 0 {
        remarks.push(format!(
            "{left_out} vectors hold no signal and were left out"
        ));
    }
    let summary = format!(
        "CPHD phase history {:?}, {} pulses × {} frequencies",
        history.description.name,
        read.time_s.len(),
        read.frequency.count
    );
    let frequency_hz = (0..read.frequency.count).map(|n| read.frequency.hz(n));
    Ok(PhaseHistory {
        spectrum: Spectrum::new(
            frequency_hz.collect(),
            read.spectrum.into_owned(),
            read.time_s,
        )?,
        positions: TracePositions {
            position_m: read.position_m,
            antennas_m: None,
            line_starts: Vec::new(),
            is_by_line_ends: false,
            frame: Frame::Enu(frame),
            time_origin: start.map_or(TimeOrigin::Relative, TimeOrigin::Gps),
        },
        summary,
        remarks,
    })
}
