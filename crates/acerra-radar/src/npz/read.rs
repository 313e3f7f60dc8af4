//! Reading the neutral file.

use std::io::{self, Read, Seek};

use acerra_npz::{NpyError, NpyHeader, NpzError as ArchiveError, NpzReader};
use num_complex::{Complex32, Complex64};
use thiserror::Error;

use super::{NeutralContent, NeutralFile};
use crate::limits::Limits;
use crate::radargram::{Radargram, RadargramError, Samples};
use crate::spectrum::Spectrum;

/// Largest distance of a fast time from the even axis, as a fraction of the step. At 4.8 GHz and 61 ps it is
/// 2 mrad of phase.
pub const FAST_TIME_TOLERANCE: f64 = 1e-3;

/// Reason why a neutral file could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NpzError {
    /// The archive itself is damaged.
    #[error("not a readable NPZ archive: {0}")]
    Archive(io::Error),
    /// An array is present but damaged.
    #[error("array `{array}`: {source}")]
    Array {
        /// The array's name.
        array: &'static str,
        /// Defect found.
        source: NpyError,
    },
    /// A needed array is absent.
    #[error("array `{array}` is missing{because}; the archive holds: {present}")]
    Missing {
        /// The array's name.
        array: &'static str,
        /// Reason why it is needed.
        because: &'static str,
        /// Names of the arrays in the archive.
        present: String,
    },
    /// The archive holds both kinds of content.
    #[error("both `data` and `spectrum` are present: keep the one to be imaged")]
    Ambiguous,
    /// A value is NaN or infinite (or too large for single precision, in `data`).
    #[error("array `{array}`: value at {index:?} is not a finite number")]
    NotFinite {
        /// The array's name.
        array: &'static str,
        /// Index, one number a dimension.
        index: Vec<usize>,
    },
    /// Fast time is not evenly spaced.
    #[error(
        "array `fast_time_s`: value {index} is {off_s:e} s off an evenly spaced axis of step \
         {step_s:e} s (tolerance {FAST_TIME_TOLERANCE} steps); resample the data first"
    )]
    UnevenFastTime {
        /// Index of the value farthest from the axis.
        index: usize,
        /// How far off it is, s.
        off_s: f64,
        /// Step of the even axis, s.
        step_s: f64,
    },
    /// The arrays do not make a radargram or spectrum.
    #[error(transparent)]
    Radargram(#[from] RadargramError),
}

impl From<ArchiveError> for NpzError {
    fn from(error: ArchiveError) -> Self {
        match error {
            ArchiveError::Array { array, source } => Self::Array { array, source },
            ArchiveError::Archive(source) => Self::Archive(source),
            other => Self::Archive(io::Error::other(other)),
        }
    }
}

