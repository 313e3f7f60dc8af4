//! Beat signals in an NPZ archive.

use std::io::{Read, Seek};

use acerra_npz::{NpzError, NpzReader};
use num_complex::Complex64;

use super::deramp::{Chirp, deramp};
use crate::error::{FormatError, Place};
use crate::limits::Limits;
use crate::recording::{Axis, Channel, Format, Positions, Recording, Values};

/// Whether an archive holds beat signals.
pub fn is_beat_npz(reader: impl Read + Seek) -> bool {
    NpzReader::new(reader)
        .is_ok_and(|archive| archive.members().iter().any(|name| name == "beat.npy"))
}

fn broken(error: NpzError) -> FormatError {
    FormatError::content(Place::Whole, "a readable NPZ archive", error)
}

/// Reads `beat` `[traces, samples]` with `start_frequency_hz`, `slope_hz_per_s` and `sample_rate_hz`, and
/// `time_s` and `position_m` if present. `conjugate`, a number other than 0, means that phases of echoes lag.
///
/// # Errors
/// An archive that is broken or lacks an array, arrays of another shape, more than `limits` admit.
pub fn read_beat_npz(reader: impl Read + Seek, limits: &Limits) -> Result<Recording, FormatError> {
    let mut archive = NpzReader::new(reader).map_err(broken)?;
    let members = archive.members();
    let has = |name: &str| members.iter().any(|m| m.strip_suffix(".npy") == Some(name));
    let limit = usize::try_from(limits.max_samples).unwrap_or(usize::MAX);
    let is_fortran = archive
        .with("beat", |header, _| Ok(header.fortran_order))
        .map_err(broken)?;
    let (shape, values) = archive.values("beat", limit).map_err(broken)?;
    let [traces, samples] = match shape[..] {
        [traces, samples] if traces > 0 && samples > 1 => [traces as usize, samples as usize],
        _ => {
            return Err(FormatError::content(
                Place::field("beat"),
                "[traces, samples]",
                format!("{shape:?}"),
            ));
        }
    };
    limits.check_trace(Place::field("beat"), samples as u64)?;
    let at = |i: usize| {
        if is_fortran {
            values[i % samples * traces + i / samples]
        } else {
            values[i]
        }
    };
    let beat: Vec<Complex64> = (0..traces * samples)
        .map(|i| Complex64::new(at(i).0, at(i).1))
        .collect();
    let mut scalar = |name: &'static str| -> Result<f64, FormatError> {
        let (_, values) = archive.values(name, 1).map_err(broken)?;
        match values[..] {
            [(value, _)] if value.is_finite() && value != 0.0 => Ok(value),
            _ => Err(FormatError::content(
                Place::field(name),
                "one number other than 0",
                format!("{} values", values.len()),
            )),
        }
    };
    let chirp = Chirp {
        start_frequency_hz: scalar("start_frequency_hz")?,
        slope_hz_per_s: scalar("slope_hz_per_s")?,
        sample_rate_hz: scalar("sample_rate_hz")?,
        is_conjugate: has("conjugate") && scalar("conjugate").is_ok(),
    };
    if chirp.sample_rate_hz < 0.0 {
        return Err(FormatError::content(
            Place::field("sample_rate_hz"),
            "a positive number",
            chirp.sample_rate_hz,
        ));
    }
    let spectra = deramp(&beat, samples, &chirp);
    let mut recording = Recording::new(Format::Fmcw);
    describe(&mut recording, &chirp, samples);
    let axis = Axis::Frequency(chirp.frequency_hz(samples));
    let mut channel = Channel::new("1", traces, axis, Values::Complex(spectra));
    if has("time_s") {
        let (_, values) = archive.values("time_s", limit).map_err(broken)?;
        channel.time_s = Some(values.into_iter().map(|v| v.0).collect());
    }
    if has("position_m") {
        let is_fortran = archive
            .with("position_m", |header, _| Ok(header.fortran_order))
            .map_err(broken)?;
        let (shape, v) = archive.values("position_m", limit).map_err(broken)?;
        if shape != [traces as u64, 3] {
            return Err(FormatError::content(
                Place::field("position_m"),
                format!("[{traces}, 3]"),
                format!("{shape:?}"),
            ));
        }
        let index = |i: usize, k: usize| {
            if is_fortran {
                k * traces + i
            } else {
                3 * i + k
            }
        };
        channel.positions = Some(Positions::Local(
            (0..traces)
                .map(|i| [0, 1, 2].map(|k| v[index(i, k)].0))
                .collect(),
        ));
    }
    recording.channels.push(channel);
    recording.checked()
}

/// What the chirp can see.
pub(super) fn describe(recording: &mut Recording, chirp: &Chirp, samples: usize) {
    recording.fact("start_frequency_hz", chirp.start_frequency_hz);
    recording.fact("slope_hz_per_s", chirp.slope_hz_per_s);
    recording.fact("sample_rate_hz", chirp.sample_rate_hz);
    recording.fact(
        "bandwidth_hz",
        chirp.slope_hz_per_s.abs() * samples as f64 / chirp.sample_rate_hz,
    );
}
