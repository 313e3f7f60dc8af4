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
