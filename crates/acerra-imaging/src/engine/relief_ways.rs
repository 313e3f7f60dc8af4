//! Ways of echoes from a run of pulses to the points of a tile of pixels below uneven ground.
//!
//! The search for the earliest ray of all is run on a lattice of columns, rows and pulses. The crossing of the surface
//! moves little from a point or pulse to the next, so that a crossing between two others follows from them by a step of
//! Newton's method ([`Search::between`]). Where neighbours cross at different minima of the optical length, all of these
//! are tried, so that lengths need not be smooth.

use super::weights::WeightedPulses;
use crate::refraction::Ground;
use crate::refraction::relief::Search;
use crate::vector::range_m;
use std::ops::Range;

/// Rows of a tile, at most.
pub(crate) const TILE_ROWS: usize = 16;
/// Pulses of a run, at most.
pub(crate) const RUN: usize = 64;
/// Columns and rows from a crossing that is searched for to the next.
const LATTICE: usize = 8;
/// Motion of an antenna between pulses whose crossings are found without those of other pulses, as a share of the
/// antenna's height above the ground.
const MOTION_SHARE: f64 = 0.25;

/// Points of a few rows, seen by pulses.
pub(crate) struct ReliefTile<'t> {
    echoes: &'t WeightedPulses<'t>,
    ground: &'t Ground,
    /// Row by row.
    points_m: Vec<[f64; 3]>,
    is_below: Vec<bool>,
    columns: usize,
    /// Gain, m, of a step that need not be followed by another; `None` where every crossing is searched for.
    tolerance_m: Option<f64>,
}

/// Crossings of the rays from transmitter and receiver to all points; one list where one antenna sends and receives.
type Crossings = Vec<Vec<[f64; 2]>>;

impl<'t> ReliefTile<'t> {
    /// Rows of equal length; lengths of ways deviate by much less than `tolerance_m`, without which every crossing is
    /// searched for. `None` unless the ground is uneven.
    pub fn new(
        echoes: &'t WeightedPulses<'t>,
        rows_m: &[&[[f64; 3]]],
        tolerance_m: Option<f64>,
    ) -> Option<Self> {
        let ground = echoes.pulses.ground()?;
        let points_m = rows_m.concat();
        ground.level_m().is_none().then(|| Self {
            echoes,
            ground,
            is_below: (points_m.iter())
                .map(|point_m| ground.depth_m(*point_m) > 0.0)
                .collect(),
            points_m,
            columns: rows_m.first().map_or(0, |row_m| row_m.len()),
            tolerance_m,
        })
    }

    /// Gives, for every pulse of a run, half the optical lengths (m) of the ways to all points, row by row, and their
    /// weights without those of the pulses.
    pub fn ways(&self, pulses: Range<usize>, mut give: impl FnMut(usize, &[f64], &[f64])) {
        let mut ways = [(); 2].map(|()| vec![0.0; self.points_m.len()]);
        let mut give_at = |pulse: usize, crossings: &Crossings| {
            let [half_m, weight] = &mut ways;
            for (k, (half_m, weight)) in half_m.iter_mut().zip(weight).enumerate() {
                [*half_m, *weight] = self.half_way(pulse, k, crossings);
            }
            give(pulse, &ways[0], &ways[1]);
        };
        let mut from = pulses.start;
        let mut first = self.searched(from);
        give_at(from, &first);
        while from + 1 < pulses.end {
            let to = self.next(from, pulses.end - 1);
            let last = self.searched(to);
            for pulse in from + 1..to {
                let share = (pulse - from) as f64 / (to - from) as f64;
                let between = |antenna: usize| {
                    let ends = [&first, &last].map(|crossings| &crossings[antenna]);
                    self.between(pulse, antenna, ends, share)
                };
                give_at(pulse, &(0..first.len()).map(between).collect());
            }
            give_at(to, &last);
            (from, first) = (to, last);
        }
    }

    /// The last pulse up to `end` before which no antenna has moved farther than [`MOTION_SHARE`], or the next one.
    fn next(&self, from: usize, end: usize) -> usize {
        let pulses = &self.echoes.pulses;
        let start_m = pulses.antennas_m(from);
        let is_near = |pulse: &usize| {
            (pulses.antennas_m(*pulse).iter().zip(start_m)).all(|(antenna_m, start_m)| {
                let height_m = -self.ground.depth_m(start_m);
                range_m(*antenna_m, start_m) <= MOTION_SHARE * height_m
            })
        };
        (from + 1..=end)
            .take_while(is_near)
            .last()
            .unwrap_or(from + 1)
    }

