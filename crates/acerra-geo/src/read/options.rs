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
    /// What the heights of a table are above, where its header does not say.
    pub heights: Option<HeightDatum>,
    /// Raises heights above the sea to the ellipsoid; without it they are taken as above the ellipsoid, and a warning
    /// says so.
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
    /// The same with an origin of the local frame.
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

    /// The same with the rigid body of that name.
    #[must_use]
    pub fn with_rigid_body(mut self, name: impl Into<String>) -> Self {
        self.rigid_body = Some(name.into());
        self
    }
}
