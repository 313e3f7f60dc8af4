//! Writing the neutral file.

use std::io::{self, Seek, Write};

use acerra_npz::{NpyValue, NpzWriter};
use thiserror::Error;

use super::NeutralContent;
use crate::radargram::{RadargramError, Samples};

/// Reason why a neutral file could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NpzWriteError {
    /// The output failed.
    #[error("writing array `{array}`: {source}")]
    Io {
        /// The array being written.
        array: &'static str,
        /// The failure.
        source: io::Error,
    },
    /// The content is inconsistent.
    #[error(transparent)]
    Radargram(#[from] RadargramError),
}

/// Writes a neutral NPZ file: `data` as float32 or complex64 (or `spectrum` as complex128), the
/// axes and positions as float64.
///
/// # Errors
/// If the content is not valid, the positions are not one a trace, or the output fails.
pub fn write_npz(
    writer: impl Write + Seek,
    content: &NeutralContent,
    position_m: Option<&[[f64; 3]]>,
) -> Result<(), NpzWriteError> {
    match content {
        NeutralContent::Radargram(r) => r.validate()?,
        NeutralContent::Spectrum(s) => s.validate()?,
    }
    let traces = content.time_s().len();
    if let Some(p) = position_m
        && p.len() != traces
    {
        return Err(RadargramError::Length {
            what: "position_m",
            expected: traces,
            found: p.len(),
        }
        .into());
    }
    let mut npz = NpzWriter::deflated(writer);
    let rows = traces as u64;
    match content {
        NeutralContent::Radargram(r) => {
            let shape = [rows, r.samples_per_trace as u64];
            match &r.samples {
                Samples::Real(v) => array(&mut npz, "data", &shape, v)?,
                Samples::Complex(v) => array(&mut npz, "data", &shape, v)?,
            }
            array(&mut npz, "fast_time_s", &shape[1..], &r.fast_time_axis_s())?;
        }
        NeutralContent::Spectrum(s) => {
            let shape = [rows, s.frequency_hz.len() as u64];
            array(&mut npz, "spectrum", &shape, &s.values)?;
            array(&mut npz, "frequency_hz", &shape[1..], &s.frequency_hz)?;
        }
    }
    array(&mut npz, "time_s", &[rows], content.time_s())?;
    if let Some(p) = position_m {
        array(&mut npz, "position_m", &[rows, 3], p.as_flattened())?;
    }
    npz.finish().map(drop).map_err(|source| NpzWriteError::Io {
        array: "(archive)",
        source,
    })
}

fn array<W: Write + Seek, T: NpyValue>(
    npz: &mut NpzWriter<W>,
    name: &'static str,
    shape: &[u64],
    values: &[T],
) -> Result<(), NpzWriteError> {
    npz.array(name, shape, values.iter().copied())
        .map_err(|source| NpzWriteError::Io {
            array: name,
            source,
        })
}
