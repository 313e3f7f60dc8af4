//! Pulses per second under interrupts, loss, noise and false edges: the clock is right and as certain as it
//! says, and pulses that are not GPS time's are not used.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures

use acerra_geo::time::GpsTime;
use acerra_record::timing::{
    Latency, MarkError, MarkedScans, Pair, Pulse, PulseError, PulsedClock, PulsedClockError,
    Stamps, logged_clock, marked_clock, pulsed_clock,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const DURATION_S: f64 = 300.0;
/// First epoch: within a second, and shortly before the end of a GPS week.
const FIRST_TOW_S: f64 = 604_699.4;
/// Host seconds in a second of GPS time, and of the radio's clock.
const HOST_RATE: f64 = 1.0 + 30e-6;
const RADIO_RATE: f64 = 1.0 - 20e-6;
/// Time from an epoch to its first byte (s), which nobody states.
const LATENCY_S: f64 = 0.060;

/// Standard deviation of the kernel's stamps (s).
const STAMP_SIGMA_S: f64 = 40e-6;

/// Host clock at a GPS time (s after the first epoch).
fn host_s(gps_s: f64) -> f64 {
    5.0 + HOST_RATE * gps_s
}

/// A recording of a radio whose messages are late by up to some milliseconds, and of a receiver.
struct Recording {
    random: ChaCha8Rng,
    /// Edges that the kernel counted.
    edges: u32,
}

impl Recording {
    fn new(seed: u64) -> Self {
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            edges: u32::MAX - 40,
        }
    }

    fn exponential(&mut self, mean_s: f64) -> f64 {
        let uniform: f64 = self.random.random();
        -mean_s * (1.0 - uniform).ln()
    }

    fn normal(&mut self) -> f64 {
        let [a, b]: [f64; 2] = [self.random.random(), self.random.random()];
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    fn stamps(&mut self) -> Stamps {
        let radio = (0..(DURATION_S / 0.05) as u32).map(|scan| {
            let radar_s = 0.05 * f64::from(scan);
            Pair {
                sent_s: radar_s,
                arrived_s: host_s(RADIO_RATE * radar_s) + self.exponential(1e-3),
            }
        });
        let radio = radio.collect();
        let gps = (0..(5.0 * DURATION_S) as u32).map(|epoch| {
            let gps_s = 0.2 * f64::from(epoch);
            let late_s = LATENCY_S + self.exponential(4e-3);
            let time = GpsTime::from_week_tow(2345, FIRST_TOW_S + gps_s);
            (time, host_s(gps_s) + late_s)
        });
        Stamps {
            gps: gps.collect(),
            radio,
            first: (7, 60_000),
            latency: [
                Latency::default(),
                Latency {
                    delay_s: 0.0,
                    sigma_s: 0.020,
                },
            ],
        }
    }

    /// An edge at a GPS time (s after the first epoch) that the kernel stamps with errors of ± 40 µs.
    fn edge(&mut self, gps_s: f64) -> Pulse {
        self.edges = self.edges.wrapping_add(1);
        Pulse {
            sequence: self.edges,
            host_s: host_s(gps_s) + STAMP_SIGMA_S * self.normal(),
            has_fix: true,
        }
    }

    /// One pulse a second, `late_s` behind it.
    fn pulses(&mut self, late_s: f64) -> Vec<Pulse> {
        let seconds = 0..DURATION_S as u32;
        let second = |k| 0.6 + f64::from(k) + late_s;
        seconds.map(|k| self.edge(second(k))).collect()
    }
}

/// Error of a clock at a radar time (s).
fn error_s(clock: &acerra_radar::LoggedClock, radar_s: f64) -> f64 {
    let time = GpsTime::from_week_tow(clock.gps_week, clock.time_offset_s) + clock.rate * radar_s;
    let true_s = RADIO_RATE * radar_s;
    time.seconds_since(GpsTime::from_week_tow(2345, FIRST_TOW_S)) - true_s
}

fn refused(stamps: &Stamps, pulses: &[Pulse]) -> PulseError {
    match pulsed_clock(stamps, pulses).unwrap_err() {
        PulsedClockError::Pulses(error) => error,
        other => panic!("{other}"),
    }
}

fn check_right(found: &PulsedClock) {
    assert!(error_s(&found.clock, 0.5 * DURATION_S).abs() < 0.2e-3);
    assert!((found.shortest_latency_s - LATENCY_S).abs() < 0.2e-3);
}

#[test]
fn trace_times_are_right_without_a_latency_stated_and_as_certain_as_they_say() {
    let (mut chi_squared, mut latency_chi) = (0.0, 0.0);
    let (mut largest_s, mut least_without_s) = (0.0_f64, f64::INFINITY);
    for seed in 0..100 {
        let mut recording = Recording::new(seed);
        let stamps = recording.stamps();
        let mut pulses = recording.pulses(0.0);
        pulses.retain(|_| !recording.random.random_bool(0.2));
        let found = pulsed_clock(&stamps, &pulses).unwrap();
        let clock = &found.clock;
        assert_eq!((clock.gps_week, clock.first_message_id), (2345, 7));
        assert!(clock.pulses >= 220 && clock.pulses + found.outlying == pulses.len());
        assert!(clock.sigma_s < 0.15e-3, "{}", clock.sigma_s);
        assert!(clock.sigma_s >= 50e-6, "interrupts are never surer");
        for radar_s in [0.0, 0.5 * DURATION_S, DURATION_S] {
            largest_s = largest_s.max(error_s(clock, radar_s).abs());
        }
        chi_squared += (error_s(clock, 0.5 * DURATION_S) / clock.sigma_stamps_s).powi(2);
        let sigma_s = logged_clock(&stamps).unwrap().sigma_stamps_s;
        latency_chi += ((found.shortest_latency_s - LATENCY_S) / sigma_s).powi(2);
        assert!((found.median_latency_s - LATENCY_S - 4e-3 * 2_f64.ln()).abs() < 0.5e-3);
        assert!(
            found.is_as_stated,
            "60 ms are three deviations of 0 ± 20 ms"
        );
        let without = logged_clock(&stamps).unwrap();
        least_without_s = least_without_s.min(error_s(&without, 0.5 * DURATION_S).abs());
    }
    println!(
        "largest error {:.3} ms with pulses, least without {:.1} ms; chi squared {chi_squared:.1}, of the latency \
         {latency_chi:.1}",
        1e3 * largest_s,
        1e3 * least_without_s
    );
    assert!(largest_s < 0.3e-3, "{largest_s}");
    assert!(least_without_s > 0.055, "{least_without_s}");
    // Between the 0.1 % and 99.9 % points of the distribution with 100 degrees of freedom.
    assert!((61.9..=149.4).contains(&chi_squared), "{chi_squared}");
    assert!(latency_chi < 149.4, "{latency_chi}");
}

#[test]
fn missed_doubled_and_outlying_pulses_do_no_harm() {
    let mut recording = Recording::new(1);
    let stamps = recording.stamps();
    let mut pulses = Vec::new();
    for second in 0..DURATION_S as u32 {
        let gps_s = 0.6 + f64::from(second);
        match second % 10 {
            // Not counted by the kernel.
            0 => {}
            // Counted, not read.
            1 => drop(recording.edge(gps_s)),
            // Doubled: the later of two edges is read.
            6 => {
                recording.edge(gps_s);
                pulses.push(recording.edge(gps_s + 2e-3));
            }
            // Held up by an interrupt that took long.
            3 if second % 20 == 3 => pulses.push(recording.edge(gps_s + 0.8e-3)),
            // Noise.
            4 if second % 50 == 4 => {
                pulses.push(recording.edge(gps_s));
                pulses.push(recording.edge(gps_s + 0.37));
            }
            _ => pulses.push(recording.edge(gps_s)),
        }
    }
    let found = pulsed_clock(&stamps, &pulses).unwrap();
    println!("{found:?}");
    check_right(&found);
    // The noise comes without a second of its own.
    assert_eq!((found.doubled, found.outlying), (30 + 6, 15));
    assert!((found.scatter_s / STAMP_SIGMA_S - 1.0).abs() < 0.2);
    assert_eq!(found.clock.pulses, 195);
}

/// Stamps that come by USB: late by up to a millisecond. They are used, and their clock says how sure it is.
#[test]
fn pulses_that_scatter_make_the_clock_less_sure() {
    let mut recording = Recording::new(2);
    let stamps = recording.stamps();
    let mut pulses = recording.pulses(0.0);
    for pulse in &mut pulses {
        pulse.host_s += 1e-3 * recording.random.random::<f64>();
    }
    let found = pulsed_clock(&stamps, &pulses).unwrap();
    let error_s = error_s(&found.clock, 0.5 * DURATION_S);
    println!("{error_s} {found:?}");
    assert!((0.25e-3..0.35e-3).contains(&found.clock.sigma_s));
    assert!(error_s.abs() < 2.0 * found.clock.sigma_s);
    for pulse in &mut pulses {
        pulse.host_s += 6e-3 * recording.random.random::<f64>();
    }
    let error = refused(&stamps, &pulses);
    assert!(matches!(error, PulseError::Unsteady { .. }), "{error}");
}

/// What is taken for the host clock steps halfway: the clock does not claim microseconds.
#[test]
fn a_step_is_refused_or_stated() {
    let mut recording = Recording::new(8);
    let stamps = recording.stamps();
    let mut stepped_by = |step_s: f64| {
        let mut pulses = recording.pulses(0.0);
        for pulse in pulses.iter_mut().skip(150) {
            pulse.host_s += step_s;
        }
        pulses
    };
    let error = refused(&stamps, &stepped_by(3e-3));
    assert!(matches!(error, PulseError::Wandering { .. }), "{error}");
    for step_s in [0.1e-3, 0.3e-3, 0.8e-3] {
        let found = pulsed_clock(&stamps, &stepped_by(step_s)).unwrap();
        for radar_s in [0.0, DURATION_S] {
            let sigmas = error_s(&found.clock, radar_s) / found.clock.sigma_s;
            assert!(sigmas.abs() < 2.5, "{step_s}: {sigmas} {found:?}");
        }
    }
}

#[test]
fn another_edge_and_pulses_of_another_clock_are_not_used() {
    let mut recording = Recording::new(3);
    let stamps = recording.stamps();
    // An inverted wire: the end of a pulse 100 ms long.
    let error = refused(&stamps, &recording.pulses(0.1));
    assert!(matches!(error, PulseError::Early { latency_s } if (latency_s + 0.04).abs() < 1e-3));
    let text = error.to_string();
    assert!(
        text.starts_with("the receiver's first byte would come 40.") && text.contains("other edge"),
        "{text}"
    );
    // A latency of 310 ms at 5 measurements a second.
    let error = refused(&stamps, &recording.pulses(-0.25));
    assert!(matches!(error, PulseError::Late { limit_s, .. } if (limit_s - 0.2).abs() < 1e-6));
    // A clock of its own that is 30 ppm fast, one that is 100 ppm fast, and one that is no clock at all.
    let mut drifting = recording.pulses(0.0);
    let began_s = drifting[0].host_s;
    let drift_by = |ppm: f64, pulses: &mut [Pulse]| {
        for pulse in pulses {
            pulse.host_s -= 1e-6 * ppm * (pulse.host_s - began_s);
        }
    };
    drift_by(30.0, &mut drifting);
    let error = refused(&stamps, &drifting);
    assert!(
        matches!(error, PulseError::Rate { found_ppm, .. } if (found_ppm + 30.0).abs() < 10.0),
        "{error}"
    );
    drift_by(70.0, &mut drifting);
    let error = refused(&stamps, &drifting);
    assert!(matches!(error, PulseError::NotSeconds { .. }), "{error}");
    for pulse in &mut drifting {
        pulse.host_s += recording.random.random::<f64>();
    }
    let error = refused(&stamps, &drifting);
    assert!(matches!(error, PulseError::NotSeconds { .. }), "{error}");
}

#[test]
fn pulses_without_a_fix_do_not_count() {
    let mut recording = Recording::new(4);
    let stamps = recording.stamps();
    let mut pulses = recording.pulses(0.0);
    // Before the fix the receiver's seconds are its own.
    for pulse in &mut pulses[..60] {
        pulse.has_fix = false;
        pulse.host_s += 0.3;
    }
    let found = pulsed_clock(&stamps, &pulses).unwrap();
    check_right(&found);
    assert_eq!(
        (found.without_fix, found.clock.pulses),
        (60, 240 - found.outlying - found.doubled)
    );
    // If they were said to be with a fix, they would show.
    for pulse in &mut pulses[..80] {
        pulse.has_fix = true;
    }
    for pulse in &mut pulses[60..80] {
        pulse.host_s += 0.3;
    }
    let error = refused(&stamps, &pulses);
    assert!(matches!(error, PulseError::NotSeconds { .. }), "{error}");
    for pulse in &mut pulses[5..] {
        pulse.has_fix = false;
    }
    let text = refused(&stamps, &pulses).to_string();
    assert!(text.contains("found 5 (295 without a fix, "), "{text}");
    let text = refused(&stamps, &[]).to_string();
    assert!(text.contains("found 0"), "{text}");
}

#[test]
fn pulses_of_a_part_of_the_recording_and_unsure_seconds_are_refused() {
    let mut recording = Recording::new(5);
    let mut stamps = recording.stamps();
    let pulses = recording.pulses(0.0);
    let error = refused(&stamps, &pulses[..100]);
    assert_eq!(
        error.to_string(),
        "the pulses with a fix span 99 s of 300 s; expected half of it at least"
    );
    stamps.latency[1].sigma_s = 0.2;
    let error = refused(&stamps, &pulses);
    assert!(matches!(error, PulseError::Ambiguous { .. }), "{error}");
    stamps.gps.truncate(15);
    assert!(matches!(
        pulsed_clock(&stamps, &pulses),
        Err(PulsedClockError::Timing(_))
    ));
}

/// A stated latency that the pulses contradict is told; the pulses count.
#[test]
fn a_stated_latency_that_the_pulses_contradict_is_told() {
    let mut recording = Recording::new(6);
    let mut stamps = recording.stamps();
    let pulses = recording.pulses(0.0);
    stamps.latency[1] = Latency {
        delay_s: 0.010,
        sigma_s: 0.002,
    };
    let found = pulsed_clock(&stamps, &pulses).unwrap();
    assert!(!found.is_as_stated);
    check_right(&found);
}

/// Scans each 50 ms: times of arrival with a receiver's latency of 0 ± 20 ms do not tell which scan a mark is of,
/// pulses do.
#[test]
fn marks_need_no_measured_latency_where_there_are_pulses() {
    let mut recording = Recording::new(7);
    let stamps = recording.stamps();
    let radar_s: Vec<f64> = stamps.radio.iter().map(|pair| pair.sent_s).collect();
    let first = GpsTime::from_week_tow(2345, FIRST_TOW_S);
    let marks: Vec<GpsTime> = radar_s
        .iter()
        .step_by(4)
        .map(|s| first + RADIO_RATE * s)
        .collect();
    let scans = MarkedScans {
        radar_s: &radar_s,
        marks: &marks,
        delay: Latency::default(),
    };
    let by_arrival = marked_clock(&scans, &logged_clock(&stamps).unwrap());
    assert!(matches!(
        by_arrival,
        Err(MarkError::Ambiguous {
            has_pulses: false,
            ..
        })
    ));
    let pulses = recording.pulses(0.0);
    let pulsed = pulsed_clock(&stamps, &pulses).unwrap().clock;
    let marked = marked_clock(&scans, &pulsed).unwrap();
    assert!(error_s(&marked, 0.5 * DURATION_S).abs() < 2e-6);
    assert_eq!((marked.marks, marked.pulses), (marks.len(), pulsed.pulses));
}
