//! Datasets and attributes as numbers.

use hdf5_pure::{AttrValue, DType, Dataset};
use num_complex::Complex64;

use crate::error::{FormatError, Place};
use crate::limits::Limits;
use crate::named::{Array, Numbers};

/// Largest number of members of a group that are read.
pub(super) const MAX_MEMBERS: usize = 4096;

pub(super) fn broken(place: &str, error: impl std::fmt::Display) -> FormatError {
    FormatError::content(Place::field(place), "readable HDF5", error)
}

/// A dataset of numbers; complex ones are pairs of two equal fields.
pub(super) fn read(dataset: &Dataset, name: &str, limits: &Limits) -> Result<Array, FormatError> {
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

pub(super) type Attributes = std::collections::HashMap<String, AttrValue>;

pub(super) fn number(attributes: &Attributes, name: &str) -> Option<f64> {
    numbers(attributes.get(name)?).first().copied()
}

pub(super) fn numbers(value: &AttrValue) -> Vec<f64> {
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

pub(super) fn place(attributes: &Attributes, name: &str) -> Option<[f64; 3]> {
    let v = numbers(attributes.get(name)?);
    let place = <[f64; 3]>::try_from(v).ok()?;
    place.iter().all(|x| x.is_finite()).then_some(place)
}
