//! Data, pixels and requirements of a plan.

use super::options::PlanOptions;
use crate::engine::direct::{half_ways_m, table_ranges_m, uneven_ranges_m};
use crate::engine::level_ways::LevelWays;
use crate::engine::weights::{WeightedPulses, Weights};
use crate::error::ImagingError;
use crate::grid::image::ImageGrid;
use crate::grid::tilted::TiltedGrid;
use crate::kernel::direct::rays::MOST_RECORDS;
use crate::pulses::{Pulses, Spreading};
use crate::vector::range_m;
use std::ops::Range;

/// Propagation paths between antennas and pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Propagation {
    /// Straight lines both ways.
    Straight,
    /// Refraction into level ground, to level planes: for each pulse and plane the path is a function of the
    /// distance.
    LevelGround,
    /// Refraction through an uneven surface, to a level plane.
    UnevenGround,
    /// A separate ray for every pulse and pixel.
    Any,
}

/// Data, pixels and requirements of a plan.
#[derive(Debug)]
pub(crate) struct Request<'a> {
    pub echoes: WeightedPulses<'a>,
    pub grid: ImageGrid<'a>,
    /// Further planes that the same engine images, the other slices of a volume; empty for a single image.
    pub slices: Vec<TiltedGrid>,
    pub options: PlanOptions,
    /// Share of the accuracy that the first plan aims at.
    pub aim: f64,
    /// Margin by which the tables extend beyond the ranges of the pixels on either side, m.
    pub reach_m: f64,
}

impl<'a> Request<'a> {
    /// Checks data, pixels and requirements.
    ///
    /// # Errors
    /// An accuracy outside (0, 0.1], a level the processor lacks, an antenna exactly on a pixel
    /// (with 1/R²), a weight by incidence that has no meaning here.
    pub fn new(
        pulses: Pulses<'a>,
        grid: ImageGrid<'a>,
        options: &PlanOptions,
    ) -> Result<Self, ImagingError> {
        options.level.checked()?;
        if !(options.accuracy > 0.0 && options.accuracy <= 0.1) {
            return Err(ImagingError::OutOfRange {
                what: "accuracy",
                expected: "above 0 and at most 0.1",
                found: options.accuracy,
            });
        }
        check_apart(&pulses, &grid, options)?;
        // Without an antenna pattern the boresight has no effect.
        let is_patterned = options.incidence.is_some_and(|w| w.cosine_power > 0.0);
        let pulses = match is_patterned {
            true => pulses,
            false => pulses.without_boresight(),
        };
        let weights = Weights::new(&pulses, &grid, options.spreading, options.incidence)?;
        Ok(Self {
            echoes: WeightedPulses::new(pulses, weights),
            grid,
            slices: Vec::new(),
            options: *options,
            aim: 1.0,
            reach_m: 0.0,
        })
    }

    /// This request with further planes, which the engine must be able to image too.
    ///
    /// # Errors
    /// An antenna exactly on a pixel (with 1/R²).
    pub fn with_slices(self, slices: Vec<TiltedGrid>) -> Result<Self, ImagingError> {
        for slice in &slices {
            check_apart(&self.echoes.pulses, &(*slice).into(), &self.options)?;
        }
        Ok(Self { slices, ..self })
    }

    /// Least and greatest range (m) that imaging looks up for each of the pulses `which`, on the grid that
    /// `of` derives from each plane of the request.
    ///
    /// For separate transmitter and receiver, a range is half the two-way path, which is refracted below level ground.
    pub fn ranges_m(
        &self,
        which: Range<usize>,
        of: impl Fn(&TiltedGrid) -> TiltedGrid,
    ) -> Vec<[f64; 2]> {
        let pulses = &self.echoes.pulses;
        let slices = self.slices.iter().map(|slice| (*slice).into());
        let refracted: Vec<_> = (slices.chain([self.grid]))
            .map(|grid: ImageGrid| half_ways_m(pulses, &grid))
            .collect();
        let straight_m = match refracted.iter().all(Option::is_some) {
            true => Vec::new(),
            false => self.straight_ranges_m(which.clone(), of),
        };
        let below = refracted
            .iter()
            .flatten()
            .map(|all_m| &all_m[which.clone()]);
        let mut ranges_m = straight_m;
        for others_m in below {
            if ranges_m.is_empty() {
                ranges_m = others_m.to_vec();
            }
            join(&mut ranges_m, others_m);
        }
        ranges_m
    }

    fn straight_ranges_m(
        &self,
        which: Range<usize>,
        of: impl Fn(&TiltedGrid) -> TiltedGrid,
    ) -> Vec<[f64; 2]> {
        let mut of_antennas = (self.echoes.pulses.antenna_places_m())
            .map(|places_m| self.ranges_from_m(&places_m[which.clone()], &of));
        let mut ranges_m = of_antennas.next().unwrap_or_default();
        for other_m in of_antennas {
            for (range, other) in ranges_m.iter_mut().zip(other_m) {
                *range = [0, 1].map(|bound| 0.5 * (range[bound] + other[bound]));
            }
        }
        ranges_m
    }