/// Reads a neutral NPZ file (see the [module](super)).
///
/// Memory is allocated for as many bytes as the archive's length justifies, whatever a header claims; each
/// array is read up to [`Limits::max_samples`] values and checked against the archive's checksum.
///
/// # Errors
/// If the archive or an array is damaged, an array is missing or of the wrong shape, fast time is not even
/// within [`FAST_TIME_TOLERANCE`] of a step, or any number is not finite.
///
/// ```
/// use acerra_radar::{Limits, NeutralContent, Radargram, Samples, npz};
/// let radargram =
///     Radargram::new(vec![0.0, 0.1], 0.0, 61e-12, Samples::Real(vec![1.0, 2.0, 3.0, 4.0]))?;
/// let content = NeutralContent::Radargram(radargram);
/// let mut file = std::io::Cursor::new(Vec::new());
/// npz::write_npz(&mut file, &content, None)?;
/// assert_eq!(npz::read_npz(file, &Limits::default())?.content, content);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_npz(reader: impl Read + Seek, limits: &Limits) -> Result<NeutralFile, NpzError> {
    let mut archive = NpzReader::new(reader)?;
    let mut names = archive.members();
    let has = |name: &str| names.iter().any(|n| n.strip_suffix(".npy") == Some(name));
    let present = names.join(", ");
    let missing = |array, because| NpzError::Missing {
        array,
        because,
        present: present.clone(),
    };

    let mut used = vec!["time_s", "position_m", "transmitter_m", "receiver_m"];
    let (content, traces) = match (has("data"), has("spectrum")) {
        (true, true) => return Err(NpzError::Ambiguous),
        (false, false) => return Err(missing("data", " (or `spectrum`)")),
        (true, false) => {
            if !has("fast_time_s") {
                return Err(missing("fast_time_s", " with `data`"));
            }
            used.extend(["data", "fast_time_s"]);
            let (samples, shape) = read_data(&mut archive, limits)?;
            let fast_time_s = read_vector(&mut archive, "fast_time_s", Some(shape[1]), limits)?;
            (Loaded::Data(samples, fast_time_s), shape[0])
        }
        (false, true) => {
            if !has("frequency_hz") {
                return Err(missing("frequency_hz", " with `spectrum`"));
            }
            used.extend(["spectrum", "frequency_hz"]);
            let (values, shape) = read_spectrum(&mut archive, limits)?;
            let frequency_hz = read_vector(&mut archive, "frequency_hz", Some(shape[1]), limits)?;
            (Loaded::Spectrum(values, frequency_hz), shape[0])
        }
    };
    let position_m = has("position_m")
        .then(|| read_places(&mut archive, "position_m", traces, limits))
        .transpose()?;
    let antennas_m = match (has("transmitter_m"), has("receiver_m")) {
        (false, false) => None,
        (true, false) => return Err(missing("receiver_m", " with `transmitter_m`")),
        (false, true) => return Err(missing("transmitter_m", " with `receiver_m`")),
        (true, true) => Some([
            read_places(&mut archive, "transmitter_m", traces, limits)?,
            read_places(&mut archive, "receiver_m", traces, limits)?,
        ]),
    };
    let middles = |[transmitter_m, receiver_m]: &[Vec<[f64; 3]>; 2]| {
        let places = transmitter_m.iter().zip(receiver_m);
        let middle = |(t, r): (&[f64; 3], &[f64; 3])| std::array::from_fn(|k| 0.5 * (t[k] + r[k]));
        places.map(middle).collect()
    };
    let position_m = position_m.or_else(|| antennas_m.as_ref().map(middles));
    let time_missing = !has("time_s");
    let time_s = if !time_missing {
        read_vector(&mut archive, "time_s", Some(traces), limits)?
    } else if position_m.is_some() {
        (0..traces).map(|i| i as f64).collect()
    } else {
        return Err(missing("time_s", " (needed unless `position_m` is given)"));
    };
    let content = match content {
        Loaded::Data(samples, fast_time_s) => {
            let (start_s, step_s) = even_axis(&fast_time_s)?;
            NeutralContent::Radargram(Radargram::new(time_s, start_s, step_s, samples)?)
        }
        Loaded::Spectrum(values, frequency_hz) => {
            NeutralContent::Spectrum(Spectrum::new(frequency_hz, values, time_s)?)
        }
    };
    names.retain(|n| !used.iter().any(|u| n.strip_suffix(".npy") == Some(u)));
    Ok(NeutralFile {
        content,
        position_m,
        antennas_m,
        time_missing,
        ignored: names,
    })
}

enum Loaded {
    Data(Samples, Vec<f64>),
    Spectrum(Vec<Complex64>, Vec<f64>),
}

fn matrix_shape(header: &NpyHeader, what: &str) -> Result<[usize; 2], NpyError> {
    let shape = |expected: String| NpyError::Shape {
        expected,
        found: header.shape.clone(),
    };
    match header.shape[..] {
        [rows, columns] if rows > 0 && columns > 0 => Ok([rows as usize, columns as usize]),
        _ => Err(shape(format!("[traces, {what}], both above 0"))),
    }
}

/// Row-major from column-major, for arrays stored so.
fn row_major<T: Copy>(values: Vec<T>, shape: [usize; 2], fortran_order: bool) -> Vec<T> {
    if !fortran_order {
        return values;
    }
    let [rows, columns] = shape;
    (0..rows * columns)
        .map(|i| values[i % columns * rows + i / columns])
        .collect()
}

fn not_finite(array: &'static str, flat: usize, columns: usize) -> NpzError {
    NpzError::NotFinite {
        array,
        index: vec![flat / columns, flat % columns],
    }
}

fn read_data<R: Read + Seek>(
    archive: &mut NpzReader<R>,
    limits: &Limits,
) -> Result<(Samples, [usize; 2]), NpzError> {
    let (samples, shape) = archive.with("data", |header, mut reader| {
        let limit = limits.max_samples;
        let count = header.value_count(limit)?;
        let shape = matrix_shape(header, "samples")?;
        let samples = if header.is_complex() {
            let mut v = Vec::with_capacity(count);
            header.read_values(&mut reader, limit, |re, im| {
                v.push(Complex32::new(re as f32, im as f32));
            })?;
            Samples::Complex(row_major(v, shape, header.fortran_order))
        } else {
            let mut v = Vec::with_capacity(count);
            header.read_values(&mut reader, limit, |re, _| v.push(re as f32))?;
            Samples::Real(row_major(v, shape, header.fortran_order))
        };
        Ok((samples, shape))
    })?;
    match samples.first_non_finite() {
        Some(flat) => Err(not_finite("data", flat, shape[1])),
        None => Ok((samples, shape)),
    }
}

