//! Solutions computed by an emulated receiver: NAV-PVT and NAV-HPPOSLLH in addition to the measurements.

use std::str::FromStr;

use acerra_geo::geodesy::{EnuFrame, Geodetic, geodetic_from_ecef};
use acerra_geo::matrix::{add, scale, subtract};
use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::epoch_time;
use acerra_gnss::ubx::frame::{Piece, encode, pieces};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Time over which errors of a solution forget themselves (s).
const CORRELATION_S: f64 = 30.0;
/// Standard deviation of a velocity, each axis in the plane and up (m/s): by carrier-phase rates, independent
/// of the position's quality.
const VELOCITY_SIGMA_M_S: [f64; 2] = [0.01, 0.02];
/// Half the time over which the true velocity is taken (s).
const VELOCITY_HALF_S: f64 = 0.01;

/// How good the solutions of an emulated receiver are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quality {
    /// Code alone: metres.
    Single,
    /// Carrier phase with real ambiguities: decimetres.
    Float,
    /// Carrier phase with integer ambiguities: millimetres to a centimetre.
    Fixed,
}

impl Quality {
    /// Standard deviations of its errors, each axis in the plane and up (m): those that change over half a
    /// minute, and white ones.
    fn sigma_m(self) -> [[f64; 2]; 2] {
        match self {
            Self::Single => [[1.0, 2.0], [0.05, 0.1]],
            Self::Float => [[0.15, 0.3], [0.01, 0.02]],
            Self::Fixed => [[0.004, 0.008], [0.001, 0.002]],
        }
    }

    /// The flags of NAV-PVT.
    fn flags(self) -> u8 {
        match self {
            Self::Single => 0x01,
            Self::Float => 0x43,
            Self::Fixed => 0x83,
        }
    }
}

impl FromStr for Quality {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "single" => Ok(Self::Single),
            "float" => Ok(Self::Float),
            "fixed" => Ok(Self::Fixed),
            _ => Err("expected single, float or fixed".to_owned()),
        }
    }
}

/// A log with a solution after each epoch's measurements: at the antenna's place by `place_ecef_m`, with
/// errors by `quality`. Epochs without a place get none.
#[must_use]
pub fn with_solutions(
    log: &[u8],
    place_ecef_m: impl Fn(GpsTime) -> Option<[f64; 3]>,
    quality: Quality,
    seed: u64,
) -> Vec<u8> {
    let mut errors = Errors::new(quality, seed);
    let mut out = Vec::with_capacity(log.len() + log.len() / 4);
    for piece in pieces(log) {
        match piece {
            Piece::Frame(frame) => {
                out.extend_from_slice(&log[frame.offset..frame.offset + frame.payload.len() + 8]);
                if let Some(time) = epoch_time(&frame)
                    && let Some(true_ecef_m) = place_ecef_m(time)
                {
                    let at = |after_s: f64| place_ecef_m(time + after_s);
                    let moved_ecef_m = at(VELOCITY_HALF_S)
                        .zip(at(-VELOCITY_HALF_S))
                        .map(|(after, before)| subtract(after, before));
                    let frame = EnuFrame::from_ecef(true_ecef_m);
                    let velocity_m_s = moved_ecef_m.map_or([0.0; 3], |moved| {
                        let moved_m = frame.enu_from_ecef(add(true_ecef_m, moved));
                        add(
                            scale(0.5 / VELOCITY_HALF_S, moved_m),
                            errors.of_velocity_m_s(),
                        )
                    });
                    let place = geodetic_from_ecef(frame.ecef_from_enu(errors.at(time)));
                    out.extend(solution(time, &place, velocity_m_s, quality));
                }
            }
            Piece::Outside { offset, bytes } => {
                out.extend_from_slice(&log[offset..offset + bytes]);
            }
            Piece::BadChecksum { .. } | Piece::CutOff { .. } => {}
        }
    }
    out
}

/// Errors east, north, up: some that wander, some that are new with each epoch.
struct Errors {
    rng: ChaCha8Rng,
    velocity_rng: ChaCha8Rng,
    quality: Quality,
    slow_m: [f64; 3],
    latest: Option<GpsTime>,
}

