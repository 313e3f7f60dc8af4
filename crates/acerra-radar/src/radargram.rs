//! Radargram, traces × fast time: the input of the cleaning stages.

use num_complex::{Complex32, Complex64};
use thiserror::Error;

/// The samples of a radargram, row-major `[traces, samples_per_trace]`.
#[derive(Debug, Clone, PartialEq)]
pub enum Samples {
    /// Real samples, as a pulse radar delivers them.
    Real(Vec<f32>),
    /// Complex samples (range-compressed or demodulated data).
    Complex(Vec<Complex32>),
}

impl Samples {
    /// Number of samples held.
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

    /// Whether the samples are complex.
    #[must_use]
    pub fn is_complex(&self) -> bool {
        matches!(self, Self::Complex(_))
    }

    /// Sample `index` as a complex number.
    ///
    /// # Panics
    /// If `index` is out of range.
    #[must_use]
    pub fn at(&self, index: usize) -> Complex64 {
        match self {
            Self::Real(v) => Complex64::new(f64::from(v[index]), 0.0),
            Self::Complex(v) => {
                let z = v[index];
                Complex64::new(f64::from(z.re), f64::from(z.im))
            }
        }
    }

    /// Index of the first sample that is NaN or infinite.
    #[must_use]
    pub fn first_non_finite(&self) -> Option<usize> {
        match self {
            Self::Real(v) => v.iter().position(|x| !x.is_finite()),
            Self::Complex(v) => v
                .iter()
                .position(|z| !z.re.is_finite() || !z.im.is_finite()),
        }
    }
}

/// Reason why numbers are no valid radargram.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RadargramError {
    /// No trace, or traces without samples.
    #[error(
        "a radargram needs at least one trace of at least two samples, found {traces} × {samples_per_trace}"
    )]
    Empty {
        /// Traces given.
        traces: usize,
        /// Samples per trace given.
        samples_per_trace: usize,
    },
    /// A vector's length disagrees with the shape.
    #[error("{what}: expected {expected} values, found {found}")]
    Length {
        /// Name of the vector.
        what: &'static str,
        /// Length by the shape.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// A number is NaN or infinite.
    #[error("{what}[{index}] is not a finite number")]
    NotFinite {
        /// Name of the vector.
        what: &'static str,
        /// Index of the first offender.
        index: usize,
    },
    /// The fast-time step is not a positive number.
    #[error("fast-time step must be positive, found {step_s} s")]
    Step {
        /// Step found, s.
        step_s: f64,
    },
    /// A frequency is zero or negative.
    #[error("frequency_hz[{index}] must be positive, found {frequency_hz} Hz")]
    Frequency {
        /// Index of the first offender.
        index: usize,
        /// Frequency found, Hz.
        frequency_hz: f64,
    },
    /// A trace index beyond the number of traces.
    #[error("trace {index} asked for, but there are only {traces}")]
    NoSuchTrace {
        /// Index asked for.
        index: usize,
        /// Traces there are.
        traces: usize,
    },
}

/// Traces over evenly spaced fast time.
///
/// ```
/// use acerra_radar::{Radargram, Samples};
/// let radargram = Radargram::new(
///     vec![0.0, 0.07],
///     10e-9,
///     61e-12,
///     Samples::Real(vec![0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
/// )?;
/// assert_eq!((radargram.traces, radargram.samples_per_trace), (2, 3));
/// assert_eq!(radargram.fast_time_s(2), 10e-9 + 2.0 * 61e-12);
/// # Ok::<(), acerra_radar::RadargramError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Radargram {
    /// Slow time of each trace, s.
    pub time_s: Vec<f64>,
    /// Fast time of the first sample, s.
    pub fast_time_start_s: f64,
    /// Spacing of samples along fast time, s.
    pub fast_time_step_s: f64,
    /// Samples, row-major `[traces, samples_per_trace]`.
    pub samples: Samples,
    /// Number of traces.
    pub traces: usize,
    /// Samples per trace.
    pub samples_per_trace: usize,
}

