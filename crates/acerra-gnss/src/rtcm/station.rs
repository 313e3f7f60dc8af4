//! Messages about the reference station: 1005, 1006 (position), 1007, 1008 (antenna), 1033
//! (antenna and receiver), 1013 (date) (RTCM 10403.3, sections 3.5.3 ff.).

use acerra_geo::time::{Calendar, GpsTime};

use crate::orbits::bits::BitCursor;

/// Modified Julian date of 1970-01-01.
const MJD_1970: i64 = 40_587;

/// Data of a message on the station.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum StationMessage {
    /// 1005, 1006: antenna reference point (ECEF, m).
    Position([f64; 3]),
    /// 1007, 1008: antenna descriptor.
    Antenna(String),
    /// 1033: antenna descriptor and receiver type.
    AntennaAndReceiver(String, String),
}

/// Reads message 1005, 1006, 1007, 1008 or 1033: the station's number and the data on the station.
pub(super) fn read(number: u16, payload: &[u8]) -> Option<(u16, StationMessage)> {
    let mut bits = BitCursor::new(payload);
    bits.skip(12)?;
    let station = bits.unsigned(12)? as u16;
    let message = match number {
        1005 | 1006 => {
            // Realisation year, services, kind of station.
            bits.skip(6 + 4)?;
            let x = bits.signed(38)?;
            bits.skip(2)?;
            let y = bits.signed(38)?;
            bits.skip(2)?;
            let z = bits.signed(38)?;
            // The antenna height of 1006 leads down to the marker: the coordinates are the
            // antenna's.
            StationMessage::Position([x, y, z].map(|steps| steps as f64 * 1e-4))
        }
        1007 | 1008 => StationMessage::Antenna(text(&mut bits)?),
        1033 => {
            let antenna = text(&mut bits)?;
            bits.skip(8)?;
            let _serial = text(&mut bits)?;
            let receiver = text(&mut bits)?;
            StationMessage::AntennaAndReceiver(antenna, receiver)
        }
        _ => return None,
    };
    Some((station, message))
}

/// Eight bits of length and as many characters.
fn text(bits: &mut BitCursor<'_>) -> Option<String> {
    let length = bits.unsigned(8)?;
    (0..length)
        .map(|_| bits.byte(8).map(printable))
        .collect::<Option<String>>()
        .map(|text| text.trim_end().to_owned())
}

fn printable(byte: u8) -> char {
    match byte {
        b' '..=b'~' => char::from(byte),
        _ => ' ',
    }
}

/// The date and time (UTC) of message 1013.
pub(super) fn date(payload: &[u8]) -> Option<GpsTime> {
    let mut bits = BitCursor::new(payload);
    bits.skip(24)?;
    let days = i64::try_from(bits.unsigned(16)?).ok()? - MJD_1970;
    let seconds = i64::try_from(bits.unsigned(17)?).ok()?;
    if days < 0 || seconds > 86_400 {
        return None;
    }
    let utc = Calendar::from_seconds_since_1970(days * 86_400 + seconds, 0.0);
    GpsTime::from_utc(&utc).ok()
}
