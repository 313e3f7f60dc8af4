//! Quantities of each track that an autofocus estimates: delay and phase of the track's instrument, and the
//! common error of its positions.

use std::ops::Range;

use acerra_autofocus::Effect;

use super::options::AutofocusOptions;
use crate::align::quantity::Quantity;
use crate::choices::Sum;
use crate::prepare::{Prepared, Track};

impl Prepared {
    /// Delay and phase of a track's instrument, and the common error of the track's positions.
    pub(super) fn in_common(
        &self,
        number: usize,
        options: &AutofocusOptions,
    ) -> Vec<(Quantity, f64, Effect)> {
        let own = self.tracks[number].range.clone();
        if own.is_empty() {
            return Vec::new();
        }
        let mut free = self.lasting_errors(number, options);
        if self.tracks.len() > 1 {
            let found_ns = || found_delay_sigma_ns(&self.tracks[number]);
            let sigma_ns = options.track_delay_sigma_ns.unwrap_or_else(found_ns);
            free.push((Quantity::TrackDelay, sigma_ns, Effect::Delay(own.clone())));
        }
        // The phases of the points are relative to the first track.
        if number > 0 && options.sum == Sum::Coherent {
            let sigma_deg = options.track_phase_sigma_deg;
            free.push((Quantity::TrackPhase, sigma_deg, Effect::Phase(own)));
        }
        free
    }

    /// Shift of a track and its change along it, on each axis.
    fn lasting_errors(
        &self,
        number: usize,
        options: &AutofocusOptions,
    ) -> Vec<(Quantity, f64, Effect)> {
        let track = &self.tracks[number];
        let own = track.range.clone();
        let lasting = self.lasting(track, options);
        let time_s = &self.aligned.time_s;
        let (traces, middle_s) = (
            time_s.len(),
            0.5 * (time_s[own.start] + time_s[own.end - 1]),
        );
        let axes = [
            [Quantity::TrackEast, Quantity::TrackEastRate],
            [Quantity::TrackNorth, Quantity::TrackNorthRate],
            [Quantity::TrackUp, Quantity::TrackUpRate],
        ];
        let mut free = Vec::new();
        for (axis, [shift, rate]) in axes.into_iter().enumerate() {
            let shifted = match (shift, track.has_zero_by_surface()) {
                (Quantity::TrackUp, true) => Effect::RiseOverSurface(own.clone()),
                _ => moved(traces, own.clone(), axis, |_| 1.0),
            };
            free.push((shift, lasting.shift_sigma_m[axis], shifted));
            let drifting = moved(traces, own.clone(), axis, |m| time_s[m] - middle_s);
            free.push((rate, lasting.rate_sigma_m_s[axis], drifting));
        }
        free
    }

    /// Deviation of the fast time at which range is zero of a single track: as stated, else that of an
    /// estimated delay.
    pub(super) fn delay_sigma_ns(&self, options: &AutofocusOptions) -> f64 {
        let found_ns = || match self.tracks.as_slice() {
            [only] => found_delay_sigma_ns(only),
            _ => 0.0,
        };
        options.delay_sigma_ns.unwrap_or_else(found_ns)
    }
}

/// Deviation of a track's delay, where it was found from the data.
fn found_delay_sigma_ns(track: &Track) -> f64 {
    let found = track.delay.as_ref();
    found.map_or(0.0, |delay| 1e9 * delay.sigma_s)
}

/// A shift of these traces along an axis, with the shift of each trace for one unit.
pub(super) fn moved(
    traces: usize,
    own: Range<usize>,
    axis: usize,
    by: impl Fn(usize) -> f64,
) -> Effect {
    let mut first = vec![[0.0; 3]; traces];
    own.for_each(|m| first[m][axis] = by(m));
    let second = vec![[0.0; 3]; traces];
    Effect::Position { first, second }
}
