//! Options of the trajectory readers.

use std::sync::Arc;

use super::csv_heights::HeightDatum;
use super::format::TrajectoryFormat;
use crate::geodesy::Geodetic;
use crate::geoid::GeoidGrid;

/// How to read a trajectory.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Origin of the local frame. Geodetic and ECEF positions are expressed about it; positions
    /// that are local already are taken to be about it. None: as the [module](super) says.
    pub origin: Option<Geodetic>,
    /// Which rigid body (or marker) of a motion-capture file; none: the only rigid body.
    pub rigid_body: Option<String>,
    /// The format, when it is known; none: recognised from content.
    pub format: Option<TrajectoryFormat>,
    /// Vertical datum of the heights of a table, where its header states none.
    pub heights: Option<HeightDatum>,
    /// Raises heights above the sea to the ellipsoid; without a geoid these heights count as above the
    /// ellipsoid, with a warning.
    pub geoid: Option<Arc<GeoidGrid>>,
    /// Whether a table may give numbers of a radar's traces in place of times, for callers that know the traces.
    pub trace_numbers: bool,
    /// Most positions accepted.
    pub max_fixes: usize,
    /// Longest line accepted (bytes).
    pub max_line_bytes: usize,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            origin: None,
            rigid_body: None,
            format: None,
            heights: None,
            geoid: None,
            trace_numbers: false,
            max_fixes: 10_000_000,
            max_line_bytes: 1 << 20,
        }
    }
}

impl ReadOptions {
    /// These options with an origin of the local frame.
    #[must_use]
    pub fn with_origin(mut self, origin: Geodetic) -> Self {
        self.origin = Some(origin);
        self
    }

    /// A place whose height is above the sea, its height above the ellipsoid; none without a grid there.
    pub(super) fn above_ellipsoid(&self, place: Geodetic) -> Option<Geodetic> {
        let geoid = self.geoid.as_ref()?;
        let raised_m = geoid.height_m(place.latitude_deg(), place.longitude_deg())?;
        Some(Geodetic {
            height_m: place.height_m + raised_m,
            ..place
        })
    }

    /// These options with the rigid body of that name.
    #[must_use]
    pub fn with_rigid_body(mut self, name: impl Into<String>) -> Self {
        self.rigid_body = Some(name.into());
        self
    }

    /// Options with a geoid that is as high everywhere, from 10° south and west to 70° north and 150° east.
    #[cfg(test)]
    #[allow(clippy::expect_used)]
    pub(super) fn over_a_flat_geoid(height_m: f32) -> Self {
        let mut grid = Vec::new();
        for value in [-10.0_f64, -10.0, 20.0, 20.0] {
            grid.extend(value.to_be_bytes());
        }
        grid.extend([5_i32, 9].iter().flat_map(|n| n.to_be_bytes()));
        grid.extend([height_m; 45].iter().flat_map(|v| v.to_be_bytes()));
        let geoid = GeoidGrid::from_reader(&grid[..]).expect("a grid");
        Self {
            geoid: Some(Arc::new(geoid)),
            ..Self::default()
        }
    }
}
