//! Inputs of a single-point position, and the position.

use crate::measurements::constellation::{Constellation, SatelliteState, Unusable};
use crate::measurements::measurement::Epoch;
use crate::options::PpkOptions;
use crate::orbits::navigation::Klobuchar;
use acerra_geo::time::GpsTime;

/// Inputs of a single-point position.
pub(crate) struct SingleContext<'a> {
    pub constellation: &'a Constellation,
    pub klobuchar: &'a Klobuchar,
    pub options: &'a PpkOptions,
    /// Whether the receiver is the base (for the C/N₀ mask).
    pub base: bool,
}

/// A validated single-point position.
#[derive(Debug, Clone)]
pub(crate) struct SinglePoint {
    pub position_ecef_m: [f64; 3],
    pub covariance_ecef_m2: [[f64; 3]; 3],
    pub satellites: usize,
    /// Velocity (m/s) and its covariance.
    pub velocity: Option<([f64; 3], [[f64; 3]; 3])>,
    /// Tag minus receiver clock.
    pub time: GpsTime,
}

impl SingleContext<'_> {
    /// Satellite states of an epoch, one per measurement.
    pub(crate) fn states(
        &self,
        epoch: &Epoch,
        selection_time: GpsTime,
        with_rates: bool,
    ) -> Vec<Result<SatelliteState, Unusable>> {
        epoch
            .measurements
            .iter()
            .map(|m| {
                let rates = with_rates && m.doppler_hz[0] != 0.0;
                let pseudorange = m.any_pseudorange_m();
                self.constellation
                    .state(m.satellite, selection_time, epoch.tag, pseudorange, rates)
            })
            .collect()
    }
}
