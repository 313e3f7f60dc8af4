//! Any bytes as RINEX observations: an answer or an error, and what is read keeps its promises.
#![no_main]

use acerra_gnss::input::Limits;
use acerra_gnss::{EPOCH_TOLERANCE_S, read_observations};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok((data, _)) = read_observations(bytes, Limits::default()) else { return };
    for pair in data.epochs.windows(2) {
        assert!(pair[1].time - pair[0].time >= EPOCH_TOLERANCE_S);
    }
    for epoch in &data.epochs {
        assert!(epoch.satellites.windows(2).all(|w| w[0].satellite < w[1].satellite));
        for satellite in &epoch.satellites {
            let system = satellite.satellite.system();
            for (slot, signal) in satellite.signals.iter().enumerate() {
                let Some(signal) = signal else { continue };
                assert_eq!(signal.code.slot(system), Some(slot));
                let values = [signal.pseudorange_m, signal.phase_cycles, signal.doppler_hz];
                assert!(values.into_iter().flatten().all(|v| v.is_finite() && v != 0.0));
                assert!(signal.loss_of_lock.0 < 4);
            }
        }
    }
});
