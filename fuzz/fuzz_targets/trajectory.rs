//! Any bytes as a trajectory: an answer or an error, and what is read can be used.
#![no_main]

use acerra_geo::interpolate::{InterpolationOptions, Interpolator};
use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
use acerra_geo::read::{ReadOptions, TrajectoryFormat, read_trajectory, sniff};
use acerra_geo::write::write_trajectory_csv;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = sniff(bytes);
    // Content decides; so that no reader is left out, each also gets bytes not meant for it.
    let forced = [
        None,
        Some(TrajectoryFormat::RtklibPos),
        Some(TrajectoryFormat::Csv),
        Some(TrajectoryFormat::Nmea),
        Some(TrajectoryFormat::Motive),
    ];
    for format in forced {
        let mut options = ReadOptions::default();
        options.format = format;
        let Ok((track, _)) = read_trajectory(bytes, &options) else {
            continue;
        };
        let middle = 0.5 * (track.start_s() + track.end_s());
        let at = Interpolator::new(&track, &InterpolationOptions::default()).at(middle);
        assert!(at.position_m.iter().all(|v| v.is_finite()));
        let _ = apply_lever_arm(&track, [0.1, 0.0, -0.2], &HeadingOptions::default());
        let mut table = Vec::new();
        write_trajectory_csv(&mut table, &track).expect("memory takes all");
        let (back, _) =
            read_trajectory(&table[..], &ReadOptions::default()).expect("our own table");
        assert_eq!(back.fixes().len(), track.fixes().len());
    }
});
