//! Positions that a receiver computes itself: NAV-PVT and NAV-HPPOSLLH.

use acerra_geo::geodesy::Geodetic;
use acerra_geo::time::{Calendar, GpsTime};
use acerra_geo::trajectory::SolutionStatus;

use super::frame::Frame;
use super::measurement::bytes;

const MILLIMETRE_M: f64 = 1e-3;
/// Unit of NAV-PVT's angles (degrees): 11 mm along a meridian.
const COARSE_DEG: f64 = 1e-7;
/// Unit of the additional digits of NAV-HPPOSLLH (degrees, m).
const FINE_DEG: f64 = 1e-9;
const FINE_M: f64 = 1e-4;
/// Largest difference of a solution's UTC reading and its time of week that is rounding (s).
const SAME_EPOCH_S: f64 = 1.5e-3;

/// A receiver's own solution (NAV-PVT).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReceiverSolution {
    /// Time of week of the navigation epoch (ms of GPS time), which messages of one epoch share.
    pub tow_ms: u32,
    /// Time of the epoch; `None` while the receiver does not know date and time.
    pub time: Option<GpsTime>,
    /// Position of the antenna.
    pub place: Geodetic,
    /// Standard deviations east, north, up (m). The message has one value for both horizontal axes together,
    /// which is shared equally.
    pub sigma_m: [f64; 3],
    /// Velocity east, north, up (m/s).
    pub velocity_m_s: [f64; 3],
    /// Status: fixed and float for carrier-phase solutions, DGPS for a solution with any correction; `None`
    /// without a position in three dimensions.
    pub status: Option<SolutionStatus>,
    /// Satellites used.
    pub satellites: u8,
}

/// The finer position of an epoch (NAV-HPPOSLLH).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FinePosition {
    /// Time of week of the navigation epoch (ms of GPS time).
    pub tow_ms: u32,
    /// Position of the antenna, to 0.1 mm.
    pub place: Geodetic,
    /// Standard deviations east, north, up (m), as [`ReceiverSolution::sigma_m`].
    pub sigma_m: [f64; 3],
}

/// The solution in a message NAV-PVT (01 07); `None` for other messages, for one cut short, and for invalid
/// coordinates.
#[must_use]
pub fn receiver_solution(frame: &Frame<'_>) -> Option<ReceiverSolution> {
    if (frame.class, frame.id) != (0x01, 0x07) || frame.payload.len() < 84 {
        return None;
    }
    let p = frame.payload;
    let tow_ms = u32::from_le_bytes(bytes(p, 0)?);
    let millimetres = |at| Some(MILLIMETRE_M * f64::from(i32::from_le_bytes(bytes(p, at)?)));
    let angle = |at| Some(COARSE_DEG * f64::from(i32::from_le_bytes(bytes(p, at)?)));
    let sigma = |at| Some(MILLIMETRE_M * f64::from(u32::from_le_bytes(bytes(p, at)?)));
    let place = somewhere(angle(28)?, angle(24)?, millimetres(32)?)?;
    Some(ReceiverSolution {
        tow_ms,
        time: time_of(p, tow_ms),
        place,
        sigma_m: axes(sigma(40)?, sigma(44)?),
        velocity_m_s: [millimetres(52)?, millimetres(48)?, -millimetres(56)?],
        status: status_of(p[20], p[21]),
        satellites: p[23],
    })
}

/// The position in a message NAV-HPPOSLLH (01 14); `None` for other messages, for one with its invalid flag
/// set, and for invalid coordinates.
#[must_use]
pub fn fine_position(frame: &Frame<'_>) -> Option<FinePosition> {
    const INVALID: u8 = 1;
    if (frame.class, frame.id) != (0x01, 0x14) || frame.payload.len() < 36 {
        return None;
    }
    let p = frame.payload;
    if p[3] & INVALID != 0 {
        return None;
    }
    let whole = |at| Some(f64::from(i32::from_le_bytes(bytes(p, at)?)));
    let digits = |at: usize| f64::from(i8::from_le_bytes([p[at]]));
    let sigma = |at| Some(FINE_M * f64::from(u32::from_le_bytes(bytes(p, at)?)));
    let longitude_deg = COARSE_DEG * whole(8)? + FINE_DEG * digits(24);
    let latitude_deg = COARSE_DEG * whole(12)? + FINE_DEG * digits(25);
    let height_m = MILLIMETRE_M * whole(16)? + FINE_M * digits(26);
    Some(FinePosition {
        tow_ms: u32::from_le_bytes(bytes(p, 4)?),
        place: somewhere(latitude_deg, longitude_deg, height_m)?,
        sigma_m: axes(sigma(28)?, sigma(32)?),
    })
}

