//! Gathering epochs into a log with ascending, distinct tags.

use crate::input::{DropReason, Place, ReadReport};
use crate::observations::observation::{
    EPOCH_TOLERANCE_S, EventRecord, ObservationData, ObservationEpoch,
};

/// Collects epochs and events in any order and returns [`ObservationData`] with its guarantees.
#[derive(Debug, Default)]
pub(crate) struct Collector {
    epochs: Vec<(Place, ObservationEpoch)>,
    events: Vec<EventRecord>,
}

impl Collector {
    pub(crate) fn epoch(&mut self, epoch: ObservationEpoch, place: Place) {
        if !epoch.satellites.is_empty() {
            self.epochs.push((place, epoch));
        }
    }

    pub(crate) fn event(&mut self, event: EventRecord) {
        self.events.push(event);
    }

    /// Sorts the epochs, and merges epochs of equal tags; the first of two records of a satellite is kept.
    pub(crate) fn finish(mut self, data: &mut ObservationData, report: &mut ReadReport) {
        for pair in self.epochs.windows(2) {
            if pair[1].1.time < pair[0].1.time {
                report.drop_one(DropReason::EpochOutOfOrder, pair[1].0);
            }
        }
        self.epochs.sort_by_key(|(_, e)| e.time);
        data.epochs.reserve(self.epochs.len());
        for (place, epoch) in self.epochs {
            match data.epochs.last_mut() {
                Some(last) if epoch.time - last.time < EPOCH_TOLERANCE_S => {
                    report.drop_one(DropReason::DuplicateEpoch, place);
                    for satellite in epoch.satellites {
                        if let Err(at) = last
                            .satellites
                            .binary_search_by_key(&satellite.satellite, |s| s.satellite)
                        {
                            last.satellites.insert(at, satellite);
                        }
                    }
                }
                _ => data.epochs.push(epoch),
            }
        }
        self.events.sort_by_key(|e| e.time);
        data.events = self.events;
    }
}
