//! Ways of echoes from antennas above level ground to a level plane below it.
//!
//! The optical length and the weight of a ray depend on the height of its antenna and on the straight distance to the
//! point alone. Cubics over the distance replace the search for the ray of every point; antennas of equal height share
//! one table, so that a survey at constant height has a single table.

use super::level_law::{EqualHeights, Knots, LawPoint};
use super::ways::{BLOCK, Ways};
use super::weights::{WeightedPulses, Weights};
use crate::grid::image::ImageGrid;
use crate::kernel::level::SimdLevel;
use crate::kernel::level_ways::{AntennaRays, half_ways};
use crate::kernel::profile::DELAYS;
use crate::kernel::tabulated::{Bin, Bins};
use crate::refraction::Ground;
use rayon::prelude::*;

/// Contributions (pixel × pulse) for which an exact ray is traced without tables, about.
const CONTRIBUTIONS_A_RAY: u128 = 4;

/// Rays of antennas of one height, over the straight distance.
#[derive(Debug)]
pub(super) struct RayTable {
    pub first_bin: f64,
    pub bins_per_m: f64,
    /// Half the optical length, m, and the weight of one way.
    pub bins: Vec<Bin>,
}

/// Rays from every antenna to one plane.
#[derive(Debug)]
pub(crate) struct LevelWays {
    level: SimdLevel,
    tables: Vec<RayTable>,
    /// Tables of transmitter and receiver of each pulse.
    of_pulse: Vec<[usize; 2]>,
}

/// The antennas of pulses above a level plane below level ground.
struct Antennas<'a> {
    ground: &'a Ground,
    depth_m: f64,
    /// Transmitter and receiver of each pulse.
    heights: EqualHeights,
}

impl LevelWays {
    /// The rays from the antennas of `echoes` to `grid`, in at most `most_bytes`; `None` where the ground or the grid is
    /// uneven, the grid is not below the surface, weights depend on the direction of rays, or tables of so many heights
    /// take more memory or more rays than the pixels do.
    pub fn new(
        echoes: &WeightedPulses,
        grid: &ImageGrid,
        level: SimdLevel,
        most_bytes: u128,
    ) -> Option<Self> {
        let Antennas {
            ground,
            depth_m,
            heights,
        } = Antennas::of(echoes, grid, most_bytes)?;
        let knots = heights.tabulated(ground, echoes.pulses.light_speed_m_s(), depth_m);
        let pairs = heights.of_antenna.chunks_exact(2);
        Some(Self {
            level,
            tables: (knots.par_iter())
                .map(|knots| RayTable::of(knots, 1, |point| of_way(point, &echoes.weights)))
                .collect(),
            of_pulse: pairs.map(|pair| [pair[0], pair[1]]).collect(),
        })
    }

    /// Whether [`LevelWays::new`] finds tables, none of them of more than `most_rays`.
    pub fn pay(
        echoes: &WeightedPulses,
        grid: &ImageGrid,
        (most_bytes, most_rays): (u128, usize),
    ) -> bool {
        Antennas::of(echoes, grid, most_bytes)
            .is_some_and(|antennas| antennas.heights.longest(antennas.depth_m) <= most_rays)
    }

    /// Bytes of [`LevelWays::new`], 0 where it is `None`.
    pub fn bytes_for(echoes: &WeightedPulses, grid: &ImageGrid, most_bytes: u128) -> u128 {
        Antennas::of(echoes, grid, most_bytes).map_or(0, |antennas| antennas.bytes())
    }

    /// Ways of a pulse to points of the plane, at most [`BLOCK`], evenly along a line.
    pub fn ways(&self, echoes: &WeightedPulses, pulse: usize, points_m: &[[f64; 3]]) -> Ways {
        let mut ways = Ways::default();
        let [transmitter_m, receiver_m] = echoes.pulses.antennas_m(pulse);
        let [sent, received] = self.of_pulse[pulse].map(|k| self.tables[k].bins());
        let antennas = [(transmitter_m, sent), (receiver_m, received)]
            .map(|(antenna_m, bins)| AntennaRays { antenna_m, bins });
        let last = points_m.len().min(BLOCK) - 1;
        let steps = last.max(1) as f64;
        let step_m = std::array::from_fn(|k| (points_m[last][k] - points_m[0][k]) / steps);
        let halves = ways.half_m.chunks_exact_mut(DELAYS);
        let weights = ways.weight.chunks_exact_mut(DELAYS);
        let of_pulse = echoes.pulses.weight()[pulse];
        for ((some_m, half_m), weight) in points_m.chunks(DELAYS).zip(halves).zip(weights) {
            let [found_m, found] = half_ways(self.level, &antennas, [some_m[0], step_m]);
            half_m.copy_from_slice(&found_m);
            weight.copy_from_slice(&found.map(|w| of_pulse * w));
        }
        ways
    }
}

