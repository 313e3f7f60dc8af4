//! Heights of uneven ground along a route.

use std::path::Path;

use acerra_geo::geodesy::EnuFrame;
use acerra_geo::terrain::{Crs, LocalTerrain, TerrainFile, TerrainOptions};
use acerra_geo::trajectory::Frame;

use super::PlanError;

/// Spacing of the places at which the ground along a leg is evaluated (m).
const STEP_M: f64 = 1.0;
/// Least error of the height between waypoints that needs a further waypoint (m).
const LEAST_TOLERANCE_M: f64 = 0.1;

/// The ground under a plan, from a raster of heights.
#[derive(Clone, Debug)]
pub struct Ground {
    terrain: LocalTerrain,
    frame: EnuFrame,
    home_m: f64,
    tolerance_m: f64,
}

impl Ground {
    /// Reads the raster under a rectangle about home, `[west, south, east, north]` in metres.
    ///
    /// `stray_m` is the error of the height that a mission may have between its waypoints.
    ///
    /// # Errors
    /// A file that cannot be read, does not reach over the rectangle, or has no height at home.
    pub fn read(
        file: &Path,
        crs: Option<&str>,
        frame: &EnuFrame,
        [west, south, east, north]: [f64; 4],
        stray_m: f64,
    ) -> Result<Self, PlanError> {
        let failed = |error: acerra_geo::terrain::TerrainError| PlanError::Terrain {
            path: file.to_owned(),
            cause: error.to_string(),
        };
        let mut options = TerrainOptions::default();
        if let Some(crs) = crs {
            options = options.with_crs(Crs::parse(crs).map_err(failed)?);
        }
        let terrain = TerrainFile::open_path(file, &options)
            .and_then(|open| open.in_frame(&Frame::Enu(*frame), [west, east], [south, north]))
            .map_err(failed)?;
        let mut ground = Self {
            terrain,
            frame: *frame,
            home_m: 0.0,
            tolerance_m: stray_m.max(LEAST_TOLERANCE_M),
        };
        ground.home_m = ground.raster_m([0.0; 2]).map_err(failed)?;
        Ok(ground)
    }

    /// Height of the raster at home (m).
    #[must_use]
    pub fn home_m(&self) -> f64 {
        self.home_m
    }

    /// The raster's height at a place east and north of home (m).
    fn raster_m(&self, [e, n]: [f64; 2]) -> Result<f64, acerra_geo::terrain::TerrainError> {
        let z_m = self.terrain.height_m(e, n)?;
        Ok(self.frame.geodetic_from_enu([e, n, z_m]).height_m)
    }

    /// Height of the ground above that at home (m).
    ///
    /// # Errors
    /// A place without a height.
    pub fn height_m(&self, place_m: [f64; 2]) -> Result<f64, PlanError> {
        let raster_m = self.raster_m(place_m).map_err(|error| {
            PlanError::Impossible(format!("[area] terrain: {error}, on the path of a flight"))
        })?;
        Ok(raster_m - self.home_m)
    }

    /// Places between the ends of a leg at which a waypoint is needed, so that the height above the ground
    /// departs from the required one by at most the tolerance between waypoints.
    ///
    /// # Errors
    /// A place without a height.
    pub fn between(&self, from_m: [f64; 2], to_m: [f64; 2]) -> Result<Vec<[f64; 2]>, PlanError> {
        let length_m = (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]);
        let steps = (length_m / STEP_M).ceil().max(1.0) as usize;
        let at = |k: usize| {
            let share = k as f64 / steps as f64;
            [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]))
        };
        let heights = (0..=steps)
            .map(|k| self.height_m(at(k)))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(corners(&heights, self.tolerance_m)
            .into_iter()
            .map(at)
            .collect())
    }
}

/// Indices of the inner points of a profile at even steps that a broken line needs to stay within
/// `tolerance` of it (Douglas and Peucker 1973), in order.
fn corners(heights: &[f64], tolerance: f64) -> Vec<usize> {
    let mut kept = Vec::new();
    let mut open = vec![(0, heights.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let slope = (heights[to] - heights[from]) / (to - from).max(1) as f64;
        let off = |k: usize| (heights[k] - heights[from] - slope * (k - from) as f64).abs();
        let worst = (from + 1..to).max_by(|a, b| off(*a).total_cmp(&off(*b)));
        if let Some(worst) = worst.filter(|k| off(*k) > tolerance) {
            kept.push(worst);
            open.extend([(from, worst), (worst, to)]);
        }
    }
    kept.sort_unstable();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broken_line_stays_within_the_tolerance() {
        let heights: Vec<f64> = (0..200)
            .map(|k| 3.0 * (f64::from(k) / 20.0).sin())
            .collect();
        let kept = corners(&heights, 0.3);
        assert!(kept.len() < 40, "{}", kept.len());
        let all: Vec<usize> = [0].into_iter().chain(kept).chain([199]).collect();
        for ends in all.windows(2) {
            let [from, to] = [ends[0], ends[1]];
            for k in from..=to {
                let share = (k - from) as f64 / (to - from) as f64;
                let line = heights[from] + share * (heights[to] - heights[from]);
                assert!((line - heights[k]).abs() <= 0.3 + 1e-12);
            }
        }
        // A slope needs none.
        assert!(corners(&[0.0, 1.0, 2.0, 3.0], 0.1).is_empty());
        assert!(corners(&[1.0], 0.1).is_empty());
    }
}
