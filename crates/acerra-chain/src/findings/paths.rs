//! Two-way paths of echoes from a point, refracted where it lies below ground.

use std::ops::Range;

use acerra_imaging::refraction::Ground;

use crate::echoes::history::distance_m;
use crate::focus::Focused;
use crate::prepare::Prepared;

/// Paths from the antennas of an image's traces.
pub(super) struct Paths<'a> {
    prepared: &'a Prepared,
    ground: Option<Ground>,
}

impl<'a> Paths<'a> {
    /// As the image was focused.
    pub(super) fn of(prepared: &'a Prepared, focused: &Focused) -> Self {
        let frequency_hz = &prepared.spectrum.frequency_hz;
        let ground = (focused.underground.as_ref())
            .and_then(|underground| underground.seen_at(frequency_hz).ok());
        Self { prepared, ground }
    }

    /// From transmitter to the point to receiver, in air that is as long, for each of some traces (m).
    pub(super) fn to_m(&self, point_m: [f64; 3], traces: Range<usize>) -> Vec<f64> {
        let one_way_m = |antenna_m: [f64; 3]| match &self.ground {
            Some(ground) => ground.ray(antenna_m, point_m).optical_m,
            None => distance_m(antenna_m, point_m),
        };
        let antennas = traces.map(|k| self.prepared.aligned.antennas_at_m(k));
        let path_m = |[transmitter_m, receiver_m]: [[f64; 3]; 2]| {
            one_way_m(transmitter_m) + one_way_m(receiver_m)
        };
        antennas.map(path_m).collect()
    }
}
