//! HDF5: outputs of gprMax, and named arrays (MATLAB 7.3 among them).

use hdf5_pure::{AttrValue, DType, Dataset, File, Group};
use num_complex::Complex64;

use crate::error::{FormatError, Place};
use crate::limits::Limits;
use crate::named::{Array, Arrays, Numbers, traces};
use crate::recording::{Axis, Channel, Format, Positions, Recording, Values};

/// Largest number of members of a group that are read.
const MAX_MEMBERS: usize = 4096;

/// Whether a file is HDF5: its signature is at the beginning, or behind 512 bytes of a MATLAB header.
#[must_use]
pub fn is_hdf5(head: &[u8]) -> bool {
    const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
    [0, 512, 1024, 2048]
        .iter()
        .any(|at| head.get(*at..).is_some_and(|h| h.starts_with(SIGNATURE)))
}

fn broken(place: &str, error: impl std::fmt::Display) -> FormatError {
    FormatError::content(Place::field(place), "readable HDF5", error)
}

/// Reads HDF5: an output of gprMax, single or merged, or named arrays.
///
/// # Errors
/// A file that is broken, of neither kind, or larger than `limits` admit.
pub fn read_hdf5(bytes: Vec<u8>, limits: &Limits) -> Result<Recording, FormatError> {
    let limits = &limits.justified_by(bytes.len() as u64);
    let file = File::from_bytes(bytes).map_err(|e| broken("the file", e))?;
    let root = file.root();
    let groups = root.groups().map_err(|e| broken("/", e))?;
    let is_gprmax = groups.iter().any(|g| g == "rxs")
        && number(&root.attrs().map_err(|e| broken("/", e))?, "dt").is_some();
    if is_gprmax {
        return gprmax(&root, limits);
    }
    let names = root.datasets().map_err(|e| broken("/", e))?;
    let mut file = Root { root, names };
    traces(&mut file, Format::Hdf5, limits)
}

/// The datasets of the root group.
struct Root {
    root: Group,
    names: Vec<String>,
}

impl Arrays for Root {
    fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    fn array(&mut self, name: &str, limits: &Limits) -> Result<Array, FormatError> {
        let dataset = self.root.dataset(name).map_err(|e| broken(name, e))?;
        let attributes = dataset.attrs().map_err(|e| broken(name, e))?;
        Ok(Array {
            is_column_major: attributes.contains_key("MATLAB_class"),
            ..read(&dataset, name, limits)?
        })
    }
}

/// A dataset of numbers; complex ones are pairs of two equal fields.
fn read(dataset: &Dataset, name: &str, limits: &Limits) -> Result<Array, FormatError> {
    let shape = dataset.shape().map_err(|e| broken(name, e))?;
    let count = shape.iter().try_fold(1u64, |n, side| n.checked_mul(*side));
    limits.check_samples(Place::field(name), count.unwrap_or(u64::MAX))?;
    if let Some(chunk) = dataset.chunk_shape().map_err(|e| broken(name, e))? {
        let count = chunk.iter().try_fold(1u64, |n, side| n.checked_mul(*side));
        limits.check_samples(Place::field(name), count.unwrap_or(u64::MAX))?;
    }
    let dtype = dataset.dtype().map_err(|e| broken(name, e))?;
    let values = match &dtype {
        DType::Compound(fields) => {
            let of = |k: usize| fields.get(k).map(|f| &f.1);
            let raw = || dataset.read_raw().map_err(|e| broken(name, e));
            match (fields.len(), of(0), of(1)) {
                (2, Some(DType::F64), Some(DType::F64)) => pairs(&raw()?, f64::from_le_bytes),
                (2, Some(DType::F32), Some(DType::F32)) => {
                    pairs(&raw()?, |b| f64::from(f32::from_le_bytes(b)))
                }
                _ => {
                    return Err(FormatError::content(
                        Place::field(name),
                        "numbers, or pairs of them",
                        "another compound type",
                    ));
                }
            }
        }
        DType::F32 => {
            let v = dataset.read_f32().map_err(|e| broken(name, e))?;
            Numbers::Real(v.into_iter().map(f64::from).collect())
        }
        DType::F64
        | DType::I8
        | DType::I16
        | DType::I32
        | DType::I64
        | DType::U8
        | DType::U16
        | DType::U32
        | DType::U64 => Numbers::Real(dataset.read_f64().map_err(|e| broken(name, e))?),
        other => {
            return Err(FormatError::content(
                Place::field(name),
                "numbers",
                other.to_string(),
            ));
        }
    };
    let shape = shape.iter().map(|n| *n as usize).collect();
    Ok(Array {
        shape,
        values,
        is_column_major: false,
    })
}