    /// Crossings at a pulse, without those at others.
    fn searched(&self, pulse: usize) -> Crossings {
        let antennas_m = self.echoes.pulses.antennas_m(pulse);
        let antennas = 1 + usize::from(self.echoes.pulses.is_bistatic());
        let of_antenna = |antenna_m: &[f64; 3]| self.lattice(*antenna_m);
        antennas_m[..antennas].iter().map(of_antenna).collect()
    }

    /// Crossings of the rays from an antenna: searched for at the nodes of a lattice, then along its rows, then between
    /// them.
    fn lattice(&self, antenna_m: [f64; 3]) -> Vec<[f64; 2]> {
        let (columns, rows) = (self.columns, self.points_m.len() / self.columns);
        let mut crossings = vec![[0.0; 2]; self.points_m.len()];
        let between = |crossings: &mut [[f64; 2]], at: usize, ends: [usize; 2], share: f64| {
            let ends = ends.map(|k| crossings[k]);
            crossings[at] = match self.search(antenna_m, at) {
                Some(search) => self.crossing(&search, ends, share),
                None => self.above(at),
            };
        };
        for row in nodes(rows) {
            for column in nodes(columns) {
                let at = row * columns + column;
                crossings[at] = match self.search(antenna_m, at) {
                    Some(search) => search.earliest(),
                    None => self.above(at),
                };
            }
            for (column, ends, share) in between_nodes(columns) {
                let ends = ends.map(|end| row * columns + end);
                between(&mut crossings, row * columns + column, ends, share);
            }
        }
        for (row, ends, share) in between_nodes(rows) {
            for column in 0..columns {
                let ends = ends.map(|end| end * columns + column);
                between(&mut crossings, row * columns + column, ends, share);
            }
        }
        crossings
    }

    /// Crossings at a pulse between two others.
    fn between(
        &self,
        pulse: usize,
        antenna: usize,
        [from, to]: [&Vec<[f64; 2]>; 2],
        share: f64,
    ) -> Vec<[f64; 2]> {
        let antenna_m = self.echoes.pulses.antennas_m(pulse)[antenna];
        (from.iter().zip(to).enumerate())
            .map(|(at, (from, to))| match self.search(antenna_m, at) {
                Some(search) => self.crossing(&search, [*from, *to], share),
                None => self.above(at),
            })
            .collect()
    }

    /// The crossing between two others, or of the earliest ray where every crossing is searched for.
    fn crossing(&self, search: &Search, ends: [[f64; 2]; 2], share: f64) -> [f64; 2] {
        match self.tolerance_m {
            Some(tolerance_m) => search.between(ends, share, tolerance_m),
            None => search.earliest(),
        }
    }

    /// The search for a crossing; `None` for a point above the ground.
    fn search(&self, antenna_m: [f64; 3], at: usize) -> Option<Search<'_>> {
        if self.is_below[at] {
            self.ground.crossings(antenna_m, self.points_m[at])
        } else {
            None
        }
    }

    /// The place of a point.
    fn above(&self, at: usize) -> [f64; 2] {
        let [x, y, _] = self.points_m[at];
        [x, y]
    }

    /// Half the optical length and the weight of a way.
    fn half_way(&self, pulse: usize, at: usize, crossings: &Crossings) -> [f64; 2] {
        let antennas_m = self.echoes.pulses.antennas_m(pulse);
        let ray = |antenna: usize| match self.search(antennas_m[antenna], at) {
            Some(search) => search.ray(crossings[antenna][at]),
            None => self.ground.ray(antennas_m[antenna], self.points_m[at]),
        };
        let first = ray(0);
        let second = if crossings.len() > 1 { ray(1) } else { first };
        self.echoes.along_rays(pulse, &[first, second])
    }
}

/// The nodes of a lattice over `count` places: every [`LATTICE`]th and the last.
fn nodes(count: usize) -> impl Iterator<Item = usize> {
    (0..count).filter(move |k| k.is_multiple_of(LATTICE) || k + 1 == count)
}

