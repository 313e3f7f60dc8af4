//! Phase differences of the last epoch, from which changes are computed.

use acerra_geo::time::GpsTime;

/// The phase difference between rover and base of one satellite and slot at an epoch.
#[derive(Debug, Clone, Copy)]
pub(super) struct PhaseDifference {
    pub satellite: usize,
    pub slot: usize,
    pub difference_m: f64,
    pub unit_ecef: [f64; 3],
    pub slips: [u32; 2],
}

/// The phase differences of an epoch, for a rover at `place_ecef_m`.
#[derive(Debug, Clone, Default)]
pub(super) struct LastPhases {
    pub tag: Option<GpsTime>,
    pub place_ecef_m: [f64; 3],
    /// In ascending order of satellite and slot.
    pub differences: Vec<PhaseDifference>,
}
