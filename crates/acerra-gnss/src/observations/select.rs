//! Choosing one signal for each frequency slot.

use std::collections::HashMap;

use super::observation::{ObservationEpoch, SatelliteObservation, SignalObservation};
use super::recorded::{RecordedEpoch, RecordedSatellite};
use super::satellite::System;
use super::signal::{FREQUENCY_SLOTS, SignalCode};

/// Rule for choosing the signal of a slot among the tracked signals.
#[derive(Debug, Clone, Default)]
pub enum SignalChoice {
    /// One signal per system and slot for the whole file: the best of the signals in the header, listed here.
    /// A satellite without this signal has an empty slot, so that no satellite ever changes signal. RTKLIB's
    /// rule for RINEX 3.
    PerFile(HashMap<(System, usize), SignalCode>),
    /// For each satellite and epoch the best signal that has a pseudorange. RTKLIB's rule for
    /// RINEX 2 and for raw logs.
    #[default]
    PerSatellite,
}

impl SignalChoice {
    /// The per-file choice among the signals that a header lists for each system. The first listed of equally
    /// ranked signals wins.
    pub fn per_file(listed: impl IntoIterator<Item = (System, SignalCode)>) -> Self {
        let mut best: HashMap<(System, usize), (usize, SignalCode)> = HashMap::new();
        for (system, code) in listed {
            let (Some(slot), Some(rank)) = (code.slot(system), rank(system, code)) else {
                continue;
            };
            let entry = best.entry((system, slot)).or_insert((rank, code));
            if rank < entry.0 {
                *entry = (rank, code);
            }
        }
        Self::PerFile(
            best.into_iter()
                .map(|(key, (_, code))| (key, code))
                .collect(),
        )
    }
}

/// Place of a signal in the order of preference of its slot, 0 best; `None` for signals that are
/// never chosen.
///
/// Slot 0 and 1 as RTKLIB 2.4.3 orders them. In slot 2, BeiDou's B3 goes before B2a.
pub fn rank(system: System, code: SignalCode) -> Option<usize> {
    let order = match (system, code.slot(system)?) {
        (System::Gps, 0) => "CPYWMNSL",
        (System::Gps, 1) => "PYWCMNDLSX",
        (System::Glonass, 0) => "CPABX",
        (System::Glonass, 1) => "PCABX",
        (System::Galileo, 0) => "CABXZ",
        // 1E (C/B code) takes the place of 1C on QZSS satellites of the second generation.
        (System::Qzss, 0) => "CELSXZ",
        (System::Qzss, 1) => "LSX",
        (System::Sbas, 0) => "C",
        (System::Beidou, 0) => "IQXDPAN",
        (System::Beidou, 1) => "IQXDPZ",
        (System::Beidou, _) if code.band == 6 => "IQXA",
        (System::Beidou, _) => "????DPX",
        (System::Navic, _) => "ABCX",
        _ => "IQX",
    };
    order.find(code.attribute)
}

/// The epoch with one signal per slot, satellites ascending; satellites without any chosen signal are left
/// out.
pub fn select_signals(epoch: &RecordedEpoch, choice: &SignalChoice) -> ObservationEpoch {
    let mut satellites: Vec<SatelliteObservation> = epoch
        .satellites
        .iter()
        .map(|recorded| select_for_satellite(recorded, choice))
        .filter(|s| s.signals.iter().any(Option::is_some))
        .collect();
    satellites.sort_by_key(|s| s.satellite);
    satellites.shrink_to_fit();
    ObservationEpoch {
        time: epoch.time,
        satellites,
    }
}

