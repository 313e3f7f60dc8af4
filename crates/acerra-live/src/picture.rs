//! The displayed image: levels of half a decibel, in tiles that carry the version of their last change.

use acerra_imaging::PlaneGrid;
use num_complex::Complex32;
use rayon::prelude::*;

/// Pixels along each side of a tile.
pub const TILE: usize = 128;
/// Decibels of a step.
pub const STEP_DB: f32 = 0.5;
/// Level of the strongest pixel in a new scale.
const TOP: f32 = 190.0;
/// Steps that the strongest pixel may move before the scale is made again.
const ROOM: f32 = 60.0;

/// Levels of an image: 0 means no data, `k` from 1 to 255 is `base_db + k / 2` dB of modulus.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Grid of the pixels.
    pub grid: PlaneGrid,
    /// Level of step 0 (dB).
    pub base_db: f32,
    /// Level of the strongest pixel (dB); not finite without any.
    pub maximum_db: f32,
    /// Counts the states of the picture, from 1.
    pub sequence: u64,
    levels: Vec<u8>,
    /// When each tile changed last, by `sequence`.
    changed: Vec<u64>,
}

/// A tile: its place, size, and levels row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// First column and first row.
    pub at: [usize; 2],
    /// Columns and rows.
    pub size: [usize; 2],
    /// Levels, row by row.
    pub levels: Vec<u8>,
}

impl Picture {
    /// A picture of nothing.
    #[must_use]
    pub fn new(grid: PlaneGrid) -> Self {
        let tiles = grid.nx.div_ceil(TILE) * grid.ny.div_ceil(TILE);
        Self {
            grid,
            base_db: 0.0,
            maximum_db: f32::NEG_INFINITY,
            sequence: 0,
            levels: vec![0; grid.nx * grid.ny],
            changed: vec![0; tiles],
        }
    }

    /// Takes a new state of the image, `[ny, nx]` row-major; one of another size is not taken.
    pub fn update(&mut self, image: &[Complex32]) {
        if image.len() != self.levels.len() {
            return;
        }
        let power = image.par_iter().map(Complex32::norm_sqr);
        let greatest = power.reduce(|| 0.0, f32::max);
        let maximum_db = 10.0 * greatest.log10();
        self.sequence += 1;
        let strongest = (maximum_db - self.base_db) / STEP_DB;
        let is_in_scale = (strongest - TOP).abs() <= ROOM;
        let was_empty = !self.maximum_db.is_finite();
        if maximum_db.is_finite() && (was_empty || !is_in_scale) {
            self.base_db = maximum_db - TOP * STEP_DB;
        }
        self.maximum_db = maximum_db;
        let (nx, base_db, sequence) = (self.grid.nx, self.base_db, self.sequence);
        let tiles_across = nx.div_ceil(TILE);
        self.levels
            .par_chunks_mut(nx * TILE)
            .zip(image.par_chunks(nx * TILE))
            .zip(self.changed.par_chunks_mut(tiles_across))
            .for_each(|((levels, image), changed)| {
                for (row, values) in levels.chunks_mut(nx).zip(image.chunks(nx)) {
                    for (place, changed) in changed.iter_mut().enumerate() {
                        let columns = place * TILE..nx.min((place + 1) * TILE);
                        let mut differs = false;
                        for (level, v) in row[columns.clone()].iter_mut().zip(&values[columns]) {
                            let new = level_of(v.norm_sqr(), base_db);
                            differs |= new != *level;
                            *level = new;
                        }
                        if differs {
                            *changed = sequence;
                        }
                    }
                }
            });
    }

    /// The tiles that changed after state `seen`.
    pub fn tiles_since(&self, seen: u64) -> impl Iterator<Item = Tile> {
        let across = self.grid.nx.div_ceil(TILE);
        let changed = self.changed.iter().enumerate();
        changed
            .filter(move |(_, changed)| **changed > seen)
            .map(move |(k, _)| self.tile([k % across, k / across]))
    }

    fn tile(&self, [column, row]: [usize; 2]) -> Tile {
        let (nx, ny) = (self.grid.nx, self.grid.ny);
        let at = [column * TILE, row * TILE];
        let size = [TILE.min(nx - at[0]), TILE.min(ny - at[1])];
        let rows = at[1]..at[1] + size[1];
        let mut levels = Vec::with_capacity(size[0] * size[1]);
        for row in rows {
            let start = row * nx + at[0];
            levels.extend_from_slice(&self.levels[start..start + size[0]]);
        }
        Tile { at, size, levels }
    }
}

