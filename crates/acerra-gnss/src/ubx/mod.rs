//! u-blox UBX raw logs: measurements of the sixth generation (RXM-RAW) and of the eighth and
//! later (RXM-RAWX), navigation subframes (RXM-SFRB, RXM-SFRBX), time marks (TIM-TM2), and the receiver's
//! own positions (NAV-PVT, NAV-HPPOSLLH).

mod d1;
mod decoded;
mod fix;
pub mod frame;
mod glonass;
mod inav;
mod lnav;
mod log;
mod measurement;
mod position;
mod window;

use crate::observations::observation::{EventKind, EventRecord};

pub use fix::{FixState, fix_state, is_solution};
pub use log::{UbxLog, read_ubx};
pub use position::{FinePosition, ReceiverSolution, fine_position, receiver_solution};

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

/// The rising edge on the time-mark input that a message (TIM-TM2) gives, on GPS time; `None` for other
/// messages, and where the receiver does not know the time.
#[must_use]
pub fn rising_edge(frame: &frame::Frame<'_>) -> Option<EventRecord> {
    /// Base of the time in the flags: a time by the receiver alone is not GPS time.
    const TIME_BASE: u8 = 0b1_1000;
    if (frame.class, frame.id) != (0x0D, 0x03) || frame.payload.get(1)? & TIME_BASE == 0 {
        return None;
    }
    let edges = measurement::time_mark(frame.payload).ok()?;
    edges
        .into_iter()
        .find(|edge| edge.kind == EventKind::RisingEdge)
}
