//! Reflectivities from the sum of Eq. (3): every pixel divided by the sum that a point of unit reflectivity gives.
//!
//! An echo from range R falls as 1/R², and Eq. (3) weighs it by 1/R² again, so that the sum of a point grows as
//! Σ w/R⁴: of two equal reflectors at 2 m and 8 m the nearer is 48 dB brighter. The quotient is the least-squares
//! estimate of the reflectivity of a point alone in its pixel.

use acerra_imaging::{Complex32, PlaneGrid, SurfaceGrid};
use rayon::prelude::*;

use crate::scene::pixels::Pixels;

/// Spacing of the nodes between which the logarithm of the sum is linear, over the nearest range: 0.2 % of error.
const SPACING_OF_RANGE: f64 = 0.06;
/// Largest number of nodes along the longer side.
const MOST_NODES: f64 = 2000.0;

/// Divides the image by the image of a point of unit reflectivity, whose echoes the traces at `position_m`
/// receive with `weight` at `frequencies` frequencies. Values are in the echoes' unit times m².
pub(crate) fn to_reflectivity(
    image: &mut [Complex32],
    pixels: &Pixels,
    (position_m, weight): (&[[f64; 3]], &[f64]),
    frequencies: usize,
) {
    let nodes = Nodes::over(pixels, position_m, weight);
    let grid = &pixels.grid;
    let per_frequency = 1.0 / frequencies.max(1) as f64;
    image
        .par_chunks_mut(grid.nx.max(1))
        .enumerate()
        .for_each(|(iy, row)| {
            for (ix, value) in row.iter_mut().enumerate() {
                let log = nodes.at(grid.x_m(ix), grid.y_m(iy));
                let gain = per_frequency * (-log).exp();
                *value *= if gain.is_finite() { gain as f32 } else { 0.0 };
            }
        });
}

/// Logarithm of Σ w/R⁴ on nodes at multiples of their spacing, so that tiles of an image share them.
struct Nodes {
    spacing_m: f64,
    first: [f64; 2],
    nx: usize,
    log: Vec<f64>,
}

impl Nodes {
    fn over(pixels: &Pixels, position_m: &[[f64; 3]], weight: &[f64]) -> Self {
        let grid = &pixels.grid;
        let [x_m, y_m] = [
            [grid.x0_m, grid.x_m(grid.nx - 1)],
            [grid.y0_m, grid.y_m(grid.ny - 1)],
        ];
        let [low_m, high_m] = pixels.span_m();
        // Ranges are no less than the height over the pixels.
        let nearest_m = position_m
            .iter()
            .map(|p| (p[2] - p[2].clamp(low_m, high_m)).abs())
            .fold(f64::INFINITY, f64::min);
        let longest_m = (x_m[1] - x_m[0]).max(y_m[1] - y_m[0]);
        let finest_m = grid.pixel_m.max(longest_m / MOST_NODES);
        // A power of two, so that small differences of pixels or tiles do not change the spacing.
        let spacing_m = (SPACING_OF_RANGE * nearest_m.min(1e6)).max(finest_m);
        let spacing_m = spacing_m.log2().floor().exp2();
        let first = [x_m[0], y_m[0]].map(|from| (from / spacing_m).floor());
        let count = |from: f64, to_m: f64| ((to_m / spacing_m).ceil() - from) as usize + 2;
        let (nx, ny) = (count(first[0], x_m[1]), count(first[1], y_m[1]));
        let surface = pixels.surface.as_deref();
        let log = (0..nx * ny)
            .into_par_iter()
            .map(|k| {
                let [x, y] = [k % nx, k / nx].map(|i| i as f64);
                let place_m = [(first[0] + x) * spacing_m, (first[1] + y) * spacing_m];
                let z_m = height_m(surface, grid, place_m);
                let sum: f64 = position_m
                    .iter()
                    .zip(weight)
                    .map(|(p, w)| {
                        let square = (p[0] - place_m[0]).powi(2)
                            + (p[1] - place_m[1]).powi(2)
                            + (p[2] - z_m).powi(2);
                        w / (square * square)
                    })
                    .sum();
                sum.max(f64::MIN_POSITIVE).ln()
            })
            .collect();
        Self {
            spacing_m,
            first,
            nx,
            log,
        }
    }

