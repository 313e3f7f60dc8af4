//! Fields of complex values, cut into tiles at every level of a pyramid.
//!
//! A tile holds pairs of numbers (real, imaginary), row by row, little-endian: in single precision, or in
//! half precision for a screen, which shows no more. Level 0 holds the values themselves. At level L a value
//! represents 2^L × 2^L of them: its square is their mean power, its phase that of the middle one, as a mean
//! of phases is meaningless.

use half::f16;
use num_complex::Complex32;
use rayon::prelude::*;

/// Columns and rows of a tile, but for those at the upper edges.
pub const TILE: usize = 256;

/// Numbers of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// IEEE 754 binary32.
    Single,
    /// IEEE 754 binary16 of the values times 2^−exponent.
    Half {
        /// The exponent.
        exponent: i32,
    },
}

impl Precision {
    /// Half precision for values of at most `modulus`: they come to at most 2^15, and 190 dB below that
    /// to their last bit.
    #[must_use]
    pub fn half_for(modulus: f64) -> Self {
        let exponent = modulus.log2().ceil();
        #[expect(clippy::cast_possible_truncation, reason = "a number's exponent")]
        let exponent = if exponent.is_finite() {
            exponent as i32 - 15
        } else {
            0
        };
        Self::Half { exponent }
    }

    /// The factor by which values are greater than the numbers of a tile, in dB.
    #[must_use]
    pub fn scale_db(self) -> f64 {
        match self {
            Self::Single => 0.0,
            Self::Half { exponent } => 20.0 * f64::from(exponent) * std::f64::consts::LOG10_2,
        }
    }

    fn encode(self, values: &[Complex32]) -> Vec<u8> {
        let numbers = values.iter().flat_map(|v| [v.re, v.im]);
        match self {
            Self::Single => numbers.flat_map(f32::to_le_bytes).collect(),
            Self::Half { exponent } => {
                let factor = 2.0_f32.powi(-exponent);
                let halves = numbers.map(|v| f16::from_f32(v * factor));
                halves.flat_map(f16::to_le_bytes).collect()
            }
        }
    }
}

/// Values over columns and rows.
pub trait Field: Sync {
    /// Columns and rows.
    fn size(&self) -> [usize; 2];
    /// The value at a column and a row within [`size`](Self::size).
    fn at(&self, column: usize, row: usize) -> Complex32;
}

/// Levels over a number of columns and rows, level 0 included.
#[must_use]
pub fn levels(size: [usize; 2]) -> usize {
    let tiles = size[0].max(size[1]).div_ceil(TILE).max(1);
    1 + tiles.next_power_of_two().ilog2() as usize
}

/// Mean powers at the levels above 0, down to one tile.
#[derive(Clone, Debug, Default)]
pub struct Pyramid {
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    columns: usize,
    rows: usize,
    power: Vec<f32>,
}

/// The place of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileIndex {
    /// Level; each has half the columns and rows of the one below.
    pub level: usize,
    /// Tile along the columns.
    pub column: usize,
    /// Tile along the rows.
    pub row: usize,
}

impl Pyramid {
    /// The levels over a field.
    #[must_use]
    pub fn of(field: &impl Field) -> Self {
        let [columns, rows] = field.size();
        let mut levels: Vec<Level> = Vec::new();
        let mut size = [columns, rows];
        while size.iter().any(|n| *n > TILE) {
            let next = match levels.last() {
                None => Level::over(size, |i, j| field.at(i, j).norm_sqr()),
                Some(below) => Level::over(size, |i, j| below.power[j * below.columns + i]),
            };
            size = [next.columns, next.rows];
            levels.push(next);
        }
        Self { levels }
    }

    /// Number of levels, level 0 included.
    #[must_use]
    pub fn count(&self) -> usize {
        1 + self.levels.len()
    }

    /// Bytes that the levels above 0 take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.levels.iter().map(|level| 4 * level.power.len()).sum()
    }

    /// A tile in bytes; none where the field has no such tile.
    #[must_use]
    pub fn tile(
        &self,
        field: &impl Field,
        index: TileIndex,
        precision: Precision,
    ) -> Option<Vec<u8>> {
        Some(precision.encode(&self.values(field, index)?))
    }

    /// The values of a tile.
    fn values(&self, field: &impl Field, index: TileIndex) -> Option<Vec<Complex32>> {
        let above = match index.level {
            0 => None,
            level => Some(self.levels.get(level - 1)?),
        };
        let [columns, rows] = above.map_or(field.size(), |level| [level.columns, level.rows]);
        let (i0, j0) = (
            index.column.checked_mul(TILE)?,
            index.row.checked_mul(TILE)?,
        );
        if i0 >= columns || j0 >= rows {
            return None;
        }
        let (i1, j1) = ((i0 + TILE).min(columns), (j0 + TILE).min(rows));
        let mut values = Vec::with_capacity((i1 - i0) * (j1 - j0));
        for j in j0..j1 {
            values.extend((i0..i1).map(|i| match above {
                None => field.at(i, j),
                Some(level) => level.value(field, index.level, [i, j]),
            }));
        }
        Some(values)
    }
}

