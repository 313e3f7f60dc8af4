//! The simulated echoes against closed forms.

use super::*;
use crate::flight::FlightModel;

const C: f64 = 299_792_458.0;

fn quiet() -> RadarModel {
    RadarModel {
        coupling_db: 300.0,
        noise_counts: 1e-9,
        timing_jitter_ps: 0.0,
        ..Default::default()
    }
}

/// Envelope and phase of a record about `delay_s`, by direct correlation with the band's tones.
fn tone(record: &[f64], radar: &RadarModel, step_s: f64, frequency_hz: f64) -> (f64, f64) {
    let (mut re, mut im) = (0.0, 0.0);
    for (k, v) in record.iter().enumerate() {
        let t = radar.window_start_ns * 1e-9 + k as f64 * step_s;
        let (s, c) = (std::f64::consts::TAU * frequency_hz * t).sin_cos();
        re += v * c;
        im -= v * s;
    }
    (re.hypot(im) * 2.0, im.atan2(re))
}

#[test]
fn an_echo_has_the_delay_and_spectrum_of_equation_1() {
    let radar = quiet();
    let step_s = window(&radar).step_s();
    let mut shaper = PulseShaper::new(&radar, step_s);
    let range_m = 5.4321;
    let echo = Echo {
        delay_s: 2.0 * range_m / C,
        strength: 1.0,
        phase_rad: 0.0,
    };
    let mut record = Vec::new();
    shaper.shape(&[echo], radar.delay_ns * 1e-9, &mut record);
    let late = echo.delay_s + radar.delay_ns * 1e-9;
    let (flat, _) = tone(&record, &radar, step_s, 3.95e9);
    for f in [3.4e9, 3.7e9, 3.95e9, 4.2e9, 4.5e9] {
        let (amplitude, phase) = tone(&record, &radar, step_s, f);
        let expected = -std::f64::consts::TAU * f * late;
        let off = (phase - expected).sin().atan2((phase - expected).cos());
        assert!(off.abs() < 2e-3, "{off} rad at {f} Hz");
        assert!(
            (amplitude / flat - 1.0).abs() < 5e-3,
            "{amplitude} at {f} Hz"
        );
    }
    for f in [2.9e9, 5.0e9, 6.0e9] {
        let (amplitude, _) = tone(&record, &radar, step_s, f);
        assert!(20.0 * (amplitude / flat).log10() < -40.0, "{f} Hz leaks");
    }
}

#[test]
fn echoes_from_behind_the_window_do_not_come_round() {
    let radar = quiet();
    let step_s = window(&radar).step_s();
    let mut shaper = PulseShaper::new(&radar, step_s);
    let mut record = Vec::new();
    let length_s = radar.samples as f64 * step_s;
    for beyond in [1.2, 1.7, 5.0] {
        let echo = Echo {
            delay_s: beyond * length_s,
            strength: 1.0,
            phase_rad: 0.0,
        };
        shaper.shape(&[echo], 5e-9, &mut record);
        let peak = record.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(peak < 0.02, "{peak}");
    }
}

fn hover(height_m: f64) -> Flight {
    let model: FlightModel = toml::from_str(&format!(
        "track_start_m = [-1, 0]\ntrack_end_m = [1, 0]\nheight_m = {height_m}\n\
         track_duration_s = 10\nwander_m = [0, 0, 0]\ntilt_deg = [0, 0, 0]"
    ))
    .unwrap();
    Flight::fly(&model, 1).unwrap()
}

#[test]
fn amplitudes_follow_the_radar_equation() {
    let radar = RadarModel {
        noise_counts: 20.0,
        ..RadarModel::default()
    };
    let receiver = Receiver::new(&radar);
    let rcs_m2: f64 = 2.0;
    for height_m in [4.0_f64, 10.0] {
        let flight = hover(height_m);
        let mid = 0.5 * (flight.on_track_s[0] + flight.on_track_s[1]);
        let pose = flight.pose_at(mid);
        let scene = RadarScene {
            point: vec![PointTarget {
                position_m: [0.0, 0.0, 0.0],
                rcs_m2,
            }],
            ..RadarScene::default()
        };
        let mut echoes = Vec::new();
        Scattering::new(&scene, &radar, &[], 1).echoes(&pose, pose.position_m, &mut echoes);
        let counts = echoes[0].strength * receiver.counts_per_strength();
        let snr_db = 20.0 * (counts / radar.noise_counts).log10() - 3.0103;

        let wavelength = C / 3.95e9;
        let received_dbm = -13.0
            + 10.0
                * (10.0_f64.powf(1.2) * wavelength * wavelength * rcs_m2
                    / ((4.0 * std::f64::consts::PI).powi(3) * height_m.powi(4)))
                .log10();
        let noise_dbm = 10.0 * (1.380_649e-23 * 290.0 * 1.7e9 * 1e3_f64).log10() + 5.0
            - 10.0 * 2048.0_f64.log10();
        assert!(
            (snr_db - (received_dbm - noise_dbm)).abs() < 0.05,
            "{snr_db}"
        );
    }
}