impl<'a> Antennas<'a> {
    fn of(echoes: &'a WeightedPulses, grid: &ImageGrid, most_bytes: u128) -> Option<Self> {
        let pulses = &echoes.pulses;
        let ground = pulses.ground()?;
        let z_m = ground.level_m().filter(|_| grid.is_level())?;
        let depth_m = z_m - grid.plane().origin_m[2];
        if depth_m <= 0.0 || echoes.weights.is_directed() {
            return None;
        }
        let above_m = |antenna_m: [f64; 3]| {
            let [_, farthest_m] = grid.ranges_m(antenna_m, BLOCK as f64);
            [antenna_m[2] - z_m, farthest_m]
        };
        let antennas = Self {
            ground,
            depth_m,
            heights: EqualHeights::of(
                (0..pulses.len()).flat_map(|pulse| pulses.antennas_m(pulse).map(above_m)),
            ),
        };
        let contributions = grid.len() as u128 * pulses.len() as u128;
        let pays = antennas.heights.rays(depth_m) * CONTRIBUTIONS_A_RAY <= contributions;
        (pays && antennas.bytes() <= most_bytes).then_some(antennas)
    }

    fn bytes(&self) -> u128 {
        self.heights.rays(self.depth_m) * size_of::<Bin>() as u128
    }
}

impl RayTable {
    /// Two values of every `step`-th knot.
    pub fn of(knots: &Knots, step: usize, values: impl Fn(&LawPoint) -> [f64; 2]) -> Self {
        let points = knots.points().step_by(step);
        let values: Vec<[f64; 2]> = points.map(|point| values(&point)).collect();
        let [nearest_m, per_m] = knots.scale();
        let per_m = per_m / step as f64;
        let middle = |four: &[[f64; 2]]| cubic([four[0], four[1], four[2], four[3]]);
        let inner = values.windows(4).map(middle);
        // Before the second knot the first cubic goes on.
        let first = values.get(..4).map(|four| before(middle(four)));
        Self {
            first_bin: nearest_m * per_m + 0.5,
            bins_per_m: per_m,
            bins: first.into_iter().chain(inner).collect(),
        }
    }

    fn bins(&self) -> Bins<'_> {
        Bins {
            bins: &self.bins,
            first_bin: self.first_bin,
            bins_per_m: self.bins_per_m,
        }
    }
}

/// Half the optical length, m, and the weight of one way.
fn of_way(point: &LawPoint, weights: &Weights) -> [f64; 2] {
    [0.5 * point.optical_m, weights.of_law(point).sqrt()]
}

/// The cubics through values at −3/2, −1/2, 1/2 and 3/2.
fn cubic([a, b, c, d]: [[f64; 2]; 4]) -> Bin {
    let sum = |weights: [f64; 4], per: f64| {
        std::array::from_fn(|k| {
            (weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k] + weights[3] * d[k]) / per
        })
    };
    [
        sum([-1.0, 9.0, 9.0, -1.0], 16.0),
        sum([1.0, -27.0, 27.0, -1.0], 24.0),
        sum([1.0, -1.0, -1.0, 1.0], 4.0),
        sum([-1.0, 3.0, -3.0, 1.0], 6.0),
    ]
}

