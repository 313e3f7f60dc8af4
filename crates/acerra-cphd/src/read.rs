//! Reading CPHD 1.x.

use std::io::{Read, Seek, SeekFrom};

use crate::band::CommonBand;
use crate::error::ReadError;
use crate::header::{Block, Header};
use crate::layout::{Layout, ReadOptions};
use crate::model::{Channel, PhaseHistory};
use crate::pulse::{Pulse, read_vectors};
use crate::signal::Signals;

/// Longest XML block that is read (bytes).
const MAX_XML: u64 = 1 << 26;

/// A file as read: one of its channels.
#[derive(Clone, Debug)]
pub struct CphdFile {
    /// The channel, and where it belongs.
    pub history: PhaseHistory<'static>,
    /// Channels that were not read.
    pub other_channels: Vec<String>,
    /// Vectors without a signal, which were left out.
    pub left_out: usize,
}

/// Reads a channel of a CPHD file: monostatic data in the frequency domain, whose frequencies are equal for
/// all pulses.
///
/// Positions are given in a local frame about the origin that Acerra writes into its files, or else about the
/// reference point of the image area. Amplitude factors are applied, samples outside of the band stated and
/// vectors without a signal are left out. Memory is allocated only for data that the file holds.
///
/// # Errors
/// Another kind of file, blocks that do not lie in the file, XML that is malformed or describes unusable data,
/// numbers that are not finite, more samples than [`ReadOptions`] allow.
pub fn read_cphd(
    mut reader: impl Read + Seek,
    options: &ReadOptions,
) -> Result<CphdFile, ReadError> {
    let header = Header::read(&mut reader)?;
    let layout = Layout::parse(&read_xml(&mut reader, header.xml)?)?;
    let wanted = options
        .channel
        .as_ref()
        .unwrap_or(&layout.reference_channel);
    let names = || layout.channels.iter().map(|c| c.name.clone());
    let Some(channel) = layout.channels.iter().find(|c| c.name == *wanted) else {
        return Err(ReadError::NoChannel {
            wanted: wanted.clone(),
            present: names().collect::<Vec<_>>().join(", "),
        });
    };
    if channel.vectors == 0 || channel.samples == 0 {
        return Err(ReadError::Empty {
            channel: wanted.clone(),
        });
    }
    let samples = channel.vectors.saturating_mul(channel.samples);
    if samples > options.max_samples as u64 {
        return Err(ReadError::TooLarge {
            channel: wanted.clone(),
            limit: options.max_samples,
            found: samples,
        });
    }
    let vectors = read_vectors(&mut reader, header.vectors, channel, &layout.parameters)?;
    let band = CommonBand::of(&vectors, channel)?;
    let source = Signals::of(&layout, channel, header.signals)?;
    let kept: Vec<&Pulse> = vectors.iter().filter(|v| v.is_normal).collect();
    let mut spectrum = Vec::new();
    for vector in &kept {
        source.read(&mut reader, vector, &band, &mut spectrum)?;
    }
    let read = Channel {
        name: channel.name.clone(),
        time_s: kept.iter().map(|v| v.time_s).collect(),
        position_m: kept
            .iter()
            .map(|v| layout.frame.enu_from_ecef(v.place_m))
            .collect(),
        frequency: band.frequency,
        spectrum: spectrum.into(),
        fast_time_s: common_fast_time_s(&kept),
    };
    Ok(CphdFile {
        left_out: vectors.len() - kept.len(),
        other_channels: names().filter(|name| name != wanted).collect(),
        history: PhaseHistory {
            frame: layout.frame,
            start: layout.start,
            channels: vec![read],
            description: layout.description,
        },
    })
}

fn read_xml(reader: &mut (impl Read + Seek), block: Block) -> Result<String, ReadError> {
    if block.size > MAX_XML {
        return Err(ReadError::Unsupported {
            what: "XML_BLOCK_SIZE",
            expected: "at most 64 MiB",
            found: format!("{} bytes", block.size),
        });
    }
    reader.seek(SeekFrom::Start(block.offset))?;
    let mut bytes = Vec::new();
    reader.take(block.size).read_to_end(&mut bytes)?;
    String::from_utf8(bytes).map_err(|error| ReadError::Encoding {
        byte: error.utf8_error().valid_up_to(),
    })
}

/// Fast time that the swaths of all vectors hold.
fn common_fast_time_s(vectors: &[&Pulse]) -> Option<[f64; 2]> {
    let extents = vectors.iter().map(|v| v.swath_s.map(|s| s + v.srp_delay_s));
    let [from, to] = extents.fold([f64::NEG_INFINITY, f64::INFINITY], |[from, to], one| {
        [from.max(one[0]), to.min(one[1])]
    });
    (to > from).then_some([from, to])
}
