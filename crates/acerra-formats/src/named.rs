//! Named arrays, whatever file they come from, as traces.
//!
//! The names are those of the neutral NPZ file: `data` with `fast_time_s` (or `sample_interval_s`, and
//! `fast_time_start_s`), or `spectrum` with `frequency_hz`; also `time_s`, `position_m` (or `latitude_deg`,
//! `longitude_deg` and `height_m`), `transmitter_m` and `receiver_m`, `along_m`, `antenna_separation_m`.
//! Complex numbers may be two arrays, `spectrum_real` and `spectrum_imag`. A matrix of `[samples, traces]` is
//! turned where its axis shows that it is one.

use num_complex::{Complex32, Complex64};

use crate::error::{FormatError, Place};
use crate::limits::Limits;
use crate::recording::{Axis, Channel, Format, Positions, Recording, Values};

/// Largest distance of a fast time from an even axis, in steps.
const EVEN_TOLERANCE: f64 = 1e-3;

/// An array: row-major values with a shape.
#[derive(Debug, Clone)]
pub struct Array {
    pub shape: Vec<usize>,
    pub values: Numbers,
    /// Whether its file stores columns first, so that equal sides do not show the order.
    pub is_column_major: bool,
}

/// Numbers of an array.
#[derive(Debug, Clone)]
pub enum Numbers {
    Real(Vec<f64>),
    Complex(Vec<Complex64>),
}

impl Array {
    fn vector(&self, name: &str) -> Result<&[f64], FormatError> {
        let is_vector = self.shape.iter().filter(|n| **n != 1).count() <= 1;
        match &self.values {
            Numbers::Real(v) if is_vector && !v.is_empty() => Ok(v),
            _ => Err(FormatError::content(
                Place::field(name),
                "a vector of real numbers",
                format!("an array of shape {:?}", self.shape),
            )),
        }
    }

    fn places(&self, name: &str, traces: usize) -> Result<Vec<[f64; 3]>, FormatError> {
        let wrong = || {
            FormatError::content(
                Place::field(name),
                format!("real numbers of shape [{traces}, 3]"),
                format!("shape {:?}", self.shape),
            )
        };
        let Numbers::Real(v) = &self.values else {
            return Err(wrong());
        };
        match self.shape[..] {
            [rows, 3] if rows == traces && !(rows == 3 && self.is_column_major) => {
                Ok(v.as_chunks::<3>().0.to_vec())
            }
            [3, columns] if columns == traces => Ok((0..traces)
                .map(|i| [v[i], v[traces + i], v[2 * traces + i]])
                .collect()),
            _ => Err(wrong()),
        }
    }
}

/// A file of named arrays.
pub trait Arrays {
    /// Names of all numeric arrays.
    fn names(&self) -> Vec<String>;
    /// An array by its name.
    ///
    /// # Errors
    /// An array that cannot be read.
    fn array(&mut self, name: &str, limits: &Limits) -> Result<Array, FormatError>;
}

/// Arrays of which two, `NAME_real` and `NAME_imag`, are one of complex numbers.
struct Paired<'a, A>(&'a mut A);

impl<A: Arrays> Arrays for Paired<'_, A> {
    fn names(&self) -> Vec<String> {
        let own = self.0.names();
        let has = |name: String| own.contains(&name);
        let is_part = |name: &str, part: &str, other: &str| {
            name.strip_suffix(part)
                .is_some_and(|of| has(format!("{of}{other}")))
        };
        let whole = own.iter().filter_map(|name| {
            let of = name.strip_suffix("_real");
            if let Some(of) = of.filter(|of| has(format!("{of}_imag"))) {
                return Some(of.to_owned());
            }
            (!is_part(name, "_imag", "_real")).then(|| name.clone())
        });
        whole.collect()
    }

    fn array(&mut self, name: &str, limits: &Limits) -> Result<Array, FormatError> {
        if self.0.names().iter().any(|own| own == name) {
            return self.0.array(name, limits);
        }
        let [real, imaginary] = [format!("{name}_real"), format!("{name}_imag")];
        let (a, b) = (
            self.0.array(&real, limits)?,
            self.0.array(&imaginary, limits)?,
        );
        let (Numbers::Real(re), Numbers::Real(im)) = (&a.values, &b.values) else {
            return Err(FormatError::content(
                Place::field(name),
                "two arrays of real numbers",
                "complex ones",
            ));
        };
        if a.shape != b.shape {
            return Err(FormatError::content(
                Place::Field(imaginary),
                format!("shape {:?}, as {real} has", a.shape),
                format!("shape {:?}", b.shape),
            ));
        }
        let pairs = re.iter().zip(im).map(|(re, im)| Complex64::new(*re, *im));
        Ok(Array {
            values: Numbers::Complex(pairs.collect()),
            ..a
        })
    }
}