/// The places between nodes, with the nodes about them and the share of the way from the first to the second.
fn between_nodes(count: usize) -> impl Iterator<Item = (usize, [usize; 2], f64)> {
    let is_between = move |k: &usize| !k.is_multiple_of(LATTICE) && k + 1 != count;
    (0..count).filter(is_between).map(move |k| {
        let from = k / LATTICE * LATTICE;
        let to = (from + LATTICE).min(count - 1);
        (k, [from, to], (k - from) as f64 / (to - from) as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::weights::Weights;
    use crate::pulses::{PulseArrays, Pulses, Spreading};
    use crate::refraction::{Layer, Relief, Soil, Surface};
    use num_complex::Complex64;

    /// Ways below waves of the ground with slopes of 30°, seen from antennas apart in a motion that is no straight line,
    /// equal those of rays that are searched for one by one; so do weights, except where two crossings are equally early.
    #[test]
    fn ways_equal_those_of_rays_searched_one_by_one() {
        let turns = std::f64::consts::TAU;
        let height_m = |k: usize| {
            let (x, y) = (0.05 * (k % 121) as f64, 0.05 * (k / 121) as f64);
            0.1 * (turns * x).sin() * (turns * y + 1.0).cos()
        };
        let heights_m = (0..121 * 121).map(height_m).collect();
        let surface = Surface::Relief(Relief::new([-3.0; 2], 0.05, 121, heights_m).unwrap());
        let soil = Soil {
            relative_permittivity: 6.0,
            conductivity_s_m: 0.01,
        };
        let ground = Ground::new(surface, &[Layer::below_all(soil)], 1.5e9).unwrap();
        let place_m = |m: usize| [0.02 * m as f64, 0.01 * (m as f64).sin(), 1.0];
        let position_m: Vec<[f64; 3]> = (0..40).map(place_m).collect();
        let moved = |by_m: f64| -> Vec<[f64; 3]> {
            let of_position = |[x, y, z]: &[f64; 3]| [x + by_m, *y, *z];
            position_m.iter().map(of_position).collect()
        };
        let (sent_m, received_m) = (moved(-0.1), moved(0.1));
        let pulses = Pulses::new(PulseArrays {
            position_m: &position_m,
            frequency_hz: &[1e9, 2e9],
            spectrum: &[Complex64::ONE; 80],
            weight: &[0.5; 40],
            light_speed_m_s: 3e8,
        })
        .unwrap()
        .with_antennas(&sent_m, &received_m)
        .unwrap()
        .with_ground(&ground)
        .unwrap();
        let weights = Weights::spreading_alone(Spreading::InverseSquare);
        let echoes = WeightedPulses::new(pulses, weights);
        // The surface is at −0.1 to 0.1 m: some of the upper points are in air.
        for z_m in [-0.3, 0.0] {
            let row_m = |j: usize| -> Vec<[f64; 3]> {
                let point_m = |i: usize| [0.1 + 0.02 * i as f64, -0.3 + 0.02 * j as f64, z_m];
                (0..30).map(point_m).collect()
            };
            let rows_m: Vec<Vec<[f64; 3]>> = (0..15).map(row_m).collect();
            let rows_m: Vec<&[[f64; 3]]> = rows_m.iter().map(Vec::as_slice).collect();
            let points_m = rows_m.concat();
            for tolerance_m in [Some(1e-5), None] {
                let tile = ReliefTile::new(&echoes, &rows_m, tolerance_m).unwrap();
                let (mut pulses, mut other_crossings) = (Vec::new(), 0);
                tile.ways(0..40, |pulse, half_m, weight| {
                    pulses.push(pulse);
                    for (k, point_m) in points_m.iter().enumerate() {
                        let [exact_m, exact, _] = echoes.half_way(pulse, *point_m, [0.0; 3]);
                        let off_m = half_m[k] - exact_m;
                        let within_m = tolerance_m.unwrap_or(1e-12);
                        assert!(off_m.abs() < within_m, "{off_m} at {pulse}, {point_m:?}");
                        other_crossings +=
                            usize::from((0.5 * weight[k] / exact - 1.0).abs() > 1e-3);
                    }
                });
                assert_eq!(pulses, (0..40).collect::<Vec<_>>());
                assert!(other_crossings < 18_000 / 200, "{other_crossings}");
            }
        }
    }
}
