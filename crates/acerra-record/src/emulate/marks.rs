//! TIM-TM2 messages of an emulated receiver.

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::frame;

/// TIM-TM2: a rising edge at `time`, the `count`th, on the time of GPS.
pub(super) fn time_mark(time: GpsTime, count: u16) -> Vec<u8> {
    const RISING: u8 = 0x80;
    const TIME_VALID: u8 = 0x40;
    const OF_GNSS: u8 = 1 << 3;
    const RUNNING: u8 = 1 << 1;
    const ACCURACY_NS: u32 = 20;
    let (week, tow_ns) = week_and_ns(time);
    let mut payload = vec![0; 28];
    payload[1] = RISING | TIME_VALID | OF_GNSS | RUNNING;
    payload[2..4].copy_from_slice(&count.to_le_bytes());
    payload[4..6].copy_from_slice(&week.to_le_bytes());
    payload[8..12].copy_from_slice(&((tow_ns / 1_000_000) as u32).to_le_bytes());
    payload[12..16].copy_from_slice(&((tow_ns % 1_000_000) as u32).to_le_bytes());
    payload[24..28].copy_from_slice(&ACCURACY_NS.to_le_bytes());
    frame::encode(0x0D, 0x03, &payload).unwrap_or_default()
}

/// Week, and nanoseconds of the week.
fn week_and_ns(time: GpsTime) -> (u16, u64) {
    const WEEK_NS: u64 = 604_800_000_000_000;
    let start = GpsTime::from_week_tow(0, time.tow_s());
    let week = (time.seconds_since(start) / 604_800.0).round() as u16;
    let ns = (1e9 * time.tow_s()).round() as u64;
    (week.wrapping_add((ns / WEEK_NS) as u16), ns % WEEK_NS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_gnss::ubx::frame::{Piece, pieces};
    use acerra_gnss::ubx::rising_edge;

    #[test]
    fn a_mark_reads_back() {
        for (week, tow_s) in [(2345, 12.345_678_9), (2345, 604_799.999_999_999_9)] {
            let time = GpsTime::from_week_tow(week, tow_s);
            let log = time_mark(time, 7);
            let Some(Piece::Frame(frame)) = pieces(&log).next() else {
                panic!("no frame");
            };
            let edge = rising_edge(&frame).unwrap();
            assert_eq!(edge.count, Some(7));
            assert!((edge.time.seconds_since(time)).abs() < 2e-9);
        }
    }
}
