//! Exact image of point targets as a field.

use num_complex::Complex64;

use super::spread::PointSpread;
use crate::metrics::field::Field;

/// The image of point targets on a horizontal plane, evaluated by Eq. (5) at any place.
#[derive(Clone, Copy, Debug)]
pub struct PsfField<'a> {
    spread: &'a PointSpread,
    target_m: &'a [[f64; 3]],
    z_m: f64,
}

impl<'a> PsfField<'a> {
    /// The image of unit points at `target_m` on the plane at height `z_m`.
    pub fn new(spread: &'a PointSpread, target_m: &'a [[f64; 3]], z_m: f64) -> Self {
        Self {
            spread,
            target_m,
            z_m,
        }
    }

    /// The complex image at (x, y), m.
    pub fn value(&self, x_m: f64, y_m: f64) -> Complex64 {
        let at = [x_m, y_m, self.z_m];
        self.target_m
            .iter()
            .map(|t| self.spread.response(*t, at))
            .sum()
    }
}

impl Field for PsfField<'_> {
    fn amplitude(&self, x_m: f64, y_m: f64) -> Option<f64> {
        Some(self.value(x_m, y_m).norm())
    }
}
