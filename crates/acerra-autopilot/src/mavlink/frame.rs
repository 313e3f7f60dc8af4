//! Packets of MAVLink 1 and 2 in a telemetry log (MAVLink Developer Guide, "Packet Serialization").
//!
//! A ground station writes eight bytes, big-endian, of microseconds since 1970 by its own clock before each
//! packet. The checksum of a packet covers a byte derived from the definition of its message (`CRC_EXTRA`):
//! packets of unknown messages cannot be checked.

use acerra_geo::time::GpsTime;

use crate::bytes::array;
use crate::sample::gps_time_of_unix_us;

/// Stamp of the ground station (bytes).
const STAMP: usize = 8;
/// Bytes of a packet, with its stamp, that give its length.
pub const HEADER: usize = STAMP + 3;
/// First byte of a packet of version 1, and of version 2.
const VERSION_1: u8 = 0xfe;
const VERSION_2: u8 = 0xfd;
/// Longest packet with its stamp (bytes): header 10, payload 255, checksum 2, signature 13.
pub const LONGEST: usize = STAMP + 10 + 255 + 2 + 13;

/// A packet.
#[derive(Debug, Clone, PartialEq)]
pub struct Packet<'a> {
    /// When it arrived, by the ground station's clock.
    pub arrival: GpsTime,
    /// The vehicle.
    pub system: u8,
    /// Part; 1 is the autopilot.
    pub component: u8,
    /// Number of the message.
    pub message: u32,
    /// The message; zeros at its end may be left out.
    pub payload: &'a [u8],
    /// Length with the stamp (bytes).
    pub length: usize,
    checked: &'a [u8],
    checksum: u16,
}

/// Length of the packet with its stamp that begins here; none where none can.
pub fn length(start: &[u8]) -> Option<usize> {
    let stamp = array(start, 0).map(i64::from_be_bytes)?;
    gps_time_of_unix_us(stamp)?;
    let payload = usize::from(*start.get(STAMP + 1)?);
    match *start.get(STAMP)? {
        VERSION_1 => Some(STAMP + 6 + payload + 2),
        VERSION_2 => {
            let flags = *start.get(STAMP + 2)?;
            // The only defined flag announces a signature.
            let signature = if flags & 1 == 1 { 13 } else { 0 };
            (flags & !1 == 0).then_some(STAMP + 10 + payload + 2 + signature)
        }
        _ => None,
    }
}

impl<'a> Packet<'a> {
    /// The packet that these bytes hold, with its stamp.
    pub fn of(bytes: &'a [u8]) -> Option<Self> {
        let arrival = array(bytes, 0).map(i64::from_be_bytes);
        let arrival = gps_time_of_unix_us(arrival?)?;
        let packet = bytes.get(STAMP..)?;
        let payload_length = usize::from(*packet.get(1)?);
        let (system, component, message, header) = match *packet.first()? {
            VERSION_1 => (
                *packet.get(3)?,
                *packet.get(4)?,
                u32::from(*packet.get(5)?),
                6,
            ),
            _ => {
                let [a, b, c] = array(packet, 7)?;
                let message = u32::from_le_bytes([a, b, c, 0]);
                (*packet.get(5)?, *packet.get(6)?, message, 10)
            }
        };
        let end = header + payload_length;
        Some(Self {
            arrival,
            system,
            component,
            message,
            payload: packet.get(header..end)?,
            length: bytes.len(),
            checked: packet.get(1..end)?,
            checksum: u16::from_le_bytes(array(packet, end)?),
        })
    }

    /// Whether the checksum is right for a message whose definition makes this byte.
    pub fn is_whole(&self, crc_extra: u8) -> bool {
        let crc = self
            .checked
            .iter()
            .fold(0xffff, |crc, b| accumulate(crc, *b));
        accumulate(crc, crc_extra) == self.checksum
    }
}

/// One byte of the checksum: CRC-16/MCRF4XX, polynomial 0x1021 reflected, from 0xffff.
pub const fn accumulate(crc: u16, byte: u8) -> u16 {
    let mut mixed = byte ^ (crc & 0xff) as u8;
    mixed ^= mixed << 4;
    let mixed = mixed as u16;
    (crc >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_the_catalogue() {
        // CRC-16/MCRF4XX of "123456789" is 0x6f91.
        let crc = b"123456789"
            .iter()
            .fold(0xffff, |crc, b| accumulate(crc, *b));
        assert_eq!(crc, 0x6f91);
    }
}