/// The names that are known.
const KNOWN: [&str; 15] = [
    "data",
    "fast_time_s",
    "sample_interval_s",
    "fast_time_start_s",
    "spectrum",
    "frequency_hz",
    "time_s",
    "position_m",
    "transmitter_m",
    "receiver_m",
    "latitude_deg",
    "longitude_deg",
    "height_m",
    "along_m",
    "antenna_separation_m",
];

/// Traces from named arrays.
///
/// # Errors
/// Arrays that are missing, of another shape, broken or not even.
pub fn traces(
    file: &mut impl Arrays,
    format: Format,
    limits: &Limits,
) -> Result<Recording, FormatError> {
    let file = &mut Paired(file);
    let names = file.names();
    let mut file = Named {
        file,
        names,
        limits,
    };
    let mut channel = file.echoes()?;
    channel.along_m = file.optional("along_m")?;
    channel.antenna_separation_m = file.optional("antenna_separation_m")?.map(|m| m[0]);
    file.place(&mut channel)?;
    let mut recording = Recording::new(format);
    let unused = file.names.iter().filter(|n| !KNOWN.contains(&n.as_str()));
    for name in unused {
        recording.remarks.push(format!("array {name} is not used"));
    }
    recording.channels.push(channel);
    recording.checked()
}

/// A file with the names of its arrays.
struct Named<'a, A> {
    file: &'a mut A,
    names: Vec<String>,
    limits: &'a Limits,
}

impl<A: Arrays> Named<'_, A> {
    fn has(&self, name: &str) -> bool {
        self.names.iter().any(|n| n == name)
    }

    fn array(&mut self, name: &str) -> Result<Array, FormatError> {
        self.file.array(name, self.limits)
    }

    /// The vector of this name, if present.
    fn optional(&mut self, name: &str) -> Result<Option<Vec<f64>>, FormatError> {
        if !self.has(name) {
            return Ok(None);
        }
        Ok(Some(self.array(name)?.vector(name)?.to_vec()))
    }

    fn missing(&self, expected: &str) -> FormatError {
        FormatError::content(Place::Whole, expected, self.names.join(", "))
    }

    /// Whether the echoes are `data` or a `spectrum`.
    fn what(&self) -> Result<&'static str, FormatError> {
        let (expected, found) = match (self.has("data"), self.has("spectrum")) {
            (true, false) => return Ok("data"),
            (false, true) => return Ok("spectrum"),
            (true, true) => ("an array data or an array spectrum", "both".to_owned()),
            (false, false) => (
                "an array data (with fast_time_s) or spectrum (with frequency_hz)",
                match self.names.join(", ") {
                    none if none.is_empty() => "no array of numbers".to_owned(),
                    found => found,
                },
            ),
        };
        Err(FormatError::content(Place::Whole, expected, found))
    }

    /// The matrix of echoes with its axis and the traces' times, a trace in each row.
    fn echoes(&mut self) -> Result<Channel, FormatError> {
        let what = self.what()?;
        let matrix = self.array(what)?;
        let [rows, columns] = match matrix.shape[..] {
            [rows, columns] if rows > 0 && columns > 0 => [rows, columns],
            [n] if n > 0 => [1, n],
            _ => {
                return Err(FormatError::content(
                    Place::field(what),
                    "a matrix [traces, samples]",
                    format!("shape {:?}", matrix.shape),
                ));
            }
        };
        let axis_name = match what {
            "data" => "fast_time_s",
            _ => "frequency_hz",
        };
        let values = self.optional(axis_name)?;
        let time_s = self.optional("time_s")?;
        // The axis shows which side of the matrix it belongs to; without an axis, the traces' times do.
        let is_turned = match values.as_ref().map(Vec::len) {
            Some(n) if n == columns && n == rows => matrix.is_column_major,
            Some(n) if n == columns => false,
            Some(n) if n == rows => true,
            Some(n) => {
                return Err(FormatError::content(
                    Place::field(axis_name),
                    format!("{rows} or {columns} values, as {what} has"),
                    n,
                ));
            }
            None => {
                let times = time_s.as_ref().map(Vec::len);
                times.is_some_and(|n| n == columns && n != rows)
                    || matrix.is_column_major && times != Some(rows)
            }
        };
        let [traces, samples] = if is_turned {
            [columns, rows]
        } else {
            [rows, columns]
        };
        self.limits
            .check_trace(Place::field(what), samples as u64)?;
        let axis = self.axis(what, values, samples)?;
        let values = turned(matrix.values, [rows, columns], is_turned, what)?;
        let mut channel = Channel::new("1", traces, axis, values);
        channel.time_s = time_s;
        Ok(channel)
    }

    fn axis(
        &mut self,
        what: &str,
        values: Option<Vec<f64>>,
        samples: usize,
    ) -> Result<Axis, FormatError> {
        match (what, values) {
            ("spectrum", Some(hz)) => Ok(Axis::Frequency(hz)),
            ("spectrum", None) => Err(self.missing("frequency_hz beside spectrum")),
            (_, Some(at)) => even(&at),
            (_, None) => match self.optional("sample_interval_s")? {
                Some(step_s) => Ok(Axis::FastTime {
                    start_s: self.optional("fast_time_start_s")?.map_or(0.0, |s| s[0]),
                    step_s: step_s[0],
                    samples,
                }),
                None => Err(self.missing("fast_time_s or sample_interval_s beside data")),
            },
        }
    }

    /// Where each trace was recorded: local positions before geodetic ones, and the places of both antennas.
    fn place(&mut self, channel: &mut Channel) -> Result<(), FormatError> {
        let traces = channel.traces;
        let latitude_deg = self.optional("latitude_deg")?;
        let longitude_deg = self.optional("longitude_deg")?;
        if let (Some(latitude_deg), Some(longitude_deg)) = (latitude_deg, longitude_deg) {
            let height_m = self.optional("height_m")?;
            channel.positions = Some(geodetic([latitude_deg, longitude_deg], height_m)?);
        }
        if self.has("position_m") {
            let places = self.array("position_m")?;
            channel.positions = Some(Positions::Local(places.places("position_m", traces)?));
        }
        if self.has("transmitter_m") && self.has("receiver_m") {
            let mut of = |name| self.array(name)?.places(name, traces);
            let antennas: [Vec<[f64; 3]>; 2] = [of("transmitter_m")?, of("receiver_m")?];
            channel.positions.get_or_insert_with(|| {
                let pairs = antennas[0].iter().zip(&antennas[1]);
                let middle = pairs.map(|(t, r)| [0, 1, 2].map(|k| f64::midpoint(t[k], r[k])));
                Positions::Local(middle.collect())
            });
            channel.antennas_m = Some(antennas);
        }
        Ok(())
    }
}

