//! MATLAB 5 files: their numeric arrays.
//!
//! Source: The MathWorks, *MAT-File Format* (R2023a), chapter 1.

use std::io::Read;

use flate2::read::ZlibDecoder;
use num_complex::Complex64;

use crate::bytes::{Fields, Order};
use crate::error::{FormatError, Place};
use crate::limits::Limits;
use crate::named::{Array, Arrays, Numbers, traces};
use crate::recording::{Format, Recording};

const HEADER_BYTES: usize = 128;
/// Data types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Whether a file is MATLAB 5.
#[must_use]
pub fn is_matlab5(head: &[u8]) -> bool {
    head.starts_with(b"MATLAB 5.0 MAT-file")
        || (head.starts_with(b"MATLAB") && matches!(head.get(126..128), Some(b"IM" | b"MI")))
}

/// Reads the named arrays of a MATLAB 5 file.
///
/// # Errors
/// A file that is broken, without the arrays, or larger than `limits` admit.
pub fn read_matlab5(bytes: &[u8], limits: &Limits) -> Result<Recording, FormatError> {
    let of_file = limits.justified_by(bytes.len() as u64);
    let mut limits = of_file;
    let order = match bytes.get(126..128) {
        Some(b"IM") => Order::Little,
        Some(b"MI") => Order::Big,
        other => {
            return Err(FormatError::content(
                Place::Byte(126),
                "the marks IM or MI of byte order",
                other.map_or("the end of the file".to_owned(), |o| {
                    String::from_utf8_lossy(o).into_owned()
                }),
            ));
        }
    };
    let mut arrays = Vec::new();
    let mut others = Vec::new();
    let mut left = &bytes[HEADER_BYTES..];
    while !left.is_empty() {
        let at = (bytes.len() - left.len()) as u64;
        let element = Element::take(&mut left, order, at)?;
        let unpacked;
        let (kind, data) = if element.kind == COMPRESSED {
            unpacked = unpack(element.data, &limits, at)?;
            let inner = Element::take(&mut unpacked.as_slice(), order, at)?;
            (inner.kind, inner.data)
        } else {
            (element.kind, element.data)
        };
        if kind == MATRIX {
            match matrix(data, order, &limits, at)? {
                (name, Some(array)) => {
                    // All arrays together are held.
                    let held = array.shape.iter().product::<usize>();
                    limits.max_samples = limits.max_samples.saturating_sub(held as u64);
                    arrays.push((name, array));
                }
                (name, None) => others.push(name),
            }
        }
    }
    let mut recording = traces(&mut Held(arrays), Format::Matlab5, &of_file)?;
    for name in others.iter().filter(|name| !name.is_empty()) {
        recording.remarks.push(format!(
            "variable {name} is no full array of numbers and is not read"
        ));
    }
    Ok(recording)
}

/// An element: a type and its bytes.
struct Element<'a> {
    kind: u32,
    data: &'a [u8],
}

impl<'a> Element<'a> {
    /// Takes the next element. Elements of up to four bytes have type and length in one word; all others but packed
    /// ones end on multiples of eight bytes.
    fn take(left: &mut &'a [u8], order: Order, at: u64) -> Result<Self, FormatError> {
        let cut = |length: usize| {
            FormatError::content(
                Place::Byte(at),
                format!("an element of {length} bytes"),
                "the end of the data",
            )
        };
        if left.len() < 8 {
            return Err(cut(8));
        }
        let f = Fields { bytes: left, order };
        let word = f.u32(0);
        if word >> 16 != 0 {
            let length = (word >> 16) as usize;
            if length > 4 {
                return Err(FormatError::content(
                    Place::Byte(at),
                    "a small element of at most 4 bytes",
                    length,
                ));
            }
            let data = &left[4..4 + length];
            *left = &left[8..];
            return Ok(Self {
                kind: word & 0xffff,
                data,
            });
        }
        let length = f.u32(4) as usize;
        let data = left.get(8..8 + length).ok_or_else(|| cut(length))?;
        let end = if word == COMPRESSED {
            8 + length
        } else {
            8 + length.next_multiple_of(8)
        };
        *left = left.get(end..).unwrap_or_default();
        Ok(Self { kind: word, data })
    }
}

fn unpack(data: &[u8], limits: &Limits, at: u64) -> Result<Vec<u8>, FormatError> {
    // Names and axes are small relative to the samples, of eight bytes at most.
    let limit = limits
        .max_samples
        .saturating_mul(8)
        .min(limits.max_file_bytes);
    let mut out = Vec::new();
    ZlibDecoder::new(data)
        .take(limit + 1)
        .read_to_end(&mut out)
        .map_err(|e| FormatError::content(Place::Byte(at), "packed data", e))?;
    if out.len() as u64 > limit {
        return Err(FormatError::TooLarge {
            place: Place::Byte(at),
            what: "bytes unpacked",
            limit,
            found: out.len() as u64,
        });
    }
    Ok(out)
}

