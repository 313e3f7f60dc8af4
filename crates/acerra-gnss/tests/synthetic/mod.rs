//! Observations that the suite makes itself: a constellation, two receivers, and the same model
//! of ranges, clocks, delays and integers that the engine assumes.
#![allow(dead_code, clippy::unwrap_used)]

use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use acerra_gnss::{
    Ephemeris, KeplerEphemeris, Klobuchar, LossOfLock, Navigation, Niell, ObservationData,
    ObservationEpoch, SPEED_OF_LIGHT_M_S, SatelliteId, SatelliteObservation, SignalCode,
    SignalObservation, StationInfo, System, line_of_sight, saastamoinen_m,
};

pub const BASE_ECEF_M: [f64; 3] = [4_641_950.0, 1_393_058.0, 4_133_281.0];

/// First epoch of every synthetic log.
pub fn start() -> GpsTime {
    GpsTime::from_week_tow(2_445, 518_400.0)
}

/// Deterministic noise: a linear congruential generator and the sum of twelve of its numbers.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn gauss(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

fn ephemeris(satellite: SatelliteId, node_rad: f64, anomaly_rad: f64) -> Ephemeris {
    let galileo = satellite.system() == System::Galileo;
    Ephemeris::Kepler(KeplerEphemeris {
        satellite,
        iode: 1,
        iodc: 1,
        health: 0,
        data_source: if galileo { 517 } else { 0 },
        accuracy_m: 2.4,
        toc: start() - 600.0,
        toe: start() - 600.0,
        transmission_time: start() - 1_200.0,
        toe_seconds_of_week: 517_800.0,
        sqrt_semi_major_axis: if galileo { 5_440.6 } else { 5_153.7 },
        eccentricity: 0.005,
        inclination_rad: 0.96,
        ascending_node_rad: node_rad,
        perigee_rad: 0.4,
        mean_anomaly_rad: anomaly_rad,
        mean_motion_correction_rad_s: 4.5e-9,
        ascending_node_rate_rad_s: -8e-9,
        inclination_rate_rad_s: 1e-10,
        latitude_correction_rad: [1e-6, 7e-6],
        radius_correction_m: [200.0, 20.0],
        inclination_correction_rad: [1e-7, -1e-7],
        clock: [
            1e-4 * (f64::from(satellite.number()) - 16.0) / 16.0,
            1e-12,
            0.0,
        ],
        group_delay_s: [-5e-9, -4e-9],
    })
}

/// Four to six planes of GPS and Galileo satellites.
pub fn navigation() -> Navigation {
    let mut ephemerides = Vec::new();
    for number in 1..=30u8 {
        let plane = f64::from((number - 1) % 6);
        let place = f64::from((number - 1) / 6);
        ephemerides.push(ephemeris(
            SatelliteId::new(System::Gps, number).unwrap(),
            plane * std::f64::consts::TAU / 6.0,
            place * std::f64::consts::TAU / 5.0 + plane * 0.4,
        ));
    }
    for number in 1..=24u8 {
        let plane = f64::from((number - 1) % 3);
        let place = f64::from((number - 1) / 3);
        ephemerides.push(ephemeris(
            SatelliteId::new(System::Galileo, number).unwrap(),
            plane * std::f64::consts::TAU / 3.0 + 0.3,
            place * std::f64::consts::TAU / 8.0 + plane * 0.5,
        ));
    }
    Navigation {
        ephemerides,
        klobuchar: Some(Klobuchar {
            alpha: [1.1e-8, 2.2e-8, -6e-8, -1.2e-7],
            beta: [9.6e4, 1.3e5, -6.5e4, -5.9e5],
        }),
        ..Navigation::default()
    }
}

/// How a log is made.
pub struct Receiver<'a> {
    pub seed: u64,
    pub epochs: usize,
    pub interval_s: f64,
    /// Position (ECEF, m) at a time after the start (s).
    pub position: &'a dyn Fn(f64) -> [f64; 3],
    /// Receiver clock offset (s) at a time after the start.
    pub clock_s: &'a dyn Fn(f64) -> f64,
    /// Standard deviations of phase and code (m).
    pub noise_m: [f64; 2],
    /// Signals per satellite, of GPS and Galileo.
    pub signals: &'a [SignalCode],
}

