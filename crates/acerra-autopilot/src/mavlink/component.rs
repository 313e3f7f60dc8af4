//! Gimbals that are separate components, with separate clocks.
//!
//! Messages of gimbal and autopilot arrive over the same link, stamped by the ground station: these stamps
//! relate the gimbal's clock to the autopilot's. The additional delay of messages from the gimbal, some
//! milliseconds on board, stays in its time.

use std::collections::BTreeMap;

use acerra_geo::time::GpsTime;

use crate::clock::{ClockFit, fit};
use crate::collect::Collector;
use crate::sample::{ClockPair, PairKind, Stamp};

/// Clock readings of a vehicle's parts with the ground station's clock.
#[derive(Debug, Default)]
pub struct ComponentClocks {
    autopilot: Vec<ClockPair>,
    /// One reading for each attitude of a gimbal.
    gimbals: BTreeMap<String, Vec<ClockPair>>,
}

impl ComponentClocks {
    /// Notes that a message of the autopilot's clock reading arrived.
    pub fn autopilot(&mut self, boot_s: f64, arrival: GpsTime) {
        self.autopilot.push(ClockPair {
            boot_s,
            gps: arrival,
        });
    }

    /// Notes the arrival of an attitude of the gimbal `name`, stamped by the gimbal's clock.
    pub fn gimbal(&mut self, name: &str, stamp: Stamp, arrival: GpsTime) {
        if let Stamp::Boot(boot_s) = stamp {
            let pairs = self.gimbals.entry(name.to_owned()).or_default();
            pairs.push(ClockPair {
                boot_s,
                gps: arrival,
            });
        }
    }

    /// Puts the attitudes of all gimbals noted on the autopilot's clock: by a line through their readings, or where
    /// these do not make a clock, by their arrival.
    pub fn settle(self, found: &mut Collector) {
        let Some(autopilot) = line(&self.autopilot) else {
            // Times of a clock without relation to others.
            self.gimbals.keys().for_each(|name| found.drop_gimbal(name));
            return;
        };
        for (name, pairs) in &self.gimbals {
            let own = line(pairs).filter(|_| advances(pairs));
            let at = |pair: &ClockPair| own.map_or(pair.gps, |own| own.gps_at(pair.boot_s));
            let samples = found.gimbal_samples(name);
            for (sample, pair) in samples.iter_mut().zip(pairs) {
                sample.stamp = Stamp::Boot(autopilot.boot_at(at(pair)));
            }
            if own.is_none() {
                found.remarks.push(format!(
                    "{name} gives no time that advances with the ground station's clock: the time of its \
                     attitudes is that of their arrival, late by the link's delay"
                ));
            }
        }
    }
}

/// The line through readings of a clock; none where they do not agree on one.
fn line(pairs: &[ClockPair]) -> Option<ClockFit> {
    fit(pairs, PairKind::Simultaneous).ok().flatten()
}

/// Whether a clock counts at all: some devices leave their time at zero.
fn advances(pairs: &[ClockPair]) -> bool {
    let first = pairs.first().map(|pair| pair.boot_s);
    pairs.iter().any(|pair| Some(pair.boot_s) != first)
}