impl Radargram {
    /// A radargram of `time_s.len()` traces; samples are row-major, one row a trace.
    ///
    /// # Errors
    /// If the samples do not fill whole rows of two or more, or a number is not finite, or the
    /// step is not positive.
    pub fn new(
        time_s: Vec<f64>,
        fast_time_start_s: f64,
        fast_time_step_s: f64,
        samples: Samples,
    ) -> Result<Self, RadargramError> {
        let traces = time_s.len();
        let samples_per_trace = samples.len().checked_div(traces).unwrap_or(0);
        let radargram = Self {
            time_s,
            fast_time_start_s,
            fast_time_step_s,
            samples,
            traces,
            samples_per_trace,
        };
        radargram.validate()?;
        Ok(radargram)
    }

    /// Checks that shape, axes and samples agree and are finite.
    ///
    /// # Errors
    /// The first disagreement found.
    pub fn validate(&self) -> Result<(), RadargramError> {
        if self.traces == 0 || self.samples_per_trace < 2 {
            return Err(RadargramError::Empty {
                traces: self.traces,
                samples_per_trace: self.samples_per_trace,
            });
        }
        let length = |what, expected, found| {
            if expected == found {
                Ok(())
            } else {
                Err(RadargramError::Length {
                    what,
                    expected,
                    found,
                })
            }
        };
        length("time_s", self.traces, self.time_s.len())?;
        length(
            "samples",
            self.traces.saturating_mul(self.samples_per_trace),
            self.samples.len(),
        )?;
        if !(self.fast_time_step_s > 0.0 && self.fast_time_step_s.is_finite()) {
            return Err(RadargramError::Step {
                step_s: self.fast_time_step_s,
            });
        }
        let finite = |what, index: Option<usize>| match index {
            Some(index) => Err(RadargramError::NotFinite { what, index }),
            None => Ok(()),
        };
        finite(
            "fast_time_start_s",
            (!self.fast_time_start_s.is_finite()).then_some(0),
        )?;
        finite("time_s", self.time_s.iter().position(|t| !t.is_finite()))?;
        finite("samples", self.samples.first_non_finite())
    }

    /// Fast time of sample `index`, s.
    #[must_use]
    pub fn fast_time_s(&self, index: usize) -> f64 {
        self.fast_time_start_s + index as f64 * self.fast_time_step_s
    }

    /// Fractional sample index at which fast time is `fast_time_s`.
    #[must_use]
    pub fn sample_index(&self, fast_time_s: f64) -> f64 {
        (fast_time_s - self.fast_time_start_s) / self.fast_time_step_s
    }

    /// Fast time of the last sample, s.
    #[must_use]
    pub fn fast_time_end_s(&self) -> f64 {
        self.fast_time_s(self.samples_per_trace.saturating_sub(1))
    }

    /// The whole fast-time axis, s.
    #[must_use]
    pub fn fast_time_axis_s(&self) -> Vec<f64> {
        (0..self.samples_per_trace)
            .map(|i| self.fast_time_s(i))
            .collect()
    }

    /// Sample of a trace as a complex number.
    ///
    /// # Panics
    /// If either index is out of range.
    #[must_use]
    pub fn at(&self, trace: usize, sample: usize) -> Complex64 {
        assert!(
            sample < self.samples_per_trace,
            "sample {sample} out of range"
        );
        self.samples.at(trace * self.samples_per_trace + sample)
    }

    /// One trace as complex numbers, in double precision.
    ///
    /// # Panics
    /// If `trace` is out of range.
    #[must_use]
    pub fn trace(&self, trace: usize) -> Vec<Complex64> {
        let first = trace * self.samples_per_trace;
        (first..first + self.samples_per_trace)
            .map(|i| self.samples.at(i))
            .collect()
    }

