//! Gathering epochs into a log with ascending, distinct tags.

use crate::input::{DropReason, Place, ReadError, ReadReport};
use crate::observations::observation::{
    EPOCH_TOLERANCE_S, EventRecord, ObservationData, ObservationEpoch, SatelliteObservation,
};
use crate::observations::recorded::RecordedEpoch;
use crate::observations::select::{SignalChoice, select_signals};

/// Memory (bytes) that the epochs of any log may take.
const FREE_BYTES: u64 = 64 << 20;
/// Memory of epochs per byte of the log beyond that: the pseudorange alone of one signal in RINEX takes twelve.
const MOST_TIMES: u64 = 12;

/// Collects epochs and events in any order and returns [`ObservationData`] with its guarantees.
#[derive(Debug, Default)]
pub(crate) struct Collector {
    epochs: Vec<(Place, ObservationEpoch)>,
    /// Epochs of other signals than those used, and the place of the first one.
    unused: Option<(Place, u64)>,
    /// Memory of the epochs (bytes).
    bytes: u64,
    events: Vec<EventRecord>,
}

impl Collector {
    /// Takes the signals chosen from an epoch of a log of which `read_bytes` are read.
    ///
    /// # Errors
    /// [`ReadError::Limit`] where the epochs take many times the memory of the log.
    pub(crate) fn epoch(
        &mut self,
        recorded: &RecordedEpoch,
        choice: &SignalChoice,
        place: Place,
        read_bytes: u64,
    ) -> Result<(), ReadError> {
        let epoch = select_signals(recorded, choice);
        if epoch.satellites.is_empty() {
            if !recorded.satellites.is_empty() {
                self.unused.get_or_insert((place, 0)).1 += 1;
            }
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
        if let Some((place, count)) = self.unused {
            report.drop_many(DropReason::UnusedSignals, place, count);
        }
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

    use crate::observations::observation::SignalObservation;
    use crate::observations::recorded::RecordedSatellite;
    use crate::observations::satellite::{SatelliteId, System};
    use crate::observations::signal::SignalCode;

    /// An epoch of one satellite, with one signal of a band.
    fn epoch(time_s: f64, band: u8) -> RecordedEpoch {
        let mut signal = SignalObservation::empty(SignalCode::new(band, 'C'));
        signal.pseudorange_m = Some(2.1e7);
        RecordedEpoch {
            time: GpsTime::EPOCH + time_s,
            receiver_clock_s: None,
            satellites: vec![RecordedSatellite {
                satellite: SatelliteId::new(System::Gps, 1).expect("a satellite"),
                signals: vec![signal],
            }],
        }
    }

    /// Epochs of one satellite, as many as a log of so many bytes may have.
    fn most(read_bytes: u64) -> usize {
        let mut collector = Collector::default();
        let recorded = epoch(0.0, 1);
        let choice = SignalChoice::PerSatellite;
        let mut take = || collector.epoch(&recorded, &choice, Place::Byte(0), read_bytes);
        let refused = (0..400_000).find(|_| take().is_err());
        refused.unwrap_or(400_000)
    }

    #[test]
    fn epochs_of_unused_signals_are_counted() {
        let mut collector = Collector::default();
        for (k, band) in [1, 3, 1, 3, 3].into_iter().enumerate() {
            let recorded = epoch(k as f64, band);
            let place = Place::Line(k as u64);
            collector
                .epoch(&recorded, &SignalChoice::PerSatellite, place, 1_000)
                .expect("a short log");
        }
        let (mut data, mut report) = (ObservationData::default(), ReadReport::default());
        collector.finish(&mut data, &mut report);
        assert_eq!(data.epochs.len(), 2);
        assert_eq!(report.count(&DropReason::UnusedSignals), 3);
        assert_eq!(report.dropped[0].first, Place::Line(1));
    }

    #[test]
    fn epochs_are_in_proportion_to_the_log() {
        let bytes_each = size_of::<(Place, ObservationEpoch)>() + size_of::<SatelliteObservation>();
        assert_eq!(most(0), (64 << 20) / bytes_each);
        // UBX takes 56 bytes for an epoch of one satellite.
        assert_eq!(most(400_000 * 56), 400_000);
    }
}
