//! Error of interpolation over uneven ground.
//!
//! Over a plane the bounds of spatial frequencies tell it. Ground with kinks, as heights interpolated linearly between
//! the knots of a raster have them, has no such bounds: there the samples of single echoes are interpolated at random
//! places and compared.

use super::aperture::{centre_m, divided, partition_aperture};
use super::interpolation::before;
use super::lattice::Lattice;
use super::spec::{FactorizedSpec, Stage};
use crate::grid::terrain::Terrain;
use crate::grid::tilted::TiltedGrid;
use crate::pulses::Pulses;
use crate::sampling::Random;
use crate::vector::range_m;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// Places where a stage is looked at: as in self-checks a tenth of them in the corners, where frequencies are highest,
/// the others at random in the cells of a lattice; and frequencies and pulses that are taken there.
const PLACES: usize = 160;
const CORNERS: usize = 4;
const LATTICE: usize = 6;
const FREQUENCIES: usize = 4;
const PULSES: usize = 3;

/// Bound of the relative RMS error of all interpolations of `spec` over uneven ground, echoes having all frequencies of the band
/// (lowest, carrier, highest) alike.
pub(crate) fn relief_error(
    pulses: &Pulses,
    (grid, terrain): (&TiltedGrid, Terrain),
    band_hz: [f64; 3],
    spec: &FactorizedSpec,
) -> f64 {
    let parts = partition_aperture(pulses, spec.outer.pulses);
    let probe = |grid: &TiltedGrid, stage: Stage, parts: &[Range<usize>]| {
        Probe {
            pulses,
            grid,
            terrain,
            band_hz,
            lattice: &Lattice::new(pulses, grid, stage, band_hz[1]),
        }
        .mean_square(parts)
    };
    let outer = probe(grid, spec.outer, &parts);
    let shorter = spec.shorter.map_or(0.0, |stage| {
        let coarse = spec.outer.coarse.grid(grid);
        probe(&coarse, stage, &divided(&parts, stage.pulses))
    });
    (outer + shorter).sqrt()
}

/// A stage over uneven ground.
struct Probe<'a> {
    pulses: &'a Pulses<'a>,
    grid: &'a TiltedGrid,
    terrain: Terrain<'a>,
    band_hz: [f64; 3],
    lattice: &'a Lattice,
}