    /// The traces with the given indices, in that order.
    ///
    /// # Errors
    /// If the list is empty or names a trace that does not exist.
    pub fn select(&self, traces: &[usize]) -> Result<Self, RadargramError> {
        if let Some(&index) = traces.iter().find(|&&i| i >= self.traces) {
            return Err(RadargramError::NoSuchTrace {
                index,
                traces: self.traces,
            });
        }
        let n = self.samples_per_trace;
        let samples = match &self.samples {
            Samples::Real(v) => Samples::Real(
                traces
                    .iter()
                    .flat_map(|&i| &v[i * n..(i + 1) * n])
                    .copied()
                    .collect(),
            ),
            Samples::Complex(v) => Samples::Complex(
                traces
                    .iter()
                    .flat_map(|&i| &v[i * n..(i + 1) * n])
                    .copied()
                    .collect(),
            ),
        };
        Self::new(
            traces.iter().map(|&i| self.time_s[i]).collect(),
            self.fast_time_start_s,
            self.fast_time_step_s,
            samples,
        )
    }

    /// The radargram with `shift_s` added to the fast-time axis.
    #[must_use]
    pub fn shifted(mut self, shift_s: f64) -> Self {
        self.fast_time_start_s += shift_s;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Radargram {
        Radargram::new(
            vec![0.0, 1.0, 2.0],
            1e-9,
            0.5e-9,
            Samples::Real((0..12).map(|i| i as f32).collect()),
        )
        .unwrap()
    }

    #[test]
    fn axes_and_rows() {
        let r = ramp();
        assert_eq!((r.traces, r.samples_per_trace), (3, 4));
        assert_eq!(r.at(1, 2), Complex64::new(6.0, 0.0));
        assert_eq!(
            r.fast_time_axis_s(),
            [0.0, 1.0, 2.0, 3.0].map(|i| 1e-9 + i * 0.5e-9)
        );
        assert!((r.sample_index(2.25e-9) - 2.5).abs() < 1e-12);
        assert!((r.fast_time_end_s() - 2.5e-9).abs() < 1e-24);
        assert_eq!(r.shifted(-1e-9).fast_time_start_s, 0.0);
    }

    #[test]
    fn selection_keeps_order_and_refuses_strangers() {
        let r = ramp().select(&[2, 0]).unwrap();
        assert_eq!(r.time_s, vec![2.0, 0.0]);
        assert_eq!(r.at(0, 0).re, 8.0);
        assert_eq!(
            ramp().select(&[3]),
            Err(RadargramError::NoSuchTrace {
                index: 3,
                traces: 3
            })
        );
        assert!(matches!(
            ramp().select(&[]),
            Err(RadargramError::Empty { .. })
        ));
    }

    #[test]
    fn nonsense_is_refused() {
        let new = |t: Vec<f64>, step, v: Vec<f32>| Radargram::new(t, 0.0, step, Samples::Real(v));
        assert!(matches!(
            new(vec![], 1.0, vec![]),
            Err(RadargramError::Empty {
                traces: 0,
                samples_per_trace: 0
            })
        ));
        assert!(matches!(
            new(vec![0.0, 1.0], 1.0, vec![0.0; 5]),
            Err(RadargramError::Length {
                what: "samples",
                expected: 4,
                found: 5
            })
        ));
        assert!(matches!(
            new(vec![0.0], -1.0, vec![0.0; 4]),
            Err(RadargramError::Step { .. })
        ));
        assert!(matches!(
            new(vec![0.0], 1.0, vec![0.0, f32::NAN]),
            Err(RadargramError::NotFinite {
                what: "samples",
                index: 1
            })
        ));
        assert!(matches!(
            new(vec![f64::NAN], 1.0, vec![0.0, 1.0]),
            Err(RadargramError::NotFinite {
                what: "time_s",
                index: 0
            })
        ));
    }
}
