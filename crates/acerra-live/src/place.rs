//! Position of the radar at a time, and its source.

use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::SolutionStatus;

/// Position of the radar at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placed {
    /// The position after that time has not come yet.
    Waiting,
    /// Between two positions.
    At(RadarPlace),
    /// Between two positions, but the heading that orients the horizontal lever arm is not known before the
    /// platform has moved.
    WithoutHeading {
        /// Height of the radar above the origin (m), which needs no heading.
        up_m: f64,
    },
    /// Never to be known.
    Nowhere(Missing),
}

/// Position of the radar's phase centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarPlace {
    /// East, north, up about the origin (m).
    pub position_m: [f64; 3],
    /// Standard deviations (m), where the receiver states them.
    pub sigma_m: Option<[f64; 3]>,
    /// The worse kind of the positions on both sides.
    pub status: SolutionStatus,
}

/// Reason why a place is never to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// Before the first position.
    BeforeFirst,
    /// Positions were missing about it.
    Gap,
}

/// The latest position of the receiver's antenna.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latest {
    /// East, north, up about the origin (m).
    pub position_m: [f64; 3],
    /// Standard deviations (m), where they are stated.
    pub sigma_m: Option<[f64; 3]>,
    /// Kind of the solution.
    pub status: SolutionStatus,
    /// When.
    pub time: GpsTime,
}
