//! Correlation in time of a trajectory's errors.

use crate::observations::observation::EPOCH_TOLERANCE_S;

/// Correlation in time of a trajectory's errors, measured from the trajectory's fixes.
///
/// Errors of phases are a sum of first-order Gauss–Markov processes (multipath) and white noise; float
/// positions also have the slow error of their ambiguities.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorCorrelation {
    /// The parts of the phases' errors that last beyond an epoch; the remaining share, up to one, is white.
    pub phases: Vec<Lasting>,
    /// The parts of the errors of float ambiguities, whose shares make up one.
    pub ambiguities: Vec<Lasting>,
    /// Sum of the variances of east, north and up that phases alone give a position (m²): the
    /// median of the fixes.
    pub fixed_variance_m2: f64,
}

/// A first-order Gauss–Markov process as a part of an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lasting {
    /// Share of the error's variance.
    pub share: f64,
    /// Time (s) in which the correlation falls to 1/e.
    pub time_constant_s: f64,
}

impl Default for ErrorCorrelation {
    /// Defaults without measurements: multipath with the time in which its phase changes by a radian at an
    /// antenna 1 m above a reflecting ground (180 s) is half of the phases' variance, and the errors of float
    /// ambiguities last for 300 s.
    fn default() -> Self {
        Self {
            phases: vec![Lasting {
                share: 0.5,
                time_constant_s: 180.0,
            }],
            ambiguities: vec![Lasting {
                share: 1.0,
                time_constant_s: 300.0,
            }],
            fixed_variance_m2: 1e-4,
        }
    }
}

impl ErrorCorrelation {
    /// Correlation of phase errors `apart_s` apart.
    #[must_use]
    pub fn of_phases(&self, apart_s: f64) -> f64 {
        if apart_s.abs() < EPOCH_TOLERANCE_S {
            return 1.0;
        }
        sum(&self.phases, apart_s)
    }

    /// Correlation of the errors of float ambiguities `apart_s` apart.
    #[must_use]
    pub fn of_ambiguities(&self, apart_s: f64) -> f64 {
        sum(&self.ambiguities, apart_s)
    }
}

fn sum(parts: &[Lasting], apart_s: f64) -> f64 {
    parts
        .iter()
        .map(|l| l.share * (-apart_s.abs() / l.time_constant_s).exp())
        .sum()
}