impl Errors {
    fn new(quality: Quality, seed: u64) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(seed ^ 0x736F_6C75),
            velocity_rng: ChaCha8Rng::seed_from_u64(seed ^ 0x7665_6C6F),
            quality,
            slow_m: [0.0; 3],
            latest: None,
        }
    }

    fn at(&mut self, time: GpsTime) -> [f64; 3] {
        let after_s = self.latest.replace(time).map(|t| time.seconds_since(t));
        let kept = after_s.map_or(0.0, |s| (-s.max(0.0) / CORRELATION_S).exp());
        let [slow, fast] = self.quality.sigma_m();
        std::array::from_fn(|axis| {
            let kind = usize::from(axis == 2);
            let (slow_m, fast_m) = (slow[kind], fast[kind]);
            let renewed = (1.0 - kept * kept).sqrt() * slow_m * normal(&mut self.rng);
            self.slow_m[axis] = kept * self.slow_m[axis] + renewed;
            self.slow_m[axis] + fast_m * normal(&mut self.rng)
        })
    }

    fn of_velocity_m_s(&mut self) -> [f64; 3] {
        let [plane, up] = VELOCITY_SIGMA_M_S;
        [plane, plane, up].map(|sigma| sigma * normal(&mut self.velocity_rng))
    }
}

/// A normally distributed number (Box and Muller).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let u: f64 = 1.0 - rng.random::<f64>();
    let v: f64 = rng.random();
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

fn solution(time: GpsTime, place: &Geodetic, velocity_m_s: [f64; 3], quality: Quality) -> Vec<u8> {
    let [slow, fast] = quality.sigma_m();
    let sigma_m = [0, 1].map(|k: usize| slow[k].hypot(fast[k]));
    let tow_ms = (1e3 * time.tow_s()).round() as u32 % 604_800_000;
    let mut pvt = pvt(time, tow_ms, place, quality, sigma_m);
    put_velocity(&mut pvt, velocity_m_s);
    let fine = high_precision(tow_ms, place, sigma_m);
    let frames = [encode(0x01, 0x07, &pvt), encode(0x01, 0x14, &fine)];
    frames.into_iter().flatten().flatten().collect()
}

fn pvt(
    time: GpsTime,
    tow_ms: u32,
    place: &Geodetic,
    quality: Quality,
    [plane_m, up_m]: [f64; 2],
) -> [u8; 92] {
    let mut p = [0_u8; 92];
    let mut put = |at: usize, bytes: &[u8]| p[at..at + bytes.len()].copy_from_slice(bytes);
    let utc = time.to_utc();
    put(0, &tow_ms.to_le_bytes());
    put(4, &(utc.year as u16).to_le_bytes());
    put(6, &[utc.month, utc.day, utc.hour, utc.minute, utc.second]);
    put(11, &[0b111]);
    put(16, &((1e9 * utc.fraction) as i32).to_le_bytes());
    put(20, &[3, quality.flags()]);
    put(23, &[18]);
    put(
        24,
        &((1e7 * place.longitude_deg()).round() as i32).to_le_bytes(),
    );
    put(
        28,
        &((1e7 * place.latitude_deg()).round() as i32).to_le_bytes(),
    );
    put(32, &((1e3 * place.height_m).round() as i32).to_le_bytes());
    put(36, &((1e3 * place.height_m).round() as i32).to_le_bytes());
    let horizontal_m = std::f64::consts::SQRT_2 * plane_m;
    put(40, &((1e3 * horizontal_m).ceil() as u32).to_le_bytes());
    put(44, &((1e3 * up_m).ceil() as u32).to_le_bytes());
    p
}

/// Velocity north, east, down, ground speed, and the speed's accuracy (mm/s); heading of motion (1e-5°).
fn put_velocity(pvt: &mut [u8; 92], [east, north, up]: [f64; 3]) {
    let heading_deg = east.atan2(north).to_degrees().rem_euclid(360.0);
    let [plane, _] = VELOCITY_SIGMA_M_S;
    let values = [
        1e3 * north,
        1e3 * east,
        -1e3 * up,
        1e3 * east.hypot(north),
        1e5 * heading_deg,
        1e3 * std::f64::consts::SQRT_2 * plane,
    ];
    for (place, value) in pvt[48..72].chunks_mut(4).zip(values) {
        place.copy_from_slice(&(value.round() as i32).to_le_bytes());
    }
}