fn axes(horizontal_m: f64, vertical_m: f64) -> [f64; 3] {
    let each_m = horizontal_m * std::f64::consts::FRAC_1_SQRT_2;
    [each_m, each_m, vertical_m]
}

fn somewhere(latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Option<Geodetic> {
    (latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 180.0)
        .then(|| Geodetic::from_degrees(latitude_deg, longitude_deg, height_m))
}

fn status_of(kind: u8, flags: u8) -> Option<SolutionStatus> {
    const FIX_OK: u8 = 1;
    const DIFFERENTIAL: u8 = 2;
    if flags & FIX_OK == 0 || !matches!(kind, 3 | 4) {
        return None;
    }
    Some(match (kind, flags >> 6, flags & DIFFERENTIAL) {
        // Dead reckoning is included.
        (4, _, _) => SolutionStatus::Unknown,
        (_, 2, _) => SolutionStatus::Fixed,
        (_, 1, _) => SolutionStatus::Float,
        (_, _, DIFFERENTIAL) => SolutionStatus::Dgps,
        _ => SolutionStatus::Single,
    })
}

/// The epoch from its UTC reading, which gives the week, and from the time of week where both agree up to
/// rounding: the time of week is in whole milliseconds, and UTC may be off by a leap second.
fn time_of(p: &[u8], tow_ms: u32) -> Option<GpsTime> {
    const DATE_AND_TIME: u8 = 0b11;
    const WEEK_S: f64 = 604_800.0;
    if p[11] & DATE_AND_TIME != DATE_AND_TIME {
        return None;
    }
    let year = u16::from_le_bytes(bytes(p, 4)?);
    let nanoseconds = i32::from_le_bytes(bytes(p, 16)?);
    let utc = Calendar::new(year.into(), p[6], p[7], p[8], p[9], f64::from(p[10])).ok()?;
    let by_utc = GpsTime::from_utc(&utc).ok()? + 1e-9 * f64::from(nanoseconds);
    let tow_s = 1e-3 * f64::from(tow_ms);
    let weeks_off = ((by_utc.tow_s() - tow_s) / WEEK_S).round() as i64;
    let by_week = GpsTime::from_week_tow(by_utc.week() + weeks_off, tow_s);
    let is_same = by_utc.seconds_since(by_week).abs() < SAME_EPOCH_S;
    Some(if is_same { by_utc } else { by_week })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(id: u8, payload: &[u8]) -> Frame<'_> {
        Frame {
            class: 1,
            id,
            payload,
            offset: 0,
        }
    }

    /// NAV-PVT of 2019-10-15 09:51:30.2 GPST, 18 s ahead of UTC; a Tuesday.
    fn pvt() -> Vec<u8> {
        let mut p = vec![0; 92];
        p[0..4].copy_from_slice(&(208_290_200_u32).to_le_bytes());
        p[4..6].copy_from_slice(&2019_u16.to_le_bytes());
        (p[6], p[7], p[8], p[9], p[10], p[11]) = (10, 15, 9, 51, 12, 0b111);
        p[16..20].copy_from_slice(&200_000_000_i32.to_le_bytes());
        (p[20], p[21], p[23]) = (3, 1 | 2 | 2 << 6, 17);
        p[24..28].copy_from_slice(&142_000_001_i32.to_le_bytes());
        p[28..32].copy_from_slice(&409_000_002_i32.to_le_bytes());
        p[32..36].copy_from_slice(&61_234_i32.to_le_bytes());
        p[40..44].copy_from_slice(&14_u32.to_le_bytes());
        p[44..48].copy_from_slice(&20_u32.to_le_bytes());
        p[48..52].copy_from_slice(&1_000_i32.to_le_bytes());
        p[52..56].copy_from_slice(&(-500_i32).to_le_bytes());
        p[56..60].copy_from_slice(&250_i32.to_le_bytes());
        p
    }

    #[test]
    fn a_solution_is_read_with_its_time() {
        let found = receiver_solution(&frame(7, &pvt())).unwrap();
        let expected = GpsTime::from_week_tow(2075, 208_290.2);
        assert!(found.time.unwrap().seconds_since(expected).abs() < 1e-9);
        assert_eq!(found.status, Some(SolutionStatus::Fixed));
        assert!((found.place.latitude_deg() - 40.900_000_2).abs() < 1e-12);
        assert!((found.place.longitude_deg() - 14.200_000_1).abs() < 1e-12);
        assert!((found.place.height_m - 61.234).abs() < 1e-12);
        assert!((found.sigma_m[0].hypot(found.sigma_m[1]) - 0.014).abs() < 1e-12);
        assert_eq!(found.velocity_m_s, [-0.5, 1.0, -0.25]);
    }

    #[test]
    fn a_leap_second_that_the_receiver_does_not_know_yet_is_no_error_of_time() {
        let mut p = pvt();
        p[10] = 13;
        let found = receiver_solution(&frame(7, &p)).unwrap();
        let expected = GpsTime::from_week_tow(2075, 208_290.2);
        assert!(found.time.unwrap().seconds_since(expected).abs() < 1e-9);
    }

    #[test]
    fn status_follows_the_flags() {
        for (kind, flags, expected) in [
            (3, 0x01, Some(SolutionStatus::Single)),
            (3, 0x03, Some(SolutionStatus::Dgps)),
            (3, 0x43, Some(SolutionStatus::Float)),
            (3, 0x83, Some(SolutionStatus::Fixed)),
            (4, 0x83, Some(SolutionStatus::Unknown)),
            (3, 0x82, None),
            (2, 0x01, None),
        ] {
            assert_eq!(status_of(kind, flags), expected, "{kind} {flags:02x}");
        }
    }

    #[test]
    fn what_is_cut_short_undated_or_nowhere_is_told_apart() {
        let p = pvt();
        for length in 0..84 {
            assert_eq!(receiver_solution(&frame(7, &p[..length])), None);
        }
        let mut undated = p.clone();
        undated[11] = 0b101;
        assert_eq!(receiver_solution(&frame(7, &undated)).unwrap().time, None);
        let mut nowhere = p;
        nowhere[28..32].copy_from_slice(&i32::MAX.to_le_bytes());
        assert_eq!(receiver_solution(&frame(7, &nowhere)), None);
    }

    #[test]
    fn the_finer_digits_are_added() {
        let mut p = vec![0; 36];
        p[4..8].copy_from_slice(&208_290_200_u32.to_le_bytes());
        p[8..12].copy_from_slice(&142_000_001_i32.to_le_bytes());
        p[12..16].copy_from_slice(&409_000_002_i32.to_le_bytes());
        p[16..20].copy_from_slice(&61_234_i32.to_le_bytes());
        p[24..27].copy_from_slice(&[0xF6, 7, 0xFD]);
        p[28..32].copy_from_slice(&140_u32.to_le_bytes());
        p[32..36].copy_from_slice(&200_u32.to_le_bytes());
        let found = fine_position(&frame(0x14, &p)).unwrap();
        assert!((found.place.longitude_deg() - 14.200_000_09).abs() < 1e-12);
        assert!((found.place.latitude_deg() - 40.900_000_207).abs() < 1e-12);
        assert!((found.place.height_m - 61.233_7).abs() < 1e-9);
        assert!((found.sigma_m[2] - 0.02).abs() < 1e-12);
        p[3] = 1;
        assert_eq!(fine_position(&frame(0x14, &p)), None);
        assert_eq!(fine_position(&frame(0x14, &p[..35])), None);
    }
}
