//! The files of a positioning run.

use std::path::PathBuf;

use acerra_geo::time::GpsTime;

use super::antennas::AntennaInput;

/// The files of a positioning run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PositioningInput {
    /// The rover's log.
    pub rover: PathBuf,
    /// More files of the rover's receiver, joined to its log.
    pub more_rover: Vec<PathBuf>,
    /// The base's log; not needed in single-point mode.
    pub base: Option<PathBuf>,
    /// Further files of the base's receiver, for example of later hours.
    pub more_base: Vec<PathBuf>,
    /// Navigation files: broadcast ephemerides, SP3 orbits, RINEX clocks. Raw logs of rover and base contain
    /// ephemerides too.
    pub navigation: Vec<PathBuf>,
    /// Any time within half a week of logs that do not give their week (RTCM 3).
    pub date: Option<GpsTime>,
    /// Whether precise orbits must be among the navigation files.
    pub needs_precise_orbits: bool,
    /// Antenna calibrations, and the antennas that use them.
    pub antennas: AntennaInput,
}

impl PositioningInput {
    /// The rover's files.
    pub(super) fn rover_files(&self) -> Vec<PathBuf> {
        let first = std::iter::once(&self.rover);
        first.chain(&self.more_rover).cloned().collect()
    }

    /// The base's files.
    pub(super) fn base_files(&self) -> Vec<PathBuf> {
        let first = self.base.iter();
        first.chain(&self.more_base).cloned().collect()
    }
}