fn high_precision(tow_ms: u32, place: &Geodetic, [plane_m, up_m]: [f64; 2]) -> [u8; 36] {
    let mut p = [0_u8; 36];
    let mut put = |at: usize, bytes: &[u8]| p[at..at + bytes.len()].copy_from_slice(bytes);
    put(4, &tow_ms.to_le_bytes());
    // Whole units, and the remainder in hundredths (tenths of a millimetre).
    let split = |value: f64, unit: f64, fine: f64| {
        let whole = (value / unit).round();
        let rest = ((value - whole * unit) / fine).round();
        (whole as i32, rest as i8)
    };
    let parts = [
        (8, 24, split(place.longitude_deg(), 1e-7, 1e-9)),
        (12, 25, split(place.latitude_deg(), 1e-7, 1e-9)),
        (16, 26, split(place.height_m, 1e-3, 1e-4)),
    ];
    for (at, fine_at, (whole, rest)) in parts {
        put(at, &whole.to_le_bytes());
        put(fine_at, &rest.to_le_bytes());
    }
    let horizontal_m = std::f64::consts::SQRT_2 * plane_m;
    put(28, &((1e4 * horizontal_m).ceil() as u32).to_le_bytes());
    put(32, &((1e4 * up_m).ceil() as u32).to_le_bytes());
    p
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::geodesy::ecef_from_geodetic;
    use acerra_gnss::ubx::{fine_position, receiver_solution};

    /// RXM-RAW without satellites at a time of week 2075.
    fn raw(tow_ms: i32) -> Vec<u8> {
        let mut payload = vec![0; 8];
        payload[0..4].copy_from_slice(&tow_ms.to_le_bytes());
        payload[4..6].copy_from_slice(&2075_i16.to_le_bytes());
        encode(2, 0x10, &payload).unwrap()
    }

    #[test]
    fn the_velocity_is_that_of_the_platform() {
        let origin = Geodetic::from_degrees(40.9, 14.2, 60.0);
        let frame = EnuFrame::new(origin);
        let start = GpsTime::from_week_tow(2075, 200_000.0);
        let log: Vec<u8> = (0..500).flat_map(|k| raw(200_000_000 + 100 * k)).collect();
        let velocity_m_s = [1.5, -0.7, 0.3];
        let place = |time: GpsTime| {
            Some(frame.ecef_from_enu(scale(time.seconds_since(start), velocity_m_s)))
        };
        let made = with_solutions(&log, place, Quality::Float, 3);
        let (mut sum, mut squares, mut count) = ([0.0; 3], [0.0; 3], 0.0);
        for piece in pieces(&made) {
            let Piece::Frame(found) = piece else { continue };
            if let Some(solution) = receiver_solution(&found) {
                count += 1.0;
                for axis in 0..3 {
                    let off = solution.velocity_m_s[axis] - velocity_m_s[axis];
                    sum[axis] += off;
                    squares[axis] += off * off;
                }
            }
        }
        for axis in 0..3 {
            assert!((sum[axis] / count).abs() < 0.003, "{axis}");
            let sigma = (squares[axis] / count).sqrt();
            let expected = VELOCITY_SIGMA_M_S[usize::from(axis == 2)];
            assert!((sigma / expected - 1.0).abs() < 0.15, "{axis}: {sigma}");
        }
    }

    #[test]
    fn solutions_follow_the_epochs_and_are_as_good_as_they_say() {
        let origin = Geodetic::from_degrees(40.9, 14.2, 60.0);
        let frame = EnuFrame::new(origin);
        let log: Vec<u8> = (0..2000).flat_map(|k| raw(200_000_000 + 200 * k)).collect();
        let place = ecef_from_geodetic(&origin);
        let made = with_solutions(&log, |_| Some(place), Quality::Fixed, 7);
        let (mut squares, mut count, mut pairs) = ([0.0; 3], 0.0, 0);
        let mut latest = None;
        for piece in pieces(&made) {
            let Piece::Frame(found) = piece else {
                panic!("{piece:?}");
            };
            if let Some(solution) = receiver_solution(&found) {
                assert!(solution.status.unwrap().is_fixed());
                latest = Some(solution);
            }
            if let Some(fine) = fine_position(&found) {
                let coarse = latest.unwrap();
                assert_eq!(fine.tow_ms, coarse.tow_ms);
                assert!(
                    (coarse.time.unwrap().tow_s() - 1e-3 * f64::from(fine.tow_ms)).abs() < 1e-6
                );
                let enu = |place: &Geodetic| frame.enu_from_ecef(ecef_from_geodetic(place));
                let (a, b) = (enu(&fine.place), enu(&coarse.place));
                for axis in 0..3 {
                    assert!((a[axis] - b[axis]).abs() < 0.006);
                    squares[axis] += a[axis] * a[axis];
                }
                count += 1.0;
                pairs += 1;
                assert!((fine.sigma_m[2] - 0.0083).abs() < 2e-4);
            }
        }
        assert_eq!(pairs, 2000);
        let rms_m = squares.map(|s: f64| (s / count).sqrt());
        // Slow errors: 400 s hold some dozen of them.
        assert!(rms_m[0] > 0.001 && rms_m[0] < 0.009, "{rms_m:?}");
        assert!(rms_m[2] > 0.002 && rms_m[2] < 0.018, "{rms_m:?}");
    }
}