#[test]
fn a_corner_reflector_is_seen_best_along_its_axis() {
    let radar = quiet();
    let scene: RadarScene =
        toml::from_str("[[corner]]\nposition_m = [0, 0, 0]\nelevation_deg = 90").unwrap();
    let scattering = Scattering::new(&scene, &radar, &[], 1);
    let flight = hover(5.0);
    let pose = flight.pose_at(0.5 * (flight.on_track_s[0] + flight.on_track_s[1]));
    let at = |antenna: [f64; 3]| {
        let mut echoes = Vec::new();
        scattering.echoes(&pose, antenna, &mut echoes);
        echoes[0].strength * antenna.iter().map(|v| v * v).sum::<f64>()
    };
    let peak = at([0.0, 0.0, 5.0]);
    let wavelength = C / 3.95e9;
    assert!((peak * peak - corner_rcs_m2(0.4, wavelength)).abs() < 1e-9);
    // 20° off its axis: half the reflector's power, and the beam's cos² in amplitude.
    let (s, c) = 20.0_f64.to_radians().sin_cos();
    let off = at([5.0 * s, 0.0, 5.0 * c]);
    assert!(((off / peak / c.powi(2)).powi(2) - 0.5).abs() < 1e-6);
}

#[test]
fn scans_repeat_with_the_seed_and_stay_within_full_scale() {
    let radar = RadarModel {
        samples: 768,
        ..RadarModel::default()
    };
    let scene: RadarScene = toml::from_str(
        "[ground]\nfacets_per_m2 = 0.5\n[[corner]]\nposition_m = [0, 0, 0]\n\
         [[clutter]]\nfrom_m = [0, 5, 0]\nto_m = [2, 6, 2]\nscatterers = 30\nrcs_m2 = 50",
    )
    .unwrap();
    let flight = hover(4.0);
    let span = [flight.on_track_s[0], flight.on_track_s[0] + 0.5];
    let scans = simulate_scans(&radar, &scene, &flight, span, 3).unwrap();
    assert_eq!(scans.len(), 8);
    assert_eq!(
        scans,
        simulate_scans(&radar, &scene, &flight, span, 3).unwrap()
    );
    assert_ne!(
        scans,
        simulate_scans(&radar, &scene, &flight, span, 4).unwrap()
    );
    let full = (20.0 * 10.0_f64.powf(75.0 / 20.0)).round() as i32;
    assert!(
        scans
            .iter()
            .flat_map(|s| &s.samples)
            .all(|v| v.abs() <= full)
    );
    assert!(scans.iter().all(|s| s.samples.len() == 768));
}

#[test]
fn noise_has_the_stated_spread() {
    let radar = RadarModel {
        coupling_db: 300.0,
        samples: 960,
        ..RadarModel::default()
    };
    let flight = hover(4.0);
    let span = [flight.on_track_s[0], flight.on_track_s[0] + 1.0];
    let scans = simulate_scans(&radar, &RadarScene::default(), &flight, span, 3).unwrap();
    let samples: Vec<f64> = scans
        .iter()
        .flat_map(|s| &s.samples)
        .map(|v| f64::from(*v))
        .collect();
    let rms = (samples.iter().map(|v| v * v).sum::<f64>() / samples.len() as f64).sqrt();
    assert!((rms - 20.0).abs() < 0.4, "{rms}");
}

#[test]
fn nonsense_is_refused_with_the_reason() {
    let flight = hover(4.0);
    let refused = |radar: RadarModel, scene: &str| {
        let scene: RadarScene = toml::from_str(scene).unwrap();
        simulate_scans(&radar, &scene, &flight, [0.0, 1.0], 1)
            .unwrap_err()
            .to_string()
    };
    let radar = RadarModel::default;
    assert!(
        refused(
            RadarModel {
                samples: 100,
                ..radar()
            },
            ""
        )
        .contains("multiple of 96")
    );
    assert!(
        refused(
            RadarModel {
                band_ghz: [4.8, 3.1],
                ..radar()
            },
            ""
        )
        .contains("band_ghz")
    );
    assert!(refused(radar(), "[[point]]\nposition_m = [0, 0, 0]\nrcs_m2 = -1").contains("[point]"));
    assert!(refused(radar(), "[ground]\nreflection = 2").contains("[ground] reflection"));
    assert!(refused(radar(), "[[corner]]\nposition_m = [0, 0, nan]").contains("[corner]"));
}

#[test]
fn the_stamps_of_a_fast_clock_gain_on_the_flight() {
    let stamps = |clock_drift_ppm| {
        let radar = RadarModel {
            clock_drift_ppm,
            ..quiet()
        };
        let scans = simulate_scans(&radar, &RadarScene::default(), &hover(3.0), [0.0, 4.0], 1);
        let stamps = scans.unwrap();
        f64::from(stamps.last().unwrap().timestamp_ms - stamps[0].timestamp_ms)
    };
    // 1 % of 4 s, to a whole millisecond.
    let gained_ms = stamps(1e4) - stamps(0.0);
    assert!((gained_ms - 40.0).abs() <= 1.0, "{gained_ms}");
}