/// Places by latitude and longitude, at height 0 where none is stated.
fn geodetic(
    [latitude_deg, longitude_deg]: [Vec<f64>; 2],
    height_m: Option<Vec<f64>>,
) -> Result<Positions, FormatError> {
    let count = latitude_deg.len();
    let height_m = height_m.unwrap_or_else(|| vec![0.0; count]);
    if longitude_deg.len() != count || height_m.len() != count {
        return Err(FormatError::content(
            Place::field("longitude_deg, height_m"),
            format!("{count} values, as latitude_deg has"),
            format!("{}, {}", longitude_deg.len(), height_m.len()),
        ));
    }
    let places = latitude_deg.iter().zip(longitude_deg).zip(height_m);
    let places = places.map(|((latitude, longitude), height)| [*latitude, longitude, height]);
    Ok(Positions::Geodetic(places.collect()))
}

fn turned(
    values: Numbers,
    [rows, columns]: [usize; 2],
    is_turned: bool,
    what: &str,
) -> Result<Values, FormatError> {
    fn order<T: Copy, U>(
        v: &[T],
        [rows, columns]: [usize; 2],
        is_turned: bool,
        narrow: impl Fn(T) -> U,
    ) -> Vec<U> {
        if is_turned {
            (0..rows * columns)
                .map(|i| narrow(v[i % rows * columns + i / rows]))
                .collect()
        } else {
            v.iter().map(|x| narrow(*x)).collect()
        }
    }
    let shape = [rows, columns];
    let found = match &values {
        Numbers::Real(v) => v.len(),
        Numbers::Complex(v) => v.len(),
    };
    if found != rows * columns {
        return Err(FormatError::content(
            Place::field(what),
            format!("{} values", rows * columns),
            found,
        ));
    }
    let single = |z: Complex64| Complex32::new(z.re as f32, z.im as f32);
    Ok(match values {
        Numbers::Real(v) if what == "spectrum" => {
            Values::Complex(order(&v, shape, is_turned, |x| {
                Complex32::new(x as f32, 0.0)
            }))
        }
        Numbers::Real(v) => Values::Real(order(&v, shape, is_turned, |x| x as f32)),
        Numbers::Complex(v) => Values::Complex(order(&v, shape, is_turned, single)),
    })
}

/// An even axis through the values.
fn even(at: &[f64]) -> Result<Axis, FormatError> {
    let n = at.len();
    let wrong = |found: String| {
        FormatError::content(
            Place::field("fast_time_s"),
            "at least two growing values, evenly spaced",
            found,
        )
    };
    if n < 2 {
        return Err(wrong(format!("{n}")));
    }
    let step_s = (at[n - 1] - at[0]) / (n as f64 - 1.0);
    if !(step_s.is_finite() && step_s > 0.0) {
        return Err(wrong(format!("a step of {step_s:e} s")));
    }
    let off = |i: usize| ((at[i] - at[0]) / step_s - i as f64).abs();
    // Not a number is off, too.
    if let Some(i) = (0..n).find(|&i| off(i).is_nan() || off(i) > EVEN_TOLERANCE) {
        return Err(wrong(format!("value {i} off by {:.3} steps", off(i))));
    }
    Ok(Axis::FastTime {
        start_s: at[0],
        step_s,
        samples: n,
    })
}
