//! The header of a trace.

use crate::bytes::Fields;

/// Bytes of a trace header.
pub const TRACE_HEADER_BYTES: usize = 240;

/// What a trace header says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceHeader {
    /// Number of the record the trace belongs to, and of the trace in it.
    pub record: i32,
    pub in_record: i32,
    pub identification: i16,
    /// Distance between transmitter and receiver, in the file's unit of length.
    pub offset: f64,
    /// Transmitter and receiver, scaled: x, y.
    pub source: [f64; 2],
    pub group: [f64; 2],
    /// Middle, scaled (revision 1).
    pub middle: [f64; 2],
    /// Heights of the receiver and of the surface at the transmitter, scaled.
    pub elevation: [f64; 2],
    /// 1 a length, 2 seconds of arc, 3 degrees, 4 degrees, minutes and seconds.
    pub unit: i16,
    /// Delay of the first sample, in the header's unit.
    pub delay: f64,
    pub samples: u16,
    pub interval: u16,
    /// Year, day of the year, hour, minute, second.
    pub stamp: [u16; 5],
}

impl TraceHeader {
    pub fn read(f: Fields<'_>) -> Self {
        let across = f.i16(70);
        let up = f.i16(68);
        let times = f.i16(214);
        let at = |x, y| [scaled(f.i32(x), across), scaled(f.i32(y), across)];
        Self {
            record: f.i32(8),
            in_record: f.i32(12),
            identification: f.i16(28),
            offset: f64::from(f.i32(36)),
            source: at(72, 76),
            group: at(80, 84),
            middle: at(180, 184),
            elevation: [scaled(f.i32(40), up), scaled(f.i32(44), up)],
            unit: f.i16(88),
            delay: scaled(i32::from(f.i16(108)), times),
            samples: f.u16(114),
            interval: f.u16(116),
            stamp: [156, 158, 160, 162, 164].map(|at| f.u16(at)),
        }
    }
}

/// A number under SEG-Y's scalar: negative divides, positive multiplies, 0 leaves.
fn scaled(value: i32, scalar: i16) -> f64 {
    let value = f64::from(value);
    match scalar {
        0 => value,
        s if s < 0 => value / -f64::from(s),
        s => value * f64::from(s),
    }
}
