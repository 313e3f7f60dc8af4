//! Error of interpolation over uneven ground.
//!
//! Over a plane the bounds of spatial frequencies determine the error. Ground with kinks (for example heights
//! interpolated linearly between the knots of a raster) has no such bounds: the samples of single echoes are
//! interpolated at pixels of all classes of roughness and compared with the exact values.

use super::aperture::{centre_m, divided, partition_aperture};
use super::coarse::Coarse;
use super::interpolation::before;
use super::lattice::Lattice;
use super::spec::{FactorizedSpec, Stage};
use crate::grid::roughness::Roughness;
use crate::grid::terrain::Terrain;
use crate::grid::tilted::TiltedGrid;
use crate::pulses::Pulses;
use crate::sampling::Random;
use crate::vector::range_m;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// Number of places in each class of roughness and in the corners at which the error of a stage is evaluated.
const PLACES: usize = 32;
/// Number of frequencies at each place.
const FREQUENCIES: usize = 4;
/// Number of pulses at each place.
const PULSES: usize = 3;

/// Weight of the corners in the mean error: frequencies are highest in the corners, and self-checks draw
/// corners as often.
const CORNERS: f64 = 0.1;
/// Distance from a corner, in pixels, up to which a pixel belongs to the corner.
const NEAR_CORNER: usize = 8;

/// Bound of the relative RMS error of all interpolations of `spec` over uneven ground, in the whole image and
/// at rough places, for echoes of equal power at all frequencies of the band (lowest, carrier, highest).
pub(crate) fn relief_error(
    pulses: &Pulses,
    (grid, terrain, roughness): (&TiltedGrid, Terrain, &Roughness),
    band_hz: [f64; 3],
    spec: &FactorizedSpec,
) -> f64 {
    let parts = partition_aperture(pulses, spec.outer.pulses);
    let places = Places::draw(grid, roughness);
    let probe = |grid: &TiltedGrid, stage: Stage, parts: &[Range<usize>], places: &Places| {
        Probe {
            pulses,
            grid,
            terrain,
            band_hz,
            lattice: &Lattice::new(pulses, grid, stage, band_hz[1]),
        }
        .mean_square(parts, places)
    };
    let outer = probe(grid, spec.outer, &parts, &places);
    let shorter = spec.shorter.map_or(0.0, |stage| {
        let coarse = spec.outer.coarse.grid(grid);
        let places = places.on(&spec.outer.coarse);
        probe(&coarse, stage, &divided(&parts, stage.pulses), &places)
    });
    (outer + shorter).sqrt()
}

/// Pixels at which errors are evaluated.
struct Places {
    /// Share of all pixels that [`PLACES`] places represent, class after class, the corners last.
    shares: Vec<f64>,
    pixels: Vec<[usize; 2]>,
}

impl Places {
    fn draw(grid: &TiltedGrid, roughness: &Roughness) -> Self {
        let mut random = Random(0x0e1e_f000);
        let mut shares: Vec<f64> = roughness.shares().map(|s| (1.0 - CORNERS) * s).collect();
        let mut pixels: Vec<[usize; 2]> = (0..shares.len() * PLACES)
            .map(|k| roughness.draw(k / PLACES, &mut random))
            .collect();
        shares.push(CORNERS);
        let sizes = [grid.columns, grid.rows];
        pixels.extend((0..PLACES).map(|k| {
            [0, 1].map(|axis| {
                let inward = random.below(NEAR_CORNER.min(sizes[axis]));
                match (k >> axis) & 1 {
                    0 => inward,
                    _ => sizes[axis] - 1 - inward,
                }
            })
        }));
        Self { shares, pixels }
    }

    /// The samples of the coarse grid nearest to the places.
    fn on(&self, coarse: &Coarse) -> Self {
        let sample = |pixel: &[usize; 2]| {
            [0, 1].map(|axis| {
                let at = pixel[axis] as f64 / coarse.cells[axis].interval();
                at.round() as usize + before(coarse.taps)
            })
        };
        Self {
            shares: self.shares.clone(),
            pixels: self.pixels.iter().map(sample).collect(),
        }
    }
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
    /// Bound of the mean square of the errors, over random sub-apertures and at the roughest places.
    fn mean_square(&self, parts: &[Range<usize>], places: &Places) -> f64 {
        let mut random = Random(0x0e1e_f001);
        let of_parts: Vec<_> = (places.pixels.iter())
            .map(|pixel| (*pixel, parts[random.below(parts.len())].clone()))
            .collect();
        let squares: Vec<f64> = (of_parts.into_par_iter())
            .map(|(pixel, part)| self.square(pixel, part))
            .collect();
        // Means plus twice their standard deviations, over all places and over each class of roughness alone,
        // since an image's brightest target may be where the ground is roughest.
        let (mut mean, mut variance, mut worst) = (0.0, 0.0, 0.0f64);
        for (k, (squares, share)) in squares.chunks_exact(PLACES).zip(&places.shares).enumerate() {
            let of_class = squares.iter().sum::<f64>() / PLACES as f64;
            let deviations: f64 = squares.iter().map(|s| (s - of_class).powi(2)).sum();
            let variance_of_class = deviations / (PLACES * PLACES) as f64;
            mean += share * of_class;
            variance += share * share * variance_of_class;
            if k + 1 < places.shares.len() {
                worst = worst.max(of_class + 2.0 * variance_of_class.sqrt());
            }
        }
        worst.max(mean + 2.0 * variance.sqrt())
    }

    /// Mean square of the errors of a sub-aperture's echoes at a pixel.
    fn square(&self, pixel: [usize; 2], part: Range<usize>) -> f64 {
        let (grid, terrain) = (self.grid, self.terrain);
        let centre = centre_m(self.pulses, part.clone());
        let member = |k: usize| part.start + k * (part.len() - 1) / (PULSES - 1);
        let antennas: [[[f64; 3]; 2]; PULSES] =
            std::array::from_fn(|k| self.pulses.antennas_m(member(k)));
        let [low, carrier, high] = self.band_hz;
        let scale = TAU * 2.0 / self.pulses.light_speed_m_s();
        let echoes = |point: [f64; 3]| -> [[Complex64; FREQUENCIES]; PULSES] {
            let of_centre = carrier * range_m(point, centre);
            antennas.map(|[sent, received]| {
                let range = 0.5 * (range_m(point, sent) + range_m(point, received));
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

    /// Places (in pixels) and weights of the samples along an axis from which a pixel is interpolated.
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
            let roughness = Roughness::of(&(&ground).into()).unwrap();
            relief_error(
                &pulses,
                (&grid, terrain, &roughness),
                band_hz,
                &spec(interval),
            )
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
            kinks > 10.0 * wave && finer < 0.95 * kinks,
            "{kinks:e} {finer:e}"
        );
        assert_eq!(error(ridges, 1), 0.0);
        // A boulder, 15 cm × 10 cm and 30 cm high.
        let boulder: fn(f64, f64) -> f64 = |x, y| {
            let is_high = (0.7..0.85).contains(&x) && (2.0..2.1).contains(&y);
            if is_high { 0.3 } else { 0.0 }
        };
        let seen = error(boulder, 5);
        assert!(seen > 1e-2, "{seen:e}");
    }
}
