//! u-blox UBX raw logs: measurements of the sixth generation (RXM-RAW) and of the eighth and
//! later (RXM-RAWX), navigation subframes (RXM-SFRB, RXM-SFRBX) and time marks (TIM-TM2).

mod d1;
pub mod frame;
mod glonass;
mod inav;
mod lnav;
mod log;
mod measurement;

pub use log::{UbxLog, read_ubx};

/// GPS time of the epoch that a message of raw measurements (RXM-RAW, RXM-RAWX) belongs to; `None`
/// for other messages, and where the receiver does not know the time yet.
#[must_use]
pub fn epoch_time(frame: &frame::Frame<'_>) -> Option<acerra_geo::time::GpsTime> {
    /// Class of receiver manager messages.
    const RXM: u8 = 0x02;
    if frame.class != RXM {
        return None;
    }
    measurement::Measurements::time_tag(frame.id, frame.payload)
}