impl Probe<'_> {
    /// Bound of the mean square of the errors at random pixels, of random sub-apertures.
    fn mean_square(&self, parts: &[Range<usize>]) -> f64 {
        let mut random = Random(0x0e1e_f000);
        let places: Vec<_> = (0..PLACES)
            .map(|k| {
                let pixel = self.place(k % (CORNERS + LATTICE * LATTICE), &mut random);
                (pixel, parts[random.below(parts.len())].clone())
            })
            .collect();
        let squares: Vec<f64> = (places.into_par_iter())
            .map(|(pixel, part)| self.square(pixel, part))
            .collect();
        // Kinks are few: the mean with twice its standard deviation.
        let mean = squares.iter().sum::<f64>() / PLACES as f64;
        let variance = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>();
        mean + 2.0 * variance.sqrt() / PLACES as f64
    }

    /// A pixel in the `k`-th of the corners and cells.
    fn place(&self, k: usize, random: &mut Random) -> [usize; 2] {
        let sizes = [self.grid.columns, self.grid.rows];
        std::array::from_fn(|axis| {
            let (size, cell) = (sizes[axis], self.lattice.stage.coarse.cells[axis].pixels);
            let Some(of_lattice) = k.checked_sub(CORNERS) else {
                let inward = random.below(cell.min(size));
                return if (k >> axis) & 1 == 0 {
                    inward
                } else {
                    size - 1 - inward
                };
            };
            let at = [of_lattice % LATTICE, of_lattice / LATTICE][axis];
            let (from, to) = (at * size / LATTICE, (at + 1) * size / LATTICE);
            (from + random.below((to - from).max(1))).min(size - 1)
        })
    }

    /// Mean square of the errors of a sub-aperture's echoes at a pixel.
    fn square(&self, pixel: [usize; 2], part: Range<usize>) -> f64 {
        let (grid, terrain) = (self.grid, self.terrain);
        let centre = centre_m(self.pulses, part.clone());
        let member = |k: usize| part.start + k * (part.len() - 1) / (PULSES - 1);
        let antennas: [[f64; 3]; PULSES] =
            std::array::from_fn(|k| self.pulses.position_m()[member(k)]);
        let [low, carrier, high] = self.band_hz;
        let scale = TAU * 2.0 / self.pulses.light_speed_m_s();
        let echoes = |point: [f64; 3]| -> [[Complex64; FREQUENCIES]; PULSES] {
            let of_centre = carrier * range_m(point, centre);
            antennas.map(|antenna| {
                let range = range_m(point, antenna);
                let step = scale * range * (high - low) / FREQUENCIES as f64;
                let first = scale * (low * range - of_centre) + 0.5 * step;
                let (mut echo, step) = (Complex64::cis(first), Complex64::cis(step));
                [0; FREQUENCIES].map(|_| {
                    let this = echo;
                    echo *= step;
                    this
                })
            })
        };
        let [along, across] = [0, 1].map(|axis| self.taken(pixel[axis], axis));
        let mut found = [[Complex64::ZERO; FREQUENCIES]; PULSES];
        for (j, across) in across {
            for (i, along) in &along {
                let echoes = echoes(terrain.point_m(grid, *i, j));
                for (found, echoes) in found.iter_mut().zip(echoes) {
                    for (found, echo) in found.iter_mut().zip(echoes) {
                        *found += echo * (along * across);
                    }
                }
            }
        }
        let expected = echoes(terrain.point_m(grid, pixel[0] as f64, pixel[1] as f64));
        let pairs = (found.iter().zip(&expected)).flat_map(|(f, e)| f.iter().zip(e));
        let sum: f64 = pairs.map(|(f, e)| (f - e).norm_sqr()).sum();
        sum / (FREQUENCIES * PULSES) as f64
    }

    /// Where along an axis the samples stand that a pixel takes, in pixels, and their weights.
    fn taken(&self, pixel: usize, axis: usize) -> Vec<(f64, f64)> {
        let coarse = &self.lattice.stage.coarse;
        let cell = coarse.cells[axis];
        let of_cell = pixel % cell.pixels;
        let first = pixel / cell.pixels * cell.samples + cell.sample_before(of_cell);
        let weights = self.lattice.weights[axis][of_cell].iter().enumerate();
        let taken = weights.filter(|(_, weight)| **weight != 0.0);
        let at = |k: usize| (first + k) as f64 - before(coarse.taps) as f64;
        taken
            .map(|(k, weight)| (at(k) * cell.interval(), f64::from(*weight)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::cell::Cell;
    use super::super::coarse::Coarse;
    use super::*;
    use crate::error::ImagingError;
    use crate::grid::plane::PlaneGrid;
    use crate::grid::surface::SurfaceGrid;
    use crate::pulses::PulseArrays;

    #[test]
    fn kinks_are_seen_and_smooth_ground_is_not_taken_for_them() {
        let position_m: Vec<_> = (0..64)
            .map(|m| [0.0, 0.025 * f64::from(m) - 0.8, 5.0])
            .collect();
        let pulses = Pulses::new(PulseArrays {
            position_m: &position_m,
            frequency_hz: &[3.1e9, 4.8e9],
            spectrum: &[Complex64::ZERO; 128],
            weight: &[1.0; 64],
            light_speed_m_s: 3e8,
        })
        .unwrap();
        let base = PlaneGrid::new([-3.0, -3.0, 0.0], 0.01, [601, 601]).unwrap();
        let spec = |interval: usize| {
            let cell = Cell {
                pixels: interval,
                samples: 1,
            };
            FactorizedSpec {
                outer: Stage {
                    pulses: 64,
                    coarse: Coarse {
                        cells: [cell; 2],
                        taps: 16,
                    },
                    bandwidth_per_m: [6.5; 2],
                },
                shorter: None,
                interpolation_error: 0.0,
                cost: 1.0,
            }
        };
        let error = |height: fn(f64, f64) -> f64, interval: usize| {
            let ground = SurfaceGrid::from_fn(base, |x, y| Ok::<_, ImagingError>(height(x, y)));
            let ground = ground.unwrap();
            let grid = TiltedGrid::from(*ground.base());
            let terrain = Terrain::new(Some(&ground));
            let band_hz = [3.1e9, 3.95e9, 4.8e9];
            relief_error(&pulses, (&grid, terrain), band_hz, &spec(interval))
        };
        let level = error(|_, _| 0.0, 5);
        let wave = error(|x, y| 0.2 * (1.2 * x + 0.5 * y).sin(), 5);
        // Ridges a metre apart, 20 cm high.
        let ridges: fn(f64, f64) -> f64 = |x, _| 0.4 * ((x - x.floor()) - 0.5).abs();
        let (kinks, finer) = (error(ridges, 5), error(ridges, 3));
        assert!(
            level < 2e-4 && wave < 2.0 * level.max(1e-4),
            "{level:e} {wave:e}"
        );
        assert!(
            kinks > 10.0 * wave && finer < 0.7 * kinks,
            "{kinks:e} {finer:e}"
        );
        assert_eq!(error(ridges, 1), 0.0);
    }
}
