//! Inputs and sizes of the direct kernel.

use super::corners::UnevenGround;
use super::rays::RaysView;
use crate::kernel::cosine_power::CosinePower;
use crate::kernel::profile::DELAYS;
use acerra_control::Control;
use num_complex::Complex64;
use std::ops::Range;

/// Pulses handled together, so that their table entries stay in the first-level cache.
pub(super) const CHUNK: usize = 8;
/// Pixels of a tile held in accumulators.
pub(super) const TILE: usize = 2048;

/// Inputs that all blocks of a run share.
pub(crate) struct Job<'a> {
    /// Antenna positions, one array an axis, m: one set, or one of transmitters and one of receivers where
    /// these are separate. The range is then the mean of both.
    pub antennas_m: &'a [[Vec<f64>; 3]],
    pub table: TableView<'a>,
    /// Pulses summed.
    pub pulses: Range<usize>,
    /// Whether pixels are so small that single precision carries ranges from a block's centre to the block's
    /// ends.
    pub near_centre: bool,
    /// cos αδ in powers of δ².
    pub cosine: [f32; 4],
    /// sin(αδ)/δ in powers of δ².
    pub sine: [f32; 4],
    /// Distance of the lanes, m (never negative).
    pub pixel_m: f64,
    /// Truncation error allowed to the range expansion, bins.
    pub tolerance_bins: f64,
    /// Whether bins may be read from windows.
    pub windows: bool,
    /// Ranges below this are summed in double precision, m; zero where no spreading is folded in.
    pub reference_below_m: f64,
    /// A further weight of the pixels that is not part of the tables.
    pub weight: Option<PixelWeight<'a>>,
    /// Rays into level ground for antennas apart: tables are then functions of half the optical way, without weights.
    pub rays: Option<RaysView<'a>>,
    /// Uneven ground above the pixels: tables are then as for rays into level ground.
    pub ground: Option<&'a dyn UnevenGround>,
    pub reference: &'a dyn ReferenceContribution,
    pub control: Control<'a>,
}

/// A weight that changes from pixel to pixel.
#[derive(Clone, Copy)]
pub(crate) enum PixelWeight<'a> {
    /// The pattern of antennas with a tilted boresight.
    Tilt(TiltView<'a>),
    /// The ratio S²/(R_t R_r) for ranges R_t and R_r from separate antennas with mean S: the tables include
    /// 1/S².
    Ways,
}

/// The antenna's pattern in the form that the kernel reads. Tables include cosⁿ of the angle from the
/// vertical; over a level plane the cosine of the angle from the boresight is the cosine of the angle from
/// the vertical times a ratio that is linear in the pixel's place.
#[derive(Clone, Copy)]
pub(crate) struct TiltView<'a> {
    /// The boresight of each antenna divided by its height above the plane, 1/m: the ratio of cosines is the
    /// inner product of this vector with the vector from the antenna to the pixel.
    pub per_metre: &'a [[f64; 3]],
    /// The power of the ratio.
    pub power: CosinePower,
}

/// Range tables in the form that the kernel reads.
#[derive(Clone, Copy)]
pub(crate) struct TableView<'a> {
    /// `[pulse, degree + 1, re/im, stride]`, or `[pulse, stride, degree + 1, re/im]` interleaved.
    pub coefficients: &'a [f32],
    /// Place of each pulse's entry 0, in bins from range zero.
    pub first_bin: &'a [f64],
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

/// The weighted contributions of a pulse at points, in double precision.
pub(crate) trait ReferenceContribution: Sync {
    /// Contributions of `pulse` at up to [`DELAYS`] points; values beyond the points have no meaning.
    fn contributions(&self, pulse: usize, points_m: &[[f64; 3]]) -> [Complex64; DELAYS];
}

/// Some rows of an image: pixel (i, j) is at `origin_m + i·u_m + j·v_m`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Band {
    pub origin_m: [f64; 3],
    pub u_m: [f64; 3],
    pub v_m: [f64; 3],
    pub columns: usize,
    pub rows: usize,
}

/// Counts of vectors by the way in which their range bins were read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    /// Vectors read from windows in registers.
    pub window: u64,
    /// Vectors read by gathers.
    pub gather: u64,
    /// Vectors summed in double precision.
    pub reference: u64,
}

impl Tally {
    pub fn add(&mut self, other: Self) {
        self.window += other.window;
        self.gather += other.gather;
        self.reference += other.reference;
    }
}

/// Pixels along a side of a square group.
pub(crate) const SIDE: usize = 4;
/// Number of pixels of a square group.
pub(super) const GROUP: usize = SIDE * SIDE;
/// Pixels from the middle of a square group to its edge.
pub(crate) const HALF: f32 = 0.5 * (SIDE - 1) as f32;

/// Rows that a tile of square groups holds at most for vectors of `lanes`: a block is a strip of as many
/// groups as a vector has lanes.
pub(crate) const fn square_rows(lanes: usize) -> usize {
    TILE / (SIDE * lanes)
}

/// Arrangement of the pixels that share an expansion of the range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    /// Sixteen pixels of a row, read from a window of one register.
    Row,
    /// Squares of 4 × 4 pixels, read from a window of one register.
    Square,
    /// Squares of 4 × 4 pixels, read from a window of two registers.
    WideSquare,
}

impl Shape {
    /// Rows of a tile for vectors of `lanes`.
    pub const fn tile_rows(self, lanes: usize) -> usize {
        match self {
            Self::Row => tile_rows(lanes),
            Self::Square | Self::WideSquare => square_rows(lanes),
        }
    }

    /// Pixels of a group along the row and across.
    pub const fn group(self) -> [usize; 2] {
        match self {
            Self::Row => [SIDE * SIDE, 1],
            Self::Square | Self::WideSquare => [SIDE, SIDE],
        }
    }

    /// Columns of a block for vectors of `lanes`.
    pub const fn block_width(self, lanes: usize) -> usize {
        match self {
            Self::Row => block_width(lanes),
            Self::Square | Self::WideSquare => SIDE * lanes,
        }
    }

    /// Entries of a window for vectors of `lanes`.
    pub const fn window(self, lanes: usize) -> usize {
        match self {
            Self::Row | Self::Square => lanes,
            Self::WideSquare => 2 * lanes,
        }
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
