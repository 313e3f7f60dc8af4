//! The operator in double precision on any points: the reference of the fast one.

use crate::error::{InvertError, check_length};
use crate::flight::Flight;
use crate::operator::LinearOperator;
use acerra_imaging::{Complex64, Control};
use rayon::prelude::*;

/// L on a list of points, evaluated plainly in double precision: a true pair to rounding.
pub struct PointOperator<'a> {
    flight: &'a Flight,
    point_m: &'a [[f64; 3]],
}

impl<'a> PointOperator<'a> {
    /// The echoes of reflectivities at `point_m`.
    #[must_use]
    pub fn new(flight: &'a Flight, point_m: &'a [[f64; 3]]) -> Self {
        Self { flight, point_m }
    }
}

impl LinearOperator for PointOperator<'_> {
    fn pixels(&self) -> usize {
        self.point_m.len()
    }

    fn samples(&self) -> usize {
        self.flight.samples()
    }

    fn forward(
        &self,
        scene: &[Complex64],
        data: &mut [Complex64],
        control: Control,
    ) -> Result<(), InvertError> {
        check_length("scene", self.pixels(), scene.len())?;
        check_length("data", self.samples(), data.len())?;
        data.fill(Complex64::ZERO);
        for (point, value) in self.point_m.iter().zip(scene) {
            control.check()?;
            self.flight.add_echo(*point, *value, data);
        }
        Ok(())
    }

    fn adjoint(
        &self,
        data: &[Complex64],
        scene: &mut [Complex64],
        control: Control,
    ) -> Result<(), InvertError> {
        check_length("scene", self.pixels(), scene.len())?;
        check_length("data", self.samples(), data.len())?;
        scene
            .par_iter_mut()
            .zip(self.point_m)
            .for_each(|(value, point)| {
                if !control.is_cancelled() {
                    *value = self.flight.correlate(*point, data);
                }
            });
        Ok(control.check()?)
    }
}