fn read_spectrum<R: Read + Seek>(
    archive: &mut NpzReader<R>,
    limits: &Limits,
) -> Result<(Vec<Complex64>, [usize; 2]), NpzError> {
    let (values, shape) = archive.with("spectrum", |header, mut reader| {
        let count = header.value_count(limits.max_samples)?;
        let shape = matrix_shape(header, "N")?;
        let mut v = Vec::with_capacity(count);
        header.read_values(&mut reader, limits.max_samples, |re, im| {
            v.push(Complex64::new(re, im));
        })?;
        Ok((row_major(v, shape, header.fortran_order), shape))
    })?;
    match values
        .iter()
        .position(|z| !z.re.is_finite() || !z.im.is_finite())
    {
        Some(flat) => Err(not_finite("spectrum", flat, shape[1])),
        None => Ok((values, shape)),
    }
}

fn read_vector<R: Read + Seek>(
    archive: &mut NpzReader<R>,
    array: &'static str,
    expected: Option<usize>,
    limits: &Limits,
) -> Result<Vec<f64>, NpzError> {
    let values = archive.with(array, |header, mut reader| {
        let n = header.value_count(limits.max_samples)?;
        let wanted = expected.unwrap_or(n);
        if header.is_complex() {
            return Err(NpyError::ElementType {
                found: "complex".into(),
            });
        }
        if header.shape.len() != 1 || n != wanted {
            return Err(NpyError::Shape {
                expected: format!("[{wanted}]"),
                found: header.shape.clone(),
            });
        }
        let mut v = Vec::new();
        header.read_values(&mut reader, limits.max_samples, |re, _| v.push(re))?;
        Ok(v)
    })?;
    match values.iter().position(|t| !t.is_finite()) {
        Some(i) => Err(NpzError::NotFinite {
            array,
            index: vec![i],
        }),
        None => Ok(values),
    }
}

fn read_places<R: Read + Seek>(
    archive: &mut NpzReader<R>,
    array: &'static str,
    traces: usize,
    limits: &Limits,
) -> Result<Vec<[f64; 3]>, NpzError> {
    let values = archive.with(array, |header, mut reader| {
        header.value_count(limits.max_samples)?;
        if header.is_complex() {
            return Err(NpyError::ElementType {
                found: "complex".into(),
            });
        }
        if header.shape[..] != [traces as u64, 3] {
            return Err(NpyError::Shape {
                expected: format!("[{traces}, 3]"),
                found: header.shape.clone(),
            });
        }
        let mut v = Vec::new();
        header.read_values(&mut reader, limits.max_samples, |re, _| v.push(re))?;
        Ok(row_major(v, [traces, 3], header.fortran_order))
    })?;
    match values.iter().position(|t| !t.is_finite()) {
        Some(flat) => Err(not_finite(array, flat, 3)),
        None => Ok(values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()),
    }
}

/// Start and step of an evenly spaced axis, by least squares.
fn even_axis(axis: &[f64]) -> Result<(f64, f64), NpzError> {
    let n = axis.len() as f64;
    if axis.len() < 2 {
        return Err(RadargramError::Empty {
            traces: 1,
            samples_per_trace: axis.len(),
        }
        .into());
    }
    let middle = (n - 1.0) / 2.0;
    // Relative to the first value, so that a far-away start costs no digits.
    let mean = axis.iter().map(|t| t - axis[0]).sum::<f64>() / n;
    let (mut sxy, mut sxx) = (0.0, 0.0);
    for (i, t) in axis.iter().enumerate() {
        let x = i as f64 - middle;
        sxy += x * (t - axis[0] - mean);
        sxx += x * x;
    }
    let step_s = sxy / sxx;
    if step_s <= 0.0 {
        return Err(RadargramError::Step { step_s }.into());
    }
    let start_s = axis[0] + mean - middle * step_s;
    let (index, off_s) = axis
        .iter()
        .enumerate()
        .map(|(i, t)| (i, t - (start_s + i as f64 * step_s)))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .unwrap_or((0, 0.0));
    if off_s.abs() > FAST_TIME_TOLERANCE * step_s {
        return Err(NpzError::UnevenFastTime {
            index,
            off_s,
            step_s,
        });
    }
    Ok((start_s, step_s))
}
