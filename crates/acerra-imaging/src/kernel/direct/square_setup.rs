//! Blocks of squares, and their middles seen from every antenna.

use super::job::{Band, CHUNK, HALF, Job, SIDE};
use super::rays::Place;
use super::square_ground::SquareGround;
use super::tile_corners::TileCorners;
use super::unwindowed::whole_and_rest;
use crate::kernel::aligned::Aligned;
use crate::kernel::lanes::{Lanes, MAX_LANES};
use crate::vector::{dot, norm};
use std::ops::Range;

/// First row of the coefficients of third order.
pub(super) const CUBE_ROW: usize = 10;
/// First row of one over the weight: its value at the middle, changes along the row and across, and terms of second order.
pub(super) const WEIGHT_ROW: usize = 14;
/// First of five rows for pulses without the last orders: the slopes along the row and across, and the weight at the middle
/// with its changes along the row and across.
pub(super) const FLAT_ROW: usize = 20;
/// Rows of parameters of a pulse.
pub(super) const RAY_ROWS: usize = 25;

/// Pulses of a chunk and the pixels of one block: groups side by side in a strip of [`SIDE`] rows.
pub(super) struct SquareBlock<'a, S> {
    pub s: S,
    pub job: &'a Job<'a>,
    pub band: &'a Band,
    /// First column of the block, and its first row.
    pub column: usize,
    pub row: usize,
    /// Groups that hold pixels of the band.
    pub groups: usize,
    pub pulses: Range<usize>,
    /// Heights of the block's pixels; level ground for kernels without heights.
    pub ground: &'a SquareGround,
    /// Rays to the corners of the groups, below uneven ground.
    pub corners: Option<&'a TileCorners<'a>>,
}

/// Axes of a band.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    /// Distance of pixels along the row and across, m.
    pub pixel_m: [f64; 2],
    /// Unit vectors along the row and across.
    unit: [[f64; 3]; 2],
    /// Cosine of the angle between the unit vectors.
    pub skew: f64,
    /// Half the square of the distance along, the product of both distances, and half the square of that across, m².
    pub bends: [f32; 3],
}

impl Frame {
    fn of(band: &Band) -> Self {
        let pixel_m = [band.u_m, band.v_m].map(|v| norm(v).max(1e-12));
        let unit = [
            band.u_m.map(|x| x / pixel_m[0]),
            band.v_m.map(|x| x / pixel_m[1]),
        ];
        Self {
            pixel_m,
            unit,
            skew: dot(unit[0], unit[1]),
            bends: [
                (0.5 * pixel_m[0] * pixel_m[0]) as f32,
                (pixel_m[0] * pixel_m[1]) as f32,
                (0.5 * pixel_m[1] * pixel_m[1]) as f32,
            ],
        }
    }
}

impl<S: Lanes> SquareBlock<'_, S> {
    /// The point of the band's plane at some pixels from the block's first one, raised by `up_m`, m.
    #[inline(always)]
    pub fn point_m(&self, along: f64, across: f64, up_m: f64) -> [f64; 3] {
        let (i, j) = (self.column as f64 + along, self.row as f64 + across);
        let band = self.band;
        let at = |axis: usize| band.origin_m[axis] + i * band.u_m[axis] + j * band.v_m[axis];
        [at(0), at(1), at(2) + up_m]
    }
}

/// Offset of a point from an antenna.
#[derive(Clone, Copy, Default)]
pub(super) struct Seen {
    pub range_m: f32,
    /// Along the row and across, m.
    pub along_m: f32,
    pub across_m: f32,
    /// Above the antenna, m.
    pub up_m: f32,
}

/// The middle of a group, relative to the antennas of a pulse.
pub(super) struct Origin {
    pub from: [Seen; 2],
    /// Places of the ranges among tabulated rays, where there are any.
    pub places: [Place; 2],
    /// Mean range in bins, as whole bins past the pulse's entry 0 and a fraction.
    pub whole: i32,
    pub fraction: f32,
}

impl Origin {
    /// Group `k` of a block, seen by pulse `m` of the chunk.
    #[inline(always)]
    pub fn of<S: Lanes>(block: &SquareBlock<S>, frame: &Frame, k: usize, m: usize) -> Self {
        let along = (SIDE * k) as f64 + f64::from(HALF);
        let up_m = block.ground.middle_m + f64::from(block.ground.plane_m[k]);
        let (point, job) = (block.point_m(along, f64::from(HALF), up_m), block.job);
        let pulse = block.pulses.start + m;
        let (mut from, mut mean) = ([Seen::default(); 2], 0.0);
        let mut places = [Place::default(); 2];
        for (k, (seen, antenna_m)) in from.iter_mut().zip(job.antennas_m).enumerate() {
            let d: [f64; 3] = std::array::from_fn(|axis| point[axis] - antenna_m[axis][pulse]);
            let range = norm(d);
            mean += range / job.antennas_m.len() as f64;
            *seen = Seen {
                range_m: range as f32,
                along_m: dot(d, frame.unit[0]) as f32,
                across_m: dot(d, frame.unit[1]) as f32,
                up_m: d[2] as f32,
            };
            if let Some(rays) = &job.rays {
                let row = &rays.rows[k][pulse];
                places[k] = row.place(range);
                mean += row.beyond_m / job.antennas_m.len() as f64;
            }
        }
        let bins = mean * (1.0 / job.table.bin_m) - job.table.first_bin[pulse];
        let (whole, fraction) = whole_and_rest(bins);
        Self {
            from,
            places,
            whole,
            fraction,
        }
    }
}