/// A log: at every epoch the receiver's tag is `start + k·interval` on its own clock.
pub fn observe(navigation: &Navigation, receiver: &Receiver<'_>) -> ObservationData {
    let mut noise = Noise::new(receiver.seed);
    let mut epochs = Vec::new();
    let integers: Vec<f64> = (0..512)
        .map(|_| (noise.uniform() * 2e6 - 1e6).round())
        .collect();
    for k in 0..receiver.epochs {
        let elapsed_s = k as f64 * receiver.interval_s;
        let clock_s = (receiver.clock_s)(elapsed_s);
        let tag = start() + elapsed_s;
        let received = tag - clock_s;
        let position = (receiver.position)(elapsed_s - clock_s);
        let frame = EnuFrame::from_ecef(position);
        let place = frame.origin();
        let mapping = Niell::new(tag, place);
        let zenith_m = saastamoinen_m(place, std::f64::consts::FRAC_PI_2, 0.0);
        let mut satellites = Vec::new();
        for (index, e) in navigation.ephemerides.iter().enumerate() {
            // Light time and satellite clock by iteration, as the signal was sent.
            let mut travel_s = 0.07;
            let mut state = e.orbit_at(received - travel_s);
            let mut range_m = 0.0;
            for _ in 0..4 {
                state = e.orbit_at(received - travel_s);
                range_m = line_of_sight(state.position_ecef_m, position)
                    .unwrap()
                    .range_m;
                travel_s = range_m / SPEED_OF_LIGHT_M_S;
            }
            let sight = line_of_sight(state.position_ecef_m, position).unwrap();
            let (azimuth, elevation) = acerra_gnss::azimuth_elevation_rad(&frame, sight.unit_ecef);
            if elevation < 0.1 {
                continue;
            }
            let troposphere_m = zenith_m * mapping.at(elevation).hydrostatic;
            let ionosphere_l1_m = navigation
                .klobuchar
                .unwrap()
                .delay_l1_m(tag, place, azimuth, elevation);
            let satellite = e.satellite();
            let mut observation = SatelliteObservation::new(satellite);
            for code in receiver.signals {
                let Some(slot) = code.slot(satellite.system()) else {
                    continue;
                };
                let frequency = code.carrier_frequency_hz(satellite.system(), None).unwrap();
                let wavelength = SPEED_OF_LIGHT_M_S / frequency;
                let scale = (acerra_gnss::FREQUENCY_L1_HZ / frequency).powi(2);
                let common_m =
                    range_m + SPEED_OF_LIGHT_M_S * (clock_s - state.clock_s) + troposphere_m;
                let weaker = 1.0 / elevation.sin();
                let phase_m = common_m - ionosphere_l1_m * scale
                    + receiver.noise_m[0] * weaker * noise.gauss();
                let code_m = common_m
                    + ionosphere_l1_m * scale
                    + receiver.noise_m[1] * weaker * noise.gauss();
                observation.signals[slot] = Some(SignalObservation {
                    code: *code,
                    pseudorange_m: Some(code_m),
                    phase_cycles: Some(phase_m / wavelength + integers[index * 3 + slot]),
                    doppler_hz: None,
                    cn0_db_hz: Some(35.0 + 13.0 * elevation.sin()),
                    loss_of_lock: LossOfLock(0),
                });
            }
            if observation.signals.iter().any(Option::is_some) {
                satellites.push(observation);
            }
        }
        satellites.sort_by_key(|s| s.satellite);
        epochs.push(ObservationEpoch {
            time: tag,
            satellites,
        });
    }
    let mut data = ObservationData {
        epochs,
        ..ObservationData::default()
    };
    data.station = StationInfo {
        position_ecef_m: Some((receiver.position)(0.0)),
        ..StationInfo::default()
    };
    data
}

/// L1 of GPS and E1 of Galileo.
pub const L1: [SignalCode; 1] = [SignalCode::new(1, 'C')];
/// L1, L2 and L5 (E1, E5b and E5a).
pub const L1_L2_L5: [SignalCode; 4] = [
    SignalCode::new(1, 'C'),
    SignalCode::new(2, 'W'),
    SignalCode::new(7, 'Q'),
    SignalCode::new(5, 'Q'),
];

/// A base standing still.
pub fn base(navigation: &Navigation, epochs: usize, signals: &[SignalCode]) -> ObservationData {
    observe(
        navigation,
        &Receiver {
            seed: 1,
            epochs,
            interval_s: 1.0,
            position: &|_| BASE_ECEF_M,
            clock_s: &|t| -2.1e-4 + 3e-8 * t,
            noise_m: [0.001, 0.25],
            signals,
        },
    )
}

/// Where the synthetic drone is (ECEF, m) at a time after the start: it hovers, then flies a
/// widening figure at up to 8 m/s, climbing and vibrating.
pub fn flight(t_s: f64) -> [f64; 3] {
    let moving = (t_s - 20.0).max(0.0);
    let ramp = moving / (moving + 10.0);
    let east = 60.0 + 40.0 * ramp * (0.16 * moving).sin();
    let north = -25.0 + 30.0 * ramp * (0.21 * moving).cos();
    let up = 12.0 + 15.0 * ramp * (0.05 * moving).sin() + 0.01 * (88.0 * t_s).sin();
    EnuFrame::from_ecef(BASE_ECEF_M).ecef_from_enu([east, north, up])
}

/// The drone's log.
pub fn rover(navigation: &Navigation, epochs: usize, signals: &[SignalCode]) -> ObservationData {
    observe(
        navigation,
        &Receiver {
            seed: 2,
            epochs,
            interval_s: 1.0,
            position: &flight,
            clock_s: &|t| 8.3e-4 + 2e-7 * t,
            noise_m: [0.001, 0.25],
            signals,
        },
    )
}