fn pairs<const N: usize>(raw: &[u8], value: impl Fn([u8; N]) -> f64) -> Numbers {
    let words = raw.as_chunks::<N>().0;
    let pairs = words.as_chunks::<2>().0.iter();
    Numbers::Complex(
        pairs
            .map(|[re, im]| Complex64::new(value(*re), value(*im)))
            .collect(),
    )
}

type Attributes = std::collections::HashMap<String, AttrValue>;

fn number(attributes: &Attributes, name: &str) -> Option<f64> {
    numbers(attributes.get(name)?).first().copied()
}

fn numbers(value: &AttrValue) -> Vec<f64> {
    match value {
        AttrValue::F32(v) => vec![f64::from(*v)],
        AttrValue::F64(v) => vec![*v],
        AttrValue::I8(v) => vec![f64::from(*v)],
        AttrValue::I16(v) => vec![f64::from(*v)],
        AttrValue::I32(v) => vec![f64::from(*v)],
        AttrValue::I64(v) => vec![*v as f64],
        AttrValue::U8(v) => vec![f64::from(*v)],
        AttrValue::U16(v) => vec![f64::from(*v)],
        AttrValue::U32(v) => vec![f64::from(*v)],
        AttrValue::U64(v) => vec![*v as f64],
        AttrValue::F32Array(v) => v.iter().map(|x| f64::from(*x)).collect(),
        AttrValue::F64Array(v) => v.clone(),
        AttrValue::I32Array(v) => v.iter().map(|x| f64::from(*x)).collect(),
        AttrValue::I64Array(v) => v.iter().map(|x| *x as f64).collect(),
        AttrValue::U64Array(v) => v.iter().map(|x| *x as f64).collect(),
        _ => Vec::new(),
    }
}

fn place(attributes: &Attributes, name: &str) -> Option<[f64; 3]> {
    let v = numbers(attributes.get(name)?);
    let place = <[f64; 3]>::try_from(v).ok()?;
    place.iter().all(|x| x.is_finite()).then_some(place)
}

