//! Any bytes as the log of an autopilot: an answer or an error, and what is read can be used.

use acerra_autopilot::{GimbalChoice, LogOptions, read_log};
use acerra_geo::interpolate::{InterpolationOptions, Interpolator};
use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};

pub fn check(bytes: &[u8]) {
    let mut options = LogOptions::default().taking_first();
    options.max_samples = 100_000;
    let Ok((_, report)) = read_log(bytes, &options) else {
        return;
    };
    let gimbals = report.gimbal_sources.iter().map(|g| g.name.clone());
    let choices: Vec<GimbalChoice> = [GimbalChoice::None, GimbalChoice::Only]
        .into_iter()
        .chain(gimbals.take(2).map(GimbalChoice::Named))
        .collect();
    // The bytes choose one of up to 20 combinations: all of them would read every log as often.
    let sum = bytes.iter().map(|byte| usize::from(*byte)).sum::<usize>();
    let gimbal = &choices[sum % choices.len()];
    if let Some(source) = report.sources.get(sum / choices.len() % report.sources.len().max(1)) {
        let options = options.clone().with_source(source.name.clone());
        check_choice(bytes, &options.with_gimbal(gimbal.clone()));
    }
}

fn check_choice(bytes: &[u8], options: &LogOptions) {
    if let Ok((track, report)) = read_log(bytes, options) {
        let _ = report.warnings.iter().map(ToString::to_string).count();
        assert!(track.fixes().windows(2).all(|w| w[0].time_s < w[1].time_s));
        for fix in track.fixes() {
            assert!(fix.position_m.iter().all(|v| v.is_finite()));
            for attitude in fix.attitude.into_iter().chain(fix.gimbal) {
                let length: f64 = attitude.quaternion().iter().map(|v| v * v).sum();
                assert!((length - 1.0).abs() < 1e-9);
            }
        }
        let middle = 0.5 * (track.start_s() + track.end_s());
        let at = Interpolator::new(&track, &InterpolationOptions::default()).at(middle);
        assert!(at.position_m.iter().all(|v| v.is_finite()));
        let _ = apply_lever_arm(&track, [0.1, 0.0, -0.2], &HeadingOptions::default());
    }
}