    /// Least and greatest range (m) from each of `position_m` to the grids that `of` derives.
    fn ranges_from_m(
        &self,
        position_m: &[[f64; 3]],
        of: impl Fn(&TiltedGrid) -> TiltedGrid,
    ) -> Vec<[f64; 2]> {
        if let Some(span_m) = self.grid.span_m() {
            let grid = of(self.grid.plane());
            if grid == *self.grid.plane() {
                return table_ranges_m(position_m, &self.grid);
            }
            return uneven_ranges_m(position_m, (&grid, span_m), self.grid.terrain());
        }
        let mut ranges_m = table_ranges_m(position_m, &of(self.grid.plane()).into());
        for slice in &self.slices {
            join(
                &mut ranges_m,
                &table_ranges_m(position_m, &of(slice).into()),
            );
        }
        if self.reach_m > 0.0 {
            for range in &mut ranges_m {
                *range = [range[0] - self.reach_m, range[1] + self.reach_m];
            }
        }
        ranges_m
    }

    /// Bounds of half the two-way optical length from each pulse to the pixels, m.
    ///
    /// By Fermat's principle a ray is no longer than the straight line, of which the share d/(h + d) lies in ground
    /// over which an antenna hangs h high and pixels d deep, below all its relief.
    pub fn optical_ranges_m(&self) -> Vec<[f64; 2]> {
        let pulses = &self.echoes.pulses;
        let mut ranges_m = self.straight_ranges_m(0..pulses.len(), |plane| *plane);
        if pulses.is_plain() {
            return ranges_m;
        }
        for (m, range) in ranges_m.iter_mut().enumerate() {
            let position_m = pulses.position_m()[m];
            let antennas_m = pulses.antennas_m(m);
            let apart_m = antennas_m
                .map(|a| range_m(a, position_m))
                .into_iter()
                .fold(0.0, f64::max);
            *range = [(range[0] - apart_m).max(0.0), range[1] + apart_m];
            if let Some(ground) = pulses.ground() {
                let [lowest, highest] = ground.surface().span_m();
                let height_m = antennas_m
                    .iter()
                    .map(|a| a[2] - highest)
                    .fold(f64::MAX, f64::min);
                // The depth of a pixel below the antenna is at most the pixel's range.
                let depth_m = (highest - lowest) + (range[1] - height_m).max(0.0);
                let share = depth_m / (depth_m + height_m.max(0.0)).max(f64::MIN_POSITIVE);
                range[1] *= 1.0 + (ground.largest_index() - 1.0) * share.min(1.0);
            }
        }
        ranges_m
    }

    /// Propagation model of the echoes of the grid and of all slices.
    pub fn propagation(&self) -> Propagation {
        let pulses = &self.echoes.pulses;
        if pulses.is_plain() {
            return Propagation::Straight;
        }
        // The pattern weights both paths.
        if pulses.is_bistatic() && self.options.incidence.is_some() {
            return Propagation::Any;
        }
        let is_above = |grid: &ImageGrid| {
            let Some(ground) = pulses.ground() else {
                return true;
            };
            let [_, highest] = ground.surface().span_m();
            grid.is_level() && grid.plane().origin_m[2] >= highest
        };
        // Optical lengths, which bound these records, are longer than straight distances.
        let most = (self.options.memory_limit_bytes, MOST_RECORDS / 8);
        let has_law = |grid: &ImageGrid| {
            grid.is_level()
                && (!pulses.is_bistatic() || LevelWays::pay(&self.echoes, grid, most))
                && self.echoes.is_even()
                && self.echoes.weights.tilt().is_none()
                && pulses.ground().is_some_and(|g| g.level_m().is_some())
        };
        let slices: Vec<ImageGrid> = self.slices.iter().map(|s| (*s).into()).collect();
        let mut grids = std::iter::once(&self.grid).chain(&slices);
        let is_uneven = pulses.ground().is_some_and(|g| g.level_m().is_none());
        if grids.clone().all(is_above) {
            Propagation::Straight
        } else if is_uneven && grids.clone().all(ImageGrid::is_level) && self.echoes.is_even() {
            Propagation::UnevenGround
        } else if grids.all(|grid| is_above(grid) || has_law(grid)) {
            Propagation::LevelGround
        } else {
            Propagation::Any
        }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.grid.len()
    }

    /// Pixel × pulse contributions.
    pub fn contributions(&self) -> u64 {
        (self.pixels() as u64).saturating_mul(self.echoes.len() as u64)
    }
}

/// Widens ranges so that they include others.
fn join(ranges_m: &mut [[f64; 2]], others_m: &[[f64; 2]]) {
    for (range, other) in ranges_m.iter_mut().zip(others_m) {
        *range = [range[0].min(other[0]), range[1].max(other[1])];
    }
}

/// # Errors
/// An antenna exactly on a pixel, where 1/R² has no value.
fn check_apart(
    pulses: &Pulses,
    grid: &ImageGrid,
    options: &PlanOptions,
) -> Result<(), ImagingError> {
    if options.spreading == Spreading::InverseSquare {
        for places_m in pulses.antenna_places_m() {
            for (pulse, p) in places_m.iter().enumerate() {
                if let Some(point) = grid.pixel_at(*p) {
                    return Err(ImagingError::ZeroRange { pulse, point });
                }
            }
        }
    }
    Ok(())
}
