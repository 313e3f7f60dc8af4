//! The clock offset by height, motion and sharpness, and its refusals.

use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;

use acerra_radar::align::{
    AlignError, ClockPrior, FlightProfile, FlightState, OffsetLikelihood, OffsetOptions,
    offset_likelihood,
};
use acerra_radar::{Control, Radargram, Samples, two_way_delay_s};

/// Numbers that look random, the same for the same seed.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// A flight: rest, climb, hover about a height with a slow wander, descent, rest.
struct Flight {
    height_m: f64,
    /// Amplitudes, angular frequencies and phases of the wander.
    wander: Vec<[f64; 3]>,
    take_off_s: f64,
    land_s: f64,
}

impl Flight {
    fn new(noise: &mut Noise, wander_m: f64) -> Self {
        let wander = (0..12)
            .map(|_| {
                let size = wander_m * (2.0f64 / 12.0).sqrt();
                [size, 0.3 + 3.0 * noise.uniform(), TAU * noise.uniform()]
            })
            .collect();
        Self {
            height_m: 3.0 + 7.0 * noise.uniform(),
            wander,
            take_off_s: 40.0,
            land_s: 100.0,
        }
    }

    fn height_at(&self, t: f64) -> f64 {
        let share = ((t - self.take_off_s) / 6.0)
            .min((self.land_s - t) / 6.0)
            .clamp(0.0, 1.0);
        let smooth = share * share * (3.0 - 2.0 * share);
        let wander: f64 = self
            .wander
            .iter()
            .map(|[a, w, p]| a * (w * t + p).sin())
            .sum();
        0.3 + smooth * (self.height_m - 0.3 + wander)
    }

    fn along_at(&self, t: f64) -> f64 {
        1.5 * (t - self.take_off_s - 8.0).clamp(0.0, self.land_s - self.take_off_s - 16.0)
    }

    fn state(&self, t: f64) -> FlightState {
        let rate = |of: &dyn Fn(f64) -> f64| (of(t + 0.05) - of(t - 0.05)) / 0.1;
        let (up, along) = (rate(&|t| self.height_at(t)), rate(&|t| self.along_at(t)));
        FlightState {
            height_m: self.height_at(t),
            speed_m_s: up.hypot(along),
        }
    }

    fn profile(&self, error: impl Fn(f64) -> f64) -> FlightProfile {
        FlightProfile::sample([0.0, 140.0], |t| {
            let state = self.state(t);
            Some(FlightState {
                height_m: state.height_m + error(t),
                ..state
            })
        })
        .unwrap()
    }

    /// A record of `seconds` from trajectory time `from_s`: coupling with jitter, the surface with
    /// a delay of 9 ns, two reflectors, noise.
    fn record(&self, from_s: f64, seconds: f64, noise: &mut Noise) -> Radargram {
        let (interval, n, start, step) = (0.07, 800, 5e-9, 122e-12);
        let time_s: Vec<f64> = (0..(seconds / interval) as usize)
            .map(|m| m as f64 * interval)
            .collect();
        let pulse = |u: f64| (-u * u / 0.2).exp() * (TAU * 3.95 * u).cos();
        let mut samples = Vec::with_capacity(time_s.len() * n);
        for t in &time_s {
            let (h, x) = (self.height_at(t + from_s), self.along_at(t + from_s));
            let range = |place: f64| (h * h + (x - place).powi(2)).sqrt();
            let jitter = 0.001 * noise.normal();
            let echoes = [
                (9.5 + jitter, 2000.0),
                (9.0 + 1e9 * two_way_delay_s(h), 60.0 / h),
                (
                    9.0 + 1e9 * two_way_delay_s(range(20.0)),
                    150.0 / range(20.0),
                ),
                (
                    9.0 + 1e9 * two_way_delay_s(range(45.0)),
                    150.0 / range(45.0),
                ),
            ];
            samples.extend((0..n).map(|k| {
                let fast_ns = 1e9 * (start + k as f64 * step);
                let sum: f64 = echoes.iter().map(|(at, a)| a * pulse(fast_ns - at)).sum();
                (sum + noise.normal()) as f32
            }));
        }
        Radargram::new(time_s, start, step, Samples::Real(samples)).unwrap()
    }
}

fn likelihood(radargram: &Radargram, profile: &FlightProfile) -> OffsetLikelihood {
    offset_likelihood(
        radargram,
        profile,
        &OffsetOptions::default(),
        Control::default(),
    )
    .unwrap()
}

