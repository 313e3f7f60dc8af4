//! Overviews: the image with ever coarser pixels, rows from north to south as in files.

use num_complex::Complex32;
use rayon::prelude::*;

use crate::raster::{LevelScale, Raster, Values};

/// One level of an image's pyramid, rows from north to south.
pub(crate) struct Level {
    pub nx: usize,
    pub ny: usize,
    pub samples: Samples,
}

/// The samples of a level.
pub(crate) enum Samples {
    Real(Vec<f32>),
    Complex(Vec<Complex32>),
}

/// Side up to which an image needs no further overview: a tile's.
pub(crate) const TILE: usize = 256;

/// The image and its overviews, the image first; each has half the pixels a side of the one before.
pub(crate) fn pyramid(raster: &Raster<'_>) -> Vec<Level> {
    match raster.values {
        Values::Power(values) => real(raster, values, |power| power),
        Values::Level(values, scale) => real(raster, values, |power| level_db(power, scale)),
        Values::Complex(values) => levels(from_north(values, raster.nx), raster, |four| four[0])
            .into_iter()
            .map(|(nx, ny, values)| Level {
                nx,
                ny,
                samples: Samples::Complex(values),
            })
            .collect(),
    }
}

fn real(raster: &Raster<'_>, power: &[f32], shown: impl Fn(f32) -> f32 + Sync) -> Vec<Level> {
    let known = |p: f32| if p.is_finite() { p } else { f32::NAN };
    let mut full = from_north(power, raster.nx);
    full.par_iter_mut().for_each(|p| *p = known(*p));
    levels(full, raster, mean_of_known)
        .into_iter()
        .map(|(nx, ny, mut power)| {
            power.par_iter_mut().for_each(|p| *p = shown(*p));
            Level {
                nx,
                ny,
                samples: Samples::Real(power),
            }
        })
        .collect()
}

fn level_db(power: f32, scale: LevelScale) -> f32 {
    let level_db = 10.0 * f64::from(power).log10() - scale.zero_db;
    if power > 0.0 && level_db >= scale.floor_db {
        level_db as f32
    } else {
        f32::NAN
    }
}

fn mean_of_known(few: &[f32]) -> f32 {
    let (mut count, mut sum) = (0.0_f64, 0.0_f64);
    for p in few {
        if p.is_finite() {
            count += 1.0;
            sum += f64::from(*p);
        }
    }
    // Of none, 0/0 is not a number.
    (sum / count) as f32
}

fn from_north<T: Copy + Default + Send + Sync>(values: &[T], nx: usize) -> Vec<T> {
    let mut turned = vec![T::default(); values.len()];
    turned
        .par_chunks_mut(nx)
        .zip(values.par_chunks(nx).rev())
        .for_each(|(to, from)| to.copy_from_slice(from));
    turned
}

fn levels<T: Copy + Default + Send + Sync>(
    full: Vec<T>,
    raster: &Raster<'_>,
    merge: impl Fn(&[T]) -> T + Copy + Sync,
) -> Vec<(usize, usize, Vec<T>)> {
    let mut all = vec![(raster.nx, raster.ny, full)];
    while let Some((nx, ny, values)) = all.last()
        && (*nx).max(*ny) > TILE
    {
        let next = halved(values, *nx, *ny, merge);
        all.push(next);
    }
    all
}

fn halved<T: Copy + Default + Send + Sync>(
    values: &[T],
    nx: usize,
    ny: usize,
    merge: impl Fn(&[T]) -> T + Copy + Sync,
) -> (usize, usize, Vec<T>) {
    let (columns, rows) = (nx.div_ceil(2), ny.div_ceil(2));
    let mut merged = vec![T::default(); columns * rows];
    merged
        .par_chunks_mut(columns)
        .zip(values.par_chunks(2 * nx))
        .for_each(|(line, pair)| {
            // Of an odd number of rows, the last one is alone.
            let (upper, lower) = pair.split_at(nx);
            for (i, out) in line.iter_mut().enumerate() {
                let columns = 2 * i..(2 * i + 2).min(nx);
                let below = if lower.is_empty() {
                    &[]
                } else {
                    &lower[columns.clone()]
                };
                *out = match (&upper[columns], below) {
                    ([a, b], [c, d]) => merge(&[*a, *b, *c, *d]),
                    ([a, b], _) => merge(&[*a, *b]),
                    ([a], [c, ..]) => merge(&[*a, *c]),
                    (few, _) => merge(few),
                };
            }
        });
    (columns, rows, merged)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overviews_hold_the_level_of_the_mean_power() {
        let (nx, ny) = (300, 3);
        let mut power = vec![1.0_f32; nx * ny];
        // The north-western pixel: the last row of the image.
        power[2 * nx] = 5.0;
        power[2 * nx + 1] = f32::NAN;
        let levels = pyramid(&Raster::level_db(&power, nx, ny, LevelScale::ABSOLUTE));
        assert_eq!(
            levels.iter().map(|l| (l.nx, l.ny)).collect::<Vec<_>>(),
            [(300, 3), (150, 2)]
        );
        let Samples::Real(full) = &levels[0].samples else {
            panic!("levels are real");
        };
        let Samples::Real(half) = &levels[1].samples else {
            panic!("levels are real");
        };
        assert!((full[0] - 10.0 * 5.0_f32.log10()).abs() < 1e-6 && full[1].is_nan());
        // Mean of 5, 1 and 1.
        assert!((half[0] - 10.0 * (7.0_f32 / 3.0).log10()).abs() < 1e-6);
        assert!(half[1].abs() < 1e-6);
    }

    #[test]
    fn levels_count_from_the_zero_and_have_no_data_below_the_floor() {
        let power = [100.0_f32, 10.0, 1.0, 0.0];
        let scale = LevelScale {
            zero_db: 20.0,
            floor_db: -15.0,
        };
        let levels = pyramid(&Raster::level_db(&power, 2, 2, scale));
        let Samples::Real(found) = &levels[0].samples else {
            panic!("levels are real");
        };
        // The northern row comes first.
        assert!(found[0].is_nan() && found[1].is_nan(), "{found:?}");
        assert!(
            found[2].abs() < 1e-5 && (found[3] + 10.0).abs() < 1e-5,
            "{found:?}"
        );
    }
}
