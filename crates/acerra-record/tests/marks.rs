//! Time marks under loss, noise and jitter: the clock that they make is right, and as certain as it says.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures

use acerra_geo::time::GpsTime;
use acerra_radar::LoggedClock;
use acerra_record::timing::{Latency, MarkError, MarkedScans, marked_clock};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// First scan, shortly before the end of a GPS week.
const WEEK: i64 = 2345;
const FIRST_TOW_S: f64 = 604_700.0;
/// Seconds of GPS time in a second of the radio's clock, which is 20 ppm fast.
const RATE: f64 = 1.0 - 20e-6;
const SCANS: usize = 4_000;

/// A flight with a pulse a scan, of which the receiver tells the latest each 0.2 s.
struct Flight {
    random: ChaCha8Rng,
    interval_s: f64,
    /// Standard deviation of the stamps (s).
    noise_s: f64,
}

impl Flight {
    fn new(seed: u64, interval_s: f64) -> Self {
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            interval_s,
            noise_s: 50e-6,
        }
    }

    /// A normally distributed number.
    fn normal(&mut self) -> f64 {
        let [a, b]: [f64; 2] = [self.random.random(), self.random.random()];
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    /// Radar times of the scans that came: a tenth is lost.
    fn scans(&mut self) -> Vec<f64> {
        let interval_s = self.interval_s;
        let all = (0..SCANS).map(|k| interval_s * k as f64);
        all.filter(|s| *s == 0.0 || !self.random.random_bool(0.1))
            .collect()
    }

    /// Marks: the latest of each 0.2 s, a third of them lost, a twentieth of something else.
    fn marks(&mut self, delay_s: f64) -> Vec<GpsTime> {
        let last_s = self.interval_s * SCANS as f64;
        let mut marks = Vec::new();
        for k in 1..(last_s / 0.2) as usize {
            if self.random.random_bool(0.33) {
                continue;
            }
            let scan = (0.2 * k as f64 / self.interval_s).floor();
            let mut gps_s = RATE * self.interval_s * scan - delay_s + self.noise_s * self.normal();
            if self.random.random_bool(0.05) {
                gps_s += self.interval_s * self.random.random::<f64>();
            }
            marks.push(GpsTime::from_week_tow(WEEK, FIRST_TOW_S) + gps_s);
        }
        marks
    }

    /// The clock by times of arrival, off by its own deviation.
    fn arrivals(&mut self, sigma_s: f64) -> LoggedClock {
        let error_s = sigma_s * self.normal();
        LoggedClock {
            version: LoggedClock::VERSION,
            first_message_id: 1,
            first_timestamp_ms: 60_000,
            gps_week: WEEK,
            time_offset_s: FIRST_TOW_S + error_s,
            rate: RATE * (1.0 + 1e-6),
            sigma_stamps_s: 1e-4,
            sigma_s,
            radio_jitter_s: 0.0,
            gnss_jitter_s: 0.0,
            radio_latency_s: 0.0,
            gnss_latency_s: 0.0,
            marks: 0,
            pulses: 0,
        }
    }
}

/// Error of a clock at a radar time (s).
fn error_s(clock: &LoggedClock, radar_s: f64) -> f64 {
    let time = GpsTime::from_week_tow(clock.gps_week, clock.time_offset_s) + clock.rate * radar_s;
    time.seconds_since(GpsTime::from_week_tow(WEEK, FIRST_TOW_S)) - RATE * radar_s
}

#[test]
fn marks_make_the_clock_right_to_microseconds_and_as_certain_as_it_says() {
    let delay = Latency {
        delay_s: 0.010,
        sigma_s: 0.0,
    };
    let (mut chi_squared, mut largest_s) = (0.0, 0.0_f64);
    for seed in 0..100 {
        let mut flight = Flight::new(seed, 0.05);
        let (radar_s, marks) = (flight.scans(), flight.marks(delay.delay_s));
        let arrivals = flight.arrivals(4e-3);
        let scans = MarkedScans {
            radar_s: &radar_s,
            marks: &marks,
            delay,
        };
        let clock = marked_clock(&scans, &arrivals).unwrap();
        assert!(clock.marks > marks.len() * 8 / 10 && clock.sigma_s < 10e-6);
        let last_s = radar_s[radar_s.len() - 1];
        for radar_s in [0.0, 0.5 * last_s, last_s] {
            largest_s = largest_s.max(error_s(&clock, radar_s).abs());
        }
        chi_squared += (error_s(&clock, 0.5 * last_s) / clock.sigma_s).powi(2);
    }
    println!(
        "largest error {:.1} µs, chi squared {chi_squared:.1}",
        1e6 * largest_s
    );
    // 660 marks of ± 50 µs.
    assert!(largest_s < 20e-6, "{largest_s}");
    // Between the 0.1 % and 99.9 % points of the distribution with 100 degrees of freedom.
    assert!((61.9..=149.4).contains(&chi_squared), "{chi_squared}");
}

#[test]
fn the_doubt_of_the_marks_delay_is_stated() {
    let mut flight = Flight::new(1, 0.05);
    let (radar_s, marks) = (flight.scans(), flight.marks(0.0));
    let arrivals = flight.arrivals(1e-3);
    let scans = MarkedScans {
        radar_s: &radar_s,
        marks: &marks,
        delay: Latency {
            delay_s: 0.0,
            sigma_s: 2e-3,
        },
    };
    let clock = marked_clock(&scans, &arrivals).unwrap();
    assert!((clock.sigma_s - 2e-3).abs() < 1e-6 && clock.sigma_stamps_s < 10e-6);
}

/// Scans closer together than the times of arrival are sure: a mark may be of any of them.
#[test]
fn marks_that_cannot_be_told_apart_are_not_used() {
    let mut flight = Flight::new(2, 0.02);
    let (radar_s, marks) = (flight.scans(), flight.marks(0.0));
    let arrivals = flight.arrivals(0.02);
    let delay = Latency::default();
    let scans = MarkedScans {
        radar_s: &radar_s,
        marks: &marks,
        delay,
    };
    let error = marked_clock(&scans, &arrivals).unwrap_err();
    assert!(matches!(error, MarkError::Ambiguous { .. }));
    let text = error.to_string();
    assert!(
        text.starts_with("time marks each 20.0 ms cannot be assigned to scans by times of arrival, which are sure to 20.0 ms"),
        "{text}"
    );
}

#[test]
fn few_marks_and_marks_of_something_else_are_not_used() {
    let mut flight = Flight::new(3, 0.05);
    let (radar_s, mut marks) = (flight.scans(), flight.marks(0.0));
    let arrivals = flight.arrivals(1e-3);
    let clock = |marks: &[GpsTime]| {
        let scans = MarkedScans {
            radar_s: &radar_s,
            marks,
            delay: Latency::default(),
        };
        marked_clock(&scans, &arrivals).map_err(|error| error.to_string())
    };
    assert_eq!(
        clock(&marks[..9]).unwrap_err(),
        "expected 16 time marks at least while the radio scans, found 9"
    );
    for mark in &mut marks {
        let elsewhere_s = 0.05 * flight.random.random::<f64>();
        *mark = *mark + elsewhere_s;
    }
    let text = clock(&marks).unwrap_err();
    assert!(text.contains("time marks follow the scans"), "{text}");
}
