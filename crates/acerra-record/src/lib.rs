//! Recording in the field: the PulsON 400 radio driven over its MRM interface, GNSS receivers
//! logged, both on one clock, in logs that survive a power cut; and emulators of the instruments.

pub mod driver;
pub mod emulate;
pub mod gnss;
pub mod host;
pub mod link;
pub mod log;
pub mod mcap;
pub mod message;
pub mod pps;
pub mod session;
pub mod timing;