/// The polynomials about a centre that lies one bin before.
fn before([c0, c1, c2, c3]: Bin) -> Bin {
    let of = |f: &dyn Fn(usize) -> f64| [f(0), f(1)];
    [
        of(&|k| c0[k] - c1[k] + c2[k] - c3[k]),
        of(&|k| c1[k] - 2.0 * c2[k] + 3.0 * c3[k]),
        of(&|k| c2[k] - 3.0 * c3[k]),
        c3,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::ways::WayTolerance;
    use crate::grid::plane::PlaneGrid;
    use crate::pulses::{PulseArrays, Pulses, Spreading};
    use crate::refraction::{Layer, Soil, Surface};
    use num_complex::Complex64;

    /// Tabulated ways equal exact rays to 10⁻⁶ of the height, for antennas on the ground and in the air, through two
    /// layers with losses, at every instruction set.
    #[test]
    fn tabulated_ways_follow_exact_rays() {
        let soil = |relative_permittivity, conductivity_s_m| Soil {
            relative_permittivity,
            conductivity_s_m,
        };
        let top = Layer {
            soil: soil(4.0, 0.002),
            thickness_m: 0.1,
        };
        let layers = [top, Layer::below_all(soil(9.0, 0.01))];
        let ground = Ground::new(Surface::Level { z_m: 0.2 }, &layers, 1.2e9).unwrap();
        for height_m in [0.01, 0.3, 4.0] {
            let z_m = 0.2 + height_m;
            let apart = |x: f64| [[x, 0.1, z_m], [x + 0.1, -0.1, 1.5 * z_m]];
            let transmitter_m = [apart(-0.3)[0], apart(0.4)[0]];
            let receiver_m = [apart(-0.3)[1], apart(0.4)[1]];
            let position_m = [[-0.25, 0.0, z_m], [0.45, 0.0, z_m]];
            let pulses = Pulses::new(PulseArrays {
                position_m: &position_m,
                frequency_hz: &[1e9, 1.4e9],
                spectrum: &[Complex64::ONE; 4],
                weight: &[1.0, 0.5],
                light_speed_m_s: 3e8,
            })
            .unwrap()
            .with_antennas(&transmitter_m, &receiver_m)
            .unwrap()
            .with_ground(&ground)
            .unwrap();
            for z_m in [0.19, 0.0, -0.6] {
                let plane = PlaneGrid::new([-1.0, -0.5, z_m], 0.01, [210, 160]).unwrap();
                let grid = ImageGrid::from(plane);
                let weights = Weights::new(&pulses, &grid, Spreading::InverseSquare, None).unwrap();
                let echoes = WeightedPulses::new(pulses, weights);
                // Tables that take too much memory, or more rays than the pixels, are not built.
                let level = SimdLevel::detect();
                let few = ImageGrid::from(PlaneGrid::new([-1.0, -0.5, z_m], 0.01, [3, 1]).unwrap());
                assert!(LevelWays::new(&echoes, &grid, level, 500).is_none());
                assert!(LevelWays::new(&echoes, &few, level, u128::MAX).is_none());
                for &level in SimdLevel::available() {
                    let table = LevelWays::new(&echoes, &grid, level, u128::MAX).unwrap();
                    for row in (0..160).step_by(23) {
                        let points_m: Vec<[f64; 3]> =
                            (64..210).map(|column| grid.point_m(column, row)).collect();
                        for (pulse, some_m) in (0..2)
                            .flat_map(|p| points_m.chunks(BLOCK).map(move |some_m| (p, some_m)))
                        {
                            let found = table.ways(&echoes, pulse, some_m);
                            let exact = Ways::along(&echoes, pulse, some_m, WayTolerance::EXACT);
                            for k in 0..some_m.len() {
                                let difference_m = found.half_m[k] - exact.half_m[k];
                                assert!(difference_m.abs() < 1e-6 * height_m, "{difference_m}");
                                let ratio = found.weight[k] / exact.weight[k];
                                assert!((ratio - 1.0).abs() < 1e-4, "{ratio} at {height_m}");
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn cubics_meet_their_values() {
        let value = |x: f64| [1.0 + 2.0 * x - x * x, 0.5 * x * x * x - x];
        let found = cubic([-1.5, -0.5, 0.5, 1.5].map(value));
        let at = |bin: &Bin, x: f64, k: usize| {
            ((bin[3][k] * x + bin[2][k]) * x + bin[1][k]) * x + bin[0][k]
        };
        for k in 0..2 {
            for x in [-1.5, -0.2, 0.5] {
                assert!((at(&found, x, k) - value(x)[k]).abs() < 1e-12);
                assert!((at(&before(found), x, k) - value(x - 1.0)[k]).abs() < 1e-12);
            }
        }
    }
}
