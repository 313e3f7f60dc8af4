//! The receiver's clock: true GPS time of an epoch of the receiver.

use super::model::ReceiverModel;
use crate::flight::normal;
use acerra_geo::time::GpsTime;
use rand_chacha::ChaCha8Rng;

/// One epoch as the receiver's clock makes it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tick {
    /// Reading of the receiver's clock.
    pub tag: GpsTime,
    /// Reading minus GPS time (s).
    pub offset_s: f64,
    /// Rate of the offset (s/s).
    pub drift: f64,
}

/// The jumps by which the receiver keeps its clock near GPS time (s). 1575.42 MHz makes a whole
/// number of cycles in it.
const JUMP_S: f64 = 1e-3;

/// The epochs of a receiver between `start` and `duration_s` later.
pub(super) fn ticks(
    model: &ReceiverModel,
    start: GpsTime,
    duration_s: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<Tick> {
    // Counted in milliseconds of the week, so that tags stay whole milliseconds for any length.
    let ms = |seconds: f64| (seconds * 1e3).round() as i64;
    let (interval, shift) = (ms(model.interval_s), ms(model.tag_offset_s));
    let first = (ms(start.tow_s()) - shift + interval - 1).div_euclid(interval) * interval + shift;
    let last = ms(start.tow_s() + duration_s);
    let (mut offset_s, mut drift) = (model.clock_offset_s, model.clock_drift);
    let mut out = Vec::new();
    let mut tow = first;
    while tow <= last {
        let seconds = start.week() * acerra_geo::time::SECONDS_PER_WEEK + tow.div_euclid(1000);
        let tag = GpsTime::new(seconds, tow.rem_euclid(1000) as f64 * 1e-3);
        let wrapped = offset_s - (offset_s / JUMP_S).round() * JUMP_S;
        out.push(Tick {
            tag,
            offset_s: wrapped,
            drift,
        });
        offset_s += drift * model.interval_s;
        drift += model.clock_drift_walk * model.interval_s.sqrt() * normal(rng);
        tow += interval;
    }
    out
}