#[test]
fn straight_flight_take_off_and_landing_tell_the_offset_and_the_delay() {
    let mut noise = Noise(3);
    let flight = Flight::new(&mut noise, 0.06);
    let profile = flight.profile(|_| 0.0);
    // Straight flight alone; take-off and what follows; the whole flight.
    for (from_s, seconds) in [(55.3, 25.0), (30.1, 40.0), (20.7, 100.0)] {
        let radargram = flight.record(from_s, seconds, &mut noise);
        let found = likelihood(&radargram, &profile).decide().unwrap();
        assert!(
            (found.offset_s - from_s).abs() < (4.0 * found.sigma_s).max(0.02),
            "{} ± {} for {from_s}",
            found.offset_s,
            found.sigma_s
        );
        assert!(found.sigma_s < 0.06, "{}", found.sigma_s);
        let (delay_s, sigma_s) = found.delay_s.unwrap();
        assert!(
            (delay_s - 9e-9).abs() < 0.05e-9 + 4.0 * sigma_s,
            "{delay_s:e}"
        );
        assert!(found.second.is_none_or(|(_, below)| below > 6.0));
    }
}

/// Flights with white and lasting errors of the height: the stated deviation is the true one, and
/// what is not refused is right.
fn deviations_of(flights: u64) {
    let (mut chi2, mut refused) = (Vec::new(), 0);
    for seed in 0..flights {
        let mut noise = Noise(1000 + seed);
        let flight = Flight::new(&mut noise, 0.08);
        let phases: Vec<[f64; 2]> = (0..8)
            .map(|_| [0.1 + 1.2 * noise.uniform(), TAU * noise.uniform()])
            .collect();
        // Lasting errors of 6 mm, as carrier-phase heights have.
        let error = |t: f64| {
            phases
                .iter()
                .map(|[w, p]| 0.003 * (w * t + p).sin())
                .sum::<f64>()
        };
        let profile = flight.profile(error);
        let from_s = 50.0 + 20.0 * noise.uniform();
        let radargram = flight.record(from_s, 25.0, &mut noise);
        let Ok(found) = likelihood(&radargram, &profile).decide() else {
            refused += 1;
            continue;
        };
        let z = (found.offset_s - from_s) / found.sigma_s;
        assert!(z.abs() < 5.0, "seed {seed}: {found:?} for {from_s}");
        chi2.push(z * z);
    }
    let mean = chi2.iter().sum::<f64>() / chi2.len() as f64;
    println!(
        "mean of z² over {} flights: {mean:.2}; {refused} refused",
        chi2.len()
    );
    assert!(4 * refused <= flights, "{refused} of {flights} refused");
    // The mean of n draws of χ²₁ is 1 ± √(2/n): within four deviations above, and not a tenth.
    let above = 1.0 + 4.0 * (2.0 / chi2.len() as f64).sqrt();
    assert!((0.1..above).contains(&mean), "{mean}");
}

#[test]
fn the_stated_deviation_is_true() {
    deviations_of(8);
}

/// Heights by satellites err by reflections that last as long as a climb: no scatter shows them, and
/// what heights state tells how far the offset may be off by them.
#[test]
fn what_heights_state_tells_how_far_lasting_errors_move_the_offset() {
    let mut noise = Noise(5);
    let flight = Flight::new(&mut noise, 0.03);
    let from_s = 30.0;
    let radargram = flight.record(from_s, 90.0, &mut noise);
    let (mut shifts, mut stated) = (0.0, 0.0);
    let draws = 6_u32;
    for k in 0..draws {
        let phase = TAU * f64::from(k) / f64::from(draws);
        let error = |t: f64| 0.02 * 2.0f64.sqrt() * (TAU * t / 13.0 + phase).sin();
        let profile = flight.profile(error).with_stated_error_m(0.02);
        let found = likelihood(&radargram, &profile);
        let off_s = found.decide().unwrap().offset_s - from_s;
        let by_heights_s = found.height.unwrap().stated_sigma_s;
        println!(
            "{:.1} ms off, {:.1} ms stated",
            1e3 * off_s,
            1e3 * by_heights_s
        );
        shifts += off_s.powi(2);
        stated += by_heights_s.powi(2);
    }
    let ratio = (shifts / stated).sqrt();
    assert!((0.3..1.5).contains(&ratio), "{ratio}");
    let exact = likelihood(&radargram, &flight.profile(|_| 0.0));
    assert_eq!(exact.height.unwrap().stated_sigma_s, 0.0);
}