/// Name and numbers of a matrix; no numbers where it is a cell, structure, text, object or sparse.
fn matrix(
    mut left: &[u8],
    order: Order,
    limits: &Limits,
    at: u64,
) -> Result<(String, Option<Array>), FormatError> {
    let flags = Element::take(&mut left, order, at)?;
    let flags = Fields {
        bytes: flags.data,
        order,
    }
    .u32(0);
    let (class, is_complex) = (flags & 0xff, flags & 0x0800 != 0);
    if !(6..=15).contains(&class) {
        let name = Element::take(&mut left, order, at)
            .and_then(|_| Element::take(&mut left, order, at))
            .map(|e| String::from_utf8_lossy(e.data).into_owned());
        return Ok((name.unwrap_or_default(), None));
    }
    let sides = Element::take(&mut left, order, at)?;
    let f = Fields {
        bytes: sides.data,
        order,
    };
    let shape: Vec<usize> = (0..sides.data.len() / 4)
        .map(|k| usize::try_from(f.i32(4 * k)).unwrap_or(0))
        .collect();
    let name = Element::take(&mut left, order, at)?;
    let name = String::from_utf8_lossy(name.data).into_owned();
    let count = shape
        .iter()
        .try_fold(1usize, |n, side| n.checked_mul(*side));
    let count = count.unwrap_or(usize::MAX);
    limits.check_samples(Place::field(&name), count as u64)?;
    let mut part = || -> Result<Vec<f64>, FormatError> {
        let element = Element::take(&mut left, order, at)?;
        let values = decode(&element, order).ok_or_else(|| {
            FormatError::content(
                Place::field(&name),
                "a type of numbers from 1 to 13",
                element.kind,
            )
        })?;
        if values.len() != count {
            return Err(FormatError::content(
                Place::field(&name),
                format!("{count} values"),
                values.len(),
            ));
        }
        Ok(values)
    };
    let real = part()?;
    // Files hold columns; rows are handed on.
    let values = if is_complex {
        let imaginary = part()?;
        let values = real.iter().zip(&imaginary);
        let values: Vec<Complex64> = values.map(|(re, im)| Complex64::new(*re, *im)).collect();
        Numbers::Complex(rows(&values, &shape))
    } else {
        Numbers::Real(rows(&real, &shape))
    };
    Ok((
        name,
        Some(Array {
            shape,
            values,
            is_column_major: false,
        }),
    ))
}

fn rows<T: Copy>(values: &[T], shape: &[usize]) -> Vec<T> {
    match shape[..] {
        [m, n] => (0..m * n).map(|i| values[i % n * m + i / n]).collect(),
        _ => values.to_vec(),
    }
}

/// Numbers of an element: MATLAB stores whole numbers in the smallest type that holds them.
fn decode(element: &Element<'_>, order: Order) -> Option<Vec<f64>> {
    let f = Fields {
        bytes: element.data,
        order,
    };
    let n = element.data.len();
    let each = |size: usize, value: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..n / size).map(|k| value(size * k)).collect()
    };
    Some(match element.kind {
        1 => each(1, &|at| f64::from(element.data[at] as i8)),
        2 => each(1, &|at| f64::from(element.data[at])),
        3 => each(2, &|at| f64::from(f.i16(at))),
        4 => each(2, &|at| f64::from(f.u16(at))),
        5 => each(4, &|at| f64::from(f.i32(at))),
        6 => each(4, &|at| f64::from(f.u32(at))),
        7 => each(4, &|at| f64::from(f.f32(at))),
        9 => each(8, &|at| f.f64(at)),
        12 => each(8, &|at| f.u64(at) as i64 as f64),
        13 => each(8, &|at| f.u64(at) as f64),
        _ => return None,
    })
}

/// Arrays in memory.
struct Held(Vec<(String, Array)>);

impl Arrays for Held {
    fn names(&self) -> Vec<String> {
        self.0.iter().map(|(name, _)| name.clone()).collect()
    }

    fn array(&mut self, name: &str, _: &Limits) -> Result<Array, FormatError> {
        let found = self.0.iter().find(|(n, _)| n == name);
        found
            .map(|(_, array)| array.clone())
            .ok_or_else(|| FormatError::content(Place::field(name), "an array", "none"))
    }
}