/// Steps above the base; levels below the first one are 1, no data is 0.
fn level_of(power: f32, base_db: f32) -> u8 {
    /// Decibels of an octave.
    const OCTAVE_DB: f32 = 3.010_3;
    let is_something = power > 0.0 && power < f32::INFINITY;
    let steps = (OCTAVE_DB * octaves(power) - base_db) * (1.0 / STEP_DB) + 0.5;
    // Conversions saturate, and truncate the fraction.
    let level = (steps.clamp(1.0, 255.0)) as u8;
    if is_something { level } else { 0 }
}

/// The binary logarithm of a positive normal number to 2e-4, without calls, so that loops over it become vector
/// instructions.
fn octaves(power: f32) -> f32 {
    const MANTISSA: u32 = 0x007F_FFFF;
    const ONE: u32 = 0x3F80_0000;
    let bits = power.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let m = f32::from_bits((bits & MANTISSA) | ONE) - 1.0;
    // log2(1 + m) is m with a correction that vanishes at both ends.
    let bend = 0.44174 + m * (-0.26603 + m * (0.14631 + m * -0.04400));
    exponent as f32 + m + m * (1.0 - m) * bend
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(nx: usize, ny: usize) -> Picture {
        Picture::new(PlaneGrid::new([0.0; 3], 0.1, [nx, ny]).unwrap())
    }

    /// The levels as a client has them who took the tiles after `seen`.
    fn follow(client: &mut [u8], picture: &Picture, seen: u64) -> u64 {
        for tile in picture.tiles_since(seen) {
            for (k, row) in tile.levels.chunks(tile.size[0]).enumerate() {
                let start = (tile.at[1] + k) * picture.grid.nx + tile.at[0];
                client[start..start + row.len()].copy_from_slice(row);
            }
        }
        picture.sequence
    }

    #[test]
    fn a_client_that_skips_states_ends_up_with_the_picture() {
        let (nx, ny) = (300, 140);
        let mut picture = picture(nx, ny);
        let mut image = vec![Complex32::ZERO; nx * ny];
        let mut client = vec![0; nx * ny];
        let mut seen = 0;
        for k in 0..40_usize {
            // The scale is recomputed repeatedly: 4 dB a state.
            image[(k * 7919) % (nx * ny)] = Complex32::new(1.6_f32.powi(k as i32), 0.0);
            picture.update(&image);
            if k % 3 == 0 {
                seen = follow(&mut client, &picture, seen);
            }
        }
        follow(&mut client, &picture, seen);
        assert_eq!(client, picture.levels);
        let mut fresh = vec![0; nx * ny];
        follow(&mut fresh, &picture, 0);
        assert_eq!(fresh, picture.levels);
    }

    #[test]
    fn octaves_are_binary_logarithms() {
        for k in 0..200_000 {
            let power = 1.000_9_f32.powi(k - 90_000);
            if power.is_normal() {
                let off = octaves(power) - power.log2();
                assert!(off.abs() < 2e-4, "{power}: {off}");
            }
        }
        let worst =
            |level: u8, base_db: f32, db: f32| (f32::from(level) * STEP_DB + base_db - db).abs();
        for k in 0..2000 {
            let db = 0.04 * k as f32 + 20.0;
            let level = level_of(10_f32.powf(0.1 * db), 10.0);
            assert!(worst(level, 10.0, db) < 0.502 * STEP_DB, "{db}: {level}");
        }
        for nothing in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(level_of(nothing, 0.0), 0);
        }
        assert_eq!((level_of(1e-30, 0.0), level_of(1e30, 0.0)), (1, 255));
    }

    #[test]
    fn levels_tell_decibels() {
        let mut picture = picture(3, 1);
        picture.update(&[
            Complex32::new(1000.0, 0.0),
            Complex32::new(0.0, -100.0),
            Complex32::ZERO,
        ]);
        let db = |k: usize| picture.base_db + STEP_DB * f32::from(picture.levels[k]);
        assert!((db(0) - 60.0).abs() <= 0.25 && (db(1) - 40.0).abs() <= 0.25);
        assert_eq!(picture.levels[2], 0);
        assert!((picture.maximum_db - 60.0).abs() < 1e-3);
    }

    #[test]
    fn what_does_not_change_is_not_sent_again() {
        let mut picture = picture(400, 400);
        let mut image = vec![Complex32::new(1.0, 0.0); 160_000];
        picture.update(&image);
        assert_eq!(picture.tiles_since(0).count(), 16);
        image[0] = Complex32::new(2.0, 0.0);
        picture.update(&image);
        assert_eq!(picture.tiles_since(1).count(), 1);
        assert_eq!(picture.tiles_since(2).count(), 0);
    }
}