fn select_for_satellite(
    recorded: &RecordedSatellite,
    choice: &SignalChoice,
) -> SatelliteObservation {
    let system = recorded.satellite.system();
    let mut out = SatelliteObservation::new(recorded.satellite);
    for (slot, chosen) in out.signals.iter_mut().enumerate().take(FREQUENCY_SLOTS) {
        let mut candidates = recorded
            .signals
            .iter()
            .filter(|s| s.code.slot(system) == Some(slot));
        *chosen = match choice {
            SignalChoice::PerFile(best) => best
                .get(&(system, slot))
                .and_then(|code| candidates.find(|s| s.code == *code))
                .copied(),
            SignalChoice::PerSatellite => candidates
                .filter_map(|s| Some((preference(s, rank(system, s.code)?), s)))
                .min_by_key(|(preference, _)| *preference)
                .map(|(_, s)| *s),
        };
    }
    out
}

/// Signals with a pseudorange precede signals without; then the rank decides.
fn preference(signal: &SignalObservation, rank: usize) -> (bool, usize) {
    (signal.pseudorange_m.is_none(), rank)
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::time::GpsTime;

    fn signal(band: u8, attribute: char, pseudorange_m: Option<f64>) -> SignalObservation {
        SignalObservation {
            pseudorange_m,
            phase_cycles: Some(1.0),
            ..SignalObservation::empty(SignalCode::new(band, attribute))
        }
    }

    fn epoch(satellite: &str, signals: Vec<SignalObservation>) -> RecordedEpoch {
        RecordedEpoch {
            time: GpsTime::EPOCH,
            receiver_clock_s: None,
            satellites: vec![RecordedSatellite {
                satellite: satellite.parse().unwrap(),
                signals,
            }],
        }
    }

    fn chosen(epoch: &RecordedEpoch, choice: &SignalChoice, slot: usize) -> Option<String> {
        let selected = select_signals(epoch, choice);
        selected.satellites.first()?.signals[slot].map(|s| s.code.to_string())
    }

    #[test]
    fn per_file_never_falls_back() {
        let choice = SignalChoice::per_file([
            (System::Gps, SignalCode::new(1, 'W')),
            (System::Gps, SignalCode::new(1, 'C')),
            (System::Gps, SignalCode::new(2, 'X')),
            (System::Gps, SignalCode::new(2, 'W')),
            (System::Beidou, SignalCode::new(1, 'X')),
            (System::Beidou, SignalCode::new(2, 'I')),
        ]);
        let both = epoch(
            "G05",
            vec![signal(1, 'W', Some(2.0)), signal(1, 'C', Some(1.0))],
        );
        assert_eq!(chosen(&both, &choice, 0).as_deref(), Some("1C"));
        let other = epoch(
            "G05",
            vec![signal(1, 'W', Some(2.0)), signal(2, 'W', Some(2.0))],
        );
        assert_eq!(chosen(&other, &choice, 0), None);
        assert_eq!(chosen(&other, &choice, 1).as_deref(), Some("2W"));
        let beidou = epoch(
            "C08",
            vec![signal(1, 'X', Some(2.0)), signal(2, 'I', Some(2.0))],
        );
        assert_eq!(chosen(&beidou, &choice, 0).as_deref(), Some("2I"));
        let alone = epoch("E01", vec![signal(1, 'C', Some(2.0))]);
        assert!(select_signals(&alone, &choice).satellites.is_empty());
    }

    #[test]
    fn per_satellite_takes_what_is_there() {
        let both = epoch(
            "G05",
            vec![signal(1, 'W', Some(2.0)), signal(1, 'C', Some(1.0))],
        );
        let choice = SignalChoice::PerSatellite;
        assert_eq!(chosen(&both, &choice, 0).as_deref(), Some("1C"));
        let p1 = epoch("G05", vec![signal(1, 'C', None), signal(1, 'W', Some(2.0))]);
        assert_eq!(chosen(&p1, &choice, 0).as_deref(), Some("1W"));
        let l2 = epoch(
            "G05",
            vec![signal(2, 'X', Some(1.0)), signal(2, 'W', Some(2.0))],
        );
        assert_eq!(chosen(&l2, &choice, 1).as_deref(), Some("2W"));
    }
}
