//! Gathering epochs into a log with ascending, distinct tags.

use crate::input::{DropReason, Place, ReadError, ReadReport};
use crate::observations::observation::{
    EPOCH_TOLERANCE_S, EventRecord, ObservationData, ObservationEpoch, SatelliteObservation,
};

/// Memory (bytes) that the epochs of any log may take.
const FREE_BYTES: u64 = 64 << 20;
/// Memory of epochs per byte of the log beyond that: pseudorange and phase of one signal in RINEX take seven.
const MOST_TIMES: u64 = 8;

/// Collects epochs and events in any order and returns [`ObservationData`] with its guarantees.
#[derive(Debug, Default)]
pub(crate) struct Collector {
    epochs: Vec<(Place, ObservationEpoch)>,
    /// Memory of the epochs (bytes).
    bytes: u64,
    events: Vec<EventRecord>,
}

impl Collector {
    /// Takes an epoch of a log of which `read_bytes` are read.
    ///
    /// # Errors
    /// [`ReadError::Limit`] where the epochs take many times the memory of the log.
    pub(crate) fn epoch(
        &mut self,
        epoch: ObservationEpoch,
        place: Place,
        read_bytes: u64,
    ) -> Result<(), ReadError> {
        if epoch.satellites.is_empty() {
            return Ok(());
        }
        let bytes = size_of::<(Place, ObservationEpoch)>()
            + epoch.satellites.capacity() * size_of::<SatelliteObservation>();
        self.bytes += bytes as u64;
        let limit = FREE_BYTES + MOST_TIMES.saturating_mul(read_bytes);
        if self.bytes > limit {
            return Err(ReadError::Limit {
                what: "memory for the epochs of so short a log",
                limit,
            });
        }
        self.epochs.push((place, epoch));
        Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::time::GpsTime;

    use crate::observations::satellite::{SatelliteId, System};

    /// Epochs of one satellite, as many as a log of so many bytes may have.
    fn most(read_bytes: u64) -> usize {
        let satellite = SatelliteId::new(System::Gps, 1).expect("a satellite");
        let mut collector = Collector::default();
        for k in 0..400_000 {
            let epoch = ObservationEpoch {
                time: GpsTime::EPOCH + f64::from(k),
                satellites: vec![SatelliteObservation::new(satellite)],
            };
            if collector.epoch(epoch, Place::Byte(0), read_bytes).is_err() {
                return collector.epochs.len();
            }
        }
        400_000
    }

    #[test]
    fn epochs_are_in_proportion_to_the_log() {
        let bytes_each = size_of::<(Place, ObservationEpoch)>() + size_of::<SatelliteObservation>();
        assert_eq!(most(0), (64 << 20) / bytes_each);
        // UBX takes 56 bytes for an epoch of one satellite.
        assert_eq!(most(400_000 * 56), 400_000);
    }
}