impl Level {
    /// Means of 2 × 2 powers of a level with a number of columns and rows; at the upper edges of the powers
    /// that exist.
    fn over([columns, rows]: [usize; 2], power: impl Fn(usize, usize) -> f32 + Sync) -> Self {
        let (own_columns, own_rows) = (columns.div_ceil(2), rows.div_ceil(2));
        let mut means = vec![0.0; own_columns * own_rows];
        means
            .par_chunks_mut(own_columns.max(1))
            .enumerate()
            .for_each(|(j, row)| {
                let below = 2 * j..(2 * j + 2).min(rows);
                for (i, mean) in row.iter_mut().enumerate() {
                    let (mut sum, mut count) = (0.0, 0.0);
                    for y in below.clone() {
                        for x in 2 * i..(2 * i + 2).min(columns) {
                            sum += power(x, y);
                            count += 1.0;
                        }
                    }
                    *mean = sum / count;
                }
            });
        Self {
            columns: own_columns,
            rows: own_rows,
            power: means,
        }
    }

    /// The root of a mean power, with the phase of the value in the middle of its block.
    fn value(&self, field: &impl Field, level: usize, [i, j]: [usize; 2]) -> Complex32 {
        let middle = |k: usize, n: usize| ((k << level) + (1 << (level - 1))).min(n - 1);
        let [columns, rows] = field.size();
        let centre = field.at(middle(i, columns), middle(j, rows));
        let amplitude = self.power[j * self.columns + i].sqrt();
        let modulus = centre.norm();
        if modulus > 0.0 {
            centre * (amplitude / modulus)
        } else {
            Complex32::new(amplitude, 0.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Ramp([usize; 2]);

    impl Field for Ramp {
        fn size(&self) -> [usize; 2] {
            self.0
        }
        fn at(&self, column: usize, row: usize) -> Complex32 {
            Complex32::from_polar(1.0 + column as f32, 0.01 * row as f32)
        }
    }

    fn values(bytes: &[u8]) -> Vec<Complex32> {
        let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        bytes
            .chunks_exact(8)
            .map(|b| Complex32::new(number(b), number(&b[4..])))
            .collect()
    }

    fn at(level: usize, column: usize, row: usize) -> TileIndex {
        TileIndex { level, column, row }
    }

    #[test]
    fn level_zero_is_the_field_itself() {
        let field = Ramp([300, 260]);
        let pyramid = Pyramid::of(&field);
        assert_eq!(pyramid.count(), 2);
        let edge = values(
            &pyramid
                .tile(&field, at(0, 1, 1), Precision::Single)
                .unwrap(),
        );
        assert_eq!(edge.len(), 44 * 4);
        assert_eq!(edge[44 + 3], field.at(256 + 3, 256 + 1));
        for missing in [at(0, 2, 0), at(0, 0, 2), at(2, 0, 0), at(0, usize::MAX, 0)] {
            assert!(pyramid.tile(&field, missing, Precision::Single).is_none());
        }
    }

    #[test]
    fn half_precision_keeps_levels_and_phases_of_any_scale() {
        for scale in [1e-20_f32, 1.0, 3.3e7] {
            let values = [1.0_f32, 0.3, 1e-3, 1e-6].map(|v| Complex32::from_polar(v * scale, 1.0));
            let precision = Precision::half_for(scale.into());
            let factor = 10_f64.powf(precision.scale_db() / 20.0);
            for (bytes, value) in precision.encode(&values).chunks_exact(4).zip(values) {
                let [re, im] =
                    [0, 2].map(|k| f16::from_le_bytes([bytes[k], bytes[k + 1]]).to_f64());
                let [re, im] = [re, im].map(|v| factor * v);
                assert!(
                    ((re.hypot(im)) / f64::from(value.norm()) - 1.0).abs() < 5e-4,
                    "{value}"
                );
                assert!(
                    (im.atan2(re) - f64::from(value.arg())).abs() < 5e-4,
                    "{value}"
                );
            }
        }
        assert_eq!(Precision::half_for(0.0), Precision::Half { exponent: 0 });
    }

    #[test]
    fn higher_levels_keep_the_mean_power() {
        let field = Ramp([700, 513]);
        let pyramid = Pyramid::of(&field);
        assert_eq!(pyramid.count(), 3);
        for n in [1, 255, 256, 257, 511, 512, 513, 1025, 2049] {
            let counted = Pyramid::of(&Ramp([n, 1])).count();
            assert_eq!(levels([n, 1]), counted, "{n}");
        }
        let tile = values(
            &pyramid
                .tile(&field, at(2, 0, 0), Precision::Single)
                .unwrap(),
        );
        let mean = |i: usize, j: usize| {
            let block = (0..4).flat_map(|y| (0..4).map(move |x| (x, y)));
            let powers = block.map(|(x, y)| field.at(4 * i + x, 4 * j + y).norm_sqr());
            powers.sum::<f32>() / 16.0
        };
        let value = tile[7 * 175 + 20];
        assert!((value.norm_sqr() / mean(20, 7) - 1.0).abs() < 1e-5);
        assert!((value.arg() - field.at(82, 30).arg()).abs() < 1e-6);
    }
}
