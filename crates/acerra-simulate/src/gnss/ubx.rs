//! Logs as the UBX messages of a u-blox LEA-6T.

use super::lnav::{self, Words};
use super::receiver::{Observed, ObservedEpoch, ReceiverLog};
use acerra_geo::time::GpsTime;
use acerra_gnss::{Ephemeris, KeplerEphemeris, Navigation, SatelliteId};

/// Length of a subframe (s).
const SUBFRAME_S: i64 = 6;

impl ReceiverLog {
    /// The log as UBX: RXM-RAW for every epoch, and RXM-SFRB for every subframe that a tracked
    /// satellite finished sending since the epoch before.
    ///
    /// The ephemeris in the subframes is the one of `navigation` nearest in time. Ionosphere and
    /// UTC come as GPS sends them, once in 12.5 minutes.
    #[must_use]
    pub fn to_ubx(&self, navigation: &Navigation) -> Vec<u8> {
        let mut out = Vec::new();
        let mut last: Option<GpsTime> = None;
        for epoch in &self.epochs {
            message(&mut out, 0x02, 0x10, &raw(epoch));
            if let Some(last) = last {
                // A subframe that ended at `end` has arrived a tenth of a second later.
                let ended = |t: GpsTime| (t - 0.1).seconds().div_euclid(SUBFRAME_S);
                for number in ended(last) + 1..=ended(epoch.tag) {
                    let end = GpsTime::new(number * SUBFRAME_S, 0.0);
                    for (channel, seen) in epoch.observed.iter().enumerate() {
                        if let Some(words) = subframe(navigation, seen.satellite, end) {
                            message(&mut out, 0x02, 0x11, &sfrb(channel, seen.satellite, &words));
                        }
                    }
                }
            }
            last = Some(epoch.tag);
        }
        out
    }
}

/// The subframe that `satellite` finished at `end`.
fn subframe(navigation: &Navigation, satellite: SatelliteId, end: GpsTime) -> Option<Words> {
    let id = ((end.seconds() - 1).div_euclid(SUBFRAME_S).rem_euclid(5) + 1) as u8;
    if id > 3 {
        return Some(lnav::page_subframe(id, end, navigation.klobuchar));
    }
    let distance = |e: &KeplerEphemeris| e.toe.seconds_since(end).abs();
    navigation
        .ephemerides
        .iter()
        .filter_map(|ephemeris| match ephemeris {
            Ephemeris::Kepler(e) if e.satellite == satellite => Some(e),
            _ => None,
        })
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .map(|e| lnav::ephemeris_subframe(e, id, end))
}

/// The payload of RXM-RAW.
fn raw(epoch: &ObservedEpoch) -> Vec<u8> {
    let mut out = Vec::with_capacity(8 + 24 * epoch.observed.len());
    let tow_ms = (epoch.tag.tow_s() * 1e3).round() as i32;
    out.extend(tow_ms.to_le_bytes());
    out.extend((epoch.tag.week() as i16).to_le_bytes());
    out.extend([epoch.observed.len() as u8, 0]);
    for seen in &epoch.observed {
        out.extend(seen.phase_cycles.to_le_bytes());
        out.extend(seen.pseudorange_m.to_le_bytes());
        out.extend((seen.doppler_hz as f32).to_le_bytes());
        out.extend([
            seen.satellite.number(),
            quality(seen),
            seen.cn0_db_hz,
            seen.loss_of_lock.0,
        ]);
    }
    out
}

/// The receiver's own measure of quality: 7 with the half cycle resolved, else 6.
fn quality(seen: &Observed) -> u8 {
    if seen.loss_of_lock.half_cycle_unknown() {
        6
    } else {
        7
    }
}

/// The payload of RXM-SFRB.
fn sfrb(channel: usize, satellite: SatelliteId, words: &Words) -> Vec<u8> {
    let mut out = vec![channel as u8, satellite.number()];
    for word in words {
        out.extend(word.to_le_bytes());
    }
    out
}

/// Frames a message: synchronisation, class, identifier, length, payload, checksum.
fn message(out: &mut Vec<u8>, class: u8, id: u8, payload: &[u8]) {
    let [low, high] = (payload.len() as u16).to_le_bytes();
    let start = out.len() + 2;
    out.extend([0xB5, 0x62, class, id, low, high]);
    out.extend(payload);
    let check = acerra_gnss::ubx::frame::checksum(&out[start..]);
    out.extend(check);
}
