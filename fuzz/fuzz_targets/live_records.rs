//! Any bytes as what instruments send while a live image forms: nothing panics, every scan is accounted for.
#![no_main]

use std::time::Instant;

use acerra_gnss::ubx::frame::encode;
use acerra_imaging::Control;
use acerra_live::{LiveSettings, Pipeline};
use acerra_record::log::{Record, RecordKind};
use acerra_record::session::Session;
use libfuzzer_sys::fuzz_target;

const SESSION: &str = "[radio]\naddress = \"127.0.0.1:1\"\n[flight]\ndelay_ns = 1.0\n\
    [live]\nmax_pixels = 16\nfirst_traces = 2\nx_m = [0, 1]\ny_m = [0, 1]\n\
    [campaign.image]\nfrequencies = 8\n";

fuzz_target!(|bytes: &[u8]| {
    let session = Session::parse(SESSION).expect("a session");
    let mut pipeline = Pipeline::new(LiveSettings::of(&session).expect("settings"));
    let came = Instant::now();
    let mut at_ns = 0;
    for part in bytes.chunks(101) {
        let [kind, payload @ ..] = part else { continue };
        at_ns += u64::from(*kind) * 1_000_000;
        // Frames around the same bytes, so that the fuzzer need not guess checksums.
        let (kind, payload) = match kind % 6 {
            0 => (RecordKind::Radio, payload.to_vec()),
            1 => (RecordKind::Settings, payload.to_vec()),
            2 => (RecordKind::Gnss, encode(1, 7, payload).unwrap_or_default()),
            3 => (RecordKind::Gnss, encode(1, 0x14, payload).unwrap_or_default()),
            4 => (RecordKind::Gnss, encode(2, 0x15, payload).unwrap_or_default()),
            _ => (RecordKind::Gnss, payload.to_vec()),
        };
        let record = Record {
            kind,
            at_ns,
            payload,
        };
        pipeline.take(&record, came);
        // A step that fails ends the live image and nothing else.
        let Ok(_) = pipeline.step(Control::default()) else {
            return;
        };
        let pulses = pipeline.status().pulses;
        let accounted = pulses.imaged
            + pulses.waiting
            + pulses.without_position
            + pulses.without_heading
            + pulses.too_low
            + pulses.not_cleaned
            + pulses.too_many;
        assert_eq!(pulses.came, accounted);
    }
});