/// Every receiver and component of a model's output; the strongest electric component first.
///
/// Positions are the model's, z up; a model of one cell along z has y up, and is turned.
fn gprmax(root: &Group, limits: &Limits) -> Result<Recording, FormatError> {
    let attributes = root.attrs().map_err(|e| broken("/", e))?;
    let mut recording = Recording::new(Format::GprMax);
    let step_s = number(&attributes, "dt").unwrap_or(0.0);
    for name in ["Title", "gprMax"] {
        if let Some(AttrValue::String(text)) = attributes.get(name) {
            recording.fact(name, text);
        }
    }
    for name in ["Iterations", "nrx", "nsrc"] {
        if let Some(value) = number(&attributes, name) {
            recording.fact(name, value);
        }
    }
    let cells = attributes.get("nx_ny_nz").map(numbers).unwrap_or_default();
    let is_flat = cells.get(2) == Some(&1.0);
    let up = |p: [f64; 3]| if is_flat { [p[0], -p[2], p[1]] } else { p };
    let steps = |name: &str| place(&attributes, name).unwrap_or_default();
    let source = source(root)?;
    let receivers = root.group("rxs").map_err(|e| broken("/rxs", e))?;
    let mut names = receivers.groups().map_err(|e| broken("/rxs", e))?;
    names.truncate(MAX_MEMBERS);
    let mut strengths: Vec<f32> = Vec::new();
    for receiver in names {
        let at = format!("/rxs/{receiver}");
        let group = receivers.group(&receiver).map_err(|e| broken(&at, e))?;
        let own = group.attrs().map_err(|e| broken(&at, e))?;
        let components = group.datasets().map_err(|e| broken(&at, e))?;
        for component in components.into_iter().take(MAX_MEMBERS) {
            let at = format!("{at}/{component}");
            let dataset = group.dataset(&component).map_err(|e| broken(&at, e))?;
            let Array { shape, values, .. } = read(&dataset, &at, limits)?;
            let (samples, traces) = match shape[..] {
                [samples] => (samples, 1),
                [samples, traces] => (samples, traces),
                _ => {
                    return Err(FormatError::content(
                        Place::field(at),
                        "[samples] or [samples, traces]",
                        format!("{shape:?}"),
                    ));
                }
            };
            limits.check_trace(Place::field(&at), samples as u64)?;
            let Numbers::Real(values) = values else {
                return Err(FormatError::content(
                    Place::field(at),
                    "real numbers",
                    "complex ones",
                ));
            };
            if samples.checked_mul(traces) != Some(values.len()) {
                return Err(FormatError::content(
                    Place::field(at),
                    format!("{samples} × {traces} values"),
                    values.len(),
                ));
            }
            let turned: Vec<f32> = (0..samples * traces)
                .map(|i| values[i % samples * traces + i / samples] as f32)
                .collect();
            let peak = turned.iter().fold(0.0f32, |m, x| m.max(x.abs()));
            strengths.push(if component.starts_with('E') {
                peak
            } else {
                -1.0
            });
            let axis = Axis::FastTime {
                start_s: 0.0,
                step_s,
                samples,
            };
            let name = format!("{receiver}/{component}");
            let mut channel = Channel::new(name, traces, axis, Values::Real(turned));
            if let (Some(source), Some(receiver)) = (source, place(&own, "Position")) {
                let walk = |from: [f64; 3], step: [f64; 3]| -> Vec<[f64; 3]> {
                    (0..traces)
                        .map(|i| up([0, 1, 2].map(|k| from[k] + step[k] * i as f64)))
                        .collect()
                };
                let antennas = [
                    walk(source, steps("srcsteps")),
                    walk(receiver, steps("rxsteps")),
                ];
                let middle = antennas[0].iter().zip(&antennas[1]);
                channel.positions = Some(Positions::Local(
                    middle
                        .map(|(t, r)| [0, 1, 2].map(|k| f64::midpoint(t[k], r[k])))
                        .collect(),
                ));
                channel.antenna_separation_m = Some(
                    (0..3)
                        .map(|k| (source[k] - receiver[k]).powi(2))
                        .sum::<f64>()
                        .sqrt(),
                );
                channel.antennas_m = Some(antennas);
            }
            recording.channels.push(channel);
        }
    }
    let held: usize = recording.channels.iter().map(|c| c.values.len()).sum();
    limits.check_samples(Place::field("/rxs"), held as u64)?;
    // The component with the strongest signal is used.
    if let Some(best) = (0..strengths.len()).max_by(|&a, &b| strengths[a].total_cmp(&strengths[b]))
    {
        let first = recording.channels.remove(best);
        recording.channels.insert(0, first);
    }
    if recording.channels.iter().any(|c| c.positions.is_none()) {
        recording.remarks.push(
            "no positions of source and receiver: merged outputs keep none of the runs'".to_owned(),
        );
    }
    if is_flat {
        recording
            .remarks
            .push("the model is one cell deep in z: its y is up".to_owned());
    }
    recording.checked()
}

/// Position of the first source.
fn source(root: &Group) -> Result<Option<[f64; 3]>, FormatError> {
    let Ok(sources) = root.group("srcs") else {
        return Ok(None);
    };
    let names = sources.groups().map_err(|e| broken("/srcs", e))?;
    let Some(first) = names.first() else {
        return Ok(None);
    };
    let group = sources.group(first).map_err(|e| broken("/srcs", e))?;
    let attributes = group.attrs().map_err(|e| broken("/srcs", e))?;
    Ok(place(&attributes, "Position"))
}