#[test]
#[ignore = "100 flights take minutes"]
fn the_stated_deviation_is_true_over_a_hundred_flights() {
    deviations_of(100);
}

#[test]
fn a_flight_without_information_is_refused() {
    let mut noise = Noise(9);
    let mut flight = Flight::new(&mut noise, 0.0);
    flight.height_m = 6.0;
    // Constant height and speed in the record; the trajectory holds nothing else either.
    let record = flight.record(60.0, 20.0, &mut noise);
    let level = FlightProfile::sample([0.0, 140.0], |_| {
        Some(FlightState {
            height_m: 6.0,
            speed_m_s: 1.5,
        })
    })
    .unwrap();
    let options = OffsetOptions::default();
    let refused = offset_likelihood(&record, &level, &options, Control::default())
        .and_then(|l| l.decide())
        .unwrap_err();
    assert!(
        matches!(
            refused,
            AlignError::NoCue | AlignError::Vague { .. } | AlignError::Ambiguous { .. }
        ),
        "{refused}"
    );
    // The trajectory climbs and lands, but not while the radar runs.
    let refused = offset_likelihood(
        &record,
        &flight.profile(|_| 0.0),
        &options,
        Control::default(),
    )
    .and_then(|l| l.decide())
    .unwrap_err();
    assert!(
        matches!(
            refused,
            AlignError::NoCue | AlignError::Vague { .. } | AlignError::Ambiguous { .. }
        ),
        "{refused}"
    );
}

#[test]
fn a_flight_that_repeats_itself_is_refused_and_stamps_or_images_decide() {
    let mut noise = Noise(21);
    let flight = Flight::new(&mut noise, 0.08);
    let record = flight.record(60.0, 20.0, &mut noise);
    // Twice the same: 50 to 90 s, and again 40 s later.
    let twice = FlightProfile::sample([50.0, 130.0], |t| {
        Some(flight.state(if t < 90.0 { t } else { t - 40.0 }))
    })
    .unwrap();
    let options = OffsetOptions::default();
    let both = offset_likelihood(&record, &twice, &options, Control::default()).unwrap();
    assert!(both.candidates.len() >= 2, "{:?}", both.candidates);
    match both.decide() {
        Err(AlignError::Ambiguous {
            best_s, second_s, ..
        }) => {
            let mut found = [best_s, second_s];
            found.sort_by(f64::total_cmp);
            assert!((found[0] - 60.0).abs() < 0.2 && (found[1] - 100.0).abs() < 0.2);
        }
        other => panic!("{other:?}"),
    }
    // Stamps that are right to a few seconds.
    let prior = ClockPrior {
        offset_s: 63.0,
        sigma_s: 3.0,
    };
    let stamped = options.with_prior(prior);
    let found = offset_likelihood(&record, &twice, &stamped, Control::default())
        .and_then(|l| l.decide())
        .unwrap();
    assert!((found.offset_s - 60.0).abs() < 0.15, "{}", found.offset_s);
    // Images that are sharp at 60.02 s, in four parts that scatter by 4 ms.
    let score = |offsets_s: &[f64]| -> Result<Vec<Vec<f64>>, AlignError> {
        let part = |t: f64, k: f64| 2.0 + 500.0 * (-((t - 60.02 - 0.004 * k) / 0.03).powi(2)).exp();
        let parts = |t: &f64| [-1.0, 1.0, -0.5, 0.5].map(|k| part(*t, k)).to_vec();
        Ok(offsets_s.iter().map(parts).collect())
    };
    let found = both.decide_with(0.01, 400, 0.0, score).unwrap();
    assert!((found.offset_s - 60.02).abs() < 0.006, "{}", found.offset_s);
    assert!(found.sigma_s < 0.006);
    assert_eq!(found.sharpness.unwrap().parts, 4);
}

#[test]
fn it_can_be_stopped() {
    let mut noise = Noise(2);
    let flight = Flight::new(&mut noise, 0.06);
    let record = flight.record(60.0, 10.0, &mut noise);
    let stop = AtomicBool::new(true);
    let control = Control::default().cancelled_by(&stop);
    let options = OffsetOptions::default();
    assert!(matches!(
        offset_likelihood(&record, &flight.profile(|_| 0.0), &options, control),
        Err(AlignError::Cancelled(_))
    ));
}
