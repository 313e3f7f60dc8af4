//! The campaign that a corrected survey was made with.

use super::Campaign;
use super::sections::{RadarSection, TrajectorySection};
use crate::align::correction::PathCorrection;
use crate::align::quantity::Quantity;
use crate::choices::{Delay, TimeOffset};
use crate::prepare::Prepared;

impl Campaign {
    /// The campaign with the autofocus' estimates of instruments, clocks and propagation speed, where these
    /// are applied, and with the prior deviations used.
    ///
    /// Places, lever arms and heights are in the corrected trajectory.
    #[must_use]
    pub fn with_corrected(mut self, prepared: &Prepared) -> Self {
        let Some(correction) = &prepared.correction else {
            return self;
        };
        let prior = |quantity| prior_sigma(correction, quantity);
        let section = &mut self.autofocus;
        section.delay_sigma_ns = section.delay_sigma_ns.or(prior(Quantity::Delay));
        section.track_delay_sigma_ns = section.track_delay_sigma_ns.or(prior(Quantity::TrackDelay));
        section.clock_offset_sigma_s = section
            .clock_offset_sigma_s
            .or(prior(Quantity::ClockOffset));
        if !correction.is_applied() {
            return self;
        }
        self.image.light_speed_m_s = prepared.scene.light_speed_m_s;
        if let [only] = prepared.tracks.as_slice() {
            self.radar.correct(correction);
            self.trajectory.correct(only.time_offset_s, correction, 0);
        }
        let sections = self.track.iter_mut().zip(&prepared.tracks);
        for (number, (section, track)) in sections.enumerate() {
            let instrument = correction.instrument(number);
            section.delay_ns += instrument.delay_ns;
            section.phase_deg += instrument.phase_deg;
            let trajectory = &mut section.trajectory;
            trajectory.correct(track.time_offset_s, correction, number);
        }
        self
    }
}

/// Greatest prior deviation of a quantity; none where the quantity was held.
fn prior_sigma(correction: &PathCorrection, quantity: Quantity) -> Option<f64> {
    let own = correction.globals.iter().filter(|g| g.quantity == quantity);
    own.map(|g| g.prior_sigma).reduce(f64::max)
}

impl RadarSection {
    /// Adds the estimated delay to a stated one. Without a stated delay, the surface echo determines the
    /// delay again.
    fn correct(&mut self, correction: &PathCorrection) {
        if let Some(Delay::Nanoseconds(delay_ns)) = &mut self.delay_ns {
            *delay_ns += correction.of_all(Quantity::Delay);
        }
    }
}

impl TrajectorySection {
    /// States the clock offset in force, with the estimated correction.
    fn correct(&mut self, time_offset_s: f64, correction: &PathCorrection, track: usize) {
        let later_s = correction.of_track(Quantity::ClockOffset, track);
        if later_s != 0.0 {
            self.time_offset_s = Some(TimeOffset::Seconds(time_offset_s + later_s));
        }
    }
}
