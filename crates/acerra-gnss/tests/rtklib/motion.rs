//! A flight added to the measurements of a receiver that stood still: real noise, exact truth.

use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use acerra_gnss::{
    Ephemeris, Navigation, Niell, ObservationData, PositioningMode, PpkOptions, SPEED_OF_LIGHT_M_S,
    SatelliteId, azimuth_elevation_rad, line_of_sight, process, saastamoinen_m,
};
use std::f64::consts::{FRAC_PI_2, TAU};

const STEP_S: f64 = 0.01;
const LARGEST_ACCELERATION_M_S2: f64 = 2.0;

/// Legs of the flight: duration (s), speed (m/s), turn rate (rad/s), climb rate (m/s).
const LEGS: [(f64, f64, f64, f64); 14] = [
    (20.0, 0.0, 0.0, 0.0),
    (10.0, 0.0, 0.0, 2.5),
    (20.0, 1.0, 0.0, 0.0),
    (6.0, 2.0, 0.5, 0.0),
    (20.0, 3.0, 0.0, 0.2),
    (5.0, 3.0, -0.6, 0.0),
    (20.0, 8.0, 0.0, 0.0),
    (8.0, 4.0, 0.4, 1.0),
    (20.0, 6.0, 0.0, -0.5),
    (10.0, 0.0, 0.3, 0.0),
    (20.0, 2.0, 0.0, 0.0),
    (8.0, 5.0, 0.4, 0.0),
    (20.0, 5.0, 0.05, -0.8),
    (13.0, 1.0, 0.2, -0.85),
];

/// A flight path: hover, legs of 1–8 m/s, turns, climbs, and vibration all along.
pub struct Flight {
    path: Vec<[f64; 3]>,
}

impl Flight {
    /// A path of at least `duration_s`, the legs repeating.
    pub fn new(duration_s: f64) -> Self {
        let mut path = vec![[0.0; 3]];
        let (mut speed, mut heading, mut climb) = (0.0f64, 0.4f64, 0.0f64);
        let largest_step = LARGEST_ACCELERATION_M_S2 * STEP_S;
        for &(leg_s, wanted_speed, turn, wanted_climb) in LEGS.iter().cycle() {
            for _ in 0..(leg_s / STEP_S) as usize {
                speed += (wanted_speed - speed).clamp(-largest_step, largest_step);
                climb += (wanted_climb - climb).clamp(-largest_step, largest_step);
                heading += turn * STEP_S;
                let [e, n, u] = path[path.len() - 1];
                path.push([
                    e + speed * heading.sin() * STEP_S,
                    n + speed * heading.cos() * STEP_S,
                    u + climb * STEP_S,
                ]);
            }
            if path.len() as f64 * STEP_S > duration_s + 2.0 {
                return Self { path };
            }
        }
        unreachable!("the legs repeat without end")
    }

    /// East, north, up displacement (m) at a time after the start.
    pub fn at(&self, t_s: f64) -> [f64; 3] {
        let place = (t_s + 1.0) / STEP_S;
        let index = (place as usize).min(self.path.len() - 2);
        let share = place - index as f64;
        let shake = |amplitude_m: f64, frequency_hz: f64, phase: f64| {
            amplitude_m * (TAU * frequency_hz * t_s + phase).sin()
        };
        let vibration = [
            shake(0.010, 11.3, 0.2),
            shake(0.008, 9.7, 1.1),
            shake(0.005, 27.1, 2.3) + shake(0.01, 1.3, 0.0),
        ];
        std::array::from_fn(|k| {
            self.path[index][k] * (1.0 - share) + self.path[index + 1][k] * share + vibration[k]
        })
    }
}

fn ephemeris(navigation: &Navigation, id: SatelliteId, t: GpsTime) -> Option<&Ephemeris> {
    navigation
        .ephemerides
        .iter()
        .filter(|e| e.satellite() == id)
        .min_by(|a, b| {
            let distance = |e: &Ephemeris| e.toe().seconds_since(t).abs();
            distance(a).total_cmp(&distance(b))
        })
}

/// `still`, as it would have measured along `flight` about its true position; satellites without
/// an ephemeris are left out. Time zero of the flight is the first tag.
pub fn add_motion(
    still: &ObservationData,
    navigation: &Navigation,
    position_ecef_m: [f64; 3],
    options: &PpkOptions,
    flight: &Flight,
) -> ObservationData {
    // Measurements are made at the tag minus the receiver's clock offset.
    let single = options
        .clone()
        .with_mode(PositioningMode::Single)
        .with_raim(true);
    let solution = process(still, &ObservationData::default(), navigation, &single).unwrap();
    let mut moved = still.clone();
    let start = still.epochs[0].time;
    let frame = EnuFrame::from_ecef(position_ecef_m);
    moved.epochs.retain_mut(|epoch| {
        let k = solution
            .epochs
            .partition_point(|s| s.time.seconds_since(epoch.time) < -0.02);
        let Some(time) = solution
            .epochs
            .get(k)
            .map(|s| s.time)
            .filter(|t| t.seconds_since(epoch.time).abs() < 0.02)
        else {
            return false;
        };
        let there = frame.ecef_from_enu(flight.at(time.seconds_since(start)));
        let tag = epoch.time;
        epoch.satellites.retain_mut(|s| {
            let Some(e) = ephemeris(navigation, s.satellite, tag) else {
                return false;
            };
            let Some(pseudorange_m) = s.first_pseudorange_m() else {
                return false;
            };
            let sent = tag - pseudorange_m / SPEED_OF_LIGHT_M_S;
            let range = |longer_m: f64, place: [f64; 3]| {
                let satellite = e.orbit_at(sent - longer_m / SPEED_OF_LIGHT_M_S);
                let sight = line_of_sight(satellite.position_ecef_m, place).unwrap();
                let frame = EnuFrame::from_ecef(place);
                let (_, elevation) = azimuth_elevation_rad(&frame, sight.unit_ecef);
                // A receiver higher up has less air above it.
                let zenith_m = saastamoinen_m(frame.origin(), FRAC_PI_2, 0.0);
                let mapping = Niell::new(tag, frame.origin()).at(elevation);
                sight.range_m + zenith_m * mapping.hydrostatic
            };
            let before = range(0.0, position_ecef_m);
            let mut longer_m = 0.0;
            for _ in 0..3 {
                longer_m = range(longer_m, there) - before;
            }
            for signal in s.signals.iter_mut().flatten() {
                let channel = match e {
                    Ephemeris::Glonass(g) => Some(g.channel),
                    _ => None,
                };
                let frequency = signal
                    .code
                    .carrier_frequency_hz(s.satellite.system(), channel)
                    .unwrap();
                signal.pseudorange_m = signal.pseudorange_m.map(|p| p + longer_m);
                signal.phase_cycles = signal
                    .phase_cycles
                    .map(|p| p + longer_m * frequency / SPEED_OF_LIGHT_M_S);
                signal.doppler_hz = None;
            }
            true
        });
        true
    });
    moved
}
