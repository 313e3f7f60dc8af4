//! Output of every reader: traces over fast time or frequency, and their properties.

use num_complex::Complex32;

use crate::antenna::AntennaFrequency;
use crate::error::{FormatError, Place};

/// Formats that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// SEG-Y, any revision.
    SegY,
    /// GSSI DZT.
    Dzt,
    /// Sensors & Software DT1 with HD.
    Dt1,
    /// MALÅ rd3 or rd7 with rad.
    Mala,
    /// Output of gprMax.
    GprMax,
    /// HDF5 with named arrays, MATLAB 7.3 among them.
    Hdf5,
    /// MATLAB 5 with named arrays.
    Matlab5,
    /// Touchstone.
    Touchstone,
    /// Table of a network analyser.
    AnalyserCsv,
    /// Beat signals of an FMCW radar.
    Fmcw,
}

impl Format {
    /// Name for people.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SegY => "SEG-Y",
            Self::Dzt => "GSSI DZT",
            Self::Dt1 => "Sensors & Software DT1",
            Self::Mala => "MALÅ rd3/rd7",
            Self::GprMax => "gprMax output",
            Self::Hdf5 => "HDF5 with named arrays",
            Self::Matlab5 => "MATLAB 5 with named arrays",
            Self::Touchstone => "Touchstone",
            Self::AnalyserCsv => "network analyser CSV",
            Self::Fmcw => "FMCW beat signals",
        }
    }
}

/// Samples, row-major `[traces, samples]`. Integers of 32 bits and numbers in double precision are rounded to the
/// nearest single.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Real samples.
    Real(Vec<f32>),
    /// Complex samples.
    Complex(Vec<Complex32>),
}

impl Values {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Real(v) => v.len(),
            Self::Complex(v) => v.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn first_non_finite(&self) -> Option<usize> {
        match self {
            Self::Real(v) => v.iter().position(|x| !x.is_finite()),
            Self::Complex(v) => v
                .iter()
                .position(|z| !z.re.is_finite() || !z.im.is_finite()),
        }
    }
}

/// Meaning of the columns of a channel's samples.
#[derive(Debug, Clone, PartialEq)]
pub enum Axis {
    /// Evenly spaced fast time.
    FastTime {
        /// Fast time of the first sample, s.
        start_s: f64,
        /// Spacing, s.
        step_s: f64,
        /// Samples in a trace.
        samples: usize,
    },
    /// Frequencies in Hz. An echo from range R has phase e^{−j4πfR/c}.
    Frequency(Vec<f64>),
}

impl Axis {
    /// Samples in a trace.
    #[must_use]
    pub fn samples(&self) -> usize {
        match self {
            Self::FastTime { samples, .. } => *samples,
            Self::Frequency(hz) => hz.len(),
        }
    }
}

/// Places of traces, one each.
#[derive(Debug, Clone, PartialEq)]
pub enum Positions {
    /// In the file's axes: x east, y north, z up, m.
    Local(Vec<[f64; 3]>),
    /// On WGS84: latitude and longitude in degrees, ellipsoidal height in m.
    Geodetic(Vec<[f64; 3]>),
}

impl Positions {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Local(v) | Self::Geodetic(v) => v.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Traces of one antenna, or of one quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name by which it is chosen.
    pub name: String,
    /// Number of traces.
    pub traces: usize,
    /// What the columns are.
    pub axis: Axis,
    /// The samples, row-major `[traces, samples]`.
    pub values: Values,
    /// Seconds from the first trace, one a trace, where the file holds them.
    pub time_s: Option<Vec<f64>>,
    /// Distance along the line, m, one a trace, where an odometer or a step was recorded.
    pub along_m: Option<Vec<f64>>,
    /// Middle between the antennas, one a trace, where the file holds it.
    pub positions: Option<Positions>,
    /// Distance between transmitter and receiver, m, where the file holds it.
    pub antenna_separation_m: Option<f64>,
    /// Frequency that the antenna is named after, where the file states it.
    pub antenna_frequency: Option<AntennaFrequency>,
    /// Transmitter and receiver of each trace, m, in the axes of local positions.
    pub antennas_m: Option<[Vec<[f64; 3]>; 2]>,
}

impl Channel {
    /// A channel of which only the samples are known.
    pub(crate) fn new(name: impl Into<String>, traces: usize, axis: Axis, values: Values) -> Self {
        Self {
            name: name.into(),
            traces,
            axis,
            values,
            time_s: None,
            along_m: None,
            positions: None,
            antenna_separation_m: None,
            antenna_frequency: None,
            antennas_m: None,
        }
    }

