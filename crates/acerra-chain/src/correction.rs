//! What an autofocus leaves beside the corrected places.

use acerra_autofocus::{Autofocused, Decision};
use acerra_geo::interpolate::Interpolated;

use crate::quantity::{GlobalCorrection, Quantity};

/// What the autofocus of a survey found.
#[derive(Clone, Debug)]
pub struct PathCorrection {
    /// Corrections with their deviations, and whether they are applied.
    pub found: Autofocused,
    /// Places of the imaged traces as the positions have them (m).
    pub stated_m: Vec<[f64; 3]>,
    /// The places of all traces as the positions have them.
    pub stated: Vec<Interpolated>,
    /// Standard deviations before, one a trace (m).
    pub prior_sigma_m: Vec<[f64; 3]>,
    /// How long errors were taken to last (s).
    pub correlation_s: f64,
    /// Quantities of the whole flight that were left free, applied or not.
    pub globals: Vec<GlobalCorrection>,
    /// Propagation speed as stated (m/s).
    pub stated_light_speed_m_s: f64,
}

impl PathCorrection {
    /// Sum of what was found of a quantity that all tracks share, in its unit.
    #[must_use]
    pub fn total(&self, quantity: Quantity) -> f64 {
        let own = self.globals.iter().filter(|g| g.quantity == quantity);
        own.map(|g| g.value).sum()
    }

    /// Whether the image is made with corrected places.
    #[must_use]
    pub fn is_applied(&self) -> bool {
        self.found.decision == Decision::Applied
    }
}
