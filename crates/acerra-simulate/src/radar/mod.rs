//! The radar: the log of a PulsON P440 on a flight over a scene.

mod model;
mod pulse;
mod receiver;
mod scatter;
#[cfg(test)]
mod tests;

use acerra_radar::{DEFAULT_STEP_BINS, Filtering, Scan, ScanWindow};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::flight::{Flight, normal};
pub use model::{Clutter, CornerReflector, Ground, PointTarget, RadarModel, RadarScene};
pub use pulse::PulseShaper;
pub use receiver::{Receiver, noise_power_dbm};
pub use scatter::{Echo, Scattering, corner_rcs_m2};

/// Flies the radar over the scene from `start_s` to `end_s` of the flight and returns its scans,
/// the first at `start_s`. The same seed gives the same samples.
///
/// # Errors
/// A radar or a scene that cannot be.
pub fn simulate_scans(
    radar: &RadarModel,
    scene: &RadarScene,
    flight: &Flight,
    [start_s, end_s]: [f64; 2],
    seed: u64,
) -> Result<Vec<Scan>, acerra_settings::ValueError> {
    radar.check()?;
    scene.check()?;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a moderate number of scans"
    )]
    let count = ((end_s - start_s).max(0.0) / radar.scan_interval_s + 1e-9) as usize + 1;
    #[expect(clippy::cast_precision_loss, reason = "a count")]
    let time_s = |k: usize| start_s + k as f64 * radar.scan_interval_s;
    let track: Vec<[f64; 2]> = (0..count)
        .map(|k| flight.pose_at(time_s(k)).position_m)
        .map(|[east, north, _]| [east, north])
        .collect();
    let clock_rate = 1.0 + 1e-6 * radar.clock_drift_ppm;
    let scattering = Scattering::new(scene, radar, &track, seed);
    let receiver = Receiver::new(radar);
    let window = window(radar);
    let shaper = || PulseShaper::new(radar, window.step_s());

    let scan = |shaper: &mut PulseShaper, k: usize| {
        // Each scan has a separate stream of random numbers: the number of threads has no effect on the
        // samples.
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(1 + k as u64);
        let pose = flight.pose_at(time_s(k));
        let mut echoes = Vec::new();
        scattering.echoes(&pose, pose.point_m(radar.lever_arm_m), &mut echoes);
        echoes.extend_from_slice(receiver.coupling());
        let jitter_s = radar.timing_jitter_ps * 1e-12 * normal(&mut rng);
        let mut record = Vec::new();
        shaper.shape(&echoes, radar.delay_ns * 1e-9 + jitter_s, &mut record);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "milliseconds since boot, a wrapping count"
        )]
        Scan {
            source_id: 1,
            message_id: k as u16,
            timestamp_ms: (BOOT_MS + (time_s(k) - start_s) * clock_rate * 1e3) as u32,
            host_time_s: None,
            window,
            filtering: Filtering::Raw,
            antenna_id: 1,
            operation_mode: 1,
            samples: receiver.quantise(&record, &mut rng),
        }
    };
    Ok((0..count).into_par_iter().map_init(shaper, scan).collect())
}

/// Packets of a log that are lost: a share of [`RadarModel::lost_packets`], equal for equal seeds.
#[must_use]
pub fn lost_packets(radar: &RadarModel, packets: usize, seed: u64) -> Vec<bool> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::MAX);
    (0..packets)
        .map(|_| rng.random::<f64>() < radar.lost_packets)
        .collect()
}

/// Radio clock at the first scan (ms since boot); not a whole one, so that stamps are uneven.
const BOOT_MS: f64 = 570_444.37;

#[expect(
    clippy::cast_possible_truncation,
    reason = "checked to fit the radio's own fields"
)]
fn window(radar: &RadarModel) -> ScanWindow {
    let start_ps = (radar.window_start_ns * 1e3).round() as i32;
    let mut window = ScanWindow {
        start_ps,
        stop_ps: start_ps,
        step_bins: DEFAULT_STEP_BINS,
        samples: radar.samples,
    };
    #[expect(clippy::cast_precision_loss, reason = "a count")]
    let length_ps = radar.samples as f64 * window.step_s() * 1e12;
    window.stop_ps = start_ps.saturating_add(length_ps.round() as i32);
    window
}