    /// Checks that shape, axes and samples agree and are finite.
    pub(crate) fn check(&self) -> Result<(), FormatError> {
        let wrong = |place: String, expected: String, found: String| {
            Err(FormatError::Content {
                place: Place::Field(format!("channel {}{place}", self.name)),
                expected,
                found,
            })
        };
        let samples = self.axis.samples();
        if self.traces == 0 || samples == 0 {
            return wrong(
                String::new(),
                "at least one trace of one sample".to_owned(),
                format!("{} × {samples}", self.traces),
            );
        }
        if self.traces.checked_mul(samples) != Some(self.values.len()) {
            return wrong(
                String::new(),
                format!("{} × {samples} values", self.traces),
                self.values.len().to_string(),
            );
        }
        if let Some(at) = self.values.first_non_finite() {
            return wrong(
                format!(", trace {}, sample {}", at / samples + 1, at % samples + 1),
                "a finite number".to_owned(),
                "NaN or an infinite one".to_owned(),
            );
        }
        match &self.axis {
            Axis::FastTime {
                start_s, step_s, ..
            } => {
                if !(step_s.is_finite() && *step_s > 0.0 && start_s.is_finite()) {
                    return wrong(
                        ", sample interval".to_owned(),
                        "a positive number".to_owned(),
                        format!("{step_s:e} s from {start_s:e} s"),
                    );
                }
            }
            Axis::Frequency(hz) => {
                if let Some(f) = hz.iter().find(|f| !(f.is_finite() && **f > 0.0)) {
                    return wrong(
                        ", frequency".to_owned(),
                        "a positive number".to_owned(),
                        format!("{f:e} Hz"),
                    );
                }
            }
        }
        let vectors = [
            ("time_s", self.time_s.as_ref().map(Vec::len)),
            ("along_m", self.along_m.as_ref().map(Vec::len)),
            ("positions", self.positions.as_ref().map(Positions::len)),
        ];
        for (what, length) in vectors {
            if let Some(found) = length.filter(|n| *n != self.traces) {
                return wrong(
                    format!(", {what}"),
                    format!("{} values", self.traces),
                    found.to_string(),
                );
            }
        }
        Ok(())
    }
}

/// Two statements of a file, or a statement and a law of nature, that do not agree.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradiction {
    /// Subject of both, with the fields.
    pub about: String,
    /// The value that is used.
    pub used: f64,
    /// The value that contradicts it.
    pub other: f64,
    /// Unit of both.
    pub unit: &'static str,
}

/// A radar file as read.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Its format.
    pub format: Format,
    /// Channels, at least one.
    pub channels: Vec<Channel>,
    /// Further entries of the header, in the file's own names.
    pub header: Vec<(String, String)>,
    /// Traces (counted from 0) that were marked while measuring.
    pub marks: Vec<usize>,
    /// Bytes that make no whole trace, or are where none is expected.
    pub skipped_bytes: u64,
    /// Assumptions, omissions and missing data, in words.
    pub remarks: Vec<String>,
    /// Statements that do not agree.
    pub contradictions: Vec<Contradiction>,
}

impl Recording {
    pub(crate) const fn new(format: Format) -> Self {
        Self {
            format,
            channels: Vec::new(),
            header: Vec::new(),
            marks: Vec::new(),
            skipped_bytes: 0,
            remarks: Vec::new(),
            contradictions: Vec::new(),
        }
    }

    pub(crate) fn fact(&mut self, name: &str, value: impl std::fmt::Display) {
        self.header.push((name.to_owned(), value.to_string()));
    }

    /// Notes values that differ by more than a share `tolerance` of the greater.
    pub(crate) fn compare(
        &mut self,
        about: &str,
        [used, other]: [f64; 2],
        unit: &'static str,
        tolerance: f64,
    ) {
        let scale = used.abs().max(other.abs());
        if (used - other).abs() > tolerance * scale {
            self.contradictions.push(Contradiction {
                about: about.to_owned(),
                used,
                other,
                unit,
            });
        }
    }

    /// The recording, once every channel is sound.
    pub(crate) fn checked(self) -> Result<Self, FormatError> {
        if self.channels.is_empty() {
            return Err(FormatError::content(Place::Whole, "a channel", "none"));
        }
        for channel in &self.channels {
            channel.check()?;
        }
        Ok(self)
    }

    /// The channel of a name, or the first.
    ///
    /// # Errors
    /// If there is no channel of that name.
    pub fn channel(&self, name: Option<&str>) -> Result<&Channel, FormatError> {
        let found = match name {
            None => self.channels.first(),
            Some(name) => self.channels.iter().find(|c| c.name == name),
        };
        found.ok_or_else(|| {
            let names: Vec<&str> = self.channels.iter().map(|c| c.name.as_str()).collect();
            FormatError::content(
                Place::field("channel"),
                format!("one of {}", names.join(", ")),
                name.unwrap_or("none"),
            )
        })
    }
}
