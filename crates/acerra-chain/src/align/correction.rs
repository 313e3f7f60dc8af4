//! Results of an autofocus in addition to the corrected positions.

use acerra_autofocus::{Autofocused, Decision};
use acerra_geo::interpolate::Interpolated;

use crate::align::quantity::{GlobalCorrection, Quantity};
use crate::align::recording::InstrumentError;

/// Result of the autofocus of a survey.
#[derive(Clone, Debug)]
pub struct PathCorrection {
    /// Corrections with their deviations, and whether the corrections are applied.
    pub found: Autofocused,
    /// Stated positions of the imaged traces, before the correction (m).
    pub stated_m: Vec<[f64; 3]>,
    /// Stated positions of all traces, before the correction.
    pub stated: Vec<Interpolated>,
    /// Stated standard deviations of the positions, one a trace (m); empty where none are stated.
    pub prior_sigma_m: Vec<[f64; 3]>,
    /// Correlation time assumed for the errors (s).
    pub correlation_s: f64,
    /// Estimated quantities of the whole flight, applied or not.
    pub globals: Vec<GlobalCorrection>,
    /// Propagation speed as stated (m/s).
    pub stated_light_speed_m_s: f64,
}

impl PathCorrection {
    /// Estimate of a quantity that all tracks share, in its unit; 0 where the quantity was held.
    #[must_use]
    pub fn of_all(&self, quantity: Quantity) -> f64 {
        self.found_of(quantity, |track| track.is_none())
    }

    /// Estimate of a quantity of this track, in its unit; 0 where the quantity was held.
    #[must_use]
    pub fn of_track(&self, quantity: Quantity, track: usize) -> f64 {
        self.found_of(quantity, |own| own.unwrap_or(0) == track)
    }

    fn found_of(&self, quantity: Quantity, is_wanted: impl Fn(Option<usize>) -> bool) -> f64 {
        let mut found = self.globals.iter();
        let found = found.find(|g| g.quantity == quantity && is_wanted(g.track));
        found.map_or(0.0, |g| g.value)
    }

    /// Change of the delay of range zero by the height corrections of a track (ns).
    #[must_use]
    pub fn moved_zero_ns(&self, track: usize) -> f64 {
        let moves = |g: &&GlobalCorrection| g.moves_zero && g.track.unwrap_or(track) == track;
        let rise_m: f64 = self.globals.iter().filter(moves).map(|g| g.value).sum();
        -rise_m * Quantity::Delay.per_estimated(self.stated_light_speed_m_s)
    }

    /// Delay and phase found for a track's instrument.
    #[must_use]
    pub fn instrument(&self, track: usize) -> InstrumentError {
        let own_ns = self.of_track(Quantity::TrackDelay, track);
        InstrumentError {
            delay_ns: self.of_all(Quantity::Delay) + own_ns,
            phase_deg: self.of_track(Quantity::TrackPhase, track),
        }
    }

    /// Whether the image is made with corrected positions.
    #[must_use]
    pub fn is_applied(&self) -> bool {
        self.found.decision == Decision::Applied
    }
}
