//! Precise products, and satellite states from them.

use std::collections::BTreeMap;

use acerra_geo::time::GpsTime;

use super::interpolate::{NODES, clock, orbit};
use super::state::{OrbitRates, OrbitState};
use crate::observations::satellite::SatelliteId;
use crate::observations::signal::SPEED_OF_LIGHT_M_S;

/// Step of the forward difference that gives velocities (s).
const VELOCITY_STEP_S: f64 = 1e-3;
/// Longest time between clock values of a clock file that is interpolated over (s).
const MAX_CLOCK_STEP_S: f64 = 301.0;
/// Longest time between clock values of an orbit file that is interpolated over (s).
const MAX_ORBIT_CLOCK_STEP_S: f64 = 901.0;

/// Values of one satellite in ascending order of time, each time once.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series<T>(pub(super) Vec<(GpsTime, T)>);

impl<T> Default for Series<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Series<T> {
    /// Adds a value; the first of two values at one time is kept.
    pub(crate) fn insert(&mut self, time: GpsTime, value: T) {
        let at = self.0.partition_point(|(t, _)| *t < time);
        if self.0.get(at).is_none_or(|(t, _)| *t != time) {
            self.0.insert(at, (time, value));
        }
    }

    fn extend(&mut self, other: Self) {
        for (time, value) in other.0 {
            self.insert(time, value);
        }
    }
}

/// Reason for which precise products give no state of a satellite at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PreciseGap {
    /// The satellite is not in the products at all.
    #[error("the satellite is not in the precise products")]
    Satellite,
    /// Fewer than eleven positions without a gap around the time.
    #[error("fewer than {NODES} precise positions without a gap around the time")]
    Orbit,
    /// No clock values on both sides of the time, near enough.
    #[error("no precise clock values on both sides of the time")]
    Clock,
}

/// Precise orbits (SP3) and clocks (SP3, RINEX clock files) of satellites.
///
/// Positions of the centre of mass, in the products' terrestrial frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PreciseProducts {
    /// Positions (ECEF, m).
    pub(crate) orbits: BTreeMap<SatelliteId, Series<[f64; 3]>>,
    /// Clock offsets of orbit files (s).
    pub(crate) orbit_clocks: BTreeMap<SatelliteId, Series<f64>>,
    /// Clock offsets of clock files (s).
    pub(crate) clocks: BTreeMap<SatelliteId, Series<f64>>,
}

impl PreciseProducts {
    /// Whether the products have no positions.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.orbits.is_empty()
    }

    /// Whether the products have positions and clocks of a satellite, at any time.
    #[must_use]
    pub fn holds(&self, satellite: SatelliteId) -> bool {
        self.orbits.contains_key(&satellite)
            && (self.clocks.contains_key(&satellite) || self.orbit_clocks.contains_key(&satellite))
    }

    /// The satellites with positions.
    pub fn satellites(&self) -> impl Iterator<Item = SatelliteId> + '_ {
        self.orbits.keys().copied()
    }

    /// First and last time of the positions.
    #[must_use]
    pub fn span(&self) -> Option<(GpsTime, GpsTime)> {
        let ends = || self.orbits.values().map(|s| &s.0);
        let first = ends().filter_map(|s| s.first()).map(|(t, _)| *t).min()?;
        let last = ends().filter_map(|s| s.last()).map(|(t, _)| *t).max()?;
        Some((first, last))
    }

    /// Adds the data of another file; of two values at one time the present value is kept.
    pub fn merge(&mut self, other: Self) {
        for (satellite, series) in other.orbits {
            self.orbits.entry(satellite).or_default().extend(series);
        }
        for (satellite, series) in other.orbit_clocks {
            self.orbit_clocks
                .entry(satellite)
                .or_default()
                .extend(series);
        }
        for (satellite, series) in other.clocks {
            self.clocks.entry(satellite).or_default().extend(series);
        }
    }

    /// Position and clock at GPS time `t`: a polynomial of tenth degree through eleven positions, straight
    /// lines between clocks (from a clock file where it contains the satellite), and the periodic
    /// relativistic correction −2 r·v/c² (IS-GPS-200, 20.3.3.3.3.1), which products leave to the user.
    ///
    /// # Errors
    /// [`PreciseGap`] where interpolation is not possible; there is no extrapolation.
    pub fn state_at(&self, satellite: SatelliteId, t: GpsTime) -> Result<OrbitState, PreciseGap> {
        let (position_ecef_m, velocity) = self.motion_at(satellite, t)?;
        let product: f64 = (0..3).map(|k| position_ecef_m[k] * velocity[k]).sum();
        let relativity_s = 2.0 * product / (SPEED_OF_LIGHT_M_S * SPEED_OF_LIGHT_M_S);
        Ok(OrbitState {
            position_ecef_m,
            clock_s: self.clock_at(satellite, t)? - relativity_s,
        })
    }

    /// Velocity and clock drift at `t`, by forward difference over a millisecond.
    ///
    /// # Errors
    /// As [`Self::state_at`].
    pub fn rates_at(&self, satellite: SatelliteId, t: GpsTime) -> Result<OrbitRates, PreciseGap> {
        let (_, velocity_ecef_m_s) = self.motion_at(satellite, t)?;
        let (a, b) = (
            self.clock_at(satellite, t)?,
            self.clock_at(satellite, t + VELOCITY_STEP_S)?,
        );
        Ok(OrbitRates {
            velocity_ecef_m_s,
            clock_rate: (b - a) / VELOCITY_STEP_S,
        })
    }

    /// Clock at `t` without relativity (s): the correction from the satellite's time stamp to GPS time.
    ///
    /// # Errors
    /// [`PreciseGap::Satellite`] and [`PreciseGap::Clock`].
    pub fn clock_at(&self, satellite: SatelliteId, t: GpsTime) -> Result<f64, PreciseGap> {
        let of_clock_file = self.clocks.get(&satellite);
        let of_orbit_file = self.orbit_clocks.get(&satellite);
        match (of_clock_file, of_orbit_file) {
            (Some(series), _) => clock(&series.0, t, MAX_CLOCK_STEP_S),
            (None, Some(series)) => clock(&series.0, t, MAX_ORBIT_CLOCK_STEP_S),
            (None, None) => return Err(PreciseGap::Satellite),
        }
        .ok_or(PreciseGap::Clock)
    }

    /// Position (ECEF, m) and velocity in the rotating frame (m/s).
    fn motion_at(
        &self,
        satellite: SatelliteId,
        t: GpsTime,
    ) -> Result<([f64; 3], [f64; 3]), PreciseGap> {
        let series = self.orbits.get(&satellite).ok_or(PreciseGap::Satellite)?;
        let nodes = super::interpolate::window(&series.0, t).ok_or(PreciseGap::Orbit)?;
        let here = orbit(nodes, t);
        let there = orbit(nodes, t + VELOCITY_STEP_S);
        let velocity = std::array::from_fn(|k| (there[k] - here[k]) / VELOCITY_STEP_S);
        Ok((here, velocity))
    }
}
