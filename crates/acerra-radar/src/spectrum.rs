//! Spectra, traces × frequency: the input of the adjoint.

use num_complex::Complex64;

use crate::radargram::RadargramError;

/// Complex spectra at chosen frequencies, in the e^{jωt} convention: an echo from range R has
/// phase e^{−j4πfR/c}.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Frequencies, Hz, `[N]`.
    pub frequency_hz: Vec<f64>,
    /// Values, row-major `[traces, N]`.
    pub values: Vec<Complex64>,
    /// Slow time of each trace, s, `[traces]`.
    pub time_s: Vec<f64>,
}

impl Spectrum {
    /// A spectrum of `time_s.len()` traces at `frequency_hz`.
    ///
    /// # Errors
    /// If there is no trace or no frequency, the values do not fill `[traces, N]`, a number is not
    /// finite, or a frequency is not positive.
    pub fn new(
        frequency_hz: Vec<f64>,
        values: Vec<Complex64>,
        time_s: Vec<f64>,
    ) -> Result<Self, RadargramError> {
        let spectrum = Self {
            frequency_hz,
            values,
            time_s,
        };
        spectrum.validate()?;
        Ok(spectrum)
    }

    /// Checks that shape and axes agree and that every number is finite.
    ///
    /// # Errors
    /// The first disagreement found.
    pub fn validate(&self) -> Result<(), RadargramError> {
        if self.time_s.is_empty() || self.frequency_hz.is_empty() {
            return Err(RadargramError::Empty {
                traces: self.time_s.len(),
                samples_per_trace: self.frequency_hz.len(),
            });
        }
        let expected = self.time_s.len().saturating_mul(self.frequency_hz.len());
        if self.values.len() != expected {
            return Err(RadargramError::Length {
                what: "spectrum",
                expected,
                found: self.values.len(),
            });
        }
        let not_finite = |what, index| RadargramError::NotFinite { what, index };
        if let Some(i) = self.frequency_hz.iter().position(|f| !f.is_finite()) {
            return Err(not_finite("frequency_hz", i));
        }
        if let Some(index) = self.frequency_hz.iter().position(|&f| f <= 0.0) {
            return Err(RadargramError::Frequency {
                index,
                frequency_hz: self.frequency_hz[index],
            });
        }
        if let Some(i) = self.time_s.iter().position(|t| !t.is_finite()) {
            return Err(not_finite("time_s", i));
        }
        match self
            .values
            .iter()
            .position(|z| !z.re.is_finite() || !z.im.is_finite())
        {
            Some(i) => Err(not_finite("spectrum", i)),
            None => Ok(()),
        }
    }

    /// Number of traces.
    #[must_use]
    pub fn traces(&self) -> usize {
        self.time_s.len()
    }

    /// The values of one trace.
    ///
    /// # Panics
    /// If `trace` is out of range.
    #[must_use]
    pub fn trace(&self, trace: usize) -> &[Complex64] {
        let n = self.frequency_hz.len();
        &self.values[trace * n..(trace + 1) * n]
    }

    /// The traces with the given indices, in that order.
    ///
    /// # Errors
    /// If the list is empty or names a trace that does not exist.
    pub fn select(&self, traces: &[usize]) -> Result<Self, RadargramError> {
        if let Some(&index) = traces.iter().find(|&&i| i >= self.traces()) {
            return Err(RadargramError::NoSuchTrace {
                index,
                traces: self.traces(),
            });
        }
        Self::new(
            self.frequency_hz.clone(),
            traces
                .iter()
                .flat_map(|&i| self.trace(i))
                .copied()
                .collect(),
            traces.iter().map(|&i| self.time_s[i]).collect(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shape_and_frequencies_are_checked() {
        let z = Complex64::new(1.0, 0.0);
        assert!(Spectrum::new(vec![3e9, 4e9], vec![z; 4], vec![0.0, 1.0]).is_ok());
        assert!(matches!(
            Spectrum::new(vec![3e9, 4e9], vec![z; 3], vec![0.0, 1.0]),
            Err(RadargramError::Length {
                expected: 4,
                found: 3,
                ..
            })
        ));
        assert!(matches!(
            Spectrum::new(vec![3e9, 0.0], vec![z; 2], vec![0.0]),
            Err(RadargramError::Frequency { index: 1, .. })
        ));
        assert!(matches!(
            Spectrum::new(vec![3e9], vec![z * f64::NAN], vec![0.0]),
            Err(RadargramError::NotFinite {
                what: "spectrum",
                index: 0
            })
        ));
    }
}
