//! Real and complex samples through one small interface, so that each stage is written once.

use num_complex::{Complex32, Complex64};

use crate::radargram::{Radargram, Samples};
use acerra_control::Cancelled;

/// A stored sample that stages widen to double precision, work on, and narrow again.
pub(crate) trait Value: Copy + Send + Sync {
    fn wide(self) -> Complex64;
    fn narrow(z: Complex64) -> Self;
}

impl Value for f32 {
    fn wide(self) -> Complex64 {
        Complex64::new(f64::from(self), 0.0)
    }
    fn narrow(z: Complex64) -> Self {
        z.re as Self
    }
}

impl Value for Complex32 {
    fn wide(self) -> Complex64 {
        Complex64::new(f64::from(self.re), f64::from(self.im))
    }
    fn narrow(z: Complex64) -> Self {
        Self::new(z.re as f32, z.im as f32)
    }
}

/// A stage that changes samples in place, whatever their kind.
pub(crate) trait InPlace {
    fn run<V: Value>(&self, samples: &mut [V], shape: Shape) -> Result<(), Cancelled>;
}

/// Numbers of traces and of samples per trace.
#[derive(Clone, Copy)]
pub(crate) struct Shape {
    pub traces: usize,
    pub samples_per_trace: usize,
}

/// Runs a stage over a radargram's samples.
///
/// # Errors
/// If the stage was cancelled; the samples are then invalid.
pub(crate) fn in_place(radargram: &mut Radargram, stage: &impl InPlace) -> Result<(), Cancelled> {
    let shape = Shape {
        traces: radargram.traces,
        samples_per_trace: radargram.samples_per_trace,
    };
    match &mut radargram.samples {
        Samples::Real(v) => stage.run(v, shape),
        Samples::Complex(v) => stage.run(v, shape),
    }
}
