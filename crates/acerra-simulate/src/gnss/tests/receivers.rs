//! Noise, cycles and clocks of the receivers.

use super::*;
use crate::gnss::receiver::WAVELENGTH_M;
use acerra_gnss::LossOfLock;
use std::collections::BTreeMap;

#[test]
fn noise_is_as_large_as_asked_and_grows_towards_the_horizon() {
    let navigation = constellation(start(), 3600.0, 5);
    let mut quiet = GnssModel::default();
    quiet.base = ReceiverModel {
        interval_s: 1.0,
        ..quiet.base.noiseless()
    };
    let mut noisy = quiet.clone();
    noisy.base.code_noise_m = 0.5;
    noisy.base.phase_noise_m = 0.002;
    let still = |_: f64| [0.0, 0.0, 5.0];
    let setting = Setting {
        rover_m: &still,
        ..setting(&navigation, 1800.0, 5)
    };
    let a = simulate(&quiet, &setting).unwrap().base;
    let b = simulate(&noisy, &setting).unwrap().base;
    let place = EnuFrame::from_ecef(a.position_ecef_m);
    // Bins of elevation: 10–20°, 60–90°.
    let mut code = [(0.0, 0.0); 2];
    let mut phase = [(0.0, 0.0); 2];
    for (a, b) in a.epochs.iter().zip(&b.epochs) {
        for (quiet, noisy) in a.observed.iter().zip(&b.observed) {
            let e = kepler_of(&navigation, quiet.satellite, a.tag);
            let ecef = Ephemeris::Kepler(e).orbit_at(a.tag).position_ecef_m;
            let [x, y, up] = place.enu_from_ecef(ecef);
            let elevation = up.atan2(x.hypot(y)).to_degrees();
            let bin = match elevation {
                e if e < 20.0 => 0,
                e if e > 60.0 => 1,
                _ => continue,
            };
            let d = noisy.pseudorange_m - quiet.pseudorange_m;
            code[bin] = (code[bin].0 + d * d, code[bin].1 + 1.0);
            let d = (noisy.phase_cycles - quiet.phase_cycles) * WAVELENGTH_M;
            phase[bin] = (phase[bin].0 + d * d, phase[bin].1 + 1.0);
        }
    }
    let rms = |(sum, n): (f64, f64)| (sum / n).sqrt();
    // √((1 + 1/sin²)/2) is 1.00 to 1.08 above 60° and 2.2 to 4.1 between 10° and 20°.
    assert!(
        code[1].1 > 500.0 && (0.49..0.56).contains(&rms(code[1])),
        "{}",
        rms(code[1])
    );
    assert!(
        code[0].1 > 500.0 && (1.0..2.1).contains(&rms(code[0])),
        "{}",
        rms(code[0])
    );
    assert!(
        (0.0019..0.0023).contains(&rms(phase[1])),
        "{}",
        rms(phase[1])
    );
    assert!(
        (0.004..0.0085).contains(&rms(phase[0])),
        "{}",
        rms(phase[0])
    );
}

#[test]
fn cycles_change_only_where_the_log_says_so() {
    let navigation = constellation(start(), 600.0, 6);
    let mut model = bare();
    model.rover.slips_per_hour = 60.0;
    model.rover.blockages_per_hour = 40.0;
    model.rover.blockage_time_s = 4.0;
    model.rover.outages_s = vec![[200.0, 203.0]];
    let logs = simulate(&model, &setting(&navigation, 600.0, 6)).unwrap();
    let mut cycles: BTreeMap<SatelliteId, f64> = BTreeMap::new();
    let (mut slips, mut halves, mut unresolved) = (0, 0, 0);
    for epoch in &logs.rover.epochs {
        let time_s = epoch.true_time.seconds_since(start());
        assert!(
            !(200.0..203.0).contains(&time_s),
            "nothing is logged in the outage"
        );
        for seen in &epoch.observed {
            let now = seen.phase_cycles - seen.pseudorange_m / WAVELENGTH_M;
            let LossOfLock(bits) = seen.loss_of_lock;
            let before = cycles.insert(seen.satellite, now);
            if bits & LossOfLock::HALF_CYCLE != 0 {
                unresolved += 1;
            } else {
                assert!(
                    (now - now.round()).abs() < 1e-5,
                    "whole cycles when resolved: {now}"
                );
            }
            if (now * 2.0).round() as i64 % 2 != 0 {
                halves += 1;
            }
            if let Some(before) = before {
                if bits & LossOfLock::SLIP != 0 {
                    slips += 1;
                } else {
                    assert!(
                        (now - before).abs() < 1e-5,
                        "silent change of {}",
                        now - before
                    );
                }
            }
        }
    }
    assert!(slips > 30, "{slips} slips");
    assert!(
        unresolved > 100 && halves > 20,
        "{unresolved} unresolved, {halves} with a half"
    );
}

#[test]
fn the_clock_wanders_and_jumps_by_whole_milliseconds() {
    let navigation = constellation(start(), 300.0, 7);
    let mut model = GnssModel::default();
    model.rover = ReceiverModel {
        clock_offset_s: 4.9e-4,
        clock_drift: 5e-7,
        tag_offset_s: 0.013,
        ..model.rover.noiseless()
    };
    let logs = simulate(&model, &setting(&navigation, 300.0, 7)).unwrap();
    let offsets: Vec<f64> = logs
        .rover
        .epochs
        .iter()
        .map(|e| e.tag.seconds_since(e.true_time))
        .collect();
    assert!(offsets.iter().all(|o| o.abs() <= 5.0e-4 + 1e-9));
    let jumps = offsets
        .windows(2)
        .filter(|w| (w[1] - w[0] + 1e-3).abs() < 1e-5)
        .count();
    assert_eq!(jumps, 1);
    for epoch in &logs.rover.epochs {
        let ms = epoch.tag.tow_s() * 1e3;
        assert!(
            (ms - ms.round()).abs() < 1e-4,
            "tags are whole milliseconds"
        );
        assert_eq!(ms.round() as i64 % 200, 13);
    }
}

#[test]
fn nonsense_is_refused_with_the_reason() {
    let navigation = constellation(start(), 10.0, 1);
    let good = GnssModel::default();
    let refused = |model: &GnssModel| {
        simulate(model, &setting(&navigation, 10.0, 1))
            .unwrap_err()
            .to_string()
    };
    let mut model = good.clone();
    model.rover.interval_s = 0.0;
    assert!(refused(&model).contains("interval_s: expected 0.05 to 60 s"));
    let mut model = good.clone();
    model.base.code_noise_m = f64::NAN;
    assert!(refused(&model).contains("code_noise_m"));
    let mut model = good.clone();
    model.rover.outages_s = vec![[5.0, 2.0]];
    assert!(refused(&model).contains("outages_s"));
    let mut model = good.clone();
    model.elevation_mask_deg = 91.0;
    assert!(refused(&model).contains("elevation_mask_deg"));
    let empty = Navigation::default();
    let error = simulate(&good, &setting(&empty, 10.0, 1)).unwrap_err();
    assert_eq!(error, GnssError::EmptySky { most: 0 });
    let error = simulate(&good, &setting(&navigation, f64::INFINITY, 1)).unwrap_err();
    assert!(error.to_string().contains("duration_s"));
    assert!(
        toml::from_str::<GnssModel>("elevation_mask = 3").is_err(),
        "unknown keys"
    );
    let model: GnssModel = toml::from_str("[rover]\ninterval_s = 1.0").unwrap();
    assert_eq!(model.rover.interval_s, 1.0);
}
