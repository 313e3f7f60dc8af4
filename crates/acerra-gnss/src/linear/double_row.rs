//! One equation of double differences.

/// One double-difference equation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DoubleRow {
    pub slot: usize,
    pub is_code: bool,
    /// Reference satellite and the other one, as indices among the common satellites.
    pub reference: usize,
    pub other: usize,
    pub residual_m: f64,
    /// Derivative with respect to the rover's position.
    pub position: [f64; 3],
    /// Wavelengths of reference and other (m): derivative with respect to their biases (cycles).
    pub wavelengths_m: [f64; 2],
    pub variance_reference_m2: f64,
    pub variance_other_m2: f64,
    /// Standard deviation (m) of the common error of all codes, in this difference; 0 for phases.
    pub common_delay_m: f64,
    /// Both variances for an undisturbed signal, without regard to signal strength.
    pub undisturbed_m2: [f64; 2],
    /// Channel number of the reference less that of the other, of GLONASS phases; else 0.
    pub channels_apart: f64,
    /// Rows with the same block share their reference's noise.
    pub block: usize,
}