/// Parameters of the pulses of a chunk for one block.
pub(super) struct SquareSetup {
    /// Parameters of each pulse that has windows, [`Self::rows`] rows of N, one lane a group: slopes of the
    /// range along the row and across (bins a pixel); half its second derivatives along, mixed (whole) and
    /// across; one over the range in bins; and for either vector the range at the group's middle in bins past
    /// that vector's window, and the bits of the integer at which the window starts in the chunk's table;
    /// over uneven ground also the change of the range with height (bins a metre), that of its slopes along
    /// the row and across, and half its second derivative with height; last the weight of the group, where
    /// pixels have one. Below level ground the rows of rays follow instead. Pulses of narrow windows are stored from the front on, those of wide ones from the
    /// back.
    pub windowed: Aligned<{ CHUNK * Self::MOST_ROWS * MAX_LANES }>,
    pub frame: Frame,
    /// Middle of the block from each antenna of each pulse, and the mean range in bins.
    pub from: [[Seen; CHUNK]; 2],
    /// Places of these ranges among tabulated rays, where there are any.
    pub places: [[Place; CHUNK]; 2],
    pub fraction: [f32; CHUNK],
    pub whole: [i32; CHUNK],
}

impl SquareSetup {
    const MOST_ROWS: usize = RAY_ROWS;

    /// Rows of parameters of a pulse.
    pub const fn rows(relief: bool, rays: bool) -> usize {
        if rays {
            RAY_ROWS
        } else {
            Self::weight_row(relief) + 1
        }
    }

    /// The row of the weights.
    pub const fn weight_row(relief: bool) -> usize {
        if relief { 14 } else { 10 }
    }

    pub fn new(band: &Band) -> Self {
        Self {
            windowed: Aligned([0.0; CHUNK * Self::MOST_ROWS * MAX_LANES]),
            frame: Frame::of(band),
            from: [[Seen::default(); CHUNK]; 2],
            places: [[Place::default(); CHUNK]; 2],
            fraction: [0.0; CHUNK],
            whole: [0; CHUNK],
        }
    }

    /// Computes the ranges from every antenna to the block's middle in double precision.
    #[inline(always)]
    pub fn measure<S: Lanes, const RAYS: bool>(&mut self, block: &SquareBlock<S>) {
        if let (true, Some(corners)) = (RAYS, block.corners) {
            let table = &block.job.table;
            for m in 0..block.pulses.len() {
                let first_bin = table.first_bin[block.pulses.start + m];
                let bins = corners.base_m(m) / table.bin_m - first_bin;
                (self.whole[m], self.fraction[m]) = whole_and_rest(bins);
            }
            return;
        }
        let along = 0.5 * (SIDE * S::N - 1) as f64;
        let middle = block.point_m(along, f64::from(HALF), block.ground.middle_m);
        let ([x, y, z], job) = (middle, block.job);
        let ([u, v], inverse_bin) = (self.frame.unit, 1.0 / job.table.bin_m);
        let start = &job.table.first_bin[block.pulses.clone()];
        let share = 1.0 / job.antennas_m.len() as f64;
        let [mut mean, mut ranges_m] = [[0f64; CHUNK]; 2];
        let seen = self.from.iter_mut().zip(&mut self.places);
        for (k, ((from, places), antenna_m)) in seen.zip(job.antennas_m).enumerate() {
            let px = &antenna_m[0][block.pulses.clone()];
            let py = &antenna_m[1][block.pulses.clone()];
            let pz = &antenna_m[2][block.pulses.clone()];
            for m in 0..block.pulses.len() {
                let (dx, dy, dz) = (x - px[m], y - py[m], z - pz[m]);
                let range = (dx * dx + dy * dy + dz * dz).sqrt();
                mean[m] += share * range;
                from[m] = Seen {
                    range_m: range as f32,
                    along_m: (dx * u[0] + dy * u[1] + dz * u[2]) as f32,
                    across_m: (dx * v[0] + dy * v[1] + dz * v[2]) as f32,
                    up_m: dz as f32,
                };
                ranges_m[m] = range;
            }
            if RAYS && let Some(rays) = &job.rays {
                let rows = &rays.rows[k][block.pulses.clone()];
                for (m, row) in rows.iter().enumerate() {
                    places[m] = row.place(ranges_m[m]);
                    mean[m] += share * row.beyond_m;
                }
            }
        }
        for m in 0..block.pulses.len() {
            (self.whole[m], self.fraction[m]) = whole_and_rest(mean[m] * inverse_bin - start[m]);
        }
    }
}