    /// The logarithm at a place, interpolated between four nodes.
    fn at(&self, x_m: f64, y_m: f64) -> f64 {
        let [u, v] = [
            x_m / self.spacing_m - self.first[0],
            y_m / self.spacing_m - self.first[1],
        ];
        let (i, j) = (u.floor(), v.floor());
        let (a, b) = (u - i, v - j);
        let k = j as usize * self.nx + i as usize;
        let row = |k: usize| (1.0 - a) * self.log[k] + a * self.log[k + 1];
        (1.0 - b) * row(k) + b * row(k + self.nx)
    }
}

fn height_m(surface: Option<&SurfaceGrid>, grid: &PlaneGrid, [x_m, y_m]: [f64; 2]) -> f64 {
    surface.map_or(grid.z_m, |s| s.height_m(x_m, y_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_imaging::reference::{self, Scatterer};
    use acerra_imaging::{PulseArrays, Pulses, Spreading};

    #[test]
    fn equal_points_near_and_far_are_equally_bright() {
        let position_m: Vec<[f64; 3]> = (0..81).map(|k| [0.05 * f64::from(k), 0.0, 1.5]).collect();
        let frequency_hz: Vec<f64> = (0..60).map(|k| 3.1e9 + 28e6 * f64::from(k)).collect();
        let grid = PlaneGrid::from_ranges([-1.0, 5.0], [0.5, 9.0], 0.0, 0.25).unwrap();
        for place_m in [[2.0, 1.0, 0.0], [1.0, 8.0, 0.0]] {
            let point = Scatterer {
                position_m: place_m,
                reflectivity: acerra_imaging::Complex64::new(3.0, 0.0),
            };
            let inverse = Spreading::InverseSquare;
            let echo =
                reference::forward(&position_m, &frequency_hz, &[point], 299_792_458.0, inverse)
                    .unwrap();
            let weight = vec![0.5; position_m.len()];
            let pulses = Pulses::new(PulseArrays {
                position_m: &position_m,
                frequency_hz: &frequency_hz,
                spectrum: &echo,
                weight: &weight,
                light_speed_m_s: 299_792_458.0,
            })
            .unwrap();
            let pixels = Pixels::plane(grid);
            let places: Vec<[f64; 3]> = (0..grid.len()).map(|k| pixels.place_m(k)).collect();
            let sum = reference::adjoint(&pulses, &places, inverse).unwrap();
            let mut image: Vec<Complex32> = sum
                .iter()
                .map(|v| Complex32::new(v.re as f32, v.im as f32))
                .collect();
            to_reflectivity(&mut image, &pixels, (&position_m, &weight), 60);
            let at = places
                .iter()
                .position(|p| (p[0] - place_m[0]).hypot(p[1] - place_m[1]) < 1e-9)
                .unwrap();
            assert!((image[at].norm() - 3.0).abs() < 0.01, "{}", image[at]);
        }
    }

    #[test]
    fn tiles_share_the_nodes_of_the_image() {
        let position_m = [[0.3, -0.2, 2.0], [1.3, 0.1, 2.1]];
        let weight = [1.0, 2.0];
        let whole = PlaneGrid::new([-3.0, -2.0, 0.0], 0.05, [120, 90]).unwrap();
        let part = PlaneGrid::new([-3.0, whole.y_m(31), 0.0], 0.05, [120, 16]).unwrap();
        let made = |grid: PlaneGrid| {
            let mut image = vec![Complex32::new(1.0, 0.0); grid.len()];
            let pixels = Pixels::plane(grid);
            to_reflectivity(&mut image, &pixels, (&position_m, &weight), 1);
            image
        };
        let (image, tile) = (made(whole), made(part));
        for (k, value) in tile.iter().enumerate() {
            let expected = image[31 * 120 + k];
            assert!((value.re / expected.re - 1.0).abs() < 1e-5);
        }
    }
}
