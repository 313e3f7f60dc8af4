//! Inputs and sizes of the direct kernel.

use crate::control::Control;
use num_complex::Complex64;
use std::ops::Range;

/// Pulses handled together, so that their table entries stay in the first-level cache.
pub(super) const CHUNK: usize = 8;
/// Pixels of a tile held in accumulators.
pub(super) const TILE: usize = 2048;

/// Everything that the blocks of a run share.
pub(crate) struct Job<'a> {
    /// Antenna positions, one array an axis, m.
    pub antenna_m: [&'a [f64]; 3],
    pub table: TableView<'a>,
    /// Pulses summed.
    pub pulses: Range<usize>,
    /// Whether single precision may carry ranges from a block's centre to its ends: small pixels.
    pub near_centre: bool,
    /// cos αδ in powers of δ².
    pub cosine: [f32; 4],
    /// sin(αδ)/δ in powers of δ².
    pub sine: [f32; 4],
    /// Distance of the lanes, m (never negative).
    pub pixel_m: f64,
    /// Truncation error allowed to the range expansion, bins.
    pub tolerance_bins: f64,
    /// Ranges below this are summed in double precision, m; zero where no spreading is folded in.
    pub reference_below_m: f64,
    pub reference: &'a dyn ReferenceContribution,
    pub control: Control<'a>,
}

/// Range tables as the kernel reads them.
#[derive(Clone, Copy)]
pub(crate) struct TableView<'a> {
    /// `[pulse, degree + 1, re/im, stride]`, or `[pulse, stride, degree + 1, re/im]` interleaved.
    pub coefficients: &'a [f32],
    /// Absolute bin number of each pulse's entry 0.
    pub first_bin: &'a [i64],
    /// Numbers from one coefficient row to the next.
    pub stride: usize,
    /// Numbers from one pulse to the next.
    pub pulse_stride: usize,
    /// Width of a bin, m.
    pub bin_m: f64,
    /// Factor by which the coefficients were multiplied.
    pub scale: f64,
    /// Degree of the polynomials.
    pub degree: usize,
    /// Coefficients of a bin side by side, for gathers.
    pub interleaved: bool,
}

/// The weighted contribution of a pulse at a point, in double precision.
pub(crate) trait ReferenceContribution: Sync {
    fn contribution(&self, pulse: usize, point_m: [f64; 3]) -> Complex64;
}

/// Some rows of an image: pixel (i, j) stands at `origin_m + i·u_m + j·v_m`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Band {
    pub origin_m: [f64; 3],
    pub u_m: [f64; 3],
    pub v_m: [f64; 3],
    pub columns: usize,
    pub rows: usize,
}

/// Numbers of vectors by the way in which their range bins were read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    /// From windows in registers.
    pub window: u64,
    /// By gathers.
    pub gather: u64,
    /// In double precision.
    pub reference: u64,
}

impl Tally {
    pub fn add(&mut self, other: Self) {
        self.window += other.window;
        self.gather += other.gather;
        self.reference += other.reference;
    }
}

/// Vectors in a group: two share the expansion where vectors are short.
pub(super) const fn vectors_a_group(lanes: usize) -> usize {
    if lanes <= 8 { 2 } else { 1 }
}

/// Pixels of a block for vectors of `lanes`.
pub(crate) const fn block_width(lanes: usize) -> usize {
    lanes * lanes * vectors_a_group(lanes)
}

/// Rows that a tile holds at most for vectors of `lanes`.
pub(crate) const fn tile_rows(lanes: usize) -> usize {
    TILE / block_width(lanes)
}
