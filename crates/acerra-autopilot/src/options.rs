//! Options of the readers.

use std::sync::Arc;

use acerra_geo::geodesy::Geodetic;
use acerra_geo::geoid::GeoidGrid;

/// Whether the attitude of a gimbal is requested, and of which one.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum GimbalChoice {
    /// Of none.
    #[default]
    None,
    /// Of the only one in the log.
    Only,
    /// Of the one with that name.
    Named(String),
}

impl GimbalChoice {
    /// The name of the requested gimbal, if named.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Named(name) => Some(name),
            Self::None | Self::Only => None,
        }
    }
}

/// How to read a log.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LogOptions {
    /// Origin of the local frame; none: the first position.
    pub origin: Option<Geodetic>,
    /// Source of the positions: `"gnss"`, `"ekf"`, or one by its name; none: the receiver's, or where
    /// there is no receiver the filter's.
    pub source: Option<String>,
    /// Source of the attitudes by its name; none: the only one.
    pub attitude_source: Option<String>,
    /// Source of each position's attitude in addition to the vehicle's.
    pub gimbal: GimbalChoice,
    /// Of several sources that are as good, the first is taken and the others are named, instead of
    /// refusing to choose.
    pub takes_first: bool,
    /// These options with several unnamed sources of positions allowed: for a log that is read for its
    /// attitudes.
    pub takes_first_positions: bool,
    /// Grid of the geoid, by which heights above the sea become heights above the ellipsoid.
    pub geoid: Option<Arc<GeoidGrid>>,
    /// Most positions, attitudes and clock readings accepted, each.
    pub max_samples: usize,
}

impl Default for LogOptions {
    fn default() -> Self {
        Self {
            origin: None,
            source: None,
            attitude_source: None,
            gimbal: GimbalChoice::None,
            takes_first: false,
            takes_first_positions: false,
            geoid: None,
            max_samples: 10_000_000,
        }
    }
}

impl LogOptions {
    /// These options with an origin of the local frame.
    #[must_use]
    pub const fn with_origin(mut self, origin: Geodetic) -> Self {
        self.origin = Some(origin);
        self
    }

    /// These options with that source of the positions.
    #[must_use]
    pub fn with_source(mut self, name: impl Into<String>) -> Self {
        self.source = Some(name.into());
        self
    }

    /// These options with that source of the attitudes.
    #[must_use]
    pub fn with_attitude_source(mut self, name: impl Into<String>) -> Self {
        self.attitude_source = Some(name.into());
        self
    }

    /// These options with the attitude of a gimbal.
    #[must_use]
    pub fn with_gimbal(mut self, gimbal: GimbalChoice) -> Self {
        self.gimbal = gimbal;
        self
    }

    /// These options with the first of several sources.
    #[must_use]
    pub const fn taking_first(mut self) -> Self {
        self.takes_first = true;
        self
    }

    /// These options for the attitudes alone, whatever the positions.
    #[must_use]
    pub const fn for_attitudes(mut self) -> Self {
        self.takes_first_positions = true;
        self
    }

    /// These options with a grid of the geoid.
    #[must_use]
    pub fn with_geoid(mut self, grid: Arc<GeoidGrid>) -> Self {
        self.geoid = Some(grid);
        self
    }
}
