//! Clocks under drift, jitter, bursts and loss: right, and as certain as they say.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures, and why a test is skipped

use acerra_geo::time::GpsTime;
use acerra_record::timing::{Latency, Pair, Stamps, clock_line, logged_clock};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const DURATION_S: f64 = 300.0;
const JITTER_S: f64 = 5e-3;

/// A link that delays each message by an exponential time of 5 ms on average, by 50 ms more in bursts
/// of up to 3 s, and loses a fifth.
struct Link {
    random: ChaCha8Rng,
    burst_until_s: f64,
}

impl Link {
    fn new(seed: u64) -> Self {
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            burst_until_s: f64::NEG_INFINITY,
        }
    }

    /// Delay of a message sent at `time_s`; `None` where it is lost.
    fn delay_s(&mut self, time_s: f64) -> Option<f64> {
        let uniform: f64 = self.random.random();
        let mut delay_s = -JITTER_S * (1.0 - uniform).ln();
        if self.random.random_bool(0.002) {
            self.burst_until_s = time_s + 3.0 * self.random.random::<f64>();
        }
        if time_s < self.burst_until_s {
            delay_s += 0.05;
        }
        (!self.random.random_bool(0.2)).then_some(delay_s)
    }
}

/// Stamps of a flight: GPS time is host time plus 7 s less 10 ppm, the radio 20 ppm fast.
fn stamps(seed: u64) -> Stamps {
    let mut link = Link::new(seed);
    let mut radio = Vec::new();
    for scan in 0..(DURATION_S / 0.05) as u32 {
        let host_s = 0.05 * f64::from(scan) + 4.0;
        if let Some(delay_s) = link.delay_s(host_s) {
            radio.push(Pair {
                sent_s: (host_s - 4.0) * (1.0 + 20e-6),
                arrived_s: host_s + delay_s,
            });
        }
    }
    let mut link = Link::new(seed + 1_000_000);
    let mut gps = Vec::new();
    for epoch in 0..(5.0 * DURATION_S) as u32 {
        let tow_s = 604_700.0 + 0.2 * f64::from(epoch);
        let host_s = host_of_tow_s(tow_s);
        if let Some(delay_s) = link.delay_s(host_s) {
            gps.push((GpsTime::from_week_tow(2345, tow_s), host_s + delay_s));
        }
    }
    Stamps {
        radio,
        gps,
        first: (7, 60_000),
        latency: [Latency::default(); 2],
    }
}

fn host_of_tow_s(tow_s: f64) -> f64 {
    2.0 + (tow_s - 604_700.0) * (1.0 + 10e-6)
}

/// GPS time of a radar time, in seconds of week 2345.
fn true_tow_s(radar_s: f64) -> f64 {
    let host_s = 4.0 + radar_s / (1.0 + 20e-6);
    604_700.0 + (host_s - 2.0) / (1.0 + 10e-6)
}

#[test]
fn trace_times_are_within_half_a_millisecond_and_as_certain_as_they_say() {
    let mut chi_squared = [0.0; 3];
    let mut largest_s = 0.0_f64;
    for seed in 0..100 {
        let stamps = stamps(seed);
        let clock = logged_clock(&stamps).unwrap();
        assert_eq!((clock.gps_week, clock.first_message_id), (2345, 7));
        let error_s =
            |radar_s: f64| clock.time_offset_s + clock.rate * radar_s - true_tow_s(radar_s);
        for radar_s in [0.0, 0.5 * DURATION_S, DURATION_S] {
            largest_s = largest_s.max(error_s(radar_s).abs());
        }
        let middle = error_s(0.5 * DURATION_S) / clock.sigma_s;
        chi_squared[0] += middle * middle;
        let line = clock_line(&stamps.radio).unwrap();
        let reading = (line.reading_s(line.at_s) - 4.0 - line.at_s / (1.0 + 20e-6)) / line.sigma_s;
        chi_squared[1] += reading * reading;
        let rate = (line.rate - 1.0 / (1.0 + 20e-6)) / line.sigma_rate;
        chi_squared[2] += rate * rate;
    }
    println!(
        "largest error {:.3} ms, chi squared {chi_squared:.1?}",
        1e3 * largest_s
    );
    assert!(largest_s < 0.5e-3, "{largest_s}");
    // Between the 0.1 % and 99.9 % points of the distribution with 100 degrees of freedom.
    for value in chi_squared {
        assert!((61.9..=149.4).contains(&value), "{value}");
    }
}

/// A flight over the end of a GPS week.
#[test]
fn the_week_may_end_in_flight() {
    let mut stamps = stamps(3);
    stamps.radio.retain(|pair| pair.sent_s > 200.0);
    for pair in &mut stamps.radio {
        pair.sent_s -= 200.0;
    }
    let clock = logged_clock(&stamps).unwrap();
    assert_eq!(clock.gps_week, 2346);
    assert!((clock.time_offset_s + 604_800.0 - true_tow_s(200.0)).abs() < 0.5e-3);
}

#[test]
fn latencies_are_taken_off_and_their_doubt_is_stated() {
    let mut stamps = stamps(5);
    let without = logged_clock(&stamps).unwrap();
    stamps.latency = [
        Latency {
            delay_s: 0.010,
            sigma_s: 0.003,
        },
        Latency {
            delay_s: 0.060,
            sigma_s: 0.004,
        },
    ];
    let with = logged_clock(&stamps).unwrap();
    assert!((with.time_offset_s - without.time_offset_s - 0.050).abs() < 1e-6);
    assert!((with.sigma_s - 0.005).abs() < 1e-4, "{}", with.sigma_s);
}

#[test]
fn too_few_stamps_and_impossible_clocks_are_refused() {
    let mut few = stamps(1);
    few.gps.truncate(15);
    let text = logged_clock(&few).unwrap_err().to_string();
    assert_eq!(
        text,
        "GPS time: expected 16 pairs of stamps at least, found 15"
    );
    let mut fast = stamps(1);
    for pair in &mut fast.radio {
        pair.sent_s *= 1.001;
    }
    let text = logged_clock(&fast).unwrap_err().to_string();
    assert_eq!(
        text,
        "the radio's clock and GPS time differ by -1029 parts in a million; expected less than 500"
    );
    let standing = vec![
        Pair {
            sent_s: 1.0,
            arrived_s: 2.0
        };
        100
    ];
    let text = clock_line(&standing).unwrap_err().to_string();
    assert_eq!(text, "the pairs of stamps span no time");
}
